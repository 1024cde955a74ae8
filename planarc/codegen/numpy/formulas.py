"""Expressions as Python text.

A formula that stands inside a condition's branch is evaluated only when the
condition asks for it. A temporary that was taken out of such branches is evaluated
always, so its divisions and roots are written with `safe`, which gives nan instead
of an error.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from planarc.codegen.refusal import NotDifferentiable
from planarc.ir.expr import Expr, Op, postorder
from planarc.runtime import elementary

_TRUTHS = (Op.LESS, Op.LESS_EQUAL, Op.EQUAL, Op.AND, Op.OR, Op.NOT)

#: operator, binding strength as in Python's grammar
_OPERATORS: Mapping[Op, tuple[str, int]] = {
    Op.OR: (" or ", 2),
    Op.AND: (" and ", 3),
    Op.LESS: (" < ", 5),
    Op.LESS_EQUAL: (" <= ", 5),
    Op.EQUAL: (" == ", 5),
}
_ATOM = 20

Text = tuple[str, int]  # with its binding strength


def is_truth(e: Expr) -> bool:
    """Whether the value is True or False (and not a stored 1.0 or 0.0)."""
    while e.op is Op.IF:
        e = e.args[1]
    return e.op in _TRUTHS or (e.op is Op.CONST and isinstance(e.data, bool))


def formula(root: Expr, leaf: Callable[[Expr], str], *, careful: bool = False) -> str:
    """The expression as Python; `leaf` writes symbols, time, events and left limits, and the names
    of loops."""
    done: dict[Expr, Text] = {}
    for e in postorder((root,)):
        if e.op is Op.CONST:
            done[e] = _constant(e.data)
        elif not e.args:
            done[e] = leaf(e), _ATOM
        elif e.op is Op.LOOP:  # its function has a name, as a leaf has
            given = ", ".join(done[a][0] for a in e.args)
            done[e] = f"{leaf(e)}({given})[{e.data[1]}]", _ATOM
        else:
            done[e] = _node(e, [done[a] for a in e.args], careful)
    return done[root][0]


def _constant(value: float | bool) -> Text:
    if isinstance(value, bool):
        return str(value), _ATOM
    if not math.isfinite(value):
        return {math.inf: "inf", -math.inf: "(-inf)"}.get(value, "nan"), _ATOM
    return repr(value), 12 if math.copysign(1.0, value) < 0 else _ATOM


def _bound(part: Text, strength: int) -> str:
    return part[0] if part[1] >= strength else f"({part[0]})"


def _node(e: Expr, args: list[Text], careful: bool) -> Text:
    match e.op:
        case Op.ADD:
            first, *rest = (_bound(a, 10) for a in args)
            return first + "".join(
                f" - {t[1:]}" if t.startswith("-") else f" + {t}" for t in rest
            ), 10
        case Op.MUL:
            return "*".join(_bound(a, 11 if i == 0 else 13) for i, a in enumerate(args)), 11
        case Op.NEG:
            return "-" + _bound(args[0], 11), 10
        case Op.DIV if careful:
            return f"safe_div({args[0][0]}, {args[1][0]})", _ATOM
        case Op.DIV:
            return f"{_bound(args[0], 11)}/{_bound(args[1], 13)}", 11
        case Op.POW:
            return _power(e, args, careful)
        case Op.NOT:
            return "not " + _bound(args[0], 5), 4
        case Op.IF:
            condition, then, otherwise = args
            return f"({then[0]} if {condition[0]} else {otherwise[0]})", _ATOM
        case Op.CALL:
            return _call(e.data, [a[0] for a in args], careful), _ATOM
        case Op.PAST:
            delay, order = e.data
            return f"past({delay}, {order}, {args[0][0]})", _ATOM
        case Op.APPLY:
            function, output, wrt = e.data
            if wrt:
                raise NotDifferentiable(function)
            given = "".join(f"{a[0]}, " for a in args)
            return f"external({function!r}, {output}, ({given}))", _ATOM
        case _:
            sign, strength = _OPERATORS[e.op]
            tighter = strength + (strength == 5)
            return sign.join(_bound(a, tighter) for a in args), strength


def _call(function: str, args: list[str], careful: bool) -> str:
    row = elementary.TABLE.get(function)
    if careful and not (row and row.total):
        return f"safe({', '.join([function, *args])})"
    return f"{function}({', '.join(args)})"


def _power(e: Expr, args: list[Text], careful: bool) -> Text:
    exponent = e.args[1]
    if exponent.is_const and exponent.data == int(exponent.data) and abs(exponent.data) <= 8:
        n = int(exponent.data)
        base = _bound(args[0], 15)
        if args[0][1] == _ATOM and "(" not in base and abs(n) <= 3:
            product = "*".join([base] * abs(n))
            power = product, (_ATOM if abs(n) == 1 else 11)
        else:
            power = f"{base}**{abs(n)}", 14
        if n > 0:
            return power
        if careful:
            return f"safe_div(1.0, {power[0]})", _ATOM
        return f"1.0/{_bound(power, 13)}", 11
    return _call("pow", [args[0][0], args[1][0]], careful), _ATOM
