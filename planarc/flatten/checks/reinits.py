"""States that several when-equations set anew.

In:   the equations of a model
Out:  warnings F321, in the user's own text

    when x > 1 then reinit(v, -v); end when;
    when x < 0 then reinit(v, -v); end when;      `elsewhen x < 0 then` of the first is meant

Both act as they are written; where they do at one instant, the later one counts. Other tools refuse
the model: a variable is set anew in one when-equation, whose branches have an order.

Reference: Modelica Language Specification 3.6, section 8.3.6.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from planarc.core.diagnostic import Diagnostic, Related, Severity
from planarc.flatten.tree.nodes import Session
from planarc.ir import flat
from planarc.ir.flatwalk import inside, variables_of_target


def check_reinits(equations: Iterable[flat.Equation], session: Session) -> None:
    """Warn of each `reinit` of what an earlier when-equation sets anew, too."""
    whens = [e for e in equations if isinstance(e, flat.WhenEquation)]
    if not whens:
        return
    from planarc.ir.text.flat import print_expression

    files = session.own_files()
    first: dict[str, tuple[flat.WhenEquation, flat.Reinit]] = {}
    for when in whens:
        for reinit, variable in _reinits(when):
            earlier, there = first.setdefault(print_expression(variable), (when, reinit))
            if earlier is not when and reinit.span.source.name in files:
                session.warnings.append(_told(reinit, there))


def _reinits(when: flat.WhenEquation) -> Iterator[tuple[flat.Reinit, flat.Reference]]:
    for item in inside((when,)):
        if isinstance(item, flat.Reinit):
            yield from ((item, variable) for variable in variables_of_target(item.variable))


def _told(reinit: flat.Reinit, there: flat.Reinit) -> Diagnostic:
    name = reinit.variable.span.text
    message = f"`{name}` is set anew in two whens: where both act at one instant, this one counts"
    hint = "make an `elsewhen` of one of them, as other tools ask for it"
    related = (Related("the other one", there.span),)
    return Diagnostic("F321", message, reinit.span, Severity.WARNING, hint, related)
