"""Fields of records in functions have the values of their declarations and modifiers."""

from __future__ import annotations

from collections.abc import Callable

import pytest

import planarc
from planarc.ir import flat
from planarc.ir.flat import Assignment

TEXT = """
package P
  record D
    Real re=1;
    Real im=5;
  end D;
  record N
    parameter Integer n=2;
    Real x[n];
  end N;
  record W
    D a(re=7);
    D b;
    D c[2](im={3, 4});
    Real z=a.re + b.im;
  end W;
  function output_
    input Real x;
    output D d(re=x);
  algorithm
    d.im := 2*x;
  end output_;
  function local_
    input Real x;
    output Real y;
  protected
    D d;
  algorithm
    y := x + d.re + 10*d.im;
  end local_;
  function vector
    input Real x;
    output D d[2](im={1, 2}, each re=x);
  algorithm
    d[1].im := d[1].im + 8;
  end vector;
  function open_
    input Real x;
    input Integer n;
    output D d[n](im=1:n, each re=x);
  algorithm
    d[1].re := 0;
  end open_;
  function base
    input Real x;
    output D d;
  algorithm
    d.im := d.im + x;
  end base;
  function derived
    extends base(d(re=4));
  end derived;
  function short = base(d(re=8));
  function nested
    input Real x;
    output W w(a(im=x));
  algorithm
    w.b.re := x;
  end nested;
  function sized
    input Integer m;
    output N q(n=m);
  algorithm
    for i in 1:m loop
      q.x[i] := 10*i;
    end for;
  end sized;
  record Ratio
    Real whole=3*part;
    Real part=whole/3;
  end Ratio;
  function circle
    input Real x;
    output Ratio r(whole=x);
  algorithm
    assert(r.part < 100, "");
  end circle;
  function order
    input Real x;
    output Real y=d.re + 1;
  protected
    Real u=2*x;
    D d(re=u);
    Real v=d.im + u;
  algorithm
    y := y + 100*v;
  end order;
end P;
"""

RECORD = "  record E\n    Real re;\n    Real im;\n  end E;\n  record D"

CASES = {
    "an output": ("D d=P.output_(3*time)", {"d.re": 3, "d.im": 6}),
    "a local": ("Real y=P.local_(3*time)", {"y": 54}),
    "a vector": (
        "D d[2]=P.vector(3*time)",
        {"d[1].re": 3, "d[2].re": 3, "d[1].im": 9, "d[2].im": 2},
    ),
    "a size of an input": (
        "D d[3]=P.open_(3*time, 3)",
        {"d[1].re": 0, "d[2].re": 3, "d[3].im": 3},
    ),
    "a base": ("D d=P.derived(3*time)", {"d.re": 4, "d.im": 8}),
    "a short class": ("D d=P.short(3*time)", {"d.re": 8, "d.im": 8}),
    "records in a record": (
        "W w=P.nested(3*time)",
        {"w.a.re": 7, "w.a.im": 3, "w.b.re": 3, "w.b.im": 5, "w.c[2].im": 4, "w.z": 12},
    ),
    "a size of a field": ("N q(n=3)=P.sized(3)", {"q.x[1]": 10, "q.x[3]": 30}),
    "a circle that is broken": ("P.Ratio r=P.circle(3*time)", {"r.whole": 3, "r.part": 1}),
    "the order of values": ("Real y=P.order(3*time)", {"y": 1 + 6 + 100 * (5 + 6)}),
}


@pytest.mark.parametrize(("declared", "expected"), CASES.values(), ids=CASES)
def test_fields_have_their_first_values(declared: str, expected: dict[str, float]) -> None:
    text = f"{TEXT}model M\n  import P.D;\n  import P.N;\n  import P.W;\n  {declared};\nend M;\n"
    result = planarc.load(text, "M").simulate(1.0)
    assert {name: result[name][-1] for name in expected} == pytest.approx(expected)


@pytest.mark.parametrize("given", ["P.output_(3).re", "P.vector(3)[2].re", "P.nested(3).a.im"])
def test_a_call_that_is_run_while_compiling_has_them_too(given: str) -> None:
    name, _, rest = given.partition("(3)")
    kind = {"P.output_": "D", "P.vector": "D", "P.nested": "W"}[name]
    dims = "[2]" if "vector" in name else ""
    body = f"constant P.{kind} d{dims}={name}(3); Real x[integer(d{rest})]=ones(3)*time;"
    assert planarc.load(f"{TEXT}model M\n  {body}\nend M;\n", "M").simulate(1.0)["x[3]"][-1] == 1


def test_the_values_of_a_vector_of_records_fit_its_size() -> None:
    text = TEXT.replace("im={1, 2}", "im={1, 2, 3}")
    with pytest.raises(planarc.PlanarcError, match="must be of type Real"):
        planarc.load(f"{text}model M\n  P.D d[2]=P.vector(time);\nend M;\n", "M")


def test_an_output_that_is_given_field_by_field_has_a_value() -> None:
    told = planarc.load(f"{TEXT}model M\n  P.D d=P.output_(time);\nend M;\n", "M").warnings
    assert [w.message for w in told if w.code == "L321"] == []
    partly = TEXT.replace("output D d(re=x)", "output E d").replace("  record D", RECORD)
    told = planarc.load(f"{partly}model M\n  P.E d=P.output_(time);\nend M;\n", "M").warnings
    assert [w.code for w in told] == ["L321"]


def test_a_value_that_nothing_reads_is_left_out(
    flatten_text: Callable[..., flat.FlatModel],
) -> None:
    """Of `d.re := 1; d.im := 5;`, the second: the first is overwritten before it is read."""
    body = "function f input Real x; output D d; algorithm d.re := x; d.im := d.re; end f;"
    text = f"{TEXT.replace('end P;', body)}end P;\nmodel M\n  P.D d=P.f(time);\nend M;\n"
    (function,) = flatten_text(text).functions
    targets = [s.target.name for s in function.body if isinstance(s, Assignment)]
    assert targets == ["d.im", "d.re", "d.im"]
