"""Records as arguments, results and variables of algorithms: values against hand-made ones."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import planarc
from planarc import load
from planarc.api.result import Result

HEAD = """
  record R Real a; Real b; end R;
  function swapped input R r; output R s; algorithm s := r; s.a := r.b; s.b := r.a; end swapped;
  function moments
    input R r[:]; output Real y;
  algorithm
    y := 0; for i in 1:size(r, 1) loop y := y + r[i].a*r[i].b; end for;
  end moments;
  function ladder
    input Integer n; input Real x; output R r[n]; output Real total;
  algorithm
    total := 0;
    for i in 1:n loop r[i].a := i*x; r[i].b := 2*i; total := total + r[i].a; end for;
  end ladder;
"""


def run(folder: Path, body: str) -> Result:
    file = folder / "M.mo"
    file.write_text(f"model M\n{HEAD}{body}\nend M;\n")
    return load(file).simulate(1.0, intervals=4)


def test_record_is_argument_and_result(tmp_path: Path) -> None:
    result = run(tmp_path, "R r; algorithm r.a := time; r.b := 2; r := swapped(r);")
    assert result["r.a"] == pytest.approx(2)
    assert result["r.b"] == pytest.approx(result.time)


def test_record_arrays_go_in_and_come_out(tmp_path: Path) -> None:
    result = run(
        tmp_path,
        """
        R r[3](a={1, 2, 3}*time, each b=2); Real y = moments(r);
        R q[2]; Real total;
      equation
        (q, total) = ladder(2, time);
        """,
    )
    t = result.time
    assert result["y"] == pytest.approx(12 * t)
    assert result["q[2].a"] == pytest.approx(2 * t)
    assert result["q[2].b"] == pytest.approx(4)
    assert result["total"] == pytest.approx(3 * t)


def test_fields_of_entries_are_assigned_one_by_one(tmp_path: Path) -> None:
    result = run(
        tmp_path,
        """
        R r[2]; R s;
      algorithm
        for i in 1:2 loop r[i].a := i*time; r[i].b := -i; end for;
        r[2] := swapped(r[2]);
        s := r[2];
        s.a := s.a - 1;
        """,
    )
    t = result.time
    assert result["r[1].a"] == pytest.approx(t)
    assert result["r[2].b"] == pytest.approx(2 * t)
    assert result["s.a"] == pytest.approx(-3)
    assert result["s.b"] == pytest.approx(2 * t)


#: A capacitor behind a resistance that a data sheet gives, by way of a function.
SHEET = """
  record Sheet
    parameter Real r = 0;
    parameter Real c = 1;
  end Sheet;
  record Values
    parameter Real ohms;
    parameter Real farads;
  end Values;
  function values
    input Sheet sheet;
    output Values found;
  algorithm
    found.ohms := max(sheet.r, 0);
    found.farads := sheet.c;
  end values;
"""


@pytest.mark.parametrize("ohms", [0.0, 0.5])
@pytest.mark.parametrize("evaluated", ["final ", ""])
def test_records_that_are_final_or_evaluated_shape_the_equations(
    ohms: float, evaluated: str
) -> None:
    """Without resistance the capacitor has the source's voltage, and is no state any more."""
    prefix, note = ("final ", "") if evaluated else ("", " annotation(Evaluate = true)")
    text = f"""
model M
{SHEET}
  {prefix}parameter Sheet sheet(r = {ohms}){note};
  final parameter Values found = values(sheet);
  Real i;
  Real v(start = 0, fixed = {str(ohms > 0).lower()});
equation
  i*found.ohms = sin(time) - v;
  i = found.farads*der(v);
end M;
"""
    result = planarc.load(text).simulate(1.0, tolerance=1e-9)
    if ohms == 0.0:
        assert result.at("v", 1.0) == pytest.approx(math.sin(1.0))
        assert result.at("i", 1.0) == pytest.approx(math.cos(1.0))
    else:  # v' = (sin(t) - v)/ohms
        lag = math.sin(1.0) - ohms * math.cos(1.0) + ohms * math.exp(-1.0 / ohms)
        v = lag / (1 + ohms**2)
        assert result.at("v", 1.0) == pytest.approx(v, rel=1e-6)


def test_a_field_of_a_final_record_is_not_set() -> None:
    text = f"""
model M
{SHEET}
  final parameter Sheet sheet(r = 2);
  Real x = sheet.r*time;
end M;
"""
    with pytest.raises(planarc.PlanarcError, match="cannot be set"):
        planarc.load(text).simulate(1.0, parameters={"sheet.r": 3.0})


def test_a_record_set_as_a_whole_at_an_event_is_held_until_the_next_one(tmp_path: Path) -> None:
    result = run(
        tmp_path,
        """
        R p(a=time, b=2); R r(a(start=1), b(start=2)); R s[2]; R q;
      equation
        when {time > 0.3, time > 0.6} then
          r = R(pre(r.a) + 1, time);
        end when;
        when time > 0.6 then
          s = {p, swapped(p)};
        end when;
        when time > 0.3 then
          q = if r.a > 1.5 then p else r;
        end when;
        """,
    )
    t = result.time
    assert result["r.a"][t < 0.3] == pytest.approx(1)
    assert result["r.a"][-1] == 3
    assert result["r.b"][-1] == pytest.approx(0.6)
    assert result["s[1].a"][-1] == result["s[2].b"][-1] == pytest.approx(0.6)
    assert result["s[1].b"][-1] == result["s[2].a"][-1] == 2
    assert result["q.a"][-1] == pytest.approx(0.3)


@pytest.mark.parametrize("field", ["r = swapped(r);", "r.b = 3;"])
def test_a_record_is_given_once_in_a_branch(field: str, tmp_path: Path) -> None:
    with pytest.raises(planarc.PlanarcError, match=r"given twice in one branch of a when"):
        run(tmp_path, f"R r; equation when time > 0.3 then r = R(1, 2); {field} end when;")


def test_pre_of_a_record_is_that_of_its_fields() -> None:
    text = """
model M
  record R
    Real a(start=1);
    Integer n(start=2);
  end R;
  R r[2], s;
equation
  when sample(0.25, 0.25) then
    r[1] = R(pre(s.a) + 1, pre(s.n));
    r[2] = pre(r[1]);
    s = pre(r[2]);
  end when;
end M;
"""
    found = planarc.load(text).simulate(1.1)
    one, two, three = 1.0, 1.0, 1.0
    for _ in range(4):
        one, two, three = three + 1, one, two
    assert [found[n][-1] for n in ("r[1].a", "r[2].a", "s.a", "s.n")] == [one, two, three, 2]
