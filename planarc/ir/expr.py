"""Scalar expressions: immutable, shared, ordered by creation.

From `lower` to `codegen` every formula is a tree of `Expr`. Equal trees are the
same object (hash consing), so that comparing is `is`, differentiating and
printing are done once per distinct node, and common subexpressions are found by
counting. The table of shared nodes, `Exprs`, belongs to one compilation. It
builds nodes and applies only rules that are true for all finite values:

    x + 0 = x     2*x + 3*x = 5*x     x - x = 0     -(-x) = x     sin(0) = 0

All walks are iterative: chains are deeper than Python's recursion limit. Nodes
are ordered by `id`, their number of creation, never by address or hash.

The file is long because a node, its table and the folding rules know each other.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from enum import IntEnum
from typing import Any, TypeVar

from planarc.ir.loop import Loop
from planarc.runtime import elementary, external, texts

T = TypeVar("T")


class Op(IntEnum):
    """The operation of a node; in brackets its `data`."""

    CONST = 0  # [float or bool]
    SYMBOL = 1  # [(name, order)] a variable or parameter; order counts its der()
    TIME = 2
    PRE = 3  # [name] left limit of a discrete variable
    EVENT = 4  # [index] stored truth value of a relation, constant between events
    ADD = 5  # any number of terms
    MUL = 6  # any number of factors, a constant one first
    NEG = 7
    DIV = 8
    POW = 9
    CALL = 10  # [function name] one of `runtime.elementary`
    LESS = 11  # a < b, evaluated where it stands
    LESS_EQUAL = 12
    EQUAL = 13
    AND = 14
    OR = 15
    NOT = 16
    IF = 17  # (condition, then, otherwise)
    APPLY = 18  # [(function, output, wrt)] one of `external`; wrt: partial derivatives
    PAST = 19  # [(delay, order)] a delayed signal at the instant args[0]; order of derivative
    LOOP = 20  # [(loop, output)] what one of `ir.loop` leaves behind


#: Length from which sums and products stay whole inside others: taking a chain of them
#: apart again and again would cost the square of its length.
_MERGED = 256


#: Characters of an expression in a message, and what stands for parts that are too long.
_BRIEF, CUT = 500, "..."


# Where it counts, operations are compared by these names: until Python 3.12 an enumeration
# looks up its members by a function.
_CONST, _SYMBOL, _ADD, _MUL, _NEG = Op.CONST, Op.SYMBOL, Op.ADD, Op.MUL, Op.NEG
_DIV, _POW, _IF, _NOT = Op.DIV, Op.POW, Op.IF, Op.NOT
_CALL, _APPLY, _PAST = Op.CALL, Op.APPLY, Op.PAST


class Expr:
    """A node. Made by `Exprs` only; never changed."""

    __slots__ = ("args", "data", "id", "op")

    op: Op
    args: tuple[Expr, ...]
    data: Any
    id: int

    def __repr__(self) -> str:
        return text(self)

    def __lt__(self, other: Expr) -> bool:
        return self.id < other.id

    @property
    def name(self) -> str:
        """The variable's name, of a SYMBOL or PRE."""
        return self.data[0] if self.op is _SYMBOL else self.data  # type: ignore[no-any-return]

    @property
    def order(self) -> int:
        """The number of times that a SYMBOL is differentiated."""
        return self.data[1]  # type: ignore[no-any-return]

    @property
    def is_const(self) -> bool:
        return self.op is _CONST

    @property
    def is_symbol(self) -> bool:
        return self.op is _SYMBOL


class Exprs:
    """The table of shared nodes of one compilation, and the only maker of nodes."""

    def __init__(self) -> None:
        self._nodes: tuple[dict[Any, Expr], ...] = tuple({} for _ in Op)  # by operation
        self._symbols: dict[Any, Expr] = self._nodes[_SYMBOL]
        self._numbers: dict[float, Expr] = {}  # constants except zeros, truth values and nan
        self.all: list[Expr] = []  # by id
        self.texts: set[str] = set()  # those that numbers stand for
        self.zero = self.const(0.0)
        self.one = self.const(1.0)
        self.true = self.const(True)
        self.false = self.const(False)
        self.time = self.node(Op.TIME)

    def node(self, op: Op, args: tuple[Expr, ...] = (), data: Any = None) -> Expr:
        """The node as given, without any simplification."""
        key = args if data is None else (data, args) if args else data
        found = self._nodes[op].get(key)
        return self._new(key, op, args, data) if found is None else found

    def _plain(self, op: Op, args: tuple[Expr, ...]) -> Expr:
        """A node that has arguments and no data."""
        return self._nodes[op].get(args) or self._new(args, op, args, None)

    def _new(self, key: Any, op: Op, args: tuple[Expr, ...], data: Any) -> Expr:
        found = self._nodes[op][key] = Expr()
        found.op, found.args, found.data, found.id = op, args, data, len(self.all)
        self.all.append(found)
        return found

    # Leaves

    def const(self, value: float | bool) -> Expr:
        # Python calls True equal to 1.0 and -0.0 equal to 0.0, which are different nodes.
        if isinstance(value, bool) or not value or value != value:
            value = value if isinstance(value, bool) else float(value)
            key = repr(value)
            found = self._nodes[_CONST].get(key)
            return self._new(key, _CONST, (), value) if found is None else found
        found = self._numbers.get(value)
        if found is None:
            value = float(value)
            found = self._numbers[value] = self._new(repr(value), _CONST, (), value)
        return found

    def text(self, text: str) -> Expr:
        """The number that stands for a text."""
        self.texts.add(text)
        return self.const(texts.number_of(text))

    def symbol(self, name: str, order: int = 0) -> Expr:
        key = name, order
        found = self._symbols.get(key)
        return self._new(key, _SYMBOL, (), key) if found is None else found

    def symbols(self) -> list[Expr]:
        """All symbols so far, in the order of their creation."""
        return list(self._symbols.values())

    def knows(self, name: str) -> bool:
        """Whether there is a symbol of this name."""
        return (name, 0) in self._symbols

    def der(self, symbol: Expr) -> Expr:
        """The symbol differentiated once more."""
        return self.symbol(symbol.name, symbol.order + 1)

    def pre(self, name: str) -> Expr:
        return self.node(Op.PRE, (), name)

    def event(self, index: int) -> Expr:
        return self.node(Op.EVENT, (), index)

    # Arithmetic

    def add(self, *terms: Expr) -> Expr:
        coefficients: dict[Expr, float] = {}
        return self._sum(coefficients, self._gather(coefficients, 0.0, terms, 1.0))

    def _gather(
        self, coefficients: dict[Expr, float], constant: float, terms: Sequence[Expr], factor: float
    ) -> float:
        """Add factor*terms to a sum, and give its constant. Sums in sums are merged already, so
        that this goes a step or two deep."""
        for term in terms:
            op, number = term.op, factor
            while op is _NEG:
                term, number = term.args[0], -number
                op = term.op
            if op is _CONST:
                constant += number * term.data
            elif op is _ADD and len(term.args) <= _MERGED:
                constant = self._gather(coefficients, constant, term.args, number)
            else:
                if op is _MUL and term.args[0].op is _CONST:
                    own, term = self._split(term)
                    number *= own
                coefficients[term] = coefficients.get(term, 0.0) + number
        return constant

    def _sum(self, coefficients: dict[Expr, float], constant: float) -> Expr:
        parts = []
        for base, number in coefficients.items():
            if number != 0.0:
                parts.append(base if number == 1.0 else self.scale(number, base))
        if constant != 0.0 or not parts:
            parts.append(self.const(constant))
        return parts[0] if len(parts) == 1 else self._plain(_ADD, tuple(parts))

    def _split(self, term: Expr) -> tuple[float, Expr]:
        """A term as number times the rest."""
        if term.op is _MUL and term.args[0].op is _CONST:
            rest = term.args[1:]
            return term.args[0].data, rest[0] if len(rest) == 1 else self.node(_MUL, rest)
        return 1.0, term

    def scale(self, number: float, base: Expr) -> Expr:
        """number*base, for a base without a constant factor."""
        if number == 1.0:
            return base
        if number == -1.0:
            return self._plain(_NEG, (base,))
        return self.mul(self.const(number), base)

    def sub(self, a: Expr, b: Expr) -> Expr:
        coefficients: dict[Expr, float] = {}
        constant = self._gather(coefficients, 0.0, (a,), 1.0)
        return self._sum(coefficients, self._gather(coefficients, constant, (b,), -1.0))

    def neg(self, a: Expr) -> Expr:
        if a.op is _CONST:
            return self.const(0.0 if a.data == 0 else -a.data)
        if a.op is _NEG:
            return a.args[0]
        if a.op is _MUL and a.args[0].op is _CONST:
            number, base = self._split(a)
            return self.scale(-number, base)
        return self._plain(_NEG, (a,))

    def mul(self, *factors: Expr) -> Expr:
        powers: dict[Expr, int] = {}
        number = _multiply(powers, 1.0, factors)
        if number == 0.0:
            return self.zero
        parts = []
        for base, n in powers.items():
            parts.append(base if n == 1 else self.node(_POW, (base, self.const(n))))
        if not parts:
            return self.const(number)
        if number == -1.0:
            return self.neg(parts[0] if len(parts) == 1 else self.node(_MUL, tuple(parts)))
        if number != 1.0:
            parts.insert(0, self.const(number))
        return parts[0] if len(parts) == 1 else self._plain(_MUL, tuple(parts))

    def div(self, a: Expr, b: Expr) -> Expr:
        if b.op is _CONST and b.data != 0:
            if a.op is _CONST:
                return self.const(a.data / b.data)
            if b.data in (1.0, -1.0):
                return a if b.data == 1.0 else self.neg(a)
        if a.op is _CONST and a.data == 0 and not (b.op is _CONST and b.data == 0):
            return self.zero
        if a.op is _NEG:
            return self.neg(self.div(a.args[0], b))
        if b.op is _NEG:
            return self.neg(self.div(a, b.args[0]))
        return self.node(_DIV, (a, b))

    def pow(self, a: Expr, b: Expr) -> Expr:
        if b.op is _CONST:
            if b.data == 1:
                return a
            if b.data == 0:
                return self.one
            if a.op is _CONST:
                return self._folded(_POW, (a, b), None, lambda x, y: x**y)
        return self.node(_POW, (a, b))

    def call(self, function: str, *args: Expr) -> Expr:
        """A function of `runtime.elementary`."""
        if all(a.op is _CONST for a in args):
            return self._folded(_CALL, args, function, elementary.TABLE[function].value)
        return self.node(_CALL, args, function)

    def _folded(
        self, op: Op, args: tuple[Expr, ...], data: str | None, value: Callable[..., Any]
    ) -> Expr:
        """The value of a function of constants, or the call where it has none."""
        try:
            result = value(*(a.data for a in args))
        except (ValueError, OverflowError, ZeroDivisionError):
            return self.node(op, args, data)
        if isinstance(result, complex) or not math.isfinite(result):
            return self.node(op, args, data)
        return self.const(result)

    def apply(
        self, function: str, args: tuple[Expr, ...], output: int = 0, wrt: tuple[int, ...] = ()
    ) -> Expr:
        """One scalar output of a function of numbers in `external`, or its partial derivative.

        Array arguments and outputs count element by element; `wrt` lists the scalar
        arguments to differentiate by, in ascending order.
        """
        if not wrt and external.is_pure(function) and all(a.op is _CONST for a in args):
            return self.const(external.number(function, output, [a.data for a in args]))
        return self.node(_APPLY, args, (function, output, tuple(sorted(wrt))))

    def past(self, delay: int, instant: Expr, order: int = 0) -> Expr:
        """The signal of `Dae.delays[delay]` at an instant, or a derivative of it."""
        return self.node(_PAST, (instant,), (delay, order))

    def loop(self, loop: Loop, output: int, args: tuple[Expr, ...]) -> Expr:
        """A value behind a loop's last turn, or whether it ended: the last output of all."""
        return self.node(Op.LOOP, args, (loop, output))

    # Truth

    def _compared(self, op: Op, holds: Callable[[Any, Any], Any], a: Expr, b: Expr) -> Expr:
        if a.is_const and b.is_const:
            return self.const(bool(holds(a.data, b.data)))
        return self.node(op, (a, b))

    def less(self, a: Expr, b: Expr) -> Expr:
        return self._compared(Op.LESS, operator.lt, a, b)

    def less_equal(self, a: Expr, b: Expr) -> Expr:
        return self._compared(Op.LESS_EQUAL, operator.le, a, b)

    def equal(self, a: Expr, b: Expr) -> Expr:
        return self.true if a is b else self._compared(Op.EQUAL, operator.eq, a, b)

    def and_(self, a: Expr, b: Expr) -> Expr:
        if self.false in (a, b):
            return self.false
        if a is self.true or a is b:
            return b
        return a if b is self.true else self.node(Op.AND, (a, b))

    def or_(self, a: Expr, b: Expr) -> Expr:
        if self.true in (a, b):
            return self.true
        if a is self.false or a is b:
            return b
        return a if b is self.false else self.node(Op.OR, (a, b))

    def not_(self, a: Expr) -> Expr:
        if a.op is _CONST:
            return self.const(not a.data)
        return a.args[0] if a.op is _NOT else self.node(_NOT, (a,))

    def if_(self, condition: Expr, then: Expr, otherwise: Expr) -> Expr:
        if condition.op is _CONST:
            return then if condition.data else otherwise
        if then is otherwise:
            return then
        return self.node(_IF, (condition, then, otherwise))

    def rebuild(self, e: Expr, args: tuple[Expr, ...]) -> Expr:
        """The node with other arguments, simplified again."""
        if args == e.args:
            return e
        maker = _MAKERS.get(e.op)
        if maker is not None:
            return maker(self, *args)
        if e.op is _CALL:
            return self.call(e.data, *args)
        if e.op is _APPLY:
            function, output, wrt = e.data
            return self.apply(function, args, output, wrt)
        return self.node(e.op, args, e.data)

    def make(self, op: Op, args: tuple[Expr, ...]) -> Expr:
        """The node of an operator, simplified."""
        return _MAKERS[op](self, *args)


_MAKERS: Mapping[Op, Callable[..., Expr]] = {
    Op.ADD: Exprs.add,
    Op.MUL: Exprs.mul,
    Op.NEG: Exprs.neg,
    Op.DIV: Exprs.div,
    Op.POW: Exprs.pow,
    Op.LESS: Exprs.less,
    Op.LESS_EQUAL: Exprs.less_equal,
    Op.EQUAL: Exprs.equal,
    Op.AND: Exprs.and_,
    Op.OR: Exprs.or_,
    Op.NOT: Exprs.not_,
    Op.IF: Exprs.if_,
}


def _multiply(powers: dict[Expr, int], number: float, factors: Sequence[Expr]) -> float:
    """Multiply a product by factors, and give its number; as `Exprs._gather` for sums."""
    for factor in factors:
        op = factor.op
        while op is _NEG:
            number, factor = -number, factor.args[0]
            op = factor.op
        if op is _CONST:
            number *= factor.data
        elif op is _MUL and len(factor.args) <= _MERGED:
            number = _multiply(powers, number, factor.args)
        elif op is _POW:
            base, exponent = _power(factor)
            powers[base] = powers.get(base, 0) + exponent
        else:
            powers[factor] = powers.get(factor, 0) + 1
    return number


def _power(factor: Expr) -> tuple[Expr, int]:
    """A power as base and whole exponent above zero."""
    base, exponent = factor.args
    if exponent.is_const and exponent.data > 0 and exponent.data == int(exponent.data):
        return base, int(exponent.data)
    return factor, 1


# Walks ---------------------------------------------------------------------------------


def postorder(roots: Iterable[Expr]) -> list[Expr]:
    """Every distinct node below the roots, arguments before the nodes that use them."""
    seen: set[Expr] = set()
    found: list[Expr] = []
    for root in roots:
        if root in seen:
            continue
        path, e, rest = [], root, iter(root.args)
        while True:
            for a in rest:
                if a not in seen:
                    if a.args:
                        path.append((e, rest))
                        e, rest = a, iter(a.args)
                        break
                    seen.add(a)
                    found.append(a)
            else:
                seen.add(e)
                found.append(e)
                if not path:
                    break
                e, rest = path.pop()
    return found


def below(roots: Iterable[Expr]) -> list[Expr]:
    """The nodes of `postorder` in another order, in half the time: for whoever only looks for some
    of them."""
    found = list(dict.fromkeys(roots))
    seen = set(found)
    for e in found:
        for a in e.args:
            if a not in seen:
                seen.add(a)
                found.append(a)
    return found


def fold(root: Expr, memo: dict[Expr, T], of: Callable[[Expr], T]) -> T:
    """`of(root)`, asked after all nodes below it; each answer stands in `memo`."""
    if root in memo:
        return memo[root]
    path, e, rest = [], root, reversed(root.args)
    while True:
        for a in rest:
            if a not in memo:
                if a.args:
                    path.append((e, rest))
                    e, rest = a, reversed(a.args)
                    break
                memo[a] = of(a)
        else:
            found = memo[e] = of(e)
            if not path:
                return found
            e, rest = path.pop()


def symbols(*roots: Expr) -> list[Expr]:
    """The distinct symbols in the expressions, in the order of their first use."""
    seen: set[Expr] = set()
    found: list[Expr] = []
    todo = list(reversed(roots))
    while todo:
        e = todo.pop()
        if e not in seen:
            seen.add(e)
            if e.args:
                todo += e.args[::-1]
            elif e.op is _SYMBOL:
                found.append(e)
    return found


class Substitution:
    """Replaces nodes by others; remembers what it did, so one serves many equations.

    `mapping` is followed once (replacements are not searched again) and must not
    change after the first use.
    """

    def __init__(self, table: Exprs, mapping: Mapping[Expr, Expr]) -> None:
        self._table = table
        self._memo: dict[Expr, Expr] = dict(mapping)
        self._known = self._memo.__getitem__

    def __call__(self, root: Expr) -> Expr:
        return fold(root, self._memo, self._of) if root.args else self._memo.get(root, root)

    def _of(self, e: Expr) -> Expr:
        return self._table.rebuild(e, tuple(map(self._known, e.args)))


# Text ------------------------------------------------------------------------------------

_OPERATORS: Mapping[Op, tuple[str, int]] = {
    Op.OR: (" or ", 1),
    Op.AND: (" and ", 2),
    Op.LESS: (" < ", 4),
    Op.LESS_EQUAL: (" <= ", 4),
    Op.EQUAL: (" == ", 4),
    Op.MUL: ("*", 6),
    Op.DIV: ("/", 6),
    Op.POW: ("^", 8),
}


def symbol_text(name: str, order: int) -> str:
    """`x`, `der(x)`, `der(der(x))`."""
    return "der(" * order + name + ")" * order


def named(table: Exprs, shown: str) -> Expr:
    """The symbol that `symbol_text` shows so."""
    order = 0
    while shown.startswith("der(", 4 * order):
        order += 1
    return table.symbol(shown[4 * order : len(shown) - order], order)


def number_text(value: float | bool) -> str:
    """A constant as Modelica writes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return str(int(value)) if value == int(value) and abs(value) < 1e15 else repr(value)


def text(root: Expr, longest: int | None = None, relations: Sequence[str] = ()) -> str:
    """The expression in Modelica's notation, with as few parentheses as it needs.

    Parts whose text would have more than `longest` characters are written `...`: shared parts
    make texts far longer than the expression is large. `relations` are the texts of the stored
    truths; without them these are numbered.
    """
    if root.op is Op.SYMBOL:
        return symbol_text(*root.data)
    done: dict[Expr, tuple[str, int]] = {}  # text and binding strength
    for e in postorder((root,)):
        if e.op is Op.EVENT and relations:
            done[e] = relations[e.data], _OPERATORS[Op.LESS][1]
            continue
        done[e] = found = _text(e, [done[a] for a in e.args])
        if longest is not None and len(found[0]) > longest and e is not root:
            done[e] = CUT, 9
    return done[root][0]


def brief(root: Expr, relations: Sequence[str] = ()) -> str:
    """The expression for a message, on a few lines at most: parts that are too long are `...`."""
    found = ""
    for longest in (_BRIEF, _BRIEF // 4, _BRIEF // 16):
        found = text(root, longest, relations)
        if len(found) <= _BRIEF:
            return found
    return f"{found[:_BRIEF]} {CUT}"


def _text(e: Expr, args: list[tuple[str, int]]) -> tuple[str, int]:
    def bound(i: int, strength: int) -> str:
        return args[i][0] if args[i][1] >= strength else f"({args[i][0]})"

    match e.op:
        case Op.CONST:
            negative = not isinstance(e.data, bool) and e.data < 0
            finite = isinstance(e.data, bool) or math.isfinite(e.data)
            shown = texts.quoted(e.data) or number_text(e.data) if finite else repr(e.data)
            return shown, 5 if negative else 9
        case Op.SYMBOL:
            return symbol_text(*e.data), 9
        case Op.TIME:
            return "time", 9
        case Op.PRE:
            return f"pre({e.data})", 9
        case Op.EVENT:
            return f"event[{e.data}]", 9
        case Op.ADD:
            first, *rest = (bound(i, 5) for i in range(len(args)))
            return first + "".join(
                f" - {t[1:]}" if t.startswith("-") else f" + {t}" for t in rest
            ), 5
        case Op.NEG:
            return f"-{bound(0, 6)}", 5
        case Op.NOT:
            return f"not {bound(0, 4)}", 3
        case Op.IF:
            return f"if {args[0][0]} then {args[1][0]} else {args[2][0]}", 0
        case Op.CALL:
            return f"{e.data}({', '.join(a for a, _ in args)})", 9
        case Op.APPLY if e.data[0] == external.JOINED:
            forms = (texts.text_of(form.data) for form in e.args[1::2])
            pairs = zip(args[::2], forms, strict=True)
            return " + ".join(a if f == texts.TEXT else f"String({a})" for (a, _), f in pairs), 5
        case Op.APPLY:
            function, output, wrt = e.data
            marks = "".join(f"_d{i + 1}" for i in wrt) + (f"[{output + 1}]" if output else "")
            return f"{function}{marks}({', '.join(a for a, _ in args)})", 9
        case Op.PAST:
            delay, order = e.data
            return f"past{delay + 1}{chr(39) * order}({args[0][0]})", 9
        case Op.LOOP:
            loop, output = e.data
            return f"{loop.name}[{output + 1}]({', '.join(a for a, _ in args)})", 9
        case Op.DIV:
            return f"{bound(0, 6)}/{bound(1, 7)}", 6
        case Op.MUL if e.args[0].is_const and args[0][1] == 5:  # -2*a needs no parentheses
            return "*".join([args[0][0], *(bound(i, 6) for i in range(1, len(args)))]), 5
        case _:
            sign, strength = _OPERATORS[e.op]
            tighter = strength + (e.op in (Op.POW, Op.LESS, Op.LESS_EQUAL, Op.EQUAL))
            return sign.join(bound(i, tighter) for i in range(len(args))), strength
