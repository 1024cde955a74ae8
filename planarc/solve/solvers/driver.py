"""CVODE's march in machine code (`codegen.native.march`), as a run calls it."""

from __future__ import annotations

import ctypes as C

from planarc.core.data import Data
from planarc.ir.frame import address
from planarc.ir.kernel import Addresses
from planarc.ir.march import Arguments
from planarc.solve.recorder import Recorder
from planarc.solve.solvers.dips import Dips
from planarc.solve.solvers.poles import Poles
from planarc.solve.solvers.sundials import Sundials
from planarc.solve.solvers.watch import Watch


class Where(Data):
    """CVODE's memory, its vectors (states, and scratch), and where it writes the time."""

    memory: int
    y: int
    dense: int
    time: C.c_double


class Driver:
    """The march of one integrator: of one run after another."""

    def __init__(
        self, sundials: Sundials, where: Where, kernel: Addresses, dips: Dips, poles: Poles
    ) -> None:
        self._call = C.CFUNCTYPE(C.c_int, C.POINTER(Arguments))(kernel.march)
        numbers = sundials.N_VGetArrayPointer
        self._arguments = Arguments(
            memory=where.memory,
            y=where.y,
            y_numbers=numbers(where.y),
            dense=where.dense,
            dense_numbers=numbers(where.dense),
            context=kernel.context,
            workspace=kernel.workspace,
            cvode=sundials.address("CVode"),
            interpolate=sundials.address("CVodeGetDky"),
            time=C.addressof(where.time),
            relations=dips.points.shape[1] - 1,
            points=address(dips.points),
            turning=address(dips.turning),
            factors=address(dips.factors),
            turning_count=len(dips.turning),
            turned=address(dips.turned),
            states=poles.size,
            places=address(poles.places),
            trail=address(poles.trail),
        )
        self._records, self._dips, self._poles = kernel.records, dips, poles
        self._arrays: object = None  # as long as their addresses are in use
        self._blocks: tuple[int, ...] = ()  # that are looked at, and where their records are
        self._rows: object = None
        self.part()

    def part(self) -> None:
        """Let go of the run."""
        self._recorder: Recorder | None = None
        self._edition, self._arrays = -1, None

    def _meet(self, recorder: Recorder, watch: Watch) -> None:
        """Take the arrays of a run."""
        import numpy as np

        a, refuge = self._arguments, watch.refuge
        if watch.blocks != self._blocks:
            self._blocks = watch.blocks
            self._rows = rows = np.array([self._records[i] for i in watch.blocks], dtype=np.int64)
            a.blocks, a.block_count = address(rows), len(rows)
        a.slots, a.columns = address(recorder.slots), len(recorder.slots)
        a.grid, a.grid_end, a.near = address(recorder.grid), len(recorder.grid), recorder.near
        a.scales = address(watch.scales)
        if refuge is not None:
            a.kept_slots, a.kept_count = address(refuge.slots), len(refuge.slots)
            a.guess, a.state = address(refuge.guess), address(refuge.state)
            a.kept_rows = address(refuge.rows)
        self._recorder, self._arrays = recorder, (watch.scales, refuge)

    def march(
        self, limit: float, recorder: Recorder, watch: Watch, steps: int, flag: int = -1
    ) -> tuple[int, Arguments]:
        """CVODE's last flag, and what the march tells in its arguments: `taken` steps, whether
        the kernel `failed`, whether it `looks` bad for the choice of states, whether there may
        be `poles` in the step just made, whether a zero function may have `dips` there, or do
        anything: called again with its `flag`, the march goes on from that step. Rows go to the
        recorder."""
        a = self._arguments
        if self._recorder is not recorder:
            self._meet(recorder, watch)
        recorder.reserve(len(recorder.grid) - recorder.next + 2)
        if self._edition != recorder.edition:
            a.rows, a.times = address(recorder.data), address(recorder.time)
            self._edition = recorder.edition
        a.limit, a.steps, a.bound, a.least = limit, steps, watch.bound, watch.least
        a.next, a.count, a.taken = recorder.next, recorder.count, 0
        a.failed = a.looks = a.poles = a.dips = 0
        a.flag, a.seen = flag, self._dips.seen
        last: int = self._call(C.byref(a))
        self._dips.seen, self._dips.farthest = a.seen, a.farthest
        recorder.next, recorder.count, watch.bound = a.next, a.count, a.bound
        return last, a
