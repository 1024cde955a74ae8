"""The rest of the model in the symbols that remain: relations, whens, assertions.

In:   Dae, the substitution of the eliminated variables
Out:  Dae whose relations, samplers, whens and assertions hold kept symbols only

`reinit(w, v)` of a variable that is -der(phi) becomes a reinit of der(phi) from -v.
Equations, variables and visuals stay as they were: messages and results speak of them.
"""

from __future__ import annotations

from collections.abc import Iterator

from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.ir.dae import (
    Action,
    Assertion,
    Dae,
    Message,
    Reinit,
    SetDiscrete,
    Terminate,
    When,
)
from planarc.ir.expr import Expr, Op, Substitution, text


def rewrite_rest(dae: Dae, substitute: Substitution) -> Dae:
    return replace(
        dae,
        relations=tuple(replace(r, zero=substitute(r.zero)) for r in dae.relations),
        whens=tuple(_when(w, dae, substitute) for w in dae.whens),
        assertions=tuple(_assertion(a, substitute) for a in dae.assertions),
    )


def expressions_of_rest(dae: Dae) -> Iterator[Expr]:
    """The values that are computed besides the continuous equations."""
    for relation in dae.relations:
        yield relation.zero
    for assertion in dae.assertions:
        yield from _of_action(assertion)
    for when in dae.whens:
        for _, actions in when.branches:
            for action in actions:
                yield from _of_action(action)
    for equation in (*dae.initial_equations, *dae.discrete_equations):
        yield equation.left
        yield equation.right


def reset_symbols(dae: Dae) -> tuple[Expr, ...]:
    """The variables that some `reinit` sets: these must stay states."""
    found = (
        action.symbol
        for when in dae.whens
        for _, actions in when.branches
        for action in actions
        if isinstance(action, Reinit)
    )
    return tuple(dict.fromkeys(found))


def _of_action(action: Action) -> Iterator[Expr]:
    match action:
        case SetDiscrete():
            yield action.value
        case Reinit():
            yield action.symbol
            yield action.value
        case Assertion():
            yield action.condition
            yield from _of_message(action.message)
        case Terminate():
            yield from _of_message(action.message)


def _of_message(message: Message) -> Iterator[Expr]:
    for part in message.parts:
        if not isinstance(part, str):
            yield part[0]


def _when(when: When, dae: Dae, substitute: Substitution) -> When:
    branches = tuple(
        (name, tuple(_action(a, dae, substitute) for a in actions))
        for name, actions in when.branches
    )
    return replace(when, branches=branches)


def _action(action: Action, dae: Dae, substitute: Substitution) -> Action:
    match action:
        case SetDiscrete():
            return replace(action, value=substitute(action.value))
        case Reinit():
            return _reinit(action, dae, substitute)
        case Assertion():
            return _assertion(action, substitute)
        case Terminate():
            return replace(action, message=_message(action.message, substitute))


def _reinit(action: Reinit, dae: Dae, substitute: Substitution) -> Reinit:
    symbol, value = substitute(action.symbol), substitute(action.value)
    if symbol.op is Op.NEG:
        symbol, value = symbol.args[0], dae.table.neg(value)
    if not symbol.is_symbol or symbol.name in {p.name for p in dae.parameters}:
        raise PlanarcError(
            Diagnostic(
                "S312",
                f"`reinit` of `{text(action.symbol)}`, which is constant: {text(symbol)}",
                action.span,
                hint="reinit a state",
            )
        )
    return replace(action, symbol=symbol, value=value)


def _assertion(assertion: Assertion, substitute: Substitution) -> Assertion:
    return replace(
        assertion,
        condition=substitute(assertion.condition),
        message=_message(assertion.message, substitute),
    )


def _message(message: Message, substitute: Substitution) -> Message:
    return Message(
        tuple(p if isinstance(p, str) else (substitute(p[0]), p[1]) for p in message.parts)
    )
