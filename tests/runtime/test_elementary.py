"""One row a function: every reader of the table knows every row, and a row is all it takes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import sici

import planarc
from planarc.core.options import Backend
from planarc.evaluate.rows import RowValues
from planarc.evaluate.tape import prepare
from planarc.evaluate.value import evaluate
from planarc.ir.calculus import partial
from planarc.ir.expr import Exprs
from planarc.runtime.elementary import TABLE, Elementary, Result, Sign, Units
from planarc.stages import study
from planarc.structure.signs import Signs

rows = pytest.mark.parametrize("row", TABLE.values(), ids=list(TABLE))
backends = pytest.mark.parametrize("backend", [b.value for b in Backend])

#: Arguments for which every function has a value: x runs from 0.3 to 0.8.
SECOND = 1.9


def _given(row: Elementary, x: float) -> tuple[float, ...]:
    return (x, SECOND)[: row.arity]


class _Numbers:
    """What formulas of the table use, for Python's numbers."""

    trunc = staticmethod(lambda x: float(math.trunc(x)))
    where = staticmethod(lambda condition, a, b: a if condition else b)

    def __getattr__(self, name: str) -> Any:
        return TABLE[name].value


@rows
def test_a_row_is_whole(row: Elementary) -> None:
    assert TABLE[row.name] is row
    assert (row.in_native or row.built) and (row.in_numpy or row.built)
    if row.inverse is not None:
        assert row.inverse(_Numbers(), row.value(0.4)) == pytest.approx(0.4)
    value = row.value(*_given(row, 0.4))
    assert isinstance(value, float)
    if row.built is not None:
        assert row.built(_Numbers(), *_given(row, 0.4)) == value


@rows
def test_slopes_are_those_of_the_value(row: Elementary) -> None:
    h = 1e-6
    for x in (0.31, 0.5, 0.77):
        at = _given(row, x)
        found = (0.0,) * row.arity if row.slopes is None else row.slopes(_Numbers(), *at)
        for i, slope in enumerate(found if isinstance(found, tuple) else (found,)):
            more, less = list(at), list(at)
            more[i], less[i] = at[i] + h, at[i] - h
            assert slope == pytest.approx((row.value(*more) - row.value(*less)) / (2 * h), abs=1e-8)


@rows
def test_signs_and_domains_are_told_truly(row: Elementary) -> None:
    t = Exprs()
    told = Signs(())(t.call(row.name, *(t.symbol(n) for n in "xy"[: row.arity])))
    assert (told == Sign.ANY) or not row.odd
    for x in (-99.5, -2.5, -0.5, 0.0, 0.5, 2.5, 99.5):
        for y in (-1.5, 0.5) if row.arity == 2 else (None,):
            try:
                value = row.value(x) if y is None else row.value(x, y)
            except (ValueError, ArithmeticError):
                assert not row.total
                continue
            sign = Sign.PLUS if value > 0 else Sign.MINUS if value < 0 else Sign.ZERO
            assert sign & row.sign
            if row.odd:
                assert value == 0.0 if x == 0 else math.copysign(1.0, value) == np.sign(x)


@rows
def test_every_way_to_evaluate_gives_the_same_value(row: Elementary) -> None:
    t = Exprs()
    x = t.symbol("x")
    e = t.call(row.name, *(x, t.const(SECOND))[: row.arity])
    at = np.array([0.31, 0.5, 0.77])
    expected = [row.value(*_given(row, v)) for v in at.tolist()]
    assert [evaluate(e, lambda _, v=v: v) for v in at.tolist()] == expected
    taped = prepare(e, lambda _: 0)
    assert [taped([v], 0.0) for v in at.tolist()] == expected
    assert np.allclose(RowValues(lambda _: at)(e), expected, rtol=1e-15)
    slope = partial(t, x)(e)
    assert math.isfinite(evaluate(slope, lambda _: 0.5))


EVERY = """model Every
  Real x(start=0.3, fixed=true);
{declarations}
equation
  der(x) = 0.5;
{equations}
  annotation(Documentation(figures={{Figure(plots={{Plot(curves={{{curves}}})}})}}));
end Every;
"""


def _every() -> str:
    calls = {n: f"{n}({'x, 1.9' if row.arity == 2 else 'x'})" for n, row in TABLE.items()}
    return EVERY.format(
        declarations="\n".join(f"  Real y_{n};" for n in calls),
        equations="\n".join(f"  y_{n} = {call};" for n, call in calls.items()),
        curves=", ".join(f"Curve(y=0.5 + {call})" for call in calls.values()),
    )


@backends
def test_every_function_runs_and_is_drawn(backend: str) -> None:
    result = planarc.load(_every(), backend=backend).simulate(1)
    x = result["x"].tolist()
    drawn = {s.name: s.values for s in study(result.rows).series}
    assert len(drawn) == len(TABLE)
    for (name, row), curve in zip(TABLE.items(), drawn.values(), strict=True):
        expected = np.array([row.value(*_given(row, v)) for v in x])
        assert np.allclose(result[f"y_{name}"], expected, rtol=1e-14, atol=0), name
        assert np.allclose(curve, 0.5 + expected, rtol=1e-14, atol=1e-15), name


@rows
def test_units_and_types_are_checked_by_the_row(row: Elementary) -> None:
    second = ", n" if row.arity == 2 else ""
    text = f"""model M
      parameter Real w(unit="m") = 0.5; parameter Real n(unit="s") = 0.7; parameter Integer k = 3;
      Real y(unit="kg") = {row.name}(w{second});
      Integer i = {row.name}(k{", k" if second else ""});
    end M;"""
    if row.result is Result.REAL:
        with pytest.raises(planarc.PlanarcError):
            planarc.load(text)
        text = text.replace("Integer i", "Real i")
    found = [d.message for d in planarc.load(text).warnings]
    complaint = {
        Units.NUMBER: f"`{row.name}` takes a number: these have different units",
        Units.SAME: f"the arguments of `{row.name}` have different units",
        Units.RATIO: f"the arguments of `{row.name}` have different units",
        Units.KEPT: "`y` and its value have different units: `kg` and `m`",
        Units.ROOT: "`y` and its value have different units: `kg` and `m0.5`",
    }.get(row.units)
    assert found if complaint else not found, found
    assert complaint is None or any(m.startswith(complaint[:40]) for m in found), found


# A new function ----------------------------------------------------------------------------------

SINC = Elementary(
    "sinc",
    1,
    lambda x: math.sin(x) / x if x else 1.0,
    # A slope is differentiated again: near 0 a series, no constant.
    lambda f, x: f.where(
        f.abs(x) > 0.01, (f.cos(x) - f.sinc(x)) / x, x * (x * x / 30.0 - 1.0 / 3.0)
    ),
    built=lambda f, x: f.where(f.abs(x) > 0.0, f.sin(x) / x, 1.0),
    total=True,
)

MODEL = """model Waves
  Angle a;
  Real s(start=0, fixed=true) "integral of sinc";
  Real z(start=1) "needs the slope of sinc";
  Boolean low = sinc(a.phi) < 0.5;
  Real since(start=0, fixed=true) "time after sinc fell below a half";
  discrete Real fell(start=-1, fixed=true);
  parameter Real p = sinc(0.5);
  constant Real c = sinc(0);
equation
  der(s) = sinc(a.phi);
  z + 0.9*sinc(z) = 1 + a.phi;
  der(since) = if low then 1 else 0;
  when low then
    fell = time;
  end when;
  annotation(Documentation(figures={Figure(plots={Plot(curves={
    Curve(y=sinc(a.phi)), Curve(y=2*sinc(2*a.phi))})})}));
end Waves;

model Angle
  Real phi(unit="rad", start=0, fixed=true);
equation
  der(phi) = 1;
end Angle;
"""


@pytest.fixture
def sinc(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(TABLE, "sinc", SINC)


@backends
def test_one_row_makes_a_function(sinc: None, backend: str) -> None:
    model = planarc.load(MODEL, "Waves", backend=backend)
    assert not model.warnings
    result = model.simulate(4, tolerance=1e-9)
    t = result.time
    assert np.max(np.abs(result["s"] - sici(t)[0])) < 1e-6

    def closed(v: float) -> float:
        return brentq(lambda z: z + 0.9 * SINC.value(z) - 1 - v, -1, 6, xtol=1e-14)

    assert np.max(np.abs(result["z"] - [closed(v) for v in t.tolist()])) < 1e-8
    half = brentq(lambda x: SINC.value(x) - 0.5, 1, 3, xtol=1e-14)
    assert result["fell"][-1] == pytest.approx(half, abs=1e-7)
    assert result["since"][-1] == pytest.approx(4 - half, abs=1e-6)
    assert result["p"][0] == pytest.approx(math.sin(0.5) / 0.5)
    assert result["c"][0] == 1.0
    drawn = {s.name: s.values for s in study(result.rows).series}
    assert list(drawn) == ["sinc(a.phi)", "2*sinc(2*a.phi)"]
    assert np.max(np.abs(drawn["sinc(a.phi)"] - np.sinc(result["a.phi"] / math.pi))) < 1e-14
    assert "2*sinc(2*a.phi)" in result.animate().text


def test_its_units_are_checked(sinc: None) -> None:
    wrong = """model Wrong
      Real l(unit="m") = 1 + time;
      Real y(unit="m") = sinc(l/l);
      Real z = sinc(l);
    end Wrong;"""
    told = [d.message for d in planarc.load(wrong).warnings]
    assert told == [
        "`y` and its value have different units: `m` and `1`",
        "`sinc` takes a number: these have different units: `m` and `1`",
    ]


def test_a_variable_of_its_name_is_another_thing(sinc: None) -> None:
    text = "model M Real sinc = time; Real y = 2*sinc; end M;"
    result = planarc.load(text, backend="numpy").simulate(1)
    assert result["y"][-1] == pytest.approx(2.0)


def test_without_its_row_it_is_unknown() -> None:
    with pytest.raises(planarc.PlanarcError, match="unknown function `sinc`"):
        planarc.load("model M Real y = sinc(time); end M;")
