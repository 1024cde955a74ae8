"""What planarc reads from annotations: visuals, experiment, Evaluate, derivative.

Annotations are parsed only when their text holds a word that matters.

Reference: Modelica Language Specification 3.6, chapter 18 and section 12.7.1.
"""

from __future__ import annotations

from msgspec.structs import replace

from planarc.core.diagnostic import PlanarcError, error
from planarc.core.source import Span
from planarc.flatten.functions import functions
from planarc.flatten.tree import lookup
from planarc.flatten.tree.nodes import Class, Instance, Layout, Scope, Session
from planarc.flatten.typing import expressions
from planarc.flatten.typing.environment import Env
from planarc.flatten.values import evaluate
from planarc.ir import flat, syntax


def arguments_of(
    annotation: syntax.Annotation | None, word: str, session: Session
) -> tuple[syntax.Argument, ...]:
    """The arguments of an annotation that mentions `word`, parsed once."""
    if annotation is None:
        return ()
    key = id(annotation)
    known = session.annotations.get(key)
    if known is None:
        if word not in annotation.span.text:
            return ()
        known = annotation, session.library.parse_annotation(annotation)
        session.annotations[key] = known
    return known[1]


def find_argument(
    arguments: tuple[syntax.Argument, ...], name: str
) -> syntax.ElementModification | None:
    for argument in arguments:
        if isinstance(argument, syntax.ElementModification) and argument.name == (name,):
            return argument
    return None


def inside(argument: syntax.ElementModification | None) -> tuple[syntax.Argument, ...]:
    if argument is None or argument.modification is None:
        return ()
    return argument.modification.arguments


def binding_of(argument: syntax.ElementModification | None) -> syntax.Expression | None:
    if argument is None or argument.modification is None:
        return None
    return argument.modification.binding


def warn_obsolete(cls: Class, span: Span, session: Session) -> None:
    """`annotation(obsolete = "use B")`: whoever uses the class is told (18.7)."""
    arguments = arguments_of(cls.definition.annotation, "obsolete", session)
    argument = find_argument(arguments, "obsolete")
    if argument is not None:
        value = binding_of(argument)
        advice = value.value if isinstance(value, syntax.String) else None
        kind = cls.definition.kind.value
        session.warn("F266", f"the {kind} `{cls.name}` is obsolete", span, advice)


def visual_kind(cls: Class, session: Session) -> str | None:
    """`annotation(__planarc(visual="shape"))`: an instance is drawn, not simulated."""
    arguments = arguments_of(cls.definition.annotation, "__planarc", session)
    value = binding_of(find_argument(inside(find_argument(arguments, "__planarc")), "visual"))
    return value.value if isinstance(value, syntax.String) else None


def find_visual(layout: Layout, session: Session) -> None:
    """Notes in the layout of a class what its instances are drawn as."""
    if layout.visual is None:
        kinds = (visual_kind(part.cls, session) for part in layout.parts)
        layout.visual = next((kind for kind in kinds if kind), "")


def is_evaluated(annotation: syntax.Annotation | None, session: Session) -> bool:
    """`annotation(Evaluate=true)` on a parameter."""
    arguments = arguments_of(annotation, "Evaluate", session)
    value = binding_of(find_argument(arguments, "Evaluate"))
    return isinstance(value, syntax.Boolean) and value.value


def experiment_of(instance: Instance, session: Session) -> flat.Experiment:
    """`annotation(experiment(StartTime, StopTime, Interval, Tolerance))`."""
    found = flat.Experiment()
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
        found = replace(found, **{name: number})
    if found.stop < found.start:
        raise error(
            "F287",
            f"the experiment stops at {found.stop:g}, before it starts at {found.start:g}",
            None if annotation is None else annotation.span,
        )
    return found


_EXPERIMENT = {
    "StartTime": "start",
    "StopTime": "stop",
    "Interval": "interval",
    "Tolerance": "tolerance",
}


def _number(expression: syntax.Expression, scope: Scope, name: str) -> float:
    typed = expressions.type_expression(expression, Env(scope))
    value = evaluate.structural_value(typed, Env(scope), f"`{name}` of the experiment")
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise error("F287", f"`{name}` of the experiment must be a number", expression.span)
    return float(value)


def derivatives_of(instance: Instance, session: Session) -> tuple[tuple[str, int], ...]:
    """`annotation(derivative(order=2)=f_d)` of a function: functions and orders."""
    found = []
    scope = instance.scope()
    for part in instance.layout.parts:
        annotation = _function_annotation(part.cls, session)
        for argument in annotation:
            if not isinstance(argument, syntax.ElementModification):
                continue
            value = binding_of(argument)
            if argument.name != ("derivative",) or not isinstance(value, syntax.Ref):
                continue
            order = binding_of(find_argument(inside(argument), "order"))
            number = order.value if isinstance(order, syntax.Integer) else 1
            try:
                info = functions.function_of(lookup.find_class(scope, value), session, value.span)
            except PlanarcError:
                continue  # the function is differentiated itself
            if not info.bound:
                found.append((info.signature.name, number))
    return tuple(found)


def _function_annotation(cls: Class, session: Session) -> tuple[syntax.Argument, ...]:
    found = arguments_of(cls.definition.annotation, "derivative", session)
    body = cls.definition.body
    external = body.external if isinstance(body, syntax.Composition) else None
    if external is not None:
        found += arguments_of(external.annotation, "derivative", session)
    return found
