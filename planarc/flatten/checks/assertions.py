"""Assertions that no run can meet: they fail by the sizes of arrays alone, or by parameters with
which a library's text has no value.

In:   FlatModel, and the errors found so far
Out:  an error F288 for each, at the user's part, in place of what libraries say that came of it

Only of the user's own parts: a library's class that is checked by itself has not its values yet.

Example: `CombiTimeTable way(table=[0; 1])` has no column to interpolate, and says so by an
assertion; otherwise the first news were a `transpose` in the library that cannot be applied. Of
`GenevaWheel geneva(n=0)` they were a division by `n` in what is drawn.
"""

from __future__ import annotations

from collections.abc import Iterable

from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic, PlanarcError, Related
from planarc.core.source import NOWHERE
from planarc.flatten.sections.home import FromLibrary
from planarc.flatten.terms.constant import NotConstant
from planarc.flatten.tree.nodes import Session
from planarc.flatten.values.evaluator import Evaluator
from planarc.ir import flat
from planarc.ir.flatwalk import nodes_of
from planarc.ir.given import Given
from planarc.ir.places import own_part, point_home


def check_assertions(model: flat.FlatModel, session: Session) -> None:
    """Report assertions whose conditions are false whatever parameters are; with their present
    values where a library's text has none of its own."""
    users = session.library.user_files()
    parts = {p.name for p in model.parts if p.span.source.name in users}
    present = any(isinstance(d, FromLibrary) for d in session.errors)
    found = [d for d in session.errors if not isinstance(d, FromLibrary)]
    own = [d for d in found if d.span is None or d.span.source.name in users]
    failed = [
        e
        for e in model.equations
        if isinstance(e, flat.Assert) and e.component.partition(".")[0] in parts
        if _fails(e, session, present) and not _is_wrong(model, e.component, own)
    ]
    if not failed:
        return
    session.errors[:] = [*own, *(_impossible(model, e) for e in failed)]


def _is_wrong(model: flat.FlatModel, component: str, own: Iterable[Diagnostic]) -> bool:
    """Whether a mistake is known in what the user wrote of a part: its values are not meant."""
    part = own_part(model, component)
    return part is not None and any(d.span and part.span.covers(d.span) for d in own)


def _fails(equation: flat.Assert, session: Session, present: bool) -> bool:
    if equation.warning or not isinstance(equation.message, flat.Literal):
        return False
    named = any(isinstance(n, flat.Reference) for n in nodes_of((equation.condition,)))
    if named and not present:
        return False
    try:
        return Evaluator(session, mark=False).value(equation.condition) is False
    except (NotConstant, PlanarcError):
        return False


def _impossible(model: flat.FlatModel, equation: flat.Assert) -> Diagnostic:
    assert isinstance(equation.message, flat.Literal)
    where = f" in `{equation.component}`" if equation.component else ""
    message = f"assertion failed{where}: {equation.message.value}"
    found = Diagnostic("F288", message, equation.span)
    place = Given(model)(equation)
    if place is not NOWHERE:
        there = Related("the assertion stands here", equation.span, detail=True)
        return replace(found, span=place, related=(there,))
    return point_home(model, found, equation.component, "the assertion stands here")
