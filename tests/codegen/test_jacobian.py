"""Jacobians of torn blocks against sympy, inner assignments put in."""

from __future__ import annotations

import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from planarc.codegen import jacobian as forward
from planarc.codegen.factoring import Factoring
from planarc.evaluate.value import evaluate
from planarc.ir.expr import Expr, Exprs, Op, postorder
from planarc.ir.sorted import Assignment


def to_sympy(root: Expr) -> sympy.Expr:
    done: dict[Expr, sympy.Expr] = {}
    for e in postorder((root,)):
        a = [done[x] for x in e.args]
        match e.op:
            case Op.CONST:
                done[e] = sympy.Float(e.data)
            case Op.SYMBOL:
                done[e] = sympy.Symbol(e.name)
            case Op.ADD:
                done[e] = sympy.Add(*a)
            case Op.MUL:
                done[e] = sympy.Mul(*a)
            case Op.NEG:
                done[e] = -a[0]
            case Op.DIV:
                done[e] = a[0] / a[1]
            case Op.POW:
                done[e] = a[0] ** int(e.args[1].data)
            case _:
                done[e] = getattr(sympy, e.data)(*a)
    return done[root]


@st.composite
def blocks(
    draw: st.DrawFn,
) -> tuple[Exprs, tuple[Expr, ...], tuple[tuple[Expr, Expr], ...], tuple[Expr, ...]]:
    """Tears, inner assignments, residuals of random shape."""
    t = Exprs()
    tears = tuple(t.symbol(f"x{i}") for i in range(draw(st.integers(1, 3))))
    known = [*tears, t.symbol("p")]
    pick = st.integers(0, 10**6)

    def formula() -> Expr:
        a, b, c = (known[draw(pick) % len(known)] for _ in range(3))
        return draw(
            st.sampled_from(
                [
                    t.add(a, t.neg(b), t.mul(a, c)),
                    t.mul(a, b, t.const(2.0)),
                    t.mul(t.call("sin", a), b),
                    t.add(t.call("cos", t.add(a, b)), c),
                    t.div(a, t.add(t.const(3.0), t.mul(b, b))),
                    t.pow(t.add(a, c), t.const(3.0)),
                    a,
                ]
            )
        )

    inner = []
    for i in range(draw(st.integers(0, 5))):
        inner.append((t.symbol(f"a{i}"), formula()))
        known.append(inner[-1][0])
    return t, tears, tuple(inner), tuple(formula() for _ in tears)


POINT = {"x0": 0.3, "x1": -0.7, "x2": 1.1, "p": 0.4}


@settings(max_examples=80)
@given(blocks())
def test_both_forms_are_the_derivatives_that_sympy_finds(
    block: tuple[Exprs, tuple[Expr, ...], tuple[tuple[Expr, Expr], ...], tuple[Expr, ...]],
) -> None:
    t, tears, inner, residuals = block
    values = dict(POINT)
    replaced: dict[sympy.Expr, sympy.Expr] = {}
    factoring = Factoring(t)
    for symbol, value in inner:
        values[symbol.name] = evaluate(value, lambda e: values[e.name])
        replaced[sympy.Symbol(symbol.name)] = to_sympy(value).subs(replaced)
        factoring.learn((Assignment(symbol, value, 0),))
    point = {sympy.Symbol(k): v for k, v in POINT.items()}
    wanted = [
        [
            float(sympy.diff(to_sympy(r).subs(replaced), sympy.Symbol(x.name)).subs(point))
            for x in tears
        ]
        for r in residuals
    ]
    slopes = forward.local_slopes(t, tears, inner, residuals)

    unrolled = forward.unroll(t, tears, slopes, factoring)
    local = dict(values)
    for symbol, value in unrolled.steps:
        local[symbol.name] = evaluate(value, lambda e: local[e.name])
    found = [[0.0] * len(tears) for _ in residuals]
    for i, j, value in unrolled.entries:
        found[i][j] = evaluate(value, lambda e: local[e.name])
    assert all(
        close(a, b) for x, y in zip(found, wanted, strict=True) for a, b in zip(x, y, strict=True)
    )

    tangent = forward.tangent(t, tears, slopes)
    for symbol, value in tangent.slopes:
        local[symbol.name] = evaluate(value, lambda e: local[e.name])
    for j in range(len(tears)):
        for i, seed in enumerate(tangent.seeds):
            local[seed.name] = float(i == j)
        for symbol, value in tangent.steps:
            local[symbol.name] = evaluate(value, lambda e: local[e.name])
        column = [evaluate(e, lambda e: local[e.name]) for e in tangent.entries]
        assert all(close(a, row[j]) for a, row in zip(column, wanted, strict=True))


def close(a: float, b: float) -> bool:
    return abs(a - b) <= 1e-10 * (1.0 + abs(b))
