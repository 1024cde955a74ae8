"""Blocks that change their shape at events.

In:   the steps that are computed while running, in their order; the Dae for its discrete variables
Out:  `Modes`, which tells of a block whether its matrix depends on discrete values

Example: `mass := if event[0] then 2 else 0` switches; mass*der(v) = f is a modal block.

Needs:     every step that a block depends on is among the steps before it.
"""

from __future__ import annotations

from collections.abc import Iterable

from planarc.codegen.derive import Derived
from planarc.ir.dae import Dae
from planarc.ir.expr import Expr, Op, postorder
from planarc.ir.sorted import Assignment


class Modes:
    def __init__(self, dae: Dae, steps: Iterable[Derived | Assignment]) -> None:
        self._present = bool(dae.discretes or dae.relations or dae.samplers)
        self._discretes = frozenset(v.name for v in dae.discretes)
        self._switching: set[Expr] = set()
        for step in steps if self._present else ():
            for a in step.inner:
                if self._switches((a.value,)):
                    self._switching.add(a.target)

    def is_modal(self, derived: Derived) -> bool:
        """Whether the matrix of a block of the top level depends on discrete values."""
        if not self._present or derived.height or not derived.block.residuals:
            return False
        slopes = [value for _, value in derived.steps] + [v for _, _, v in derived.entries]
        if derived.tangent is not None:
            slopes += [v for _, v in derived.tangent.steps] + list(derived.tangent.entries)
        return self._switches(slopes)

    def _switches(self, formulas: Iterable[Expr]) -> bool:
        return any(
            e.op in (Op.EVENT, Op.PRE)
            or e in self._switching
            or (e.op is Op.SYMBOL and e.name in self._discretes)
            for e in postorder(formulas)
        )
