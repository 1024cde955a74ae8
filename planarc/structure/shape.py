"""The shape of an equation: what it is when its parts are only numbered.

In:   a residual and the unknown to solve it for
Out:  Shape   the residual as words, its parts without the unknown as numbered leaves

Example: exp(x/T) - cos(phi), for x

    +:2 exp:1 /:2 $0 $1 $2      leaves x, T, -cos(phi)

An operator stands with its count of arguments, before them.

So the same equation of eighty equal links has one shape. An answer is words, too, and
`decode` puts the leaves of the equation that asked back in.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from planarc.ir.expr import Expr, Exprs, Op
from planarc.structure.linear import Contents
from planarc.structure.signs import Signs

T = TypeVar("T")

_WORDS = {Op.ADD: "+", Op.MUL: "*", Op.NEG: "~", Op.DIV: "/", Op.POW: "^"}
_OPS = {word: op for op, word in _WORDS.items()}


class Shape:
    """A residual whose parts without the unknown are numbered leaves, as is the unknown.

    Equal shapes have equal keys; the signs that leaves may have belong to the key.
    """

    def __init__(self, residual: Expr, unknown: Expr, contents: Contents, signs: Signs) -> None:
        self.leaves: list[Expr] = []
        number: dict[Expr, int] = {}
        words: list[str] = []
        stack = [residual]
        while stack:
            e = stack.pop()
            if e.is_const:
                words.append(repr(float(e.data)))
            elif e is unknown or unknown not in contents(e):
                if e not in number:
                    number[e] = len(self.leaves)
                    self.leaves.append(e)
                words.append(f"${number[e]}")
            else:
                name = e.data if e.op is Op.CALL else _WORDS[e.op]
                words.append(f"{name}:{len(e.args)}")
                stack.extend(reversed(e.args))
        self.text = " ".join(words)
        self.unknown = number[unknown]
        self.signs = [signs(leaf) for leaf in self.leaves]
        self.key = f"{self.unknown}|{','.join(str(s.value) for s in self.signs)}|{self.text}"


def decode(table: Exprs, words: str, leaves: list[Expr]) -> Expr:
    """The expression that words stand for, with these leaves."""

    def node(name: str, args: Sequence[Expr]) -> Expr:
        op = _OPS.get(name)
        return table.make(op, tuple(args)) if op else table.call(name, *args)

    return read(words, leaves, lambda word: table.const(float(word)), node)


def read(
    words: str,
    leaves: Sequence[T],
    number: Callable[[str], T],
    node: Callable[[str, Sequence[T]], T],
) -> T:
    """The value of words, with what leaves, numbers and operators stand for."""
    stack: list[T] = []
    for word in reversed(words.split()):
        name, colon, count = word.partition(":")
        if word[0] == "$":
            stack.append(leaves[int(word[1:])])
        elif not colon:
            stack.append(number(word))
        else:
            stack.append(node(name, [stack.pop() for _ in range(int(count))]))
    return stack.pop()
