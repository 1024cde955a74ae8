"""Random systems: refused by a diagnostic, or sorted so that every equation holds."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from planarc.core.diagnostic import PlanarcError
from planarc.evaluate.value import evaluate
from planarc.ir.dae import Dae
from planarc.ir.expr import Expr, Op, symbols, text
from planarc.ir.sorted import SortedDae
from planarc.structure.pipeline import structure
from tests.ir.check.sorted import check_sorted

SIZE = 5
VALUES = {"p": 1.7, "q": -0.6}

_symbol = st.builds(
    lambda order, v: "der(" * order + f"x{v}" + ")" * order,
    st.sampled_from([0, 0, 0, 1, 2]),
    st.integers(0, SIZE - 1),
)
_factor = st.sampled_from(["", "-", "2*", "p*", "-q*", "sin(p)*"])
_term = st.builds(lambda f, s: f + s, _factor, _symbol)
_given = st.sampled_from(["0", "1", "p", "q*p", "sin(time)", "time*time", "cos(q*time)"])
_equation = st.builds(
    lambda terms, right: " + ".join(terms) + " = " + right,
    st.lists(_term, min_size=1, max_size=3, unique=True),
    _given,
)
_systems = st.lists(_equation, min_size=SIZE, max_size=SIZE)


@given(_systems, st.lists(st.floats(-1, 1), min_size=3 * SIZE, max_size=3 * SIZE))
@settings(max_examples=400)
def test_every_equation_of_the_user_holds(
    make: Callable[..., Dae], point: Any, equations: list[str], guesses: list[float]
) -> None:
    dae = make(*equations, **VALUES)
    if not all(symbols(e.left) for e in dae.equations):
        return
    names = [text(dae.table.symbol(f"x{i}", k)) for i in range(SIZE) for k in range(3)]
    try:
        model = structure(dae)
    except PlanarcError:
        return
    check_sorted(model)
    try:
        p = point(model, None, dict(zip(names, guesses, strict=True)), time=0.7)
    except AssertionError:
        assume(False)  # singular in numbers, though not by structure
    for e in dae.equations:
        values = [evaluate(side, lambda leaf: _value(model, p, leaf)) for side in (e.left, e.right)]
        size = max(1.0, *(abs(v) for v in p.values.values()))
        assert values[0] == pytest.approx(values[1], abs=1e-6 * size), text(e.left)


def _value(model: SortedDae, p: Any, leaf: Expr) -> float:
    """The value of any symbol of the user's equations, through aliases."""
    if leaf.op is Op.TIME:
        return float(p.time)
    for a in model.aliases:
        if a.name == leaf.name:
            if not a.target.is_symbol or a.target.name in VALUES:
                return 0.0 if leaf.order else a.sign * p.value(a.target)
            return float(a.sign * p.values[a.target.name, a.target.order + leaf.order])
    return float(p.values[leaf.data])
