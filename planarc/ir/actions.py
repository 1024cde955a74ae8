"""What happens at events, as values: the expressions of an action, and the same with others."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeVar

from msgspec.structs import replace

from planarc.ir.dae import Action, Assertion, Impact, Message, Reinit, SetDiscrete, Terminate
from planarc.ir.expr import Expr, Exprs, Op

A = TypeVar("A", bound=Action)


def expressions_of(action: Action) -> Iterator[Expr]:
    match action:
        case SetDiscrete():
            yield action.value
        case Reinit():
            yield from (action.symbol, action.value)
        case Assertion():
            yield action.condition
            yield from _of_message(action.message)
        case Terminate():
            yield from _of_message(action.message)
        case Impact():
            yield from action.arguments


def _of_message(message: Message) -> Iterator[Expr]:
    yield from (part[0] for part in message.parts if not isinstance(part, str))


def rewrite_action(action: A, table: Exprs, rewrite: Callable[[Expr], Expr]) -> A:
    """The action with other expressions; `reinit(-x, v)` becomes `reinit(x, -v)`."""

    def message(given: Message) -> Message:
        return Message(
            tuple(p if isinstance(p, str) else (rewrite(p[0]), p[1]) for p in given.parts)
        )

    match action:
        case SetDiscrete():
            return replace(action, value=rewrite(action.value))
        case Assertion():
            condition = rewrite(action.condition)
            return replace(action, condition=condition, message=message(action.message))
        case Terminate():
            return replace(action, message=message(action.message))
        case Impact():
            return replace(action, arguments=tuple(map(rewrite, action.arguments)))
        case Reinit():
            symbol, value = rewrite(action.symbol), rewrite(action.value)
            if symbol.op is Op.NEG:
                symbol, value = symbol.args[0], table.neg(value)
            return replace(action, symbol=symbol, value=value)
    raise TypeError(f"no action: {action!r}")
