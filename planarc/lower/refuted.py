"""Why a library's text cannot be lowered: an assertion that the values it was given fail.

In:   an error in a library's text, the Model as far as it was lowered, FlatModel
Out:  the error in the words of assertions, at the values that these are about; else at the one part
      of the user's in whose equation or declaration it stands, where that is known

Example: `Ratchet ratchet(n=0)` divides by `n` for the angle from tooth to tooth (L303), and asks
for three teeth in an assertion, which says what to do.
"""

from __future__ import annotations

from collections.abc import Iterator

from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic, Explained, PlanarcError, Related
from planarc.core.source import NOWHERE, Span
from planarc.ir import flat
from planarc.ir.given import Given
from planarc.ir.places import is_own, own_part, point_home
from planarc.lower.scalar import lower_expression
from planarc.lower.scope import Model, Scope
from planarc.lower.values import Text, expr


def at_home(problem: PlanarcError, model: Model, source: flat.FlatModel) -> PlanarcError:
    """The error in words of what the user gave to a library, where it stands in one."""
    spans = [d.span for d in problem.diagnostics]
    if any(s is None or is_own(source, s) for s in spans):
        return problem
    first = problem.diagnostics[0]
    refuted = [_failed(source, first, e, text) for e, text in _refuted(model, source)]
    if refuted:
        return PlanarcError(refuted)
    return PlanarcError(_at_part(source, model, d) for d in problem.diagnostics)


def _refuted(model: Model, source: flat.FlatModel) -> Iterator[tuple[flat.Assert, str]]:
    """Assertions on the user's parts that do not hold with the values known so far, their texts."""
    for e in source.equations:
        if not isinstance(e, flat.Assert) or e.warning or is_own(source, e.span):
            continue
        if own_part(source, e.component) is None:
            continue
        scope = Scope(model, events=False)
        try:
            condition = model.number(expr(lower_expression(scope, e.condition)))
            text = lower_expression(scope, e.message)
        except PlanarcError:
            continue
        if condition.is_const and not condition.data and isinstance(text, Text) and text.constant:
            yield e, text.constant


def _failed(
    source: flat.FlatModel, came: Diagnostic, equation: flat.Assert, text: str
) -> Diagnostic:
    message = f"assertion failed in `{equation.component}`: {text}"
    of_it = Related(came.message, came.span, detail=True)
    found = Explained(came.code, message, equation.span, related=(of_it,))
    given = Given(source)(equation)
    if given is NOWHERE:
        return point_home(source, found, equation.component, "the assertion stands here")
    there = Related("the assertion stands here", equation.span, detail=True)
    return replace(found, span=given, related=(of_it, there))


def _at_part(source: flat.FlatModel, model: Model, found: Diagnostic) -> Diagnostic:
    """The message at the one part that it can be about."""
    assert found.span is not None
    # What is being lowered; parameters come first, when nothing of a component is.
    components = {model.component} if model.component else {*_components(source, found.span)}
    if len(components) != 1:
        return found
    (component,) = components
    part = own_part(source, component)
    if part is None:
        return found
    told = point_home(source, found, component)
    return replace(told, hint=f"check the values that `{part.name}` is given")


def _components(source: flat.FlatModel, span: Span) -> Iterator[str]:
    """The components whose declarations hold a place."""
    for v in source.variables:
        if v.binding is not None and v.binding.span.covers(span):
            yield v.component
