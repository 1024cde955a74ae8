"""Values outside of `min` and `max`: of parameters, and start values.

In:   the variables with their attributes
Out:  a warning for each variable whose value is known now and lies outside

Reference: Modelica Language Specification 3.6, section 4.9.1.
"""

from __future__ import annotations

from planarc.core.diagnostic import PlanarcError
from planarc.flatten.terms.constant import NotConstant
from planarc.flatten.tree.nodes import Leaf, Session
from planarc.flatten.values.compute import flat_values
from planarc.flatten.values.evaluator import Evaluator
from planarc.ir import flat


def check_ranges(pairs: list[tuple[Leaf, flat.Variable | None]], session: Session) -> None:
    """Warn of values that their own declaration does not allow (F265)."""
    for leaf, v in pairs:
        if v is None or (v.attributes.min is None and v.attributes.max is None):
            continue
        what, value = "start value", v.attributes.start
        if v.variability <= flat.Variability.PARAMETER and v.binding is not None:
            what, value = "value", v.binding
        if value is None:
            continue
        found = _outside(value, v.attributes, session)
        if found is not None:
            number, side, bound = found
            session.warn(
                "F265",
                f"the {what} {number:.6g} of `{leaf.name}` lies {side} its {bound}",
                value.span,
            )


def _outside(
    value: flat.Expression, attributes: flat.Attributes, session: Session
) -> tuple[float, str, str] | None:
    numbers = _numbers(value, session)
    bounds = ((attributes.min, 1, "below", "minimum"), (attributes.max, -1, "above", "maximum"))
    for bound, sign, side, name in bounds:
        limits = [] if bound is None else _numbers(bound, session)
        if len(limits) == 1:
            limits *= len(numbers)
        for number, limit in zip(numbers, limits, strict=False):
            if sign * number < sign * limit:
                return number, side, f"{name} {limit:.6g}"
    return None


def _numbers(e: flat.Expression, session: Session) -> list[float]:
    """All entries, none where they are not known before the run."""
    try:
        values = flat_values(Evaluator(session).value(e))
    except (NotConstant, PlanarcError):
        return []
    return [float(v) for v in values if isinstance(v, int | float)]
