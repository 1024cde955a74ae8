"""Answers that are the only solution, and each that would lose a branch, refused."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import Any

import pytest

from planarc.evaluate.value import evaluate
from planarc.ir.dae import Kind, Parameter
from planarc.ir.expr import Expr, Exprs, Op, postorder, symbols
from planarc.ir.sorted import Assignment, Block, SortedDae
from planarc.structure.algebra import Algebra
from planarc.structure.linear import Contents
from planarc.structure.signs import Signs

Read = Callable[[Exprs, str], Expr]


def _solver(t: Exprs) -> Algebra:
    positive = Parameter("T", Kind.REAL, t.one, settable=True, minimum=t.const(0.1))
    return Algebra(t, Contents("xyzL".__contains__), Signs((positive,)))


def _value(read: Read, source: str, unknown: str = "x") -> Expr | None:
    t = Exprs()
    left, right = source.split(" = ")
    answer = _solver(t).solve(t.sub(read(t, left), read(t, right)), t.symbol(unknown))
    return None if answer is None else answer.value


REFUSED = [
    ("atan2(y, x) = 0", "y"),  # forgets x > 0: the wrong side of a contact
    ("atan2(y, x) = 0", "x"),
    ("sqrt(x) = y", "x"),
    ("asin(x) = y", "x"),
    ("acos(x) = y", "x"),
    ("atan(x) = y", "x"),
    ("sin(x) = y", "x"),
    ("tan(x) = y", "x"),
    ("x^2 = y", "x"),
    ("L*L = x*x + y*y", "x"),
    ("L*L = x*x + y*y", "L"),
    ("L^4 = x", "L"),
    ("x^3 = y", "x"),  # its root has no slope at 0
    ("x^3 = x + y", "x"),
    ("y/x = z", "x"),  # divides by z
    ("x/(1 + x) = y", "x"),
    ("(x + y)^2 - x^2 = z", "x"),  # divides by y
    ("exp(x) - x = y", "x"),  # falls, then rises
    ("y*exp(x) = z", "x"),  # y may vanish
    ("abs(x) = y", "x"),
    ("cosh(x) = y", "x"),
    ("max(x, 1) = y", "x"),
    ("x*exp(-x) = y", "x"),
    ("exp(x) = -T", "x"),  # never
    ("0.1*x*x + y*x = z", "x"),
]


@pytest.mark.parametrize(("source", "unknown"), REFUSED)
def test_an_answer_that_loses_a_branch_is_refused(read: Read, source: str, unknown: str) -> None:
    assert _value(read, source, unknown) is None


SOLVED = [
    ("(x + T)^2 - x^2 = y", {"y": 3.0, "T": 2.0}),
    ("x*(x + 2) - x*x = y", {"y": 3.0}),
    ("exp(x) = y", {"y": 2.5}),
    ("exp(2*x/T) - 1 = y", {"y": 2.5, "T": 0.7}),
    ("log(x) = y + sin(z)", {"y": -0.3, "z": 1.0}),
    ("T*sinh(x) = y", {"y": -4.0, "T": 3.0}),
    ("tanh(x/T) = y", {"y": 0.4, "T": 2.0}),
    ("T*log(exp(x) + 1) = y", {"y": 2.0, "T": 1.5}),
    ("sinh(exp(x/T)*2) = y", {"y": 2.0, "T": 1.5}),
    ("(2*x + T)*(x + 1)/T - 2*x*x/T = z", {"T": 1.5, "z": 0.3}),
]


@pytest.mark.parametrize(("source", "values"), SOLVED)
def test_an_answer_solves_the_equation(read: Read, source: str, values: dict[str, float]) -> None:
    t = Exprs()
    left, right = (read(t, side) for side in source.split(" = "))
    x = t.symbol("x")
    answer = _solver(t).solve(t.sub(left, right), x)
    assert answer is not None
    known: dict[str, Any] = dict(values)
    known["x"] = evaluate(answer.value, lambda e: known[e.name])
    assert evaluate(left, lambda e: known[e.name]) == pytest.approx(
        evaluate(right, lambda e: known[e.name]), rel=1e-12
    )


def _random(t: Exprs, random: Random, depth: int) -> Expr:
    """A formula in x, y, z and T."""
    if depth == 0 or random.random() < 0.15:
        return random.choice([*map(t.symbol, "xxyzT"), t.const(0.1), t.const(-3.0)])
    a, b = (_random(t, random, depth - 1) for _ in range(2))
    divisor = t.symbol(random.choice("yT"))
    make = [
        *(lambda: t.add(a, b), lambda: t.sub(a, b), lambda: t.mul(a, b)),
        *(lambda: t.div(a, divisor), lambda: t.pow(a, t.const(2.0)), lambda: t.neg(a)),
        *(lambda f=f: t.call(f, a) for f in ("exp", "log", "sinh", "tanh", "sin")),
    ]
    return random.choice(make)()


@pytest.mark.parametrize("seed", range(8))
def test_whatever_is_answered_solves_the_equation(seed: int) -> None:
    random, answers = Random(seed), 0
    for _ in range(60):
        t = Exprs()
        x, square = t.symbol("x"), t.pow(t.symbol("x"), t.const(2.0))
        bent = t.sub(t.mul(t.add(x, t.symbol("T")), t.add(x, t.symbol("y"), t.symbol("T"))), square)
        residual = _random(t, random, 3) if random.random() < 0.7 else t.sub(bent, t.symbol("z"))
        answer = _solver(t).solve(residual, x) if x in symbols(residual) else None
        if answer is None:
            continue
        assert x not in symbols(answer.value)
        values = {"y": random.uniform(-2, 2), "z": random.uniform(-2, 2), "T": random.uniform(1, 3)}
        try:
            values["x"] = evaluate(answer.value, lambda e, v=values: v[e.name])
            left = evaluate(residual, lambda e, v=values: v[e.name])
        except (ArithmeticError, ValueError):
            continue  # there is no solution here
        answers += 1
        assert left == pytest.approx(0.0, abs=1e-7 * max(1.0, abs(values["x"])) ** 3)
    assert answers > 3


@pytest.mark.parametrize(
    ("source", "everywhere"),
    [
        *(("log(x) = y", True), ("sinh(x) = y", True), ("exp(x) = exp(y) + 1", True)),
        *(("exp(x) = y", False), ("tanh(x) = y", False), ("log(exp(x) + 1) = y", False)),
    ],
)
def test_it_is_told_whether_there_always_is_a_value(
    read: Read, source: str, everywhere: bool
) -> None:
    t = Exprs()
    left, right = source.split(" = ")
    answer = _solver(t).solve(t.sub(read(t, left), read(t, right)), t.symbol("x"))
    assert answer is not None and answer.everywhere is everywhere


def test_a_loop_is_left_where_the_answer_has_no_value_everywhere(
    sort: Callable[..., SortedDae],
) -> None:
    """x = atanh(y - z), where Newton's steps pass by y - z > 1."""
    model = sort("y = 0.3*z + tanh(x)", "x = 0.3*z + 0.1*tanh(y)", "z = cos(y)")
    (block,) = (s for level in model.levels for s in level.steps if isinstance(s, Block))
    values = [a.value for a in block.inner] + [r.value for r in block.residuals]
    assert not any(e.op is Op.CALL and e.data == "log" for e in postorder(values))


def test_what_would_be_long_is_left_alone(read: Read) -> None:
    assert _value(read, "((x + y)^30 + z)^30 = T", "x") is None
    assert _value(read, "((x + y + z)^6 + y*z)^6*x = T", "x") is None


def test_numbers_are_exact(read: Read) -> None:
    """0.1*0.1 is not 0.01 in binary numbers."""
    answer = _value(read, "(x/10 + T)^2 - 0.01*x^2 = y")
    assert answer is not None
    values = {"T": 2.0, "y": 5.0}
    assert evaluate(answer, lambda e: values[e.name]) == pytest.approx(1 / 0.4, rel=1e-15)


def test_a_level_uses_the_answer(sort: Callable[..., SortedDae], point: Any) -> None:
    model = sort("exp(y) = 2 + time", "v = der(y)")
    assert all(isinstance(s, Assignment) for level in model.levels for s in level.steps)
    assert point(model, {}, time=1.0).of("v") == pytest.approx(1 / 3)
