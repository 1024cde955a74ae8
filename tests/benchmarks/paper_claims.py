"""The paper's claims, measured: what rods without angles save, and what planar models cost.

    python tests/benchmarks/paper_claims.py [--library FOLDER]

First table: the torn blocks of two coupled loops (the paper's figures 1 and 2), built with
JointRRWithMass and built with hinges, rods and point masses. A block of the levels below the
top is written `tears/constraints`: as many candidates for states, as many of them determined.
Second table: the examples of the paper, equations before and after alias elimination, CPU
milliseconds to compile (files parsed before, nothing else remembered) and to simulate once.
Third table: the same four-bar in PlanarMultiBody and in the Modelica Standard Library's
three-dimensional MultiBody, where FOLDER, or one of MODELICAPATH, holds that library.

Reference: M. Hoebinger, M. Otter, PlanarMultiBody, Modelica 2008, abstract, sections 4.5, 7.3.
"""

from __future__ import annotations

import argparse
import os
import tempfile
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

EXAMPLES = "PlanarMultiBody.Examples."
RODS, HINGES = "Loops.TwoLoops", "Loops.TwoLoopsWithRevolutes"
TABLE = (
    RODS,
    HINGES,
    "Loops.FourBar",
    "CurveCurveJoint.CamFollower",
    "CurveCurveJoint.CurveCurveJointSwitchSides",
    "CurveCurveJoint.SinusEllipse",
)


def sorted_model(name: str) -> Any:
    from planarc.request.request import Request, open_target
    from planarc.stages import flatten, to_dae, to_sorted

    return to_sorted(to_dae(flatten(open_target(Request(class_name=EXAMPLES + name)))))


def torn_blocks(name: str) -> dict[str, list[tuple[int, int]]]:
    """(tears, residuals) of every torn block, by its kind."""
    from planarc.ir.sorted import Block

    found: dict[str, list[tuple[int, int]]] = {"nonlinear": [], "linear": []}
    for level in sorted_model(name).levels:
        for step in level.steps:
            if isinstance(step, Block) and step.residuals:
                kind = "linear" if step.linear else "nonlinear"
                found[kind].append((len(step.tears), len(step.residuals)))
    return found


def measure(request: Any) -> tuple[tuple[int, int, float, float], Any]:
    """Equations before and after, CPU milliseconds to compile and to simulate; the result."""
    from planarc.compiled import Compiled
    from planarc.compiler import run
    from planarc.core.options import Backend, RunOptions
    from planarc.request.request import open_target
    from planarc.stages import flatten, to_code, to_dae, to_program, to_sorted

    def compiled() -> Any:
        program = to_program(to_sorted(to_dae(flatten(open_target(request)))))
        return Compiled(program, Backend.NATIVE, to_code(program, Backend.NATIVE))

    # Once before, for what is imported and parsed on the way.
    run(compiled(), RunOptions())
    begin = process_time()
    model = compiled()
    middle = process_time()
    result = run(model, RunOptions())
    end = process_time()
    program = model.program
    sizes = program.equations_before, program.equations_after
    return (*sizes, 1e3 * (middle - begin), 1e3 * (end - middle)), result


def head(title: str) -> str:
    names = ("equations", "sorted", "compile ms", "simulate ms")
    return f"{title:<44}" + "".join(f"{n:>12}" for n in names)


def row(name: str, numbers: tuple[int, int, float, float]) -> str:
    before, after, compiling, simulating = numbers
    return f"{name:<44}{before:>12}{after:>12}{compiling:>12.0f}{simulating:>12.0f}"


#: The bars, start and length of the run are those of Loops.FourBar. In space three hinges with
#: parallel axes hold the plane already, so the fourth must not hold it once more.
SPATIAL = """
model SpatialFourBar
  import Modelica.Mechanics.MultiBody.{Joints, Parts};
  inner Modelica.Mechanics.MultiBody.World world(g=9.81, n={0, -1, 0});
  Parts.Fixed groundA(r={0, 0, 0}), groundD(r={1, 0, 0});
  Joints.Revolute revA(phi(start=1, fixed=true), w(start=0, fixed=true));
  Joints.Revolute revB(phi(start=-0.46)), revD(phi(start=1.59));
  Joints.RevolutePlanarLoopConstraint revC;
  Parts.BodyShape crank(r={0.4, 0, 0}, r_CM={0.2, 0, 0}, m=1, I_33=0.0134);
  Parts.BodyShape coupler(r={0.9, 0, 0}, r_CM={0.45, 0, 0}, m=2, I_33=0.14);
  Parts.BodyShape rocker(r={0.8, 0, 0}, r_CM={0.4, 0, 0}, m=1.5, I_33=0.08);
equation
  connect(groundA.frame_b, revA.frame_a);
  connect(revA.frame_b, crank.frame_a);
  connect(crank.frame_b, revB.frame_a);
  connect(revB.frame_b, coupler.frame_a);
  connect(coupler.frame_b, revC.frame_a);
  connect(groundD.frame_b, revD.frame_a);
  connect(revD.frame_b, rocker.frame_a);
  connect(rocker.frame_b, revC.frame_b);
  annotation(experiment(StopTime=10, Interval=0.02, Tolerance=1e-8));
end SpatialFourBar;
"""
PLANAR = """
model PlanarFourBar
  extends PlanarMultiBody.Examples.Loops.FourBar;
  annotation(experiment(StopTime=10, Interval=0.02, Tolerance=1e-8));
end PlanarFourBar;
"""


def standard_library(given: Path | None) -> Path | None:
    """The folder that holds the Modelica Standard Library, of those that the user names."""
    paths = os.environ.get("MODELICAPATH", "").split(os.pathsep)
    for folder in [given] if given else [Path(p) for p in paths if p]:
        if (folder / "Modelica" / "Mechanics" / "MultiBody").is_dir():
            return folder
    return None


def compare_with_space(given: Path | None) -> None:
    from planarc.request.request import Request

    folder = standard_library(given)
    if folder is None:
        where = f"{given} holds no Modelica/Mechanics/MultiBody" if given else "no --library given"
        print(f"the same four-bar in three dimensions: not measured, {where}")
        return
    print(head("the same four-bar, tolerance 1e-8"))
    plane, planar = measure(Request(text=PLANAR))
    space, spatial = measure(Request(text=SPATIAL, libraries=(folder,)))
    print(row("PlanarMultiBody", plane))
    print(row("Modelica.Mechanics.MultiBody", space))
    ratios = "".join(f"{b / a:>12.1f}" for a, b in zip(plane, space, strict=True))
    print(f"{'times as much in space':<44}{ratios}")
    gap = difference(planar, spatial, ("revA", "revB", "revD"))
    print(f"both move alike: angles within {gap:.1e} rad")


def difference(one: Any, other: Any, joints: tuple[str, ...]) -> float:
    gaps = (np.max(np.abs(one[f"{j}.phi"] - other[f"{j}.phi"])) for j in joints)
    return float(max(gaps))


def main() -> None:
    parser = argparse.ArgumentParser(description="Measure the claims of the paper.")
    parser.add_argument("--library", type=Path, metavar="FOLDER", help="holds `Modelica`")
    folder = parser.parse_args().library
    with tempfile.TemporaryDirectory() as cache:
        os.environ["PLANARC_CACHE_DIR"] = cache
        print_claims(folder)


def print_claims(folder: Path | None) -> None:
    from planarc.request.request import Request

    print(f"{'torn blocks':<44} {'nonlinear':<22} linear")
    for name in (RODS, HINGES):
        blocks = torn_blocks(name)
        texts = [" ".join(f"{t}/{r}" for t, r in blocks[k]) or "-" for k in ("nonlinear", "linear")]
        print(f"{name:<44} {texts[0]:<22} {texts[1]}")
    print()
    print(head("example"))
    results = {}
    for name in TABLE:
        numbers, results[name] = measure(Request(class_name=EXAMPLES + name))
        print(row(name, numbers))
    gap = difference(results[RODS], results[HINGES], ("revA", "revD", "revG"))
    print(f"{RODS} and {HINGES} move alike: angles within {gap:.1e} rad")
    print()
    compare_with_space(folder)


if __name__ == "__main__":
    main()
