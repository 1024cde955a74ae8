"""Points of a study many at a time on NumPy's arrays, where that is faster.

In:   Model, options of some runs, metrics
Out:  Results, or None for those that have to be run by themselves

That is for the NumPy back end: native code needs less for one run than NumPy for its
share of a batch. See `planarc.solve.batch` for how, and for which models.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from planarc.core.data import Data
from planarc.core.options import Backend, RunOptions, Solver
from planarc.study.metric import Metrics, Reduction

if TYPE_CHECKING:
    from planarc.api.model import Model
    from planarc.api.result import Result
    from planarc.ir.program import Program

#: Fewer runs than this are faster one by one.
LEAST = 80
#: Runs in one batch: NumPy gains little by more, and the progress is seen.
MOST = 400
#: Bytes of rows that a batch may hold.
ROOM = 200_000_000


class BatchPlan(Data):
    text: str  # for arrays
    wanted: tuple[int, ...] | None  # slots to keep; None: all
    most: int  # runs at once


def plan_batch(model: Model, options: RunOptions, metrics: Metrics, count: int) -> BatchPlan | None:
    """None where runs one by one are as good, or all there is."""
    if model.backend is not Backend.NUMPY or count < LEAST:
        return None
    if options.solver is not Solver.AUTO or options.fixed_step is not None:
        return None
    from planarc.codegen.numpy.printer import source
    from planarc.solve.batch import may_batch
    from planarc.solve.settings import resolve

    program = model.program
    if not may_batch(program):
        return None
    wanted = _wanted(program, metrics)
    width = len(program.columns) if wanted is None else len(wanted) + len(program.assertions)
    rows = len(resolve(program, options).grid)
    most = min(MOST, int(ROOM / (8 * rows * max(1, width))))
    return BatchPlan(source(program, arrays=True), wanted, most) if most >= LEAST else None


def _wanted(program: Program, metrics: Metrics) -> tuple[int, ...] | None:
    parts = [part for _, part in metrics.parts]
    if not all(isinstance(part, Reduction) for part in parts):
        return None
    names = {part.variable for part in parts if isinstance(part, Reduction)}
    return tuple(c.slot for c in program.columns if c.name in names)


def run_batch(model: Model, plan: BatchPlan, options: Sequence[RunOptions]) -> list[Result | None]:
    from planarc.api.result import Result
    from planarc.solve.batch import simulate_batch
    from planarc.solve.settings import resolve

    compiled = model.compiled()
    requests = [resolve(model.program, o) for o in options]
    kernels = [compiled.load() for _ in options]
    found = simulate_batch(model.program, plan.text, kernels, requests, plan.wanted)
    return [None if rows is None else Result(rows) for rows in found]
