"""A comparison hides nothing that is not a number, unless a condition guards it."""

from __future__ import annotations

import math

import pytest

import planarc
from planarc.core.options import Backend
from planarc.runtime import elementary

HEAD = "Real x(start=1, fixed=true); "
EQUATION = " equation der(x) = -1;"

#: Models in which something is not a number from t = 0 or 0.5 s on.
HIDDEN = {
    "a relation": "Boolean b; equation b = x >= sqrt(-4);",
    "a relation of parameters": "parameter Real p = -8; Boolean b = p^(1/3) > time;",
    "a relation of a state": "Boolean b = (x - 0.5)^0.5 > 0.3;",
    "a relation in a condition": "Real y = if x >= sqrt(x - 0.5) then 1 else 2;",
    "max": "Real y = max(1, sqrt(0.5 - time));",
    "min": "Real y = min(sqrt(0.5 - time), -1);",
    "sign": "Real y = sign(sqrt(x - 0.5));",
    "noEvent": "Real y = if noEvent(x > sqrt(x - 0.5)) then 1 else 2;",
    "noEvent, and": "Boolean b = noEvent(sqrt(x - 0.5) > -1 and x > -10);",
    "noEvent, not": "Real y = if noEvent(not sqrt(x - 0.5) > 7) then x else 2;",
    "a when": "Integer n; equation when sqrt(x - 0.5) < 0.1 then n = pre(n) + 1; end when;",
    "a shared part": "Real y = if noEvent(sqrt(x - 0.5) > 7) then x else 2; "
    "Real z = if noEvent(sqrt(x - 0.5) > 7) then 3 else x;",
}
#: Models in which a condition asks only for what is a number.
GUARDED = {
    "if": "Boolean b = if x > 0.5 then sqrt(x - 0.5) > 0.5 else false;",
    "and": "Real y = if x > 0.5 and sqrt(x - 0.5) > 0.5 then 1 else 2;",
    "or": "Boolean b = x < 0.5 or sqrt(x - 0.5) < 0.5;",
    "noEvent": "Real y = noEvent(if x > 0.5 then if sqrt(x - 0.5) > 1 then 1 else 2 else 3);",
    "nested": "Real y = if x > 0.5 then if sqrt(x - 0.5) > 0.5 then 1 else 2 else 3;",
    "max": "Real y = if noEvent(x > 0.5) then max(1, sqrt(x - 0.5)) else 0;",
}


def run(body: str, backend: Backend) -> planarc.Result:
    text = f"model M {HEAD}{body}{EQUATION} end M;"
    return planarc.load(text, backend=backend.value).simulate(1.0)


@pytest.mark.parametrize("backend", Backend)
@pytest.mark.parametrize("body", HIDDEN.values(), ids=HIDDEN)
def test_what_is_not_a_number_is_refused(body: str, backend: Backend) -> None:
    with pytest.raises(planarc.PlanarcError, match=r"R4(14|20|21)"):
        run(body, backend)


@pytest.mark.parametrize("backend", Backend)
@pytest.mark.parametrize("body", GUARDED.values(), ids=GUARDED)
def test_what_no_condition_asks_for_may_be_not_a_number(body: str, backend: Backend) -> None:
    result = run(body, backend)
    assert result.time[-1] == 1.0


@pytest.mark.parametrize("backend", Backend)
def test_the_relation_is_named(backend: Backend) -> None:
    with pytest.raises(planarc.PlanarcError, match=r"`0.3 < \(x - 0.5\)\^0.5` gives no finite"):
        run(HIDDEN["a relation of a state"], backend)


@pytest.mark.parametrize("name", ["min", "max", "sign"])
def test_functions_that_are_built_give_no_number_of_none(name: str) -> None:
    class Numbers:
        @staticmethod
        def where(condition: bool, a: float, b: float) -> float:
            return a if condition else b

    row = elementary.TABLE[name]
    assert row.built is not None
    for place in range(row.arity):
        given = [1.0] * row.arity
        assert row.built(Numbers, *given) == 1.0
        given[place] = math.nan
        assert math.isnan(row.built(Numbers, *given))
