"""The generated text for arrays, run on the workspaces of many runs at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache, reduce
from types import CodeType
from typing import TYPE_CHECKING, Any

from planarc.evaluate.elementwise import functions
from planarc.ir.program import Program
from planarc.solve.batch.block import BatchBlock

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Numbers = NDArray[np.float64]
    Indices = NDArray[np.intp]


@lru_cache(maxsize=16)
def _compiled(source: str) -> CodeType:
    return compile(source, "<planarc batch>", "exec")


class BatchKernel:
    """`w` holds a number or an array over the runs for each slot.

    A run without a value somewhere gets nan in its derivatives, and the others go on.
    """

    def __init__(self, program: Program, source: str, workspaces: Sequence[Sequence[float]]):
        import numpy as np

        self.program, self.runs = program, len(workspaces)
        columns = np.array(workspaces, dtype=np.float64).T
        alike = (columns == columns[:, :1]).all(axis=1)
        #: NumPy's own numbers: dividing by zero gives infinity, not an error.
        self.w: list[Any] = [
            c[0] if same else c.copy() for c, same in zip(columns, alike.tolist(), strict=True)
        ]
        self.blocks = [BatchBlock(b, program, self.w, self.runs) for b in program.blocks]
        names: dict[str, Callable[..., Any]] = _namespace()
        exec(_compiled(source), names)
        self._levels, self._rest = names["levels"], names["rest"]
        self._slots = [c.slot for c in program.candidates]
        self._derivatives = [c.derivative for c in program.candidates]
        self._selection: Indices = np.zeros((program.state_count, self.runs), dtype=np.intp)
        self._used: list[int] = []

    def select(self, selection: Indices) -> None:
        """`selection[i, k]`: the candidate that state i of run k is."""
        import numpy as np

        self._selection = selection
        self._used = np.unique(selection).tolist()
        self._places = [np.nonzero(selection == c) for c in self._used]
        row = 0
        for block, code in zip(self.blocks, self.program.blocks, strict=True):
            if code.height and code.residuals:
                states = selection[row : row + code.free] - code.first
                free = np.zeros((len(code.tears), self.runs), dtype=bool)
                np.put_along_axis(free, states, True, axis=0)
                # Stable: the positions of what is solved for come first, in their order.
                block.select(np.argsort(free, axis=0, kind="stable")[: len(code.residuals)])
            row += code.free if code.height else 0

    def states(self, w: Sequence[Any] | None = None) -> Numbers:
        """Their present values (shape states x runs)."""
        return self._chosen(self._slots, self.w if w is None else w)

    def derivatives(self, w: Sequence[Any] | None = None) -> Numbers:
        return self._chosen(self._derivatives, self.w if w is None else w)

    def _chosen(self, slots: Sequence[int], w: Sequence[Any]) -> Numbers:
        import numpy as np

        values = np.empty(self._selection.shape)
        for c, (rows, runs) in zip(self._used, self._places, strict=True):
            values[rows, runs] = np.broadcast_to(w[slots[c]], (self.runs,))[runs]
        return values

    def rhs(self, t: Numbers, y: Numbers) -> Numbers:
        """States in, derivatives out (shapes states x runs)."""
        import numpy as np

        w = self.w
        w[0] = t
        for c, (rows, runs) in zip(self._used, self._places, strict=True):
            value = np.array(np.broadcast_to(w[self._slots[c]], (self.runs,)))
            value[runs] = y[rows, runs]
            w[self._slots[c]] = value
        with np.errstate(all="ignore"):
            self._levels(t, w, self.blocks)
        return self.derivatives()

    def outputs(self, t: Numbers, y: Numbers) -> None:
        """Fill every slot."""
        import numpy as np

        self.rhs(t, y)
        with np.errstate(all="ignore"):
            self._rest(t, self.w, self.blocks)

    def accept(self, t: Numbers, w: Sequence[Any], taken: NDArray[np.bool_]) -> None:
        """Nonlinear blocks of the runs `taken` start from the values in `w` from now on."""
        for block in self.blocks:
            block.accept(t, w, taken)


def _namespace() -> dict[str, Any]:
    """The only names that the text can reach."""
    import numpy as np

    return {
        "__builtins__": {},
        **functions(),
        "where": np.where,
        "logical_not": np.logical_not,
        "both": lambda *truths: reduce(np.logical_and, truths),
        "either": lambda *truths: reduce(np.logical_or, truths),
        "inf": np.inf,
        "nan": np.nan,
        "range": range,
        "by_columns": lambda columns: list(zip(*columns, strict=True)),
    }
