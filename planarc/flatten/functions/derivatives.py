"""Derivatives that a function's annotation names.

Reference: Modelica Language Specification 3.6, section 12.7.1.
"""

from __future__ import annotations

from planarc.core.diagnostic import PlanarcError
from planarc.flatten.tree.annotation import arguments_of, binding_of, find_argument, inside
from planarc.flatten.tree.demand import function_of
from planarc.flatten.tree.lookup import find_class
from planarc.flatten.tree.nodes import Class, Instance, Session
from planarc.ir import syntax


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
                info = function_of(find_class(scope, value), value.span)
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
