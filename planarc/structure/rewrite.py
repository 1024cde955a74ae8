"""The rest of the model in the symbols that remain: relations, whens, assertions.

In:   Dae, the substitution of the eliminated variables
Out:  Dae whose relations, samplers, whens and assertions hold kept symbols only

`reinit(w, v)` of a variable that is -der(phi) becomes a reinit of der(phi) from -v.
Equations, variables and visuals stay as they were: messages and results speak of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from msgspec import field
from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.core.prose import either, shortened
from planarc.core.source import Span
from planarc.ir.actions import expressions_of, rewrite_action
from planarc.ir.dae import Action, Dae, Reinit, When
from planarc.ir.expr import Expr, Op, Substitution, brief, postorder, symbols

#: Names of states that a hint shows.
_SHOWN = 4


def rewrite_rest(dae: Dae, substitute: Substitution) -> Dae:
    return replace(
        dae,
        relations=tuple(replace(r, zero=substitute(r.zero)) for r in dae.relations),
        whens=tuple(_when(w, dae, substitute) for w in dae.whens),
        assertions=tuple(rewrite_action(a, dae.table, substitute) for a in dae.assertions),
    )


def expressions_of_rest(dae: Dae) -> Iterator[Expr]:
    """The values that are computed besides the continuous equations."""
    for relation in dae.relations:
        yield relation.zero
    for assertion in dae.assertions:
        yield from expressions_of(assertion)
    for when in dae.whens:
        for _, actions in when.branches:
            for action in actions:
                yield from expressions_of(action)
    for equation in (*dae.initial_equations, *dae.discrete_equations):
        yield equation.left
        yield equation.right


class Resets(Data):
    """The symbols that some `reinit` sets, which must stay states; those of them that no equation
    differentiates; the names of all variables that equations differentiate; and where each is
    set."""

    symbols: tuple[Expr, ...] = ()
    stateless: frozenset[Expr] = frozenset()
    states: tuple[str, ...] = ()
    spans: Mapping[Expr, Span] = field(default_factory=dict)

    @property
    def hint(self) -> str:
        """What to set instead."""
        names = shortened([f"`{name}`" for name in self.states], _SHOWN)
        here = f", here {names}" if names else ""
        return f"`reinit` sets states, whose `der` stands in the equations{here}"


NO_RESETS = Resets()


def find_resets(dae: Dae, rewrite: Substitution) -> Resets:
    """What is set by `reinit` in a model before its aliases are eliminated."""
    actions = (a for when in dae.whens for _, found in when.branches for a in found)
    reset = {a.symbol: a.span for a in actions if isinstance(a, Reinit)}
    if not reset:
        return NO_RESETS
    sides = (side for e in dae.equations for side in (e.left, e.right))
    moved = {s.name for s in symbols(*sides) if s.order}
    states = tuple(v.name for v in dae.variables if v.name in moved)
    kept = {s.name for s in symbols(*(rewrite(dae.table.symbol(name)) for name in states))}
    found = {s: span for r, span in reset.items() for s in symbols(rewrite(r))}
    stateless = frozenset(s for s in found if s.name not in kept)
    return Resets(tuple(found), stateless, states, found)


def _when(when: When, dae: Dae, substitute: Substitution) -> When:
    branches = tuple(
        (name, tuple(_action(a, dae, substitute) for a in actions))
        for name, actions in when.branches
    )
    return replace(when, branches=branches)


def _action(action: Action, dae: Dae, substitute: Substitution) -> Action:
    new = rewrite_action(action, dae.table, substitute)
    if isinstance(action, Reinit) and isinstance(new, Reinit):
        symbol = new.symbol
        if not symbol.is_symbol or symbol.name in {p.name for p in dae.parameters}:
            raise PlanarcError(
                Diagnostic(
                    "S312",
                    f"`reinit` of `{brief(action.symbol)}`, which is constant: {brief(symbol)}",
                    action.span,
                    hint=f"reinit a state: {either(_moving(dae))}",
                )
            )
    return new


def _moving(dae: Dae) -> list[str]:
    """Variables of which an equation holds the derivative; the first few."""
    roots = [side for e in dae.equations for side in (e.left, e.right)]
    names = (e.name for e in postorder(roots) if e.op is Op.SYMBOL and e.order)
    return list(dict.fromkeys(names))[:_SHOWN]


_SHOWN = 4
