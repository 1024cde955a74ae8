"""The checker of flat models finds what is broken."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from planarc.core.source import NOWHERE
from planarc.ir import flat
from tests.ir.check.flat import BrokenPromise, check_model

X = flat.Variable("x", flat.REAL, flat.Variability.CONTINUOUS)
ONE = flat.Literal(flat.REAL, NOWHERE, 1.0)
TRUE = flat.Literal(flat.BOOLEAN, NOWHERE, True)


def reference(name: str, *subscripts: flat.Expression) -> flat.Reference:
    return flat.Reference(flat.REAL, NOWHERE, name, subscripts)


def model(*equations: flat.Equation) -> flat.FlatModel:
    return flat.FlatModel("M", (X,), equations)


def equal(left: flat.Expression, right: flat.Expression) -> flat.Equality:
    return flat.Equality(NOWHERE, "", left, right)


def test_a_sound_model_passes() -> None:
    check_model(model(equal(reference("x"), ONE)))


@pytest.mark.parametrize(
    ("broken", "message"),
    [
        (model(equal(reference("y"), ONE)), "`y` is not declared"),
        (model(equal(reference("x", ONE), ONE)), "too many subscripts"),
        (model(equal(reference("x"), TRUE)), "an equation of"),
        (model(flat.Assert(NOWHERE, "", ONE, ONE)), "a condition is not Boolean"),
        (model(equal(reference("x"), flat.Call(flat.REAL, NOWHERE, "f"))), "`f` is not declared"),
        (replace(model(), variables=(X, X)), "declared twice"),
        (replace(model(), variables=(replace(X, binding=TRUE),)), "the binding has another type"),
    ],
)
def test_a_broken_promise_is_told(broken: flat.FlatModel, message: str) -> None:
    with pytest.raises(BrokenPromise, match=message):
        check_model(broken)
