"""Drawings as scalar expressions: evaluated from results, never part of the run."""

from __future__ import annotations

from planarc.core.diagnostic import error
from planarc.core.source import Span
from planarc.ir import dae, flat
from planarc.ir.expr import Expr
from planarc.lower.scalar import lower_expression
from planarc.lower.scope import Model, Scope
from planarc.lower.values import Text, Value
from planarc.runtime.tensor import Tensor


def lower_visual(model: Model, visual: flat.Visual) -> dae.Visual:
    """A visual with every number in its attributes as an expression."""
    scope = Scope(model, events=False)
    attributes = tuple(
        (name, _plain(lower_expression(scope, value), visual.span))
        for name, value in visual.attributes
    )
    return dae.Visual(visual.component, visual.kind, attributes)


def lower_declared(model: Model, declared: flat.Declared) -> dae.Declared:
    """What a component says of itself, its value as an expression."""
    value = lower_expression(Scope(model, events=False), declared.value)
    plain = _plain(value, declared.value.span)
    return dae.Declared(declared.component, declared.kind, declared.name, plain)


def _plain(value: Value, span: Span) -> dae.VisualValue:
    if isinstance(value, Tensor):
        return tuple(_plain(row, span) for row in value.rows())
    if isinstance(value, Text):
        text = value.constant
        if text is None:
            raise error("L360", "a drawn text cannot change while running", span)
        return text
    if not isinstance(value, Expr):
        raise error("L361", "a visual's attribute must be a number, a text or an array", span)
    return value
