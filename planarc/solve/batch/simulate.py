"""A batch from its starts to its results. See `planarc.solve.batch`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from msgspec import Struct

from planarc.core.diagnostic import PlanarcError
from planarc.ir.expr import Op, postorder
from planarc.ir.program import Kernel, Let, Program
from planarc.ir.result import Result, StateChoice, Statistics
from planarc.solve.batch.kernel import BatchKernel
from planarc.solve.batch.selection import BatchSelector
from planarc.solve.batch.steps import Step, first_length
from planarc.solve.events.asserts import AssertWatch
from planarc.solve.run import Run
from planarc.solve.settings import Request
from planarc.solve.simulate import set_workspace

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Numbers = NDArray[np.float64]
    Truths = NDArray[np.bool_]

#: What arrays have no value for: calls of functions that were not put in place, and the past.
_OTHER = frozenset(op for op in Op if op.name in ("APPLY", "PAST"))
#: A run that will need more steps than this is stiff: an implicit method does better.
MOST_STEPS = 3000
#: Steps after which that is judged.
TRIAL = 200


def may_batch(program: Program) -> bool:
    """Whether nothing happens in the model but smooth motion."""
    if program.relations or program.whens or program.samplers or program.discretes:
        return False
    if program.delays:
        return False
    if not program.state_count or program.functions:
        return False
    lists = (*program.levels, program.rest)
    lets = [s for part in lists for s in part if isinstance(s, Let)]
    lets += [let for b in program.blocks for let in (*b.body, *b.jacobian_body)]
    return not any(e.op in _OTHER for e in postorder(let.value for let in lets))


class _Lane(Struct):
    """One run: its own kernel at its start."""

    index: int
    request: Request
    run: Run


def simulate_batch(
    program: Program,
    source: str,
    kernels: Sequence[Kernel],
    requests: Sequence[Request],
    wanted: Sequence[int] | None = None,
) -> list[Result | None]:
    """`wanted`: the slots to keep (None: all that change)."""
    lanes = []
    for index, (kernel, request) in enumerate(zip(kernels, requests, strict=True)):
        run = _begun(program, kernel, request)
        if run is not None:
            lanes.append(_Lane(index, request, run))
    results: list[Result | None] = [None] * len(requests)
    if lanes:
        try:
            found = Batch(program, source, lanes, wanted).go()
        except ArithmeticError:
            return results
        for lane, result in zip(lanes, found, strict=True):
            results[lane.index] = result
    return results


def _begun(program: Program, kernel: Kernel, request: Request) -> Run | None:
    run = None
    try:
        set_workspace(program, kernel, request)
        run = Run(program, kernel, request, "numpy")
        run.begin()
    except PlanarcError:
        return None
    finally:
        if run is not None:
            run.close()
    return run if run.ended is None else None


class Batch:
    """Runs that share their times and differ in their workspaces."""

    def __init__(
        self,
        program: Program,
        source: str,
        lanes: Sequence[_Lane],
        wanted: Sequence[int] | None,
    ) -> None:
        import numpy as np

        self._program, self._lanes = program, lanes
        request = lanes[0].request
        self._grid, self._stop, self._rtol = request.grid, request.stop, request.tolerance
        self._kernel = BatchKernel(program, source, [lane.run.kernel.w for lane in lanes])
        self._selector = BatchSelector(
            program, self._kernel, [lane.run.selection for lane in lanes]
        )
        self._kernel.select(self._selector.selection)
        varying = {c.slot for c in program.columns if not c.constant}
        kept = dict.fromkeys(varying if wanted is None else (s for s in wanted if s in varying))
        kept |= dict.fromkeys(AssertWatch(program, lanes[0].run.kernel).slots)
        self._stored = {slot: i for i, slot in enumerate(kept)}
        count = len(lanes)
        self._data = np.empty((count, len(self._grid), len(kept)))
        self._t = np.full(count, request.start)
        self._row = np.zeros(count, dtype=np.intp)  # the next one to take
        self._out = np.zeros(count, dtype=bool)  # fell out
        self._steps = np.zeros(count, dtype=np.intp)

    def go(self) -> list[Result | None]:
        import numpy as np

        kernel, everyone = self._kernel, np.ones(len(self._lanes), dtype=bool)
        kernel.accept(self._t, kernel.w, everyone)
        y = kernel.states()
        kernel.outputs(self._t, y)
        self._take(self._t == self._grid[0])
        f = kernel.derivatives()
        h = first_length(y, f, self._absolute(), self._rtol, self._stop - self._t[0])
        with np.errstate(all="ignore"):
            while (moving := (self._t < self._stop) & ~self._out).any():
                y, f, h = self._step(moving, y, f, h)
        return [self._result(k) for k in range(len(self._lanes))]

    def _step(
        self, moving: Truths, y: Numbers, f: Numbers, h: Numbers
    ) -> tuple[Numbers, Numbers, Numbers]:
        import numpy as np

        kernel = self._kernel
        left = self._stop - self._t
        length = np.where(moving, np.minimum(h, left), 0.0)
        step = Step(kernel.rhs, self._t, y, f, length, self._absolute(), self._rtol)
        good = moving & (step.error < 1.0)
        end = np.where(length < left, self._t + length, self._stop)
        reached = list(kernel.w)
        matrices = [b.matrix for b in kernel.blocks]
        self._take_rows(step, good, end)
        kernel.w[:] = reached
        for block, matrix in zip(kernel.blocks, matrices, strict=True):
            block.matrix = matrix
        kernel.accept(end, kernel.w, good)
        self._t = np.where(good, end, self._t)
        y, f = np.where(good, step.y, y), np.where(good, step.f, f)
        self._steps += moving
        self._drop_stiff(moving, length)
        if self._selector.check(good & ~self._out):
            kernel.select(self._selector.selection)
            new_y, new_f = kernel.states(), kernel.derivatives()
            y, f = np.where(good, new_y, y), np.where(good, new_f, f)
        self._out |= self._selector.lost
        growth = step.factor()
        return y, f, np.where(moving, length * np.where(good, growth, np.minimum(growth, 1)), h)

    def _absolute(self) -> Numbers:
        """The absolute tolerance of each state."""
        import numpy as np

        w = self._kernel.w
        sizes = []
        for c in self._program.candidates:
            size = np.abs(w[c.nominal]) if c.nominal is not None else np.float64(1.0)
            sizes.append(np.broadcast_to(np.where(size > 0, size, 1.0), self._t.shape))
        runs = np.arange(len(self._t))
        found: Numbers = self._rtol * np.array(sizes)[self._selector.selection, runs]
        return found

    def _drop_stiff(self, moving: Truths, length: Numbers) -> None:
        import numpy as np

        begin = self._grid[0]
        part = (self._t - begin) / (self._stop - begin)
        stiff = (self._steps > TRIAL) & (self._steps > MOST_STEPS * part)
        stuck = length < 1e-12 * np.maximum(1.0, np.abs(self._t))
        self._out |= moving & (stiff | (stuck & (self._t < self._stop)))

    # Rows

    def _take_rows(self, step: Step, good: Truths, end: Numbers) -> None:
        """All rows asked for within the step, one of each run at a time."""
        import numpy as np

        grid, last = self._grid, len(self._grid) - 1
        between = None
        while True:
            due = grid[np.minimum(self._row, last)]
            pending = good & (self._row <= last) & (due <= end)
            if not pending.any():
                return
            t = np.where(pending, due, end)
            between = between or step.between()
            self._kernel.outputs(t, between(t))
            self._take(pending)

    def _take(self, pending: Truths) -> None:
        import numpy as np

        runs = np.flatnonzero(pending)
        w, rows = self._kernel.w, self._row[runs]
        for slot, place in self._stored.items():
            values = w[slot]
            self._data[runs, rows, place] = values[runs] if np.ndim(values) else values
        self._row[runs] += 1

    # Results

    def _result(self, k: int) -> Result | None:
        import numpy as np

        lane, program = self._lanes[k], self._program
        data = self._data[k]
        if self._out[k] or self._row[k] < len(self._grid) or not np.isfinite(data).all():
            return None
        watch = AssertWatch(program, lane.run.kernel)
        rows = _Rows(self._grid, data, self._stored)
        found, _ = watch.check(rows, True)
        if found:
            return None
        w = lane.run.kernel.w
        steps = int(self._steps[k])
        return Result(
            program=program,
            time=self._grid,
            data=data,
            stored=self._stored,
            constants={c.slot: float(w[c.slot]) for c in program.columns if c.constant},
            statistics=Statistics("dop853 (batch)", "numpy", steps, 12 * steps),
            states=tuple(lane.run.states[:1]) or (StateChoice(self._grid[0], ()),),
            held=lane.run.held,
            warnings=tuple(watch.warnings()),
        )


class _Rows(Struct):
    """What the assertions read, as `Recorder` has it."""

    time: Any
    data: Any
    stored: dict[int, int]

    @property
    def count(self) -> int:
        return len(self.time)
