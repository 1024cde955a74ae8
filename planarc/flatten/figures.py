"""`annotation(Documentation(figures={Figure(plots={Plot(curves={Curve(y=a.phi)})})}))`.

Only curves of variables over time are kept: one of an expression, or over another variable,
is left out, as are figures that hold none.

Reference: Modelica Language Specification 3.6, section 18.4.3.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from planarc.flatten.annotation import arguments_of, binding_of, find_argument, inside
from planarc.flatten.tree import Instance, Session
from planarc.ir import syntax
from planarc.ir.figure import Figure, Plot


def figures_of(instance: Instance, session: Session) -> tuple[Figure, ...]:
    """Those of the model's own documentation."""
    arguments = arguments_of(instance.cls.definition.annotation, "figures", session)
    given = find_argument(inside(find_argument(arguments, "Documentation")), "figures")
    figures = (
        Figure(
            _text(call, "title"),
            tuple(p for p in (_plot(c) for c in _calls(_field(call, "plots"), "Plot")) if p.curves),
            _is_true(_field(call, "preferred")),
        )
        for call in _calls(binding_of(given), "Figure")
    )
    return tuple(figure for figure in figures if figure.plots)


def _plot(call: syntax.Call) -> Plot:
    over_time = (
        _field(curve, "y")
        for curve in _calls(_field(call, "curves"), "Curve")
        if _name(_field(curve, "x")) in (None, "time")
    )
    names = (_name(y) for y in over_time)
    return Plot(_text(call, "title"), tuple(name for name in names if name))


def _calls(value: syntax.Expression | None, name: str) -> Iterator[syntax.Call]:
    items: Iterable[syntax.Expression] = value.items if isinstance(value, syntax.Array) else ()
    for item in items:
        if isinstance(item, syntax.Call) and item.function.parts[-1].name == name:
            yield item


def _field(call: syntax.Call, name: str) -> syntax.Expression | None:
    return next((a.value for a in call.named if a.name == name), None)


def _text(call: syntax.Call, name: str) -> str:
    value = _field(call, name)
    return value.value if isinstance(value, syntax.String) else ""


def _is_true(value: syntax.Expression | None) -> bool:
    return isinstance(value, syntax.Boolean) and value.value


def _name(value: syntax.Expression | None) -> str | None:
    """Of a variable, as results name it; empty for any other expression."""
    if isinstance(value, syntax.Call) and str(value.function) == "der":
        inner = _name(value.arguments[0]) if len(value.arguments) == 1 else ""
        return f"der({inner})" if inner else ""
    if isinstance(value, syntax.Ref):
        return "".join(value.span.text.split())
    return None if value is None else ""
