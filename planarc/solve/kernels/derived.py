"""Derivatives of a kernel of generated code, loaded when they are first asked for."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from planarc.ir.expr import text
from planarc.ir.kernel import Unknowns
from planarc.ir.program import Program, Solve

if TYPE_CHECKING:
    from planarc.ir.derivatives import Scope


class Derivatives(Protocol):
    """Derivatives of one scope: matrices, or None where a formula has no derivative at the
    point, or a block is singular."""

    def select(self, selection: Sequence[int]) -> None:
        """The choice of states."""

    def by_states(self, t: float) -> Any: ...

    def of_values(self, t: float, leaves: Sequence[int], rows: Sequence[int]) -> Any: ...

    def of_residuals(self, t: float, unknowns: Unknowns) -> Any: ...


class Derived(ABC):
    """`Formulas` and the Jacobian of `ResidualForm`; `slopes` gives the code of a scope."""

    def __init__(self, program: Program, slopes: Callable[[Scope], Any] | None) -> None:
        self._program, self._slopes = program, slopes
        self._selection: tuple[int, ...] = ()
        self._derivatives: dict[str, Derivatives | None] = {}

    @abstractmethod
    def outputs(self, t: float, y: Sequence[float]) -> int: ...

    @abstractmethod
    def residual_form(
        self, t: float, y: Sequence[float], u: Sequence[float], unknowns: Unknowns
    ) -> tuple[int, Any, Any]: ...

    @abstractmethod
    def _solve(self, t: float, y: Sequence[float]) -> int:
        """Run `levels`."""

    @abstractmethod
    def _load(self, code: Any, scope: Scope) -> Derivatives: ...

    def _choose(self, selection: Sequence[int]) -> None:
        self._selection = tuple(selection)
        for derivatives in self._derivatives.values():
            if derivatives is not None:
                derivatives.select(selection)

    def unknowns(self) -> Unknowns:
        return _find_unknowns(self._program, self._selection)

    def state_jacobian(self, t: float, y: Sequence[float]) -> Any:
        found = None if self._solve(t, y) else self._of("RATES")
        return None if found is None else found.by_states(t)

    def derivatives(
        self, t: float, y: Sequence[float], leaves: Sequence[int], rows: Sequence[int]
    ) -> Any:
        found = None if self.outputs(t, y) else self._of("ALL")
        return None if found is None else found.of_values(t, leaves, rows)

    def residual_jacobian(
        self, t: float, y: Sequence[float], u: Sequence[float], unknowns: Unknowns
    ) -> Any:
        found = None if self.residual_form(t, y, u, unknowns)[0] else self._of("RATES")
        return None if found is None else found.of_residuals(t, unknowns)

    def _of(self, which: str) -> Any:
        """The derivatives of a `Scope`, told by its name; None where there is no code."""
        if which not in self._derivatives:
            from planarc.ir.derivatives import Scope

            scope, made = Scope[which], None
            code = self._slopes(scope) if self._slopes is not None else None
            if code is not None:
                made = self._load(code, scope)
                made.select(self._selection)
            self._derivatives[which] = made
        return self._derivatives[which]


def _find_unknowns(program: Program, selection: Sequence[int]) -> Unknowns:
    """The unknowns of the blocks that the right-hand side solves, for a choice of states."""
    states = set(selection)
    found = Unknowns([], [], [], [])
    solved = {s.block for level in program.levels for s in level if isinstance(s, Solve)}
    for i in sorted(solved):
        code = program.blocks[i]
        if not code.residuals:
            continue
        found.residuals.append((i, len(code.residuals)))
        for j, tear in enumerate(code.tears):
            if not code.height:
                found.slots.append(program.slots[text(tear)])
                found.rates.append(-1)
                found.nominals.append(-1)
            elif code.first + j not in states:
                c = program.candidates[code.first + j]
                found.slots.append(c.slot)
                found.rates.append(c.derivative)
                found.nominals.append(-1 if c.nominal is None else c.nominal)
    return found
