"""The native back end's kernel: object code, linked into this process, and its memory.

The engine is shared by all kernels of the same object code; arrays and frame belong
to one kernel. A kernel keeps alive everything that its addresses point to. The file is long because
it binds all that a native kernel can.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, MutableSequence, Sequence
from functools import cached_property, lru_cache, partial
from itertools import accumulate
from typing import TYPE_CHECKING, Any

import numpy as np

from planarc.ir.begin import LARGEST, TOLD, room
from planarc.ir.frame import Frame, Mode, Number, Record, address
from planarc.ir.kernel import Addresses, Capabilities, Lead, Reacting, ReactorMaker
from planarc.ir.program import Program
from planarc.runtime.history import History
from planarc.solve.kernels.derived import Derived
from planarc.solve.kernels.native.engine import Engine
from planarc.solve.kernels.native.layout import Table, find_layout, numbers_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from planarc.core.arrays import Vector
    from planarc.ir.derivatives import Scope
    from planarc.solve.kernels.native.derivatives import NativeDerivatives

    Indices = NDArray[np.intp]


@lru_cache(maxsize=8)
def _engine(code: bytes) -> Engine:
    return Engine(code)


class NativeKernel(Derived):
    """See `planarc.ir.kernel.Kernel`; `w` is a NumPy array."""

    w: Any

    def __init__(
        self,
        program: Program,
        code: bytes,
        slopes: Callable[[Scope], Any] | None = None,
        lead: Lead | None = None,
        reactor: ReactorMaker | None = None,
    ) -> None:
        super().__init__(program, slopes, lead)
        self._reactor = reactor
        self._engine = engine = _engine(code)
        made = find_layout(program)
        self._place = made.place
        n, relations = program.state_count, len(program.relations)
        place, initial = self._place, len(program.initial_residuals)
        short = (n, n, n, relations, relations, initial)
        lengths = (program.size, place.accepted, place.area, *short)
        self._memory = np.zeros(sum(lengths) + place.numbers)  # of all that follows
        self.w, self._accepted, self._area, *arrays, numbers = np.split(
            self._memory, [*accumulate(lengths)]
        )
        self._y, self._ydot, self._nominal, self._zeros, self._shifts, self._initial = arrays
        self._numbers = numbers.view(np.int64)
        self._discrete_slots = np.array([d.slot for d in program.discretes], np.intp)
        self._frame = np.zeros(len(Frame), np.uint64)
        for where, array in (
            (Frame.W, self.w),
            (Frame.NUMBERS, self._numbers),
            (Frame.ACCEPTED, self._accepted),
            (Frame.AREA, self._area),
            (Frame.SHIFTS, self._shifts),
            (Frame.ANGLES, made.angles),
            (Frame.NOMINAL, self._nominal),
        ):
            self._frame[where] = address(array)
        self._results, self._tear_starts = made.results, made.tear_starts
        self._first_tears = self._accepted[: len(made.tear_starts)]
        self._matrices: dict[int, Vector] = {}  # the Jacobians of blocks, in place
        self._candidate_slots, self._residual_places = made.candidates, made.residuals
        self._asked, self._selections = made.asked, made.selections
        self._made = made
        self._scratch, self._scratch_address = np.empty(0), 0
        self._bind(engine)
        self._begin_past()
        self._begin_anew()

    def _begin_past(self) -> None:
        self.history = History(len(self._program.delays))
        self._frame[Frame.PAST] = self.history.memory.buffer_info()[0]

    def _begin_anew(self) -> None:
        """What a run finds; all arrays hold zeros."""
        made = self._made
        self._numbers[Number.STATES] = len(self._y)
        self._numbers[Number.OPEN] = -1
        self._started = False
        self._settled: dict[int, Sequence[float]] = {}
        self.w[made.parameters] = made.defaults
        self.select(made.first)

    def renew(self) -> None:
        self._memory.fill(0)
        self._derivatives.clear()
        if self._program.delays:
            self._begin_past()
        self._begin_anew()

    @property
    def capabilities(self) -> Capabilities:
        return Capabilities(self, self, self, self._react, self._lead)

    def _react(self) -> Reacting:
        return self._reacting

    @cached_property
    def _reacting(self) -> Reacting:
        react = None if self._reactor is None else self._engine.react
        if self._reactor is None or react is None:
            return Reacting()
        call = _checked(react, self.w, self._results, self._discrete_slots)
        return self._reactor(self._program, self._frame, call)

    def _bind(self, engine: Engine) -> None:
        frame = ctypes.c_void_p(address(self._frame))
        y, ydot, zeros, initial = (
            ctypes.c_void_p(address(a)) for a in (self._y, self._ydot, self._zeros, self._initial)
        )
        f = engine.functions

        def bound(name: str, *rest: ctypes.c_void_p) -> Callable[[float], int]:
            function = f[name]
            return lambda t: function(frame, t, *rest)

        self._call_rhs = bound("pc_rhs", y, ydot)
        self._call_outputs = bound("pc_outputs", y)
        self._call_roots = bound("pc_roots", y, zeros)
        self._call_accept = bound("pc_accept")
        self._call_parameters = bound("pc_parameters")
        self._call_discrete = bound("pc_discrete")
        evaluate = f["pc_evaluate"]
        self._call_evaluate: Callable[[int], int] = lambda mode: evaluate(frame, mode, initial)
        self._call_differences, self._call_root, self._call_motions, self._call_begin = (
            partial(f[name], frame)
            for name in ("pc_differences", "pc_seek", "pc_motions", "pc_begin")
        )

    @property
    def failed_block(self) -> int:
        return int(self._numbers[Number.FAILED])

    @property
    def near_singular(self) -> bool:
        return bool(self._numbers[Number.NEAR])

    @property
    def open_block(self) -> int:
        return int(self._numbers[Number.OPEN])

    def sway(self, block: int, amount: float) -> None:
        self._accepted[self._tears(block)] += amount

    def origin(self, block: int) -> list[float]:
        self._begin()
        found: list[float] = self._accepted[self._tears(block)].tolist()
        return found

    def settle(self, block: int, values: Sequence[float]) -> None:
        self._settled[block] = values
        self._accepted[self._tears(block)] = values

    def be_content(self) -> None:
        self._numbers[Number.CONTENT] = 1

    def _tears(self, block: int) -> slice:
        """The places of a block's values in `accepted`."""
        record = self._place.records[block]
        first = record[Record.ACCEPTED]
        return slice(first, first + record[Record.TEARS])

    @property
    def failed_equation(self) -> int:
        found = self._first_not_finite(self.w.tolist())
        block = self.failed_block
        if found >= 0 or block < 0:
            return found
        return self._row_not_finite(block)

    def _row_not_finite(self, block: int) -> int:
        """The equation of the first residual, or row of slopes, that is not finite."""
        code = self._program.blocks[block]
        m, n = len(code.residuals), len(code.tears)
        r, a = self._place.residuals(block), self._place.jacobian(block)
        rows = self._area[a : a + m * n].reshape(m, n)
        finite = np.isfinite(self._area[r : r + m]) & np.isfinite(rows).all(axis=1)
        return -1 if finite.all() else code.equations[int(np.argmin(finite))]

    def addresses(self, vector_numbers: int) -> Addresses:
        self._frame[Frame.VECTOR] = vector_numbers
        at = self._engine.address
        return Addresses(
            cv_rhs=at("pc_cv_rhs"),
            cv_roots=at("pc_cv_roots"),
            march=at("pc_march"),
            records=tuple(accumulate(map(len, self._place.records), initial=1)),
            context=address(self._frame),
            workspace=address(self.w),
        )

    def shift(self, shifts: Sequence[float]) -> None:
        self._shifts[: len(shifts)] = shifts
        self._numbers[Number.SHIFTED] = len(shifts)

    def measure(self, nominal: Sequence[float]) -> None:
        self._nominal[:] = nominal

    # The protocol

    def parameters(self) -> int:
        self._started = False
        self._settled.clear()
        self._numbers[Number.CONTENT] = 0
        return self._call_parameters(float(self.w[0]))

    def select(self, selection: Sequence[int]) -> None:
        chosen = tuple(selection)
        known = self._selections.get(chosen)
        if known is None:
            known = self._selections[chosen] = numbers_of(self._program, self._place, chosen)
        self._numbers[Number.FIRST_STATE :] = known
        self._choose(chosen)

    def accept(self, t: float) -> None:
        self._started = True
        self._call_accept(t)

    def rhs(self, t: float, y: Sequence[float], ydot: MutableSequence[float]) -> int:
        self._begin()
        self._y[:] = y
        flag = self._call_rhs(t)
        ydot[:] = self._ydot.tolist()
        return flag

    def outputs(self, t: float, y: Sequence[float]) -> int:
        self._begin()
        self._y[:] = y
        return self._call_outputs(t) or self._check_all()

    def residuals(self, t: float, u: Sequence[float], r: MutableSequence[float]) -> int:
        self.w[0] = t
        self.w[self._candidate_slots] = u
        flag = self._evaluate(Mode.GIVEN)
        if flag:
            return flag
        found = np.concatenate([self._area[self._residual_places], self._initial])
        r[: len(found)] = found
        return 0 if np.isfinite(found.sum()) else -1

    def jacobian(self, block: int) -> Sequence[Sequence[float]]:
        code, matrix = self._program.blocks[block], self._matrices.get(block)
        if matrix is None:
            m, n, at = len(code.residuals), len(code.tears), self._place.jacobian(block)
            matrix = self._matrices[block] = self._area[at : at + m * n].reshape(m, n)
        if code.residuals:
            self._evaluate(Mode.BELOW if code.height else Mode.MATRICES)
        found: list[list[float]] = matrix.tolist()
        return found

    def differences(
        self, t: float, u: Vector, columns: tuple[int, ...], slots: tuple[int, ...], below: bool
    ) -> Vector | None:
        table = self._table(t, u, columns, slots, below)
        out = np.empty((1 + len(columns), table.width))
        flag = self._call_differences(table.address, address(out))
        return None if flag else out

    def root(
        self,
        t: float,
        u: Vector,
        columns: tuple[int, ...],
        slots: tuple[int, ...],
        rows: Sequence[int],
        wanted: Vector,
    ) -> Vector | None:
        table, m = self._conditions(t, u, columns, slots), len(columns)
        out, places = self._room((1 + m) * table.width + m * (m + 7)), np.array(rows, np.int64)
        if self._call_root(table.address, address(places), address(wanted), out, m):
            return None
        found: Vector = self.w[self._candidate_slots]
        return found

    def motions(self, t: float, u: Vector, slots: tuple[int, ...], part: float) -> Vector | None:
        n = len(u)
        if n > LARGEST:
            return None
        table = self._conditions(t, u, tuple(range(n)), slots)
        q = np.empty((n, n))
        out = self._room((1 + n) * table.width)
        rank = self._call_motions(table.address, out, address(q), part)
        return q[rank:n].T if rank >= 0 else None

    def begin(
        self, t: float, plan: NDArray[np.int64], slots: tuple[int, ...]
    ) -> Sequence[list[Any]] | None:
        self._begin()
        self.w[0] = t
        n = len(self._candidate_slots)
        table, given = self._read(tuple(range(n)), slots, not slots), self._read((), slots, False)
        out = self._room(room(n, table.width))
        if self._call_begin(table.address, given.address, address(plan), out):
            return None
        told = self._scratch[: TOLD * n].reshape(TOLD, n)
        return [*told[:2].view(np.int64).tolist(), *told[2:].tolist()]

    def _room(self, numbers: int) -> int:
        """The address of room for what a call writes, and nobody reads behind it."""
        if numbers > len(self._scratch):
            self._scratch = np.empty(numbers)
            self._scratch_address = address(self._scratch)
        return self._scratch_address

    def _conditions(
        self, t: float, u: Vector, columns: tuple[int, ...], slots: tuple[int, ...]
    ) -> Table:
        """The table of all conditions at the start, for the workspace at `u`."""
        return self._table(t, u, columns, slots, not (slots or len(self._initial)))

    def _table(
        self, t: float, u: Vector, columns: tuple[int, ...], slots: tuple[int, ...], below: bool
    ) -> Table:
        """The table that `pc_differences` reads; the workspace is at `u`."""
        self._begin()
        self.w[0] = t
        self.w[self._candidate_slots] = u
        return self._read(columns, slots, below)

    def _read(self, columns: tuple[int, ...], slots: tuple[int, ...], below: bool) -> Table:
        key = columns, slots, below
        found = self._asked.get(key)
        if found is None:
            initial = 0 if below else len(self._initial)
            places = self._residual_places
            counts = (len(columns), len(places), initial, len(slots))
            moved = self._candidate_slots[list(columns)]
            mode = Mode.BELOW if below else Mode.GIVEN
            numbers = np.concatenate([(mode, *counts), moved, places, slots]).astype(np.int64)
            found = self._asked[key] = Table(numbers, address(numbers), sum(counts[1:]))
        return found

    def roots(self, t: float, y: Sequence[float], g: MutableSequence[float]) -> int:
        self._begin()
        self._y[:] = y
        flag = self._call_roots(t)
        g[:] = self._zeros.tolist()
        return flag

    def discrete(self) -> int:
        flag = self._call_discrete(float(self.w[0]))
        return flag or (-1 if np.isnan(self.w[self._discrete_slots]).any() else 0)

    # Derivatives

    def sweep(self, *given: Any) -> int:
        *arrays, most, tolerance = given
        return self._engine.sweep(*map(address, arrays), len(arrays[4]), most, tolerance)

    def cv_differences(self, matrix_numbers: int) -> int:
        self._frame[Frame.MATRIX] = matrix_numbers
        return self._engine.address("pc_cv_differences")

    def cv_jacobian(self, matrix_numbers: int) -> int:
        found = self._of("RATES")
        if found is None:
            return 0
        self._frame[Frame.MATRIX] = matrix_numbers
        found.prepare()
        self._frame[Frame.PASSING] = address(found.memory)
        return self._engine.address("pc_cv_jacobian")

    # Below the protocol

    def _solve(self, t: float, y: Sequence[float]) -> int:
        self._begin()
        self._y[:] = y
        return self._call_rhs(t)

    def _load(self, code: bytes, scope: Scope) -> NativeDerivatives:
        from planarc.solve.kernels.native.derivatives import NativeDerivatives

        self._engine.add(code)
        frame = address(self._frame)
        return NativeDerivatives(self._program, self._engine, scope, frame)

    def _evaluate(self, mode: Mode) -> int:
        self._begin()
        return self._call_evaluate(mode)

    def _begin(self) -> None:
        """Start blocks from the start values, at rest, before a point was accepted."""
        if self._started:
            return
        self._accepted.fill(0.0)
        self.w.take(self._tear_starts, out=self._first_tears, mode="clip")
        for block, values in self._settled.items():
            self._accepted[self._tears(block)] = values

    def _check_all(self) -> int:
        return 0 if _are_finite(self.w, self._results) else -1


def _are_finite(w: Vector, slots: Indices) -> bool:
    finite = np.isfinite(w.take(slots))
    return bool(np.count_nonzero(finite) == finite.size)


def _checked(
    react: Callable[..., int], w: Vector, results: Indices, discretes: Indices
) -> Callable[[Any, int], int]:
    """The call, and -1 where a value is no number. It does not hold the kernel, which holds it."""

    def call(memory: Any, ahead: int) -> int:
        flag = react(memory, ahead)
        good = flag == 0 and _are_finite(w, results) and not np.isnan(w[discretes]).any()
        return 0 if good else flag or -1

    return call
