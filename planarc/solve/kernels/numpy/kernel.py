"""The NumPy back end's kernel: a program's generated text, run on a list of floats."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, MutableSequence, Sequence
from functools import lru_cache
from operator import itemgetter
from types import CodeType
from typing import TYPE_CHECKING, Any

from planarc.ir.kernel import Capabilities, Lead, taker
from planarc.ir.program import Program
from planarc.runtime.history import History
from planarc.solve.kernels.derived import Derived
from planarc.solve.kernels.numpy.block import (
    Block,
    NotFiniteError,
    UnsolvedError,
    by_columns,
)
from planarc.solve.kernels.numpy.pair import PairBlock
from planarc.solve.kernels.numpy.support import namespace

if TYPE_CHECKING:
    from planarc.ir.derivatives import Scope
    from planarc.solve.kernels.numpy.derivatives import NumpyDerivatives

_FILE = "<planarc numpy>"


@lru_cache(maxsize=16)
def _compiled(source: str) -> CodeType:
    return compile(source, _FILE, "exec")


class NumpyKernel(Derived):
    """See `planarc.ir.kernel.Kernel`."""

    def __init__(
        self,
        program: Program,
        source: str,
        slopes: Callable[[Scope], Any] | None = None,
        lead: Lead | None = None,
    ) -> None:
        super().__init__(program, slopes, lead)
        self.w: MutableSequence[float] = [0.0] * program.size
        self.failed_block = -1
        self.failed_equation = -1
        self._blocks = [
            (PairBlock if len(b.residuals) == 2 else Block)(i, b, program, self.w)
            for i, b in enumerate(program.blocks)
        ]
        self._modal = [b for b, c in zip(self._blocks, program.blocks, strict=True) if c.modal]
        self._below = [b for b, c in zip(self._blocks, program.blocks, strict=True) if c.height > 0]
        self._top = {i for i, b in enumerate(program.blocks) if b.height == 0}
        #: Blocks that start from accepted values; linear ones need them where they are open.
        self._starting = [
            b for b, c in zip(self._blocks, program.blocks, strict=True) if c.modal or not c.linear
        ]
        self.history = History(len(program.delays))
        own: dict[str, Any] = {"by_columns": by_columns, "past": self.history.value}
        self._functions: dict[str, Any] = {**namespace(), **own}
        exec(_compiled(source), self._functions)
        self._equations: Sequence[tuple[int, int]] = self._functions.get("equations", ())
        self._levels = self._functions["levels"]
        self._state_slots: list[int] = []
        self._rates = taker([])
        results = sorted({c.slot for c in program.columns if not c.constant})
        self._pick = itemgetter(0, 0, *results)  # twice the time, since one alone is no tuple
        self._started = False
        self._settled: dict[int, Sequence[float]] = {}
        for p in program.parameter_slots:
            if p.default is not None:
                self.w[p.slot] = p.default
        self.select(_first_states(program))

    @property
    def capabilities(self) -> Capabilities:
        return Capabilities(formulas=self, lead=self._lead)

    @property
    def near_singular(self) -> bool:
        return any(block.near for block in self._blocks)

    @property
    def open_block(self) -> int:
        return max((b.index for b in self._blocks if b.open), default=-1)

    def sway(self, block: int, amount: float) -> None:
        self._blocks[block].sway(amount)

    def origin(self, block: int) -> list[float]:
        if not self._started:
            self._begin()
        return self._blocks[block].origin()

    def settle(self, block: int, values: Sequence[float]) -> None:
        self._settled[block] = values
        self._blocks[block].begin(values)

    def be_content(self, content: bool = True) -> None:
        for block in self._blocks:
            block.content = content

    def expect_few_points(self) -> None:
        """Solve without LAPACK: importing it would take longer than all solutions."""
        for block in self._blocks:
            block.lapack = False

    def forgive(self) -> None:
        """Do not solve for accelerations and forces, which are not wanted by those who ask for
        positions alone. Where initial equations may need them, go on with zeros where there is
        no solution."""
        for block, code in zip(self._blocks, self._program.blocks, strict=True):
            needed = bool(self._program.initial_residuals)
            block.lenient = code.height == 0 and needed
            block.evaluating = code.height == 0 and not needed

    # The protocol

    def parameters(self) -> int:
        self._started = False
        self._settled.clear()
        self.be_content(False)
        return self._run("parameters")[0]

    def select(self, selection: Sequence[int]) -> None:
        program = self._program
        self._choose(selection)
        chosen = [program.candidates[i] for i in selection]
        self._state_slots = [c.slot for c in chosen]
        self._rates = taker([c.derivative for c in chosen])
        for block, code in zip(self._blocks, program.blocks, strict=True):
            if code.height:
                last = code.first + len(code.tears)
                block.select({i - code.first for i in selection if code.first <= i < last})

    def accept(self, t: float) -> None:
        self._started = True
        for block in self._starting:
            block.accept(t)

    def rhs(self, t: float, y: Sequence[float], ydot: MutableSequence[float]) -> int:
        code = self._solve(t, y)
        if code:
            return code
        ydot[:] = found = self._rates(self.w)
        total = sum(found)
        return 0 if total - total == 0.0 else self._not_finite()

    def outputs(self, t: float, y: Sequence[float]) -> int:
        return self._solve(t, y) or self._run("rest")[0] or self._check_all()

    def residuals(self, t: float, u: Sequence[float], r: MutableSequence[float]) -> int:
        self.w[0] = t
        for candidate, value in zip(self._program.candidates, _floats(u), strict=True):
            self.w[candidate.slot] = value
        code, initial = self._given("levels", "rest", "initial")
        if code and self.failed_block not in self._top:
            return code
        found = [value for block in self._below for value in block.residuals]
        found.extend(initial)
        r[: len(found)] = found  # places are known where forces have no solution
        return code or (0 if math.isfinite(sum(found)) else self._not_finite())

    def jacobian(self, block: int) -> Sequence[Sequence[float]]:
        asked = self._blocks[block]
        if self._program.blocks[block].residuals:
            asked.matrix_asked = True
            self._given("levels")
            asked.matrix_asked = False
        return asked.matrix

    def roots(self, t: float, y: Sequence[float], g: MutableSequence[float]) -> int:
        code = self._solve(t, y)
        if code:
            return code
        code, values = self._run("roots")
        if not code:
            for i, value in enumerate(values):  # g may be a bare C pointer
                g[i] = value
        return code

    def discrete(self) -> int:
        return self._run("discrete")[0]

    # Below the protocol

    def _solve(self, t: float, y: Sequence[float]) -> int:
        if not self._started:
            self._begin()
        w = self.w
        w[0] = t
        for slot, value in zip(self._state_slots, _floats(y), strict=True):
            w[slot] = value
        for block in self._modal:
            block.open = False
        try:
            self._levels(t, w, self._blocks)
        except (ArithmeticError, ValueError, UnsolvedError) as problem:
            return self._failed(problem)
        return 0

    def _load(self, code: str, scope: Scope) -> NumpyDerivatives:
        from planarc.solve.kernels.numpy.derivatives import NumpyDerivatives

        space = dict(self._functions)
        exec(_compiled(code), space)
        return NumpyDerivatives(space, self.w)

    def _run(self, function: str) -> tuple[int, Sequence[float]]:
        try:
            found = self._functions[function](self.w[0], self.w, self._blocks)
        except (ArithmeticError, ValueError, UnsolvedError) as problem:
            return self._failed(problem), ()
        return 0, found or ()

    def _given(self, *functions: str) -> tuple[int, Sequence[float]]:
        """Run functions with the candidates as they are in the workspace."""
        if not self._started:
            self._begin()
        for block in self._below:
            block.evaluating = True
        code = 0
        values: Sequence[float] = ()
        for function in functions:
            if not code:
                code, values = self._run(function)
        for block in self._below:
            block.evaluating = False
        return code, values

    def _begin(self) -> None:
        """Start blocks from the start values, before a point was accepted."""
        program, w = self._program, self.w
        starts = {c.slot: c.start for c in program.candidates} | dict(program.guesses)
        for block in self._blocks:
            block.begin(self._settled.get(block.index) or [w[starts[s]] for s in block.slots])

    # Failures

    def _failed(self, problem: Exception) -> int:
        """The return code; notes the block or the equation."""
        self.failed_block = self.failed_equation = -1
        trying = next((b.index for b in self._starting if b.trying), -1)
        for block in self._starting:
            block.done = True
        if isinstance(problem, UnsolvedError):
            self.failed_block = problem.block
            return 1
        if isinstance(problem, NotFiniteError):
            self.failed_equation = problem.equation
            return -1
        if trying >= 0:  # a step led where there are no numbers
            self.failed_block = trying
            return 1
        frame = problem.__traceback__
        while frame is not None:
            if frame.tb_frame.f_code.co_filename == _FILE:
                self.failed_equation = self._equation_at(frame.tb_lineno)
            frame = frame.tb_next
        return -1

    def _equation_at(self, line: int) -> int:
        """The equation of a line of the text: its own, or that which its value is for."""
        following = bisect_left(self._equations, (line, -1))
        return self._equations[following][1] if following < len(self._equations) else -1

    def _check_all(self) -> int:
        """The flag of a result that is not finite, after `rest`."""
        total = sum(self._pick(self.w))
        return 0 if total - total == 0.0 else self._not_finite()

    def _not_finite(self) -> int:
        self.failed_block = -1
        self.failed_equation = self._first_not_finite(self.w)
        return -1


def _floats(values: Sequence[float]) -> Sequence[float]:
    """Python floats, also from an array: NumPy's scalars are slow."""
    tolist = getattr(values, "tolist", None)
    return values[:] if tolist is None else tolist()  # a slice reads an array of C at once


def _first_states(program: Program) -> list[int]:
    """Some selection, until `select` is called."""
    return [code.first + i for code in program.blocks if code.height for i in range(code.free)]
