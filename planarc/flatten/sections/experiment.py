"""`annotation(experiment(StartTime, StopTime, Interval, Tolerance))` of the model.

Reference: Modelica Language Specification 3.6, section 18.4.
"""

from __future__ import annotations

from msgspec.structs import replace

from planarc.core.diagnostic import error
from planarc.flatten.tree.annotation import arguments_of, binding_of, find_argument, inside
from planarc.flatten.tree.nodes import Env, Instance, Scope, Session
from planarc.flatten.values import evaluate
from planarc.ir import flat, syntax


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
    env = Env(scope)
    value = evaluate.structural_value(env.typed(expression), env, f"`{name}` of the experiment")
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise error("F287", f"`{name}` of the experiment must be a number", expression.span)
    return float(value)
