"""The commands, with the examples at the end of each one's `--help`."""

from __future__ import annotations

EXAMPLES = {
    "new": ("planarc new Swing && planarc simulate Swing.pmo",),
    "simulate": (
        "planarc simulate examples/four_bar.pmo",
        "planarc simulate pendulum.pmo --stop 20 --set rod.L=2 --output run.mat",
        "planarc simulate PlanarMultiBody.Examples.Loops.FourBar --json --no-report",
        "planarc simulate crane.pmo --variables 'hook|rope' --units",
        "planarc simulate examples/four_bar.pmo --assembly",
    ),
    "view": (
        "planarc view FourBar.csv",
        "planarc view run.mat --model four_bar.pmo --output run.html --no-open",
    ),
    "gallery": (
        "planarc gallery",
        "planarc gallery examples --output examples.html --reports reports",
    ),
    "serve": (
        "planarc serve four_bar.pmo",
        "planarc serve PlanarMultiBody.Examples.CurveCurveJoint.CamFollower --port 8080 --no-open",
    ),
    "check": (
        "planarc check four_bar.pmo",
        "planarc check four_bar.pmo --start",
        "planarc check PlanarMultiBody.Joints --all",
    ),
    "flatten": ("planarc flatten four_bar.pmo > flat.mo",),
    "equations": ("planarc equations four_bar.pmo",),
    "compile": (
        "planarc compile four_bar.pmo",
        "planarc compile four_bar.pmo --emit llvm > four_bar.ll",
    ),
    "explain": ("planarc explain F320", "planarc explain R"),
    "list": (
        "planarc list",
        "planarc list PlanarMultiBody.Joints",
    ),
    "doc": ("planarc doc PlanarMultiBody",),
    "fmt": (
        "planarc fmt crane.pmo",
        "planarc fmt --check .",
        "planarc fmt - < crane.pmo",
    ),
    "compare": (
        "planarc compare reference.mat FourBar.csv",
        "planarc compare a.csv b.csv --tolerance 1e-5 --variables '^crank'",
    ),
    "plot": (
        "planarc plot FourBar.csv revA.phi revD.phi -o angles.png",
        "planarc plot FourBar.mat revA.w --x revA.phi -o phase.pdf",
    ),
    "animate": (
        "planarc animate four_bar.pmo -o four_bar.svg",
        "planarc animate four_bar.pmo --trace couplerBody --to 2.5 --width 480 -o four_bar.gif",
        "planarc animate four_bar.pmo --layer forces --at 0.6 -o forces.png",
        "planarc animate four_bar.pmo --mode 1 --around equilibrium -o mode.mp4",
    ),
    "cache": ("planarc cache", "planarc cache --clear"),
    "doctor": ("planarc doctor", "planarc doctor --json"),
    "sweep": (
        'planarc sweep four_bar.pmo --vary "crankBody.m=0.5:2:16" --metric "max(revA.w)"',
        "planarc sweep four_bar.pmo --vary crankBody.m=0.5:2 --latin 1000 --output table.csv",
    ),
    "linearize": (
        "planarc linearize four_bar.pmo --at equilibrium",
        "planarc linearize pendulum.pmo --at 0.5 --json",
    ),
    "equilibrium": ("planarc equilibrium four_bar.pmo",),
    "assemble": ("planarc assemble four_bar.pmo --set revA.phi.start=0.5",),
    "drive": ('planarc drive four_bar.pmo --motion "revA.phi=1 + 2*time" --output forces.csv',),
    "sensitivity": (
        "planarc sensitivity four_bar.pmo --parameter crankBody.m --variable revA.phi",
    ),
}

_EVERYWHERE = (
    "With every command: --quiet (-q) leaves out summaries and warnings, --verbose (-v) tells more."
)


def epilog(command: str) -> str:
    """Examples and what holds for all commands; `\\b` keeps the lines of a paragraph."""
    return "\n".join(["\b", "Examples:", *(f"  {e}" for e in EXAMPLES[command]), "", _EVERYWHERE])
