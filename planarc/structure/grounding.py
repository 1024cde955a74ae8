"""Networks of which only differences are known, as in a circuit without ground.

In:   Dae, and the unknowns that nothing determines
Out:  Diagnostic S303 in words of the network; None where equations say what a potential itself is

Potentials are the variables of connectors with one name. Where all of them may grow by the same
number and every equation still holds, no solver can tell what they are.

Example: of a battery, a resistor and a capacitor in a loop, all equations hold for 5 V and 0 V at
the battery's ends as well as for 105 V and 100 V.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from planarc.core.diagnostic import Diagnostic
from planarc.core.prose import shortened
from planarc.ir.dae import Dae, Equation
from planarc.ir.expr import Op, postorder
from planarc.ir.places import own_names, owner
from planarc.structure.linear import Contents, coefficients
from planarc.structure.places import owner_span

_SHOWN = 4


def find_ungrounded(dae: Dae, undetermined: Sequence[str]) -> Diagnostic | None:
    connectors = {c for names in dae.connections for c in names}
    for first in undetermined:
        kind = first.rpartition(".")[2]
        if owner(first) not in connectors:
            continue
        potentials = {
            v.name
            for v in dae.variables
            if owner(v.name) in connectors and v.name.rpartition(".")[2] == kind
        }
        if len(potentials) > 1 and all(_is_free(dae, e, potentials) for e in dae.equations):
            return _ungrounded(dae, kind, [n for n in undetermined if n in potentials])
    return None


def _is_free(dae: Dae, equation: Equation, potentials: Collection[str]) -> bool:
    """Whether an equation still holds when all potentials have grown by one number."""
    symbols = {e for e in postorder((equation.left, equation.right)) if e.op is Op.SYMBOL}
    if not any(e.name in potentials and not e.order for e in symbols):
        return True
    residual = dae.table.sub(equation.left, equation.right)
    factors = coefficients(dae.table, Contents(potentials.__contains__), residual)
    present = [f for e, f in factors.items() if not e.order]
    return None not in present and dae.table.add(*filter(None, present)) is dae.table.zero


def _ungrounded(dae: Dae, kind: str, open_ones: Sequence[str]) -> Diagnostic:
    parts = own_names(dae, (owner(owner(n)) for n in open_ones))
    shown = shortened([f"`{p}`" for p in parts if p], _SHOWN) or f"`{open_ones[0]}`"
    return Diagnostic(
        "S303",
        f"nothing grounds {shown}: only differences of `{kind}` are determined",
        owner_span(dae, owner(open_ones[0])),
        hint=f"connect one point of the network to a ground, which says what `{kind}` is there",
    )
