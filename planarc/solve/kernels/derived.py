"""What kernels of generated code share: derivatives, loaded when they are first asked for, and the
equation that a number which is not finite came from."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from planarc.ir.expr import text
from planarc.ir.program import Let, Program

if TYPE_CHECKING:
    from planarc.ir.derivatives import Scope
    from planarc.ir.kernel import Lead


class Derivatives(Protocol):
    """Derivatives of one scope: matrices, or None where a formula has no derivative at the
    point, or a block is singular."""

    def select(self, selection: Sequence[int]) -> None:
        """The choice of states."""

    def of_values(self, t: float, leaves: Sequence[int], rows: Sequence[int]) -> Any: ...


class Derived(ABC):
    """`Formulas`; `slopes` gives the code of a scope."""

    def __init__(
        self, program: Program, slopes: Callable[[Scope], Any] | None, lead: Lead | None
    ) -> None:
        self._program, self._slopes, self._lead = program, slopes, lead
        self.selection: Sequence[int] = ()
        self._derivatives: dict[str, Derivatives | None] = {}

    @abstractmethod
    def outputs(self, t: float, y: Sequence[float]) -> int: ...

    @abstractmethod
    def _solve(self, t: float, y: Sequence[float]) -> int:
        """Run `levels`."""

    @abstractmethod
    def _load(self, code: Any, scope: Scope) -> Derivatives: ...

    def _first_not_finite(self, w: Sequence[float]) -> int:
        """The first equation, in the order of evaluation, whose unknown is not finite, or -1."""
        program = self._program
        for statements in (program.parameters, *program.levels, program.rest, program.discrete):
            for s in statements:
                for let in (s,) if isinstance(s, Let) else program.blocks[s.block].body:
                    slot = program.slots.get(text(let.target))
                    if let.equation is not None and slot is not None and not math.isfinite(w[slot]):
                        return let.equation
        return -1

    def _choose(self, selection: Sequence[int]) -> None:
        self.selection = tuple(selection)
        for derivatives in self._derivatives.values():
            if derivatives is not None:
                derivatives.select(selection)

    def state_jacobian(self, t: float, y: Sequence[float]) -> Any:
        found = None if self._solve(t, y) else self._of("RATES")
        rates = [self._program.candidates[i].derivative for i in self.selection]
        return None if found is None else found.of_values(t, (), rates)

    def derivatives(
        self, t: float, y: Sequence[float], leaves: Sequence[int], rows: Sequence[int]
    ) -> Any:
        found = None if self.outputs(t, y) else self._of("ALL")
        return None if found is None else found.of_values(t, leaves, rows)

    def _of(self, which: str) -> Any:
        """The derivatives of a `Scope`, told by its name; None where there is no code."""
        if which not in self._derivatives:
            from planarc.ir.derivatives import Scope

            scope, made = Scope[which], None
            code = self._slopes(scope) if self._slopes is not None else None
            if code is not None:
                made = self._load(code, scope)
                made.select(self.selection)
            self._derivatives[which] = made
        return self._derivatives[which]
