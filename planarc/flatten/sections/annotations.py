"""What annotations of the model say: its figures, and how it is run.

    annotation(Documentation(figures={Figure(plots={Plot(curves={Curve(y=a.phi)})})}))
    annotation(experiment(StartTime, StopTime, Interval, Tolerance))

Only curves over time are kept, of variables and of expressions made of them by elementary
operations; one over another variable is left out, as are figures that hold none.

Reference: Modelica Language Specification 3.6, section 18.4.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic, Severity, error
from planarc.core.options import MOST_ROWS
from planarc.core.source import Span
from planarc.flatten.tree.annotation import arguments_of, binding_of, find_argument, inside
from planarc.flatten.tree.nodes import Env, Instance, Scope, Session
from planarc.flatten.values import evaluate
from planarc.ir import flat, syntax
from planarc.ir.figure import Figure, Formula, Plot, Step
from planarc.runtime import elementary


def figures_of(instance: Instance, session: Session) -> tuple[Figure, ...]:
    """The figures of the model's own documentation."""
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
    curves: list[str] = []
    formulas: list[Formula] = []
    for y in over_time:
        if y is None:
            continue
        if name := _name(y):
            curves.append(name)
        elif (steps := _steps(y)) is not None:
            from planarc.ir.text.expression import expression_text

            formulas.append(Formula(expression_text(y), tuple(steps)))
            curves.append(formulas[-1].text)
    return Plot(_text(call, "title"), tuple(curves), tuple(formulas))


def _steps(value: syntax.Expression) -> list[Step] | None:
    """The steps that compute an expression, operands first; None where more is asked for."""
    match value:
        case syntax.Integer() | syntax.Real():
            return [float(value.value)]
        case syntax.Ref():
            return [("variable", _name(value) or "")]
        case syntax.Tuple(items=(inner,)) if inner is not None:
            return _steps(inner)
        case syntax.Unary(op="-" | ".-"):
            return _applied("negative", (value.operand,))
        case syntax.Unary(op="+" | ".+"):
            return _steps(value.operand)
        case syntax.Binary(op="+" | "-" | "*" | "/" | "^" | ".+" | ".-" | ".*" | "./" | ".^"):
            return _applied(value.op.lstrip("."), (value.left, value.right))
        case syntax.Call() if str(value.function) == "der" and _name(value):
            return [("variable", _name(value) or "")]
        case syntax.Call() if not value.named:
            name = str(value.function)
            row = elementary.TABLE.get(name)
            if row is not None and row.arity == len(value.arguments):
                return _applied(name, value.arguments)
    return None


def _applied(name: str, operands: Sequence[syntax.Expression]) -> list[Step] | None:
    parts = [_steps(operand) for operand in operands]
    if any(part is None for part in parts):
        return None
    return [*(step for part in parts for step in part or ()), ("apply", name)]


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
    """The name of a variable, as results have it; empty for any other expression."""
    if isinstance(value, syntax.Call) and str(value.function) == "der":
        inner = _name(value.arguments[0]) if len(value.arguments) == 1 else ""
        return f"der({inner})" if inner else ""
    if isinstance(value, syntax.Ref):
        return "".join(value.span.text.split())
    return None if value is None else ""


# The experiment -----------------------------------------------------------------------


def experiment_of(instance: Instance, session: Session) -> flat.Experiment:
    """`annotation(experiment(StartTime, StopTime, Interval, Tolerance))`."""
    found = flat.Experiment()
    written: dict[str, Span] = {}
    annotation = instance.cls.definition.annotation
    arguments = arguments_of(annotation, "experiment", session)
    for argument in inside(find_argument(arguments, "experiment")):
        if not isinstance(argument, syntax.ElementModification):
            continue
        name = _EXPERIMENT.get(argument.name[0])
        value = binding_of(argument)
        if name is None or value is None:
            continue
        number = _number(value, instance.scope(), argument.name[0])
        if name in ("interval", "tolerance") and number <= 0:
            raise error(
                "F287", f"`{argument.name[0]}` of the experiment must be positive", value.span
            )
        if name == "tolerance" and number >= 1:
            message = f"`Tolerance` of the experiment must lie below 1, not at {number:g}"
            raise error("F287", message, value.span, hint="choose for example 1e-6")
        found, written[name] = replace(found, **{name: number}), value.span
    if found.stop < found.start:
        message = f"the experiment stops at {found.stop:g}, before it starts at {found.start:g}"
        raise error("F287", message, None if annotation is None else annotation.span)
    length = found.stop - found.start
    if found.interval is not None and found.interval > length > 0:
        message = (
            f"the rows lie {found.interval:g} s apart, but the experiment lasts {length:g} s only"
        )
        hint = f"write a part of it, such as `Interval={length / 500:g}`"
        session.warnings.append(
            Diagnostic("F287", message, written["interval"], Severity.WARNING, hint=hint)
        )
    if found.interval is not None and length > MOST_ROWS * found.interval:
        message = f"the experiment asks for {length / found.interval:.3g} rows, which are too many"
        hint = f"choose a longer interval, such as `Interval={length / 500:g}`"
        session.warnings.append(
            Diagnostic("F287", message, written["interval"], Severity.WARNING, hint=hint)
        )
    return found


_EXPERIMENT = {
    "StartTime": "start",
    "StopTime": "stop",
    "Interval": "interval",
    "Tolerance": "tolerance",
}


def _number(expression: syntax.Expression, scope: Scope, name: str) -> float:
    env = Env(scope)
    value = evaluate.structural_value(env.typed(expression), env, f"`{name}` of the experiment")
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise error("F287", f"`{name}` of the experiment must be a number", expression.span)
    return float(value)
