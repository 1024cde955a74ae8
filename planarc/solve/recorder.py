"""The rows of a result, gathered while the run goes on.

Only what changes is stored, and each slot once however many names it has. The
arrays grow, so whoever keeps their addresses looks whether the `edition` is still his.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from struct import Struct
from typing import TYPE_CHECKING, Any

from planarc.core.diagnostic import error
from planarc.ir.kernel import Kernel, Taker, taker
from planarc.ir.once import once
from planarc.ir.program import Program

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from planarc.core.arrays import Vector

Take = Callable[["Vector"], None]

#: An event this near to a row asked for, as a part of the distance of rows, takes its place.
NEAR = 1e-9


class Recorder:
    """The rows taken from a kernel's workspace. `next` is the next row asked for in `grid`."""

    def __init__(
        self,
        program: Program,
        kernel: Kernel,
        grid: Vector,
        also: Iterable[int] = (),
    ) -> None:
        import numpy as np

        self.stored, self.slots = _columns(program)
        if more := [slot for slot in dict.fromkeys(also) if slot not in self.stored]:
            self.stored = self.stored | {s: i for i, s in enumerate(more, len(self.stored))}
            self.slots = np.array(list(self.stored), dtype=np.int64)
        self.grid = np.ascontiguousarray(grid)
        self.next = 0
        self.count = 0
        self.edition = 0
        self._looked = 0  # rows that are known to hold finite numbers
        self.near = NEAR * _nearest(grid)
        self._copy = _copier(kernel, self.slots)
        rows = len(grid) + 16
        try:
            self.time, self.data = np.empty(rows), np.empty((rows, len(self.slots)))
        except MemoryError:
            raise error(
                "R408",
                f"{len(grid)} rows of {len(self.slots)} numbers do not fit into memory",
                hint="choose a longer interval",
            ) from None

    def reserve(self, rows: int) -> None:
        """Make room for so many rows more. New arrays count one `edition` up."""
        import numpy as np

        need = self.count + rows
        if need > len(self.time):
            size = max(need, 3 * len(self.time) // 2)
            time, data = np.empty(size), np.empty((size, len(self.slots)))
            time[: self.count] = self.time[: self.count]
            data[: self.count] = self.data[: self.count]
            self.time, self.data = time, data
            self.edition += 1

    def take(self, t: float) -> None:
        """A row from the workspace's present values."""
        if self.count == len(self.time):
            self.reserve(1)
        self._copy(self.data[self.count])
        self.time[self.count] = t
        self.count += 1

    def first_not_finite(self) -> int | None:
        """The first of the rows taken since the last call that holds a number that is none."""
        import numpy as np

        begin, self._looked = min(self._looked, self.count), self.count
        finite = np.isfinite(self.data[begin : self.count])
        if np.count_nonzero(finite) == finite.size:
            return None
        return begin + int(finite.all(axis=1).argmin())

    def due(self, t: float) -> float | None:
        """The time of the next row asked for, if it is not after `t`."""
        if self.next < len(self.grid) and self.grid[self.next] <= t:
            return float(self.grid[self.next])
        return None

    def pass_by(self, t: float) -> None:
        """Rows asked for at `t` need not be taken any more."""
        while self.next < len(self.grid) and self.grid[self.next] <= t + self.near:
            self.next += 1

    def cut(self, count: int) -> None:
        """Forget the rows from `count` on."""
        self.count = min(count, self.count)
        self._looked = min(self._looked, self.count)

    def back(self, count: int, following: int) -> None:
        """Go back to so many rows, with row `following` of the grid to come."""
        self.count, self.next = count, following
        self._looked = min(self._looked, count)

    def keep_last(self) -> None:
        """Forget all rows but the last one."""
        if self.count:
            self.time[0] = self.time[self.count - 1]
            self.data[0] = self.data[self.count - 1]
            self.count = self._looked = 1

    def last(self) -> dict[int, float]:
        """The last row, by slot; nothing before there is one."""
        row = self.data[self.count - 1].tolist() if self.count else ()
        return dict(zip(self.stored, row, strict=False))

    def rows(self) -> tuple[Vector, Vector]:
        time, data = self.time[: self.count], self.data[: self.count]
        if 2 * self.count < len(self.time):  # a short run does not keep the room of a long one
            return time.copy(), data.copy()
        return time, data


def _nearest(grid: Vector) -> float:
    """The least distance of rows: all are equal but the last one, which may be shorter."""
    return float(min(grid[1] - grid[0], grid[-1] - grid[-2])) if len(grid) > 1 else 0.0


@once
def _columns(program: Program) -> tuple[dict[int, int], NDArray[np.int64]]:
    """The columns of variables that are no constants, by their slots; and these."""
    import numpy as np

    slots = list(dict.fromkeys(c.slot for c in program.columns if not c.constant))
    return {slot: i for i, slot in enumerate(slots)}, np.array(slots, dtype=np.int64)


class Constants(Mapping[int, float]):
    """Values that never change, by their slots. Few are ever asked for: a dictionary of all would
    take longer than a look at them."""

    def __init__(self, places: Mapping[int, int], values: Sequence[float]) -> None:
        self._places, self._values = places, values

    def __getitem__(self, slot: int) -> float:
        return float(self._values[self._places[slot]])

    def __iter__(self) -> Iterator[int]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)


@once
def _constants(program: Program) -> tuple[dict[int, int], Taker, NDArray[np.int64]]:
    """The places of constants among themselves, by their slots; and what takes these from a list,
    and from an array."""
    import numpy as np

    slots = tuple(dict.fromkeys(c.slot for c in program.columns if c.constant))
    places = {slot: place for place, slot in enumerate(slots)}
    return places, taker(slots), np.array(slots, dtype=np.int64)


def constants(program: Program, kernel: Kernel) -> Constants:
    """The values of constants."""
    places, take, slots = _constants(program)
    w: Any = kernel.w
    return Constants(places, take(w) if isinstance(w, list) else w.take(slots))


def _copier(kernel: Kernel, slots: NDArray[np.int64]) -> Take:
    """A function that copies the slots of the workspace into a row, the fastest way there is."""
    import numpy as np

    try:
        view = np.frombuffer(kernel.w, dtype=np.float64)  # type: ignore[call-overload]
    except (TypeError, ValueError, BufferError):
        w, pick = kernel.w, taker(slots.tolist())
        pack = Struct(f"{len(slots)}d").pack_into  # twice as fast as NumPy takes numbers

        def copy_list(row: Vector) -> None:
            pack(row.data, 0, *pick(w))

        return copy_list

    def copy_array(row: Vector) -> None:
        view.take(slots, out=row, mode="clip")  # the others copy the row once more

    return copy_array
