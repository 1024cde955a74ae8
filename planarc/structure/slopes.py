"""Which variable may be the derivative of another one, by their units: for a hint.

In:   Dae, a variable that nothing decides
Out:  an equation to write, or None

Example: of `x`, `v` and `a` in m, m/s and m/s2, with `v = der(x)` and `m*a = f`: nothing decides
`a`, and `a = der(v)` is what was forgotten.
"""

from __future__ import annotations

from planarc.core import unit
from planarc.ir.dae import Dae, Variable
from planarc.ir.expr import Op, postorder


def likely_slope(dae: Dae, variable: Variable) -> str | None:
    """The equation by which a variable is the derivative of the only other one of its component
    that may be meant, or that one its own: none that has its derivative in an equation already."""
    own, second = unit.parse(variable.unit), unit.parse("s")
    if not variable.unit or own is None or second is None:
        return None
    sides = (side for e in dae.equations for side in (e.left, e.right))
    moved = {e.name for e in postorder(sides) if e.op is Op.SYMBOL and e.order}
    beside = {
        v.name: measure
        for v in dae.variables
        if v.unit and v.component == variable.component and v.name != variable.name
        if (measure := unit.parse(v.unit)) is not None
    }
    name = variable.name
    found = [
        f"{name} = der({other})"
        for other, measure in beside.items()
        if other not in moved and unit.divide(measure, second) == own
    ]
    if name not in moved:
        rate = unit.divide(own, second)
        found += [f"der({name}) = {other}" for other, measure in beside.items() if measure == rate]
    return found[0] if len(found) == 1 else None
