"""Assertions that no run can meet: they fail by the sizes of arrays alone.

In:   FlatModel, and the errors found so far
Out:  an error F288 for each, at the user's part, in place of what libraries say that came of it

Only of the user's own parts: a library's class that is checked by itself has not its values yet.

Example: `CombiTimeTable way(table=[0; 1])` has no column to interpolate, and says so by an
assertion; otherwise the first news were a `transpose` in the library that cannot be applied.
"""

from __future__ import annotations

from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.flatten.sections.home import FromLibrary
from planarc.flatten.terms.constant import NotConstant
from planarc.flatten.tree.nodes import Session
from planarc.flatten.values.evaluator import Evaluator
from planarc.ir import flat
from planarc.ir.flatwalk import nodes_of
from planarc.ir.places import point_home


def check_assertions(model: flat.FlatModel, session: Session) -> None:
    """Report assertions whose conditions are false whatever parameters are."""
    users = session.library.user_files()
    parts = {p.name for p in model.parts if p.span.source.name in users}
    failed = [
        e
        for e in model.equations
        if isinstance(e, flat.Assert) and e.component.partition(".")[0] in parts
        if _fails(e, session)
    ]
    if not failed:
        return
    found = [d for d in session.errors if not isinstance(d, FromLibrary)]
    own = [d for d in found if d.span is None or d.span.source.name in users]
    session.errors[:] = [*own, *(_impossible(model, e) for e in failed)]


def _fails(equation: flat.Assert, session: Session) -> bool:
    if equation.warning or not isinstance(equation.message, flat.Literal):
        return False
    if any(isinstance(n, flat.Reference) for n in nodes_of((equation.condition,))):
        return False
    try:
        return Evaluator(session).value(equation.condition) is False
    except (NotConstant, PlanarcError):
        return False


def _impossible(model: flat.FlatModel, equation: flat.Assert) -> Diagnostic:
    assert isinstance(equation.message, flat.Literal)
    where = f" in `{equation.component}`" if equation.component else ""
    message = f"assertion failed{where}: {equation.message.value}"
    found = Diagnostic("F288", message, equation.span)
    return point_home(model, found, equation.component, "the assertion stands here")
