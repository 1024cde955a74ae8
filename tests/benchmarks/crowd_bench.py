"""A hundred circles that fall into a box, 2 s by stepping, and the same box in Exudyn.

    python tests/benchmarks/crowd_bench.py [--only WORD]

planarc: the model of docs/howto/contacts.md with steps of 2 ms; CPU seconds of `simulate` alone,
after a first run, and of the whole command from warm caches. Exudyn, where it is installed, has
contacts that yield: spheres and walls of 1e6 N/m, followed by Euler's explicit method with steps
of 0.1 ms.
"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
import warnings
from importlib.util import find_spec
from math import sin
from pathlib import Path
from time import process_time

sys.path.insert(0, str(Path(__file__).parent))

from bench import Bar, planarc, table

PAGE = Path(__file__).parent.parent.parent / "docs" / "howto" / "contacts.md"
STEP, BODIES, RADIUS, STIFFNESS, DAMPING = 2e-3, 100, 0.05, 1e6, 2e2


def text() -> str:
    found = re.search(r"```modelica heap.pmo\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    assert found is not None
    return found[1]


def alone() -> float:
    from planarc import load

    model = load(text())
    model.simulate(0.01, fixed_step=STEP)
    begin = process_time()
    model.simulate(fixed_step=STEP)
    return process_time() - begin


def command() -> float:
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        (here / "heap.pmo").write_text(text(), encoding="utf-8")
        run = ["simulate", "heap.pmo", "--fixed-step", str(STEP), "--no-output", "--no-report"]
        planarc(run, here / "cache", here)
        return planarc(run, here / "cache", here).seconds


def exudyn() -> float:
    warnings.simplefilter("ignore", DeprecationWarning)
    import exudyn as exu
    import numpy as np
    from exudyn import itemInterface as item

    system = exu.SystemContainer().AddSystem()
    ground = system.AddMarker(
        item.MarkerBodyRigid(bodyNumber=system.AddObject(item.ObjectGround()))
    )
    contact = system.AddGeneralContact()
    contact.frictionProportionalZone = 1e-3
    contact.SetFrictionPairings(np.array([[0.3]]))
    law = {"contactStiffness": STIFFNESS, "contactDamping": DAMPING, "frictionMaterialIndex": 0}
    for i in range(1, BODIES + 1):
        at = [0.12 * (i % 10) + 0.01 * sin(i * i), 0.06 + 0.12 * ((i - 1) // 10), 0]
        node = system.AddNode(item.NodeRigidBody2D(referenceCoordinates=at))
        body = system.AddObject(
            item.ObjectRigidBody2D(physicsMass=1, physicsInertia=0.00125, nodeNumber=node)
        )
        middle = system.AddMarker(item.MarkerBodyPosition(bodyNumber=body))
        system.AddLoad(item.LoadForceVector(markerNumber=middle, loadVector=[0, -9.81, 0]))
        frame = system.AddMarker(item.MarkerBodyRigid(bodyNumber=body))
        contact.AddSphereWithMarker(frame, radius=RADIUS, **law)
    for a, b in (((1.3, 0), (-0.2, 0)), ((-0.1, 0), (-0.1, 2)), ((1.2, 2), (1.2, 0))):
        corners = [[*a, -0.2], [*b, -0.2], [*b, 0.2], [*a, 0.2]]
        contact.AddTrianglesRigidBodyBased(
            ground, pointList=corners, triangleList=[[0, 1, 2], [0, 2, 3]], **law
        )
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = 20_000, 2
    settings.solutionSettings.writeSolutionToFile = False
    begin = process_time()
    system.SolveDynamic(settings, solverType=exu.DynamicSolverType.ExplicitEuler)
    return process_time() - begin


BARS = (
    Bar("100 circles, simulate alone", "s", 3.0, alone),
    Bar("100 circles, the command, warm caches", "s", None, command),
    *([Bar("100 circles, Exudyn", "s", None, exudyn)] if find_spec("exudyn") else []),
)


def main() -> None:
    parser = argparse.ArgumentParser(description="Measure a crowd.")
    parser.add_argument("--only", default="", metavar="WORD", help="rows whose name holds WORD")
    only = parser.parse_args().only
    for line in table([bar for bar in BARS if only in bar.name]):
        print(line, flush=True)


if __name__ == "__main__":
    main()
