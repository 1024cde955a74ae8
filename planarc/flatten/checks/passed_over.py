"""Equations of branches that the values of parameters pass over: what they would have decided.

In:   the if-equations met, with the branch that was taken
Out:  Absent   for each branch passed over the variables in it, and why it is not there

Example: `if linear then b = 2*a; end if;` with `linear = false` leaves `b` without an equation.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, PlanarcError, Related, Undecided
from planarc.core.prose import listed
from planarc.core.source import Span
from planarc.flatten.tree.nodes import Chosen, Env
from planarc.flatten.values import evaluate
from planarc.ir import syntax
from planarc.ir.syntaxwalk import references_in


class Absent(Data):
    """What stands in a branch that is not there: variables by their full names, and as written."""

    component: str
    names: frozenset[str]
    where: str
    span: Span

    def holds(self, shown: str, component: str) -> bool:
        """Whether it holds a variable that messages about a component's class call so."""
        name = shown.partition("[")[0]
        if component == self.component and name in self.names:
            return True
        before = f"{self.component}." if self.component else ""
        return name.startswith(before) and name[len(before) :] in self.names


def passed_over(chosen: Iterable[Chosen]) -> Iterator[Absent]:
    """The branches that were not taken."""
    for node, taken, env in chosen:
        bodies = [*(body for _, body in node.branches), node.otherwise]
        conditions = [condition for condition, _ in node.branches]
        values = _values(conditions[: taken + 1], env)
        for number, body in enumerate(bodies):
            names = _decided(body) - _decided(bodies[taken])
            if number == taken or not names:
                continue
            at = conditions[number].span if number < len(conditions) else node.span
            where = f"where `{at.text}`" if number < len(conditions) else "in the `else`"
            yield Absent(env.component, names, f"{where}, but {values}", at)


def _decided(body: tuple[syntax.Equation, ...]) -> frozenset[str]:
    """The variables that equations give by their left sides; all of them where none is so."""
    sides = [e.left for e in body if isinstance(e, syntax.Equality)]
    refs = [s for s in sides if isinstance(s, syntax.Ref)] or references_in(body)
    return frozenset(".".join(r.names) for r in refs)


def _values(conditions: Iterable[syntax.Expression], env: Env) -> str:
    """`n` is 3 and `linear` is false."""
    found = {}
    for ref in references_in(tuple(conditions)):
        try:
            value = evaluate.try_value(env.typed(ref), env)
        except PlanarcError:
            continue
        if isinstance(value, bool | int | float | str):
            found[ref.span.text] = str(value).lower() if isinstance(value, bool) else f"{value}"
    return listed(f"`{name}` is {value}" for name, value in found.items()) or "another one holds"


def with_branch(told: Diagnostic, component: str, absent: Sequence[Absent]) -> Diagnostic:
    """The message about what nothing decides, with the branches that would decide it; or with
    those of the same component, as what is left over may be what follows from it."""
    if not isinstance(told, Undecided) or not told.names:
        return told
    near = [n for a in absent if a.component == component for n in sorted(a.names)]
    for name in dict.fromkeys((*told.names, *near)):
        notes = [
            Related(f"an equation of `{name}` stands {a.where}", a.span)
            for a in absent
            if a.holds(name, component)
        ]
        if notes:
            hint = f"say in all branches what `{name}` is"
            return replace(told, hint=hint, related=(*notes[:_SHOWN], *told.related))
    return told


_SHOWN = 2
