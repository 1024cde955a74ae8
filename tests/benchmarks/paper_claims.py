"""The paper's claims, measured: what rods without angles save, and what planar models cost.

    python tests/benchmarks/paper_claims.py

First table: the torn blocks of two coupled loops (the paper's figures 1 and 2), built with
JointRRWithMass and built with hinges, rods and point masses. A block of the levels below the
top is written `tears/constraints`: as many candidates for states, as many of them determined.
Second table: the examples of the paper, equations before and after alias elimination, CPU
milliseconds to compile and to simulate once.

Reference: M. Hoebinger, M. Otter, PlanarMultiBody, Modelica 2008, sections 4.5 and 7.3.
"""

from __future__ import annotations

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
    from planarc.compiler import flatten, to_dae, to_sorted
    from planarc.request import Request, open_target

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


def measure(name: str) -> tuple[int, int, float, float, Any]:
    from planarc.compiler import compile_model, run
    from planarc.core.options import RunOptions
    from planarc.request import Request

    begin = process_time()
    compiled = compile_model(Request(class_name=EXAMPLES + name))
    middle = process_time()
    result = run(compiled, RunOptions())
    program = compiled.program
    return (
        program.equations_before,
        program.equations_after,
        1e3 * (middle - begin),
        1e3 * (process_time() - middle),
        result,
    )


def main() -> None:
    print(f"{'torn blocks':<44} {'nonlinear':<22} linear")
    for name in (RODS, HINGES):
        blocks = torn_blocks(name)
        texts = [" ".join(f"{t}/{r}" for t, r in blocks[k]) or "-" for k in ("nonlinear", "linear")]
        print(f"{name:<44} {texts[0]:<22} {texts[1]}")
    print()
    head = ("equations", "sorted", "compile ms", "simulate ms")
    print(f"{'example':<44}" + "".join(f"{h:>12}" for h in head))
    results = {}
    for name in TABLE:
        flat, left, compiling, simulating, results[name] = measure(name)
        print(f"{name:<44}{flat:>12}{left:>12}{compiling:>12.0f}{simulating:>12.0f}")
    gap = max(
        float(np.max(np.abs(results[RODS][f"{j}.phi"] - results[HINGES][f"{j}.phi"])))
        for j in ("revA", "revD", "revG")
    )
    print(f"\n{RODS} and {HINGES} move alike: angles within {gap:.1e} rad")


if __name__ == "__main__":
    main()
