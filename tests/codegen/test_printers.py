"""Both printers say what the expression tree says, for any expression and any name."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planarc.codegen.native.machine import compile_object
from planarc.codegen.numpy.printer import source
from planarc.codegen.pipeline import generate
from planarc.evaluate.value import evaluate
from planarc.ir.expr import Expr, Exprs, Op
from planarc.ir.program import Program
from planarc.ir.sorted import Block
from planarc.solve.kernels import load
from tests.ir.check.program import check

PRINTERS: dict[str, Callable[[Program], str | bytes]] = {
    "numpy": source,
    "native": compile_object,
}
ONE = ("sin", "cos", "tan", "atan", "tanh", "abs", "sign", "floor", "ceil", "exp", "sqrt", "log")
TWO = ("atan2", "min", "max", "mod", "rem", "div")


def numbers() -> st.SearchStrategy[float]:
    return st.floats(-50, 50).filter(lambda x: x == 0 or abs(x) > 1e-6)


@st.composite
def expressions(draw: st.DrawFn, t: Exprs, leaves: list[Expr]) -> list[Expr]:
    """A growing pool of real expressions over the leaves; the last one uses many."""
    pool = [*leaves, t.const(draw(numbers())), t.const(2.0)]
    truths = [t.less(leaves[0], leaves[1])]
    pick = st.integers(0, 10**6)

    def any_of(items: list[Expr]) -> Expr:
        return items[draw(pick) % len(items)]

    for _ in range(draw(st.integers(3, 25))):
        a, b, c = any_of(pool), any_of(pool), any_of(pool)
        kind = draw(st.integers(0, 11))
        if kind == 0:
            pool.append(t.add(a, b, t.neg(c)))
        elif kind == 1:
            pool.append(t.mul(a, b))
        elif kind == 2:
            pool.append(t.div(a, b))
        elif kind == 3:
            pool.append(t.pow(a, t.const(float(draw(st.integers(-3, 5))))))
        elif kind == 4:
            pool.append(t.pow(t.call("abs", a), t.const(0.5)))
        elif kind == 5:
            pool.append(t.call(draw(st.sampled_from(ONE)), a))
        elif kind == 6:
            pool.append(t.call(draw(st.sampled_from(TWO)), a, b))
        elif kind == 7:
            pool.append(t.if_(any_of(truths), a, b))
        elif kind == 8:
            truths.append(t.less_equal(a, b))
        elif kind == 9:
            truths.append(t.and_(any_of(truths), t.not_(any_of(truths))))
        elif kind == 10:
            truths.append(t.or_(any_of(truths), t.equal(a, b)))
        else:
            pool.append(t.node(Op.NEG, (a,)))
    return pool[len(leaves) + 2 :] or [leaves[0]]


def value(e: Expr, x: float, y: float, t: float) -> float:
    """nan where it has none, or one next to an overflow."""
    try:
        found = evaluate(e, lambda s: t if s.op is Op.TIME else {"x": x, "y": y}[s.name])
    except (ArithmeticError, ValueError):
        return math.nan
    ordinary = not isinstance(found, complex) and abs(float(found)) < 1e100
    return float(found) if ordinary else math.nan


def rounding(e: Expr, x: float, y: float, t: float) -> float:
    """How much rounding may change the value: it is taken at points nearby."""
    here = value(e, x, y, t)
    off = 1e-13
    points = [(x * (1 + off), y, t), (x, y * (1 + off), t), (x, y, t * (1 + off))]
    return 1e-12 * abs(here) + 1e-300 + sum(abs(value(e, *p) - here) for p in points)


@pytest.mark.parametrize("printer", PRINTERS)
@settings(max_examples=120, derandomize=True)
@given(data=st.data(), x=numbers(), y=numbers(), t=numbers())
def test_printed_formulas_have_the_values_of_the_tree(
    printer: str, build: Any, data: st.DataObject, x: float, y: float, t: float
) -> None:
    b = build("Random")
    table = b.t
    leaves = [b.variable("x"), b.variable("y"), table.time]
    formulas = data.draw(expressions(table, leaves))
    wanted = [e for e in formulas if math.isfinite(rounding(e, x, y, t))]
    for s in leaves[:2]:
        b.candidate(s, 0.0)
    b.level(1, Block((leaves[0],)), Block((leaves[1],)))
    results = [b.variable(f"r{i}") for i in range(len(wanted))]
    steps = [b.assign(r, e) for r, e in zip(results, wanted, strict=True)]
    b.level(0, *steps, *(b.assign(table.der(s), table.time) for s in leaves[:2]))
    program = generate(b.sorted())
    check(program)
    kernel = load(program, PRINTERS[printer](program))
    kernel.parameters()
    assert kernel.outputs(t, [x, y]) == 0
    for r, e in zip(results, wanted, strict=True):
        found = float(kernel.w[program.slots[r.name]])
        assert abs(found - value(e, x, y, t)) <= rounding(e, x, y, t), e


NAMES = (
    "x'; import os; os.system('true'); '",
    '"""\nraise SystemExit\n"""',
    "a.b[1]",
    "a_b_1",
    "class",
    "sin",
    "__import__",
    "w",
    "tears",
    "t1",
    "ﬁ",
    "der(x)",
    "# e99",
    "x\\",
    "None",
)


@pytest.mark.parametrize("printer", PRINTERS)
def test_no_name_is_code_and_no_two_names_meet(printer: str, build: Any) -> None:
    """Names are made harmless, and each keeps its own value."""
    b = build("M'''; raise SystemExit\n")
    t = b.t
    states = [b.variable(name) for name in NAMES]
    parameters = [b.parameter(f"p.{name}", float(i)) for i, name in enumerate(NAMES)]
    for s in states:
        b.candidate(s, 0.0)
    b.level(1, *(Block((s,)) for s in states))
    b.level(
        0,
        *(
            b.assign(t.der(s), t.add(t.mul(s, s), p))
            for s, p in zip(states, parameters, strict=True)
        ),
    )
    program = generate(b.sorted())
    kernel = load(program, PRINTERS[printer](program))
    kernel.parameters()
    y = [0.5 + i for i in range(len(NAMES))]
    assert kernel.rhs(0.0, y, ydot := [0.0] * len(y)) == 0
    assert list(ydot) == [v * v + i for i, v in enumerate(y)]


def test_source_holds_no_text_of_the_user_outside_comments(build: Any) -> None:
    import io
    import keyword
    import tokenize

    b = build("Names")
    states = [b.variable(name) for name in NAMES]
    for s in states:
        b.candidate(s, 0.0)
    b.level(1, *(Block((s,)) for s in states))
    b.level(0, *(b.assign(b.t.der(s), s) for s in states))
    text = source(generate(b.sorted()))
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.NAME and not keyword.iskeyword(token.string):
            assert token.string.isascii()
            assert not token.string.startswith("__")
        if token.type == tokenize.STRING:  # the functions' own docstrings
            assert "raise" not in token.string


def test_same_model_gives_the_same_text(four_bar: Any) -> None:
    one, two = generate(four_bar), generate(four_bar)
    assert source(one) == source(two)
    assert compile_object(one) == compile_object(two)


def test_long_chain_of_operations_needs_no_recursion(build: Any) -> None:
    """A formula nested 5000 deep, and a sum of 5000 terms."""
    b = build("Deep")
    t = b.t
    x = b.variable("x")
    b.candidate(x, 0.5)
    deep = x
    for _ in range(5000):
        deep = t.call("sin", deep)
    wide = t.add(*(t.call("cos", t.mul(t.const(float(i)), x)) for i in range(1, 5000)))
    b.level(1, Block((x,)))
    b.level(0, b.assign(t.der(x), t.add(deep, wide)))
    program = generate(b.sorted())
    found = []
    for print_program in PRINTERS.values():
        kernel = load(program, print_program(program))
        kernel.parameters()
        ydot = [0.0]
        assert kernel.rhs(0.0, [0.5], ydot) == 0
        found.append(float(ydot[0]))
    assert found[0] == pytest.approx(found[1], rel=1e-12)
