"""A node of an expression, and a loop, as Python text: straight lines on numbers.

Example: 2*x/y, x and y in slots 7 and 8          while y < x loop y := y*2; end while;

    v0 = 2.0                                      def loop(v0, v1):
    v1 = w(7)                                         for _ in range(100000):
    v2 = v0*v1                                            v2 = v0 < v1 ...
    v3 = w(8)                                             if v2 != v2: break
    v4 = DIV(v2, v3)                                      if not v2: return v0, 1.0
                                                          v4 = v0*v3 ...

What has no value is nan, and so is what hangs on it. The text is made of numbers and names here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from planarc.evaluate.operations import SAFE
from planarc.ir.closing import opened, symbols_of
from planarc.ir.expr import Expr, Exprs, Op, postorder
from planarc.ir.loop import LOST, MOST_TURNS, Loop

#: Terms of a sum written out: Python's compiler goes down into it term by term.
WRITTEN = 100

_COMPARED = {Op.LESS: "<", Op.LESS_EQUAL: "<=", Op.EQUAL: "=="}
#: The names that texts use.
NAMES: dict[str, Any] = {
    "sum": sum,
    "prod": math.prod,
    "range": range,
    "nan": math.nan,
    "inf": math.inf,
    **{op.name: function for op, function in SAFE.items()},
}

#: The text of a call, of a node and those of its arguments.
Call = Callable[[Expr, Sequence[str]], str]


def node_text(e: Expr, a: Sequence[str], leaf: Callable[[Expr], str], call: Call) -> str:
    """The text of a node, whose arguments have names."""
    match e.op:
        case Op.CONST:
            return repr(e.data)  # `nan` and `inf` are names
        case Op.ADD:
            return " + ".join(a) if len(a) <= WRITTEN else f"sum(({', '.join(a)}))"
        case Op.MUL:
            return "*".join(a) if len(a) <= WRITTEN else f"prod(({', '.join(a)}))"
        case Op.NEG:
            return f"-{a[0]}"
        case Op.CALL | Op.APPLY | Op.LOOP:
            return call(e, a)
        case Op.LESS | Op.LESS_EQUAL | Op.EQUAL:
            compared = f"{a[0]} {_COMPARED[e.op]} {a[1]}"
            return f"{compared} if {a[0]} == {a[0]} and {a[1]} == {a[1]} else {a[0]} + {a[1]}"
        case Op.IF:
            return f"{a[0]} if {a[0]} != {a[0]} else {a[1]} if {a[0]} else {a[2]}"
        case _ if e.op in SAFE:
            return f"{e.op.name}({', '.join(a)})"
    return leaf(e)


def loop_text(loop: Loop, name: str, call: Call) -> str:
    """The function of a loop: it takes what the loop takes, and gives a tuple of what it gives."""
    table = Exprs()
    symbols = symbols_of(table, loop)
    condition, following = opened(table, loop, symbols)
    names = {e: f"v{i}" for i, e in enumerate(symbols)}
    lines = [f"def {name}({', '.join(names.values())}):", f"    for _ in range({MOST_TURNS}):"]

    def write(*roots: Expr) -> None:
        for e in postorder(roots):
            if e not in names:
                formula = node_text(e, [names[a] for a in e.args], repr, call)
                names[e] = f"v{len(names)}"
                lines.append(f"        {names[e]} = {formula}")

    def tuple_of(values: Sequence[Expr], *more: str) -> str:
        return ", ".join((*map(names.__getitem__, values), *more))

    carried = symbols[: loop.carried]
    write(condition)
    test = names[condition]
    lines.append(f"        if {test} != {test}: return {'nan, ' * len(carried)}{LOST},")
    lines.append(f"        if not {test}: return {tuple_of(carried, '1.0')},")
    write(*following)
    if carried:
        lines.append(f"        {tuple_of(carried)} = {tuple_of(following)}")
    lines.append(f"    return {'nan, ' * len(carried)}0.0,")
    return "\n".join(lines)
