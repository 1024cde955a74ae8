"""Checks of parameters: each has a value, none depends on itself, lies outside its bounds or is
given in degrees or rpm.

Reference: Modelica Language Specification 3.6, sections 4.4.4, 4.9.1 and 8.6.
"""

from __future__ import annotations

from collections.abc import Container, Sequence

from planarc.core.diagnostic import (
    Diagnostic,
    PlanarcError,
    Related,
    Severity,
    Ungiven,
    UngivenOnce,
)
from planarc.core.order import Circle, in_order
from planarc.core.prose import ticked
from planarc.core.source import Span
from planarc.core.unit import RPM, looks_like_degrees, looks_like_rpm, of_per_cent, turns
from planarc.flatten.sections.alike import Variable
from planarc.flatten.terms.constant import NotConstant
from planarc.flatten.tree.demand import attributes_of
from planarc.flatten.tree.nodes import Leaf, Session
from planarc.flatten.values.compute import flat_values
from planarc.flatten.values.evaluator import Evaluator
from planarc.ir import flat
from planarc.ir.flatwalk import nodes_of

Pairs = list[tuple[Variable, flat.Variable | None]]


def check_parameters(pairs: Pairs, session: Session) -> None:
    """Report constants without a value and circles; warn of parameters without one."""
    parameters = {v.name: v for _, v in pairs if v and v.variability <= flat.Variability.PARAMETER}
    for leaf, variable in pairs:
        if variable is None or variable.binding is not None:
            continue
        if variable.variability is flat.Variability.CONSTANT:
            message = f"the constant `{leaf.name}` has no value"
            session.errors.append(Ungiven("F286", message, leaf.span))
        elif variable.variability is flat.Variability.PARAMETER and not _is_free(variable):
            _warn(leaf if isinstance(leaf, Leaf) else leaf.leaf, session)
    try:
        in_order(parameters, lambda name: _needed(parameters[name], parameters))
    except Circle as circle:
        session.errors.append(_circle_error(circle.names, parameters))


def _warn(leaf: Leaf, session: Session) -> None:
    """The start value is used (4.4.4), which a user should know."""
    start = attributes_of(leaf).start
    default = "0 is used" if leaf.type.base in _NUMBERS else "a default is used"
    used = default if start is None else f"its start value{_as_number(start)} is used"
    span, value = _place(leaf, session)
    session.warnings.append(
        UngivenOnce(
            "F286",
            f"the parameter `{leaf.name}` has no value: {used}",
            span,
            Severity.WARNING,
            hint=f"write a value, `{value}`",
            kind=f"{span.source.name}:{span.start} {value}",  # once for all members of an array
        )
    )


def _as_number(value: flat.Expression) -> str:
    number = _as_written(value)
    return "" if number is None else f" {number:.6g}"


def _place(leaf: Leaf, session: Session) -> tuple[Span, str]:
    """The innermost declaration in the user's text at which a value can be given, and how: that
    of a part, where the parameter belongs to one."""
    files = session.library.user_files()
    own = f"{leaf.element.name} = ..."
    found, value, owner = (leaf.span, own), own, leaf.parent
    while owner.element is not None and owner.parent is not None:
        value, span = f"{owner.element.name}({value})", owner.element.definition.span
        owner = owner.parent
        if span.source.name in files:
            return span, value
    return found


_NUMBERS = (flat.Base.REAL, flat.Base.INTEGER)


def _is_free(variable: flat.Variable) -> bool:
    """`fixed=false`: found by the initial equations."""
    fixed = variable.attributes.fixed
    return isinstance(fixed, flat.Literal) and fixed.value is False


def _needed(variable: flat.Variable, parameters: dict[str, flat.Variable]) -> list[str]:
    if variable.binding is None:
        return []
    parts = nodes_of((variable.binding,))
    names = [r.name for r in parts if isinstance(r, flat.Reference) and r.name in parameters]
    if variable.type.dims:  # entries of one array may depend on each other
        names = [n for n in names if n != variable.name]
    return names


def _circle_error(circle: list[str], parameters: dict[str, flat.Variable]) -> Diagnostic:
    first = circle[0]
    if len(circle) == 1:
        message = f"the value of `{first}` depends on itself"
    else:
        message = f"these parameters depend on each other in a circle: {ticked(circle)}"
    others = tuple(Related(f"`{n}` is declared here", parameters[n].span) for n in circle[1:])
    return Diagnostic("F282", message, parameters[first].span, related=others)


# Values that were hardly meant: outside of their bounds, or in degrees or rpm ---------


def check_ranges(pairs: Pairs, session: Session) -> None:
    """Warn of values that their own declaration does not allow (F265), of degrees and of rpm
    (F331)."""
    _check_nominals([v for _, v in pairs if v is not None], session)
    values = {leaf.name: (v, *_value(v)) for leaf, v in pairs if v is not None}
    outside: dict[str, tuple[flat.Expression, str, str | None]] = {}
    for name, (v, what, value) in values.items():
        if value is None:
            continue
        subject = f"the {what} {{}} of `{name}`"
        unit = v.attributes.unit
        if unit == "rad" or (v.attributes.quantity == "Angle" and unit != "deg"):
            _check_angle(subject, value, session)
        if unit == "m" and v.attributes.display_unit in _SHOWN_IN:
            _check_length(subject, value, v.attributes.display_unit, session)
        if unit == "rad/s" and v.attributes.quantity in ("", "AngularVelocity"):
            _check_speed(subject, value, session)
        if v.attributes.min is None and v.attributes.max is None:
            continue
        found = _outside(value, v.attributes, session)
        if found is not None:
            number, side, bound, limit = found
            message = f"the {what} {number:.6g} of `{name}` lies {side} its {bound} {limit:.6g}"
            share = of_per_cent(number, limit, v.attributes.unit)
            hint = None if share is None else f"if per cent are meant, write {share:.6g}"
            outside[name] = value, message, hint
    for value, message, hint in outside.values():
        if not _is_handed_on(value, outside):
            session.warn("F265", message, value.span, hint)


def _check_nominals(variables: Sequence[flat.Variable], session: Session) -> None:
    """Warn in the user's own text of a nominal value of 0, which is no size to measure by (4.9)."""
    files, seen = session.own_files(), set[Span]()
    for v in variables:
        nominal = v.attributes.nominal
        if nominal is None or nominal.span in seen or nominal.span.source.name not in files:
            continue
        seen.add(nominal.span)
        if 0 in _numbers(nominal, session):
            message = f"the nominal value 0 of `{v.name}` says nothing of its size"
            hint = "write how large it mostly is, or leave `nominal` out"
            session.warn("F265", message, nominal.span, hint)


def _value(v: flat.Variable) -> tuple[str, flat.Expression | None]:
    if v.variability <= flat.Variability.PARAMETER and v.binding is not None:
        return "value", v.binding
    return "start value", v.attributes.start


def _is_handed_on(value: flat.Expression, known: Container[str]) -> bool:
    """Whether a part hands its value on to a part in it, or to one of its other parameters, or what
    follows from it."""
    return any(isinstance(e, flat.Reference) and e.name in known for e in nodes_of((value,)))


def _check_angle(subject: str, value: flat.Expression, session: Session) -> None:
    angle = _as_written(value)
    if angle is not None and looks_like_degrees(angle):
        shown = f"{angle:.6g}"
        hint = f"if degrees are meant, write `Modelica.Units.Conversions.from_deg({shown})`"
        message = f"{subject.format(shown)} is in radian, {turns(angle)}"
        session.warn("F331", message, value.span, hint)


#: Units in which lengths are shown, their size in m, and the length in m from which one is hardly
#: meant that is shown so.
_SHOWN_IN = {"mm": 1e-3, "cm": 1e-2}
_LONG = 10


def _check_length(subject: str, value: flat.Expression, shown_in: str, session: Session) -> None:
    length = _as_written(value)
    if length is not None and abs(length) >= _LONG:
        shown, size = f"{length:.6g}", _SHOWN_IN[shown_in]
        hint = f"`displayUnit` only says how it is shown: write {length * size:.6g} for {shown} "
        message = f"{subject.format(shown)} is in m, {length / size:.6g} {shown_in}"
        session.warn("F331", message, value.span, f"{hint}{shown_in}")


def _check_speed(subject: str, value: flat.Expression, session: Session) -> None:
    speed = _as_written(value)
    behind = value.span.source.text[value.span.end :].lstrip()
    if behind.startswith('"'):  # what it is meant to be, which is told of by itself
        return
    if speed is not None and looks_like_rpm(speed):
        shown = f"{speed:.6g}"
        hint = f"if rpm are meant, write `Modelica.Units.Conversions.from_rpm({shown})`"
        message = f"{subject.format(shown)} is in rad/s, {speed / RPM:.0f} rpm"
        session.warn("F331", message, value.span, hint)


def _as_written(value: flat.Expression) -> float | None:
    """Only of numbers: a formula is meant to be in the unit that is declared."""
    sign, operand = (-1, value.operand) if isinstance(value, flat.Unary) else (1, value)
    if not isinstance(operand, flat.Literal) or not isinstance(operand.value, int | float):
        return None
    return sign * operand.value


def _outside(
    value: flat.Expression, attributes: flat.Attributes, session: Session
) -> tuple[float, str, str, float] | None:
    numbers = _numbers(value, session)
    bounds = ((attributes.min, 1, "below", "minimum"), (attributes.max, -1, "above", "maximum"))
    for bound, sign, side, name in bounds:
        limits = [] if bound is None else _numbers(bound, session)
        if len(limits) == 1:
            limits *= len(numbers)
        for number, limit in zip(numbers, limits, strict=False):
            if sign * number < sign * limit:
                return number, side, name, limit
    return None


def _numbers(e: flat.Expression, session: Session) -> list[float]:
    """All entries, none where they are not known before the run."""
    if isinstance(e, flat.Literal) and type(e.value) in (int, float):  # as most bounds are
        return [float(e.value)]
    try:
        values = flat_values(Evaluator(session).value(e))
    except (NotConstant, PlanarcError):
        return []
    return [float(v) for v in values if isinstance(v, int | float)]
