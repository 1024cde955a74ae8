"""Long sums taken apart: the same operations in the same order."""

from __future__ import annotations

import fmpy
import pytest

from planarc.codegen.native.summing import Sums
from planarc.compiler import compile_model
from planarc.ir.expr import Exprs
from planarc.ir.program import Let
from planarc.request.request import Request
from tests.export.fmus import runs_here, written


def test_two_terms_at_a_time() -> None:
    t = Exprs()
    a, b, c, d, x, y = (t.symbol(n) for n in "abcdxy")
    kept: dict = {}
    lets = [
        Let(x, t.mul(t.sub(t.sub(t.neg(t.mul(a, b)), t.mul(c, d)), t.mul(a, d)), b)),
        Let(y, t.add(a, b, c, d, x)),
    ]
    found = [f"{let.target} := {let.value}" for let in Sums(t, kept).take_apart(lets)]
    assert found == [
        "$sum1 := -a*b - c*d",
        "x := ($sum1 - a*d)*b",
        "$sum2 := a + b",
        "$sum3 := $sum2 + c",
        "$sum4 := $sum3 + d",
        "y := $sum4 + x",
    ]
    first = t.symbol("$sum2")
    assert [kept[t.symbol(f"$sum{i}")] for i in (2, 3, 4)] == [first] * 3


def test_short_sums_and_choices_stay_as_they_are() -> None:
    t = Exprs()
    a, b, c, x = (t.symbol(n) for n in "abcx")
    lets = [Let(x, t.add(a, t.mul(b, c))), Let(x, t.if_(t.less(a, b), t.add(a, b, c), a))]
    assert Sums(t, {}).take_apart(lets) == lets


@runs_here
@pytest.mark.parametrize("name", ("NewtonsCradle", "WornSliderCrank"))
def test_values_are_equal_to_the_last_bit(
    name: str, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = compile_model(Request(class_name=f"PlanarMultiBody.Examples.Contacts.{name}"))
    rows, codes = [], []
    for worth, part in ((1e9, 0.0), (0.0, 1e9)):
        monkeypatch.setattr("planarc.codegen.native.rolling._WORTH", worth)
        monkeypatch.setattr("planarc.codegen.native.rolling._APART", part)
        path = written(tmp_path_factory.mktemp("sums") / "a.fmu", model, 3)
        rows.append(fmpy.simulate_fmu(path, fmi_type="CoSimulation", stop_time=0.5))
        codes.append(path.read_bytes())
    assert codes[0] != codes[1] and rows[0].tobytes() == rows[1].tobytes()
