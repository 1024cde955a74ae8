"""The one door to sympy: solves an equation for an unknown where the tree's rule cannot.

In:   a residual and one of its symbols, in which it is not affine by its form
Out:  the value of the symbol, or None

sympy is asked once for each *shape* of equation: its leaves are numbered in the order of
their first use, so that the same equation of eighty equal links is one question. Answers
are kept for the process, or by `memory` beyond it. sympy is imported when first asked;
equations that cannot have an answer are told before.

    (x + a)^2 - x^2 = b, a > 0      x = (b - a^2)/(2*a)     affine after all
    exp(x/T) = y                    x = T*log(y)            one function undone
    sqrt(x) = y                     None: x = y^2 forgets y >= 0
    atan2(y, x) = 0                 None: y = 0 forgets x > 0
    asin(x) = y, atan(x) = y        None: forgets the range of y
    x*x = L*L                       None: two branches
    a/x = b                         None: divides by b, which may vanish

So an unknown may stand only inside sums, products, whole powers and the functions whose
`inverse` is defined exactly where there is a solution.

Promises:  an answer is the only solution wherever there is one, and divides by nothing
           that may vanish.
"""

from __future__ import annotations

from collections.abc import Callable, MutableMapping
from typing import TYPE_CHECKING, Any

from planarc.ir.calculus import partial
from planarc.ir.expr import Expr, Exprs, Op, postorder
from planarc.runtime import elementary
from planarc.runtime.elementary import Sign
from planarc.structure.linear import Contents
from planarc.structure.shape import Shape, decode, read
from planarc.structure.signs import Signs

if TYPE_CHECKING:
    import sympy

_LARGEST = 60  # nodes of an equation that is still given to sympy
_HIGHEST = 6  # degree

#: Answers by shape: an expression in prefix form, or "" for none.
Memory = MutableMapping[str, str]

_process_memory: dict[str, str] = {}


class Algebra:
    """Answers for one model; `memory` may keep them on disk."""

    def __init__(
        self, table: Exprs, contents: Contents, signs: Signs, memory: Memory | None = None
    ) -> None:
        self._table = table
        self._contents = contents
        self._signs = signs
        self._memory = _process_memory if memory is None else memory

    def solve(self, residual: Expr, unknown: Expr) -> Expr | None:
        """The value of `unknown` where residual = 0, or None where that is not safe."""
        if not self._may_have_answer(residual, unknown):
            return None
        shape = Shape(residual, unknown, self._contents, self._signs)
        answer = self._memory.get(shape.key)
        if answer is None:
            answer = _ask(shape)
            self._memory[shape.key] = answer
        return decode(self._table, answer, shape.leaves) if answer else None

    def _may_have_answer(self, residual: Expr, unknown: Expr) -> bool:
        nodes = list(postorder((residual,)))
        if len(nodes) > _LARGEST:
            return False
        for e in nodes:
            if e.args and unknown in self._contents(e) and not _is_transparent(e):
                return False
        if _degree(nodes, unknown) > _HIGHEST:
            return False
        slope = partial(self._table, unknown)
        curvature = slope(slope(residual))
        # A curvature that does not depend on the unknown is that of a parabola.
        return curvature is self._table.zero or unknown in self._contents(curvature)


def _degree(nodes: list[Expr], unknown: Expr) -> float:
    """A bound of the degree of a polynomial when expanded; functions count as unknowns."""
    degree: dict[Expr, float] = {}
    for e in nodes:
        below = [degree[a] for a in e.args]
        match e.op:
            case Op.MUL | Op.DIV:
                degree[e] = sum(below)
            case Op.POW:
                degree[e] = below[0] * (abs(e.args[1].data) if e.args[1].is_const else 1)
            case Op.CALL:
                degree[e] = min(1, max(below, default=0))
            case _:
                degree[e] = max(below, default=float(e is unknown))
    return degree[nodes[-1]]


def _is_transparent(e: Expr) -> bool:
    match e.op:
        case Op.ADD | Op.NEG | Op.MUL | Op.DIV:
            return True
        case Op.POW:
            exponent = e.args[1]
            return exponent.is_const and exponent.data == int(exponent.data)
        case Op.CALL:
            return bool(elementary.TABLE[e.data].inverse)
    return False


# sympy -------------------------------------------------------------------------------------------


def _ask(shape: Shape) -> str:
    """The answer for a shape, as words; "" for none."""
    import sympy

    symbols = [_symbol(i, s) for i, s in enumerate(shape.signs)]
    x = symbols[shape.unknown]
    try:
        f = _to_sympy(shape.text, symbols)
        value = _solve_affine(f, x)
        if value is None and f.atoms(sympy.Function):
            value = _solve_monotone(f, x)
        return "" if value is None else " ".join(_from_sympy(value, symbols))
    except (_NoForm, NotImplementedError, ValueError, TypeError, sympy.PolynomialError):
        return ""


def _symbol(i: int, sign: Sign) -> sympy.Symbol:
    import sympy

    known = {
        Sign.PLUS: {"positive": True},
        Sign.MINUS: {"negative": True},
        Sign.PLUS | Sign.ZERO: {"nonnegative": True},
        Sign.MINUS | Sign.ZERO: {"nonpositive": True},
    }
    return sympy.Symbol(f"s{i}", **(known.get(sign) or {"real": True}))


def _solve_affine(f: Any, x: Any) -> Any:
    """-c0/c1 when f = c0 + c1*x after expansion and c1 never vanishes."""
    import sympy

    expanded = sympy.expand(f)
    if not expanded.is_polynomial(x):
        return None
    polynomial = sympy.Poly(expanded, x)
    if polynomial.degree() != 1:
        return None
    slope = sympy.factor(polynomial.coeff_monomial(x))
    if slope.is_nonzero is not True:
        return None
    return sympy.factor(-polynomial.coeff_monomial(1)) / slope


def _solve_monotone(f: Any, x: Any) -> Any:
    """Undo one function after the other, each affine in the next and all of x inside it."""
    import sympy

    inverse = {
        getattr(sympy, name): getattr(sympy, elementary.TABLE[name].inverse)
        for name in _invertible()
    }
    while True:
        outer = [a for a in f.atoms(sympy.Function) if a.has(x)]
        outer = [a for a in outer if not any(b is not a and b.has(a) for b in outer)]
        if len(outer) != 1:
            return None
        (function,) = outer
        w = sympy.Symbol("w", real=True)
        rest = f.subs(function, w)
        if rest.has(x):
            return None
        value = _solve_affine(rest, w)
        if value is None:
            return None
        f = function.args[0] - inverse[function.func](value)
        solved = _solve_affine(f, x)
        if solved is not None:
            return solved


def _invertible() -> list[str]:
    return sorted(row.name for row in elementary.TABLE.values() if row.inverse)


class _NoForm(Exception):
    """An expression that the other side does not know."""


def _to_sympy(text: str, symbols: list[Any]) -> Any:
    import sympy

    make: dict[str, Callable[..., Any]] = {
        "+": sympy.Add,
        "*": sympy.Mul,
        "~": lambda a: -a,
        "/": lambda a, b: a / b,
        "^": sympy.Pow,
        **{name: getattr(sympy, name) for name in _invertible()},
    }
    return read(
        text,
        symbols,
        lambda word: sympy.nsimplify(word, rational=True),
        lambda name, args: make[name](*args),
    )


def _from_sympy(root: Any, symbols: list[Any]) -> list[str]:
    import sympy

    number = {s: i for i, s in enumerate(symbols)}
    invertible = _invertible()
    words: list[str] = []
    stack = [root]
    while stack:
        e = stack.pop()
        if e in number:
            words.append(f"${number[e]}")
        elif e.is_Number:
            words.append(repr(float(e)))
        elif isinstance(e, sympy.Add | sympy.Mul):
            words.append(f"{'+' if isinstance(e, sympy.Add) else '*'}:{len(e.args)}")
            stack.extend(reversed(e.args))
        elif isinstance(e, sympy.Pow) and e.exp == -1:
            words.append("/:2")
            words.append("1.0")
            stack.append(e.base)
        elif isinstance(e, sympy.Pow) and e.exp == sympy.Rational(1, 2):
            words.append("sqrt:1")
            stack.append(e.base)
        elif isinstance(e, sympy.Pow):
            words.append("^:2")
            stack.extend((e.exp, e.base))
        elif type(e).__name__ in invertible:
            words.append(f"{type(e).__name__}:1")
            stack.append(e.args[0])
        elif isinstance(e, sympy.asinh):
            stack.append(sympy.log(e.args[0] + sympy.sqrt(e.args[0] ** 2 + 1)))
        elif isinstance(e, sympy.atanh):
            a = e.args[0]
            stack.append(sympy.log((1 + a) / (1 - a)) / 2)
        else:
            raise _NoForm(str(e))
    return words
