"""Loops of expressions, and expressions of loops.

In:   symbols that turns change, the condition and what follows as expressions of them
Out:  a `Loop`, which belongs to no table, and the expressions that it is given

Promises:  what no turn changes is computed once, outside of the loop.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from planarc.ir.expr import Expr, Exprs, Op, postorder
from planarc.ir.loop import Loop


def close(
    name: str,
    carried: Sequence[Expr],
    condition: Expr,
    following: Sequence[Expr],
    aside: int = 0,
) -> tuple[Loop, tuple[Expr, ...]]:
    """The loop of expressions of the symbols `carried`, and what it is given: the largest parts
    that no turn changes. For `aside` see `Loop`."""
    varied = set(carried)
    below = postorder((condition, *following))
    varied.update(e for e in below if not varied.isdisjoint(e.args))
    # `postorder` names arguments first, so that one look finds all that hangs on what is carried.
    nodes = [e for e in below if e in varied and e.args]
    read = dict.fromkeys((*(a for e in nodes for a in e.args), condition, *following))
    given = [e for e in read if e not in varied and not e.is_const]
    own = [e for e in read if e.is_const] + nodes
    number = {e: i for i, e in enumerate((*carried, *given, *own))}
    written = tuple((e.op, tuple(number[a] for a in e.args), _told(e)) for e in own)
    ends = tuple(number[e] for e in following)
    return Loop(name, len(carried), len(given), written, number[condition], ends, aside), tuple(
        given
    )


def opened(table: Exprs, loop: Loop, values: Sequence[Expr]) -> tuple[Expr, tuple[Expr, ...]]:
    """The condition and what follows, as expressions of what is carried and given."""
    found = list(values)
    for op, args, data in loop.nodes:
        if op is Op.CONST:
            found.append(table.const(_number(data)))
        else:
            found.append(table.node(Op(op), tuple(found[a] for a in args), data))
    return found[loop.condition], tuple(found[i] for i in loop.following)


def applied(e: Expr) -> Iterator[tuple[str, int, tuple[int, ...]]]:
    """The functions of `runtime.external` that a node calls, with output and derivative: also those
    in the turns of a loop."""
    nodes: list[tuple[int, Any]] = [(e.op, e.data)]
    while nodes:
        op, data = nodes.pop()
        if op == Op.APPLY:
            yield data
        elif op == Op.LOOP:
            nodes += [(inner, told) for inner, _, told in data[0].nodes]


def symbols_of(table: Exprs, loop: Loop, mark: str = "") -> tuple[Expr, ...]:
    """Symbols that stand for what is carried and given."""
    return tuple(table.symbol(f"$turn{mark}{i}") for i in range(loop.carried + loop.given))


def _told(e: Expr) -> Any:
    return repr(e.data) if e.is_const else e.data


def _number(text: str) -> float | bool:
    return text == "True" if text in ("True", "False") else float(text)
