"""Coefficients, solved forms, degrees and signs."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from planarc.evaluate.value import evaluate
from planarc.ir.dae import Kind, Parameter
from planarc.ir.expr import Expr, Exprs, text
from planarc.structure.linear import Contents, Degrees, coefficients, solve_affine
from planarc.structure.signs import Sign, Signs

Read = Callable[[Exprs, str], Expr]
UNKNOWNS = "xyzuv"


def _factors(read: Read, source: str) -> dict[str, str | None]:
    t = Exprs()
    found = coefficients(t, Contents(UNKNOWNS.__contains__), read(t, source))
    return {str(s): None if f is None else text(f) for s, f in sorted(found.items())}


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("x + 2*y - p", {"x": "1", "y": "2"}),
        ("sin(p)*x - p*(y - x)", {"x": "sin(p) + p", "y": "-p"}),
        ("x*y + z", {"x": "y", "y": "x", "z": "1"}),
        ("x*x + y", {"x": None, "y": "1"}),
        ("x/y + z/p", {"x": "1/y", "y": None, "z": "1/p"}),
        ("cos(x) + y", {"x": None, "y": "1"}),
        ("(x if p > 1 else 2*x) + y", {"x": "if 1 < p then 1 else 2", "y": "1"}),
        ("der(x) + x", {"x": "1", "der(x)": "1"}),
    ],
)
def test_coefficients(read: Read, source: str, expected: dict[str, str | None]) -> None:
    assert _factors(read, source) == expected


numbers = st.floats(0.5, 2)


@given(numbers, numbers, numbers, numbers)
def test_the_solved_form_solves(x: float, y: float, z: float, p: float) -> None:
    t = Exprs()
    v = {n: t.symbol(n) for n in "xyzp"}
    values = {v["x"]: x, v["y"]: y, v["z"]: z, v["p"]: p}
    left = t.mul(v["p"], t.add(v["x"], v["y"]))
    right = t.sub(t.call("exp", v["y"]), t.mul(v["z"], v["x"]))
    contents = Contents(UNKNOWNS.__contains__)
    factor = coefficients(t, contents, t.sub(left, right))[v["x"]]
    assert factor is not None
    values[v["x"]] = evaluate(
        solve_affine(t, contents, left, right, v["x"], factor), values.__getitem__
    )
    assert evaluate(left, values.__getitem__) == pytest.approx(
        evaluate(right, values.__getitem__), rel=1e-9, abs=1e-9
    )


def test_a_name_alone_is_not_solved_for_where_the_other_side_holds_it_too(read: Read) -> None:
    # x = 2*(x + y) - 2*x: the factor of x is 1, but the right side is no solution.
    t = Exprs()
    contents = Contents(UNKNOWNS.__contains__)
    left, right = t.symbol("x"), read(t, "2*(x + y) - 2*x")
    factor = coefficients(t, contents, t.sub(left, right))[left]
    assert factor is t.one
    value = solve_affine(t, contents, left, right, left, factor)
    assert left not in contents(value)


@pytest.mark.parametrize(
    ("source", "degree"),
    [("p*x + y", 1), ("x*y", 2), ("sin(p)", 0), ("sin(x)", 2), ("x/p", 1), ("p/x", 2),
     ("x if p > 1 else y", 1), ("p if x > 1 else p", 0), ("1 if x > 1 else 0", 2), ("w + p", 2)],
)  # fmt: skip
def test_degrees(read: Read, source: str, degree: int) -> None:
    t = Exprs()
    degrees = Degrees({t.symbol("x"): 1, t.symbol("y"): 1})
    degrees.define(t.symbol("w"), t.mul(t.symbol("x"), t.symbol("y")))
    assert degrees(read(t, source)) == degree


def _parameter(t: Exprs, name: str, value: float, low: float | None) -> Parameter:
    minimum = None if low is None else t.const(low)
    return Parameter(name, Kind.REAL, t.const(value), settable=True, minimum=minimum)


@pytest.mark.parametrize(
    ("source", "never_zero"),
    [
        ("2", True),
        ("x", False),
        ("p", False),  # may be set to 0, whatever it is now
        ("m", False),  # min = 0
        ("L", True),  # min = 0.1
        ("-L*L/2", True),
        ("1 + x^2", True),
        ("m + L", True),
        ("m + x", False),
        ("exp(x)", True),
        ("cos(x)", False),
        ("sqrt(x)", False),
        ("L if x > 0 else -L", True),
        ("L - 1", False),
    ],
)
def test_what_may_be_divided_by(read: Read, source: str, never_zero: bool) -> None:
    t = Exprs()
    parameters = (
        _parameter(t, "p", 1.0, None),
        _parameter(t, "m", 1.0, 0.0),
        _parameter(t, "L", 1.0, 0.1),
    )
    assert Signs(parameters).never_zero(read(t, source)) is never_zero


signed = st.sampled_from(["x", "-2", "3", "x*x", "exp(x)", "abs(x)", "-cosh(x)", "x^3", "0"])


@given(signed, signed, st.sampled_from("+-*/"), st.floats(-2, 2))
def test_the_sign_is_that_of_the_value(a: str, b: str, operator: str, x: float) -> None:
    t = Exprs()
    table = {"x": t.symbol("x"), "x*x": t.mul(t.symbol("x"), t.symbol("x"))}
    for name in ("exp", "abs", "cosh"):
        table[f"{name}(x)"] = t.call(name, t.symbol("x"))
    table["-cosh(x)"] = t.neg(table["cosh(x)"])
    table["x^3"] = t.pow(t.symbol("x"), t.const(3))
    left, right = (table[s] if s in table else t.const(float(s)) for s in (a, b))
    make = {"+": t.add, "-": t.sub, "*": t.mul, "/": t.div}[operator]
    e = make(left, right)
    try:
        value = evaluate(e, lambda _: x)
    except ZeroDivisionError:
        return
    if 0 < abs(value) < 1e-200 or (value == 0 and x != 0 and abs(x) < 1e-60):
        return  # underflow
    actual = Sign.PLUS if value > 0 else Sign.MINUS if value < 0 else Sign.ZERO
    assert actual & Signs(())(e)
