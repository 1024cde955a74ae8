"""Shapes of formulas: equal up to the names of leaves, and no more."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from planarc.codegen.native.shapes import Shapes
from planarc.ir.expr import Expr, Exprs, Op, postorder

Make = Callable[[Exprs, Expr, Expr, Expr], Expr]

_PAIRS = st.sampled_from([Op.ADD, Op.MUL, Op.DIV, Op.LESS, Op.AND])


def formulas(leaf: st.SearchStrategy[int]) -> st.SearchStrategy[object]:
    """Trees of operators over the numbers of leaves."""
    return st.recursive(leaf, lambda inner: st.tuples(_PAIRS, inner, inner), max_leaves=12)


def written(t: Exprs, tree: Any, names: list[str]) -> Expr:
    """The tree over symbols of these names, node by node as it is."""
    if isinstance(tree, int):
        return t.symbol(names[tree])
    op, a, b = tree
    return t.node(op, (written(t, a, names), written(t, b, names)))


@given(formulas(st.integers(0, 3)), st.permutations("pqrs"))
def test_other_names_are_the_same_shape(tree: object, others: list[str]) -> None:
    t, shapes = Exprs(), Shapes()
    one, other = written(t, tree, [*"abcd"]), written(t, tree, others)
    number, leaves = shapes(one)
    assert number is not None
    assert shapes(other)[0] == number
    renamed = dict(zip("abcd", others, strict=True))
    assert [renamed[e.name] for e in leaves] == [e.name for e in shapes(other)[1]]


@given(formulas(st.integers(0, 3)))
def test_leaves_stand_there_once(tree: object) -> None:
    t = Exprs()
    formula = written(t, tree, [*"abcd"])
    leaves = Shapes()(formula)[1]
    assert len(set(leaves)) == len(leaves)
    assert set(leaves) == {e for e in postorder((formula,)) if not e.args}


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (lambda t, x, y, z: t.add(x, y), lambda t, x, y, z: t.mul(x, y)),
        (lambda t, x, y, z: t.add(t.mul(x, y), z), lambda t, x, y, z: t.add(t.mul(x, y), x)),
        (lambda t, x, y, z: t.call("sin", x), lambda t, x, y, z: t.call("cos", x)),
        (lambda t, x, y, z: t.pow(x, t.const(2.0)), lambda t, x, y, z: t.pow(x, t.const(3.0))),
        (lambda t, x, y, z: t.add(x, y), lambda t, x, y, z: t.add(x, t.const(2.0))),
        (lambda t, x, y, z: t.add(x, y), lambda t, x, y, z: t.add(x, t.time)),
    ],
)
def test_other_formulas_have_other_shapes(one: Make, other: Make) -> None:
    t, shapes = Exprs(), Shapes()
    x, y, z = map(t.symbol, "xyz")
    assert shapes(one(t, x, y, z))[0] != shapes(other(t, x, y, z))[0]


def test_numbers_are_leaves_and_what_calls_back_has_no_shape() -> None:
    t, shapes = Exprs(), Shapes()
    x = t.symbol("x")
    assert shapes(t.add(x, t.const(2.0)))[0] == shapes(t.add(x, t.const(3.0)))[0]
    past = t.past(0, t.add(x, t.time))
    assert shapes(past) == (None, (x, t.time))
