"""Values by name: truth values, literals and arrays, structural ones among them."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planarc
from planarc import Model, Recompiled, UsageError
from planarc.api.values import elements_of
from planarc.cli.app import run

KINDS = """package Kinds
  type Mode = enumeration(slow, fast);
  model Part
    parameter Mode mode = Mode.slow;
    parameter Boolean back = false;
    parameter Integer times = 1;
    parameter Integer n = 1;
    parameter Integer order[2] = {1, 2};
    Real x(start=0, fixed=true);
    Real y[order[2]];
    Real z[n];
  equation
    der(x) = (if mode == Mode.fast then 2 else 1)*(if back then -1 else 1)*times;
    y = fill(x, order[2]);
    z = fill(time, n);
  end Part;
  model Top
    parameter Integer base = 1;
    Part p[2](n={base, 2*base});
    Part one;
  end Top;
end Kinds;
"""


@pytest.fixture(scope="module")
def kinds() -> Model:
    return planarc.load(KINDS, "Kinds.Top")


def at_end(model: Model, name: str, **values: Any) -> float:
    return float(model.simulate(1, parameters=values["parameters"])[name][-1])


@pytest.mark.parametrize(
    ("given", "slope"),
    [
        ({"one.mode": "fast"}, 2.0),
        ({"one.mode": 2}, 2.0),
        ({"one.back": True}, -1.0),
        ({"one.times": 3, "one.mode": "Mode.fast"}, 6.0),
        ({"one.back": "true"}, -1.0),
        ({"one.back": "false"}, 1.0),
    ],
)
def test_values_of_every_kind(kinds: Model, given: dict[str, Any], slope: float) -> None:
    assert at_end(kinds, "one.x", parameters=given) == pytest.approx(slope)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"one.mode": 3}, "choose among `slow`, `fast`"),
        ({"one.mode": "fats"}, "did you mean `fast`"),
        ({"one.back": 0.5}, "takes true or false, not 0.5"),
        ({"one.times": 1.5}, "takes an integer, not 1.5"),
        ({"one.n": 1.5}, "takes an integer, not 1.5"),
        ({"p.n": [1, 2, 3]}, "takes 2 numbers, `p[1].n` to `p[2].n`"),
        ({"p.order": [[1, 2]]}, "takes 2 x 2 numbers, `p[1].order[1]` to `p[2].order[2]`, not 1 x"),
        (
            {"p.order": [1, 2, 3, 4]},
            "takes 2 x 2 numbers, `p[1].order[1]` to `p[2].order[2]`, not 4:",
        ),
        ({"p.order": [[1, 2], [3]]}, "not 2: [[1, 2], [3]]"),
        ({"one.back": "True"}, "`one.back` takes true or false, not `True`\n  hint: write `true`"),
        ({"one.back": "yes"}, "`one.back` takes true or false, not `yes`"),
    ],
)
@pytest.mark.filterwarnings("error")
def test_values_that_no_parameter_of_the_kind_has(
    kinds: Model, given: dict[str, Any], words: str
) -> None:
    with pytest.raises(UsageError) as caught:
        kinds.simulate(1, parameters=given)
    assert words in str(caught.value)


FIXED = """model Fixed
  parameter String label = "one";
  parameter String labels[2] = {"a", "b"};
  parameter Real rate(fixed=false, start=1);
  Real x(start=1, fixed=true);
initial equation
  rate^3 + rate = 2;
equation
  der(x) = -rate*x*(if label == "one" then 1 else 2);
end Fixed;
"""


@pytest.fixture(scope="module")
def fixed() -> Model:
    return planarc.load(FIXED)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("label", "`label` is a String, which the model is compiled with"),
        ("labels[2]", "`labels[2]` is a String"),
        ("rate", "`rate` is found at the start (`fixed=false`): no value can be given"),
    ],
)
@pytest.mark.parametrize("value", ["other", "3", 3.0])
def test_parameters_that_take_no_value_say_why(
    fixed: Model, name: str, words: str, value: Any, tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    with pytest.raises(UsageError) as caught:
        fixed.simulate(1, parameters={name: value})
    assert words in str(caught.value)
    (tmp_path / "fixed.pmo").write_text(FIXED, "utf-8")
    command = ["simulate", str(tmp_path / "fixed.pmo"), "--no-output", "--no-report"]
    assert run([*command, "--set", f"{name}={value}"]) == 2
    assert words in capsys.readouterr().err


def test_the_hint_for_a_text_works(fixed: Model) -> None:
    other = fixed.variant({"label": '"two"'})
    assert other.simulate(1)["x"][-1] == pytest.approx(np.exp(-2), rel=1e-4)


COUNTER = """model Counter
  type Mode = enumeration(off, slow, fast);
  Integer i(start=1, fixed=true);
  Boolean b(start=false, fixed=true);
  Mode mode(start=Mode.off, fixed=true);
  Real x(start=1, fixed=true);
equation
  der(x) = -x;
  when sample(0.5, 1) then
    i = pre(i) + 1;
    b = not pre(b);
    mode = pre(mode);
  end when;
end Counter;
"""


@pytest.fixture(scope="module")
def counter() -> Model:
    return planarc.load(COUNTER)


@pytest.mark.parametrize(
    ("given", "value"),
    [
        ({"i": 3}, 3),
        ({"i.start": -2.0}, -2),
        ({"b": True}, 1),
        ({"b.start": 1}, 1),
        ({"b.start": "true"}, 1),
        ({"mode": "fast"}, 3),
        ({"mode.start": "Mode.slow"}, 2),
        ({"mode": 2}, 2),
    ],
)
def test_start_values_of_every_kind(counter: Model, given: dict[str, Any], value: float) -> None:
    (name,) = given
    assert counter.simulate(1, start=given)[name.removesuffix(".start")][0] == value


@pytest.mark.parametrize("solver", ["auto", "exported"])
@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"i": 2.5}, "`i.start` takes an integer, not 2.5"),
        ({"i": True}, "`i.start` takes an integer, not true"),
        ({"i": 2.0**60}, "`i.start` takes an integer below 2^53"),
        ({"b": 0.5}, "`b.start` takes true or false, not 0.5"),
        ({"b": "on"}, "`b.start` takes true or false, not `on`"),
        ({"mode": 7}, "`mode.start` has no literal number 7"),
        ({"mode": 0}, "choose among `off`, `slow`, `fast`"),
        ({"mode": "fats"}, "did you mean `fast`"),
        ({"mode": True}, "`mode.start` takes one of `off`, `slow`, `fast`, not true"),
        ({"x": True}, "`x.start` takes a number, not true"),
    ],
)
def test_start_values_that_no_variable_of_the_kind_has(
    counter: Model, given: dict[str, Any], words: str, solver: str
) -> None:
    with pytest.raises(UsageError) as caught:
        counter.simulate(1, start=given, solver=solver)
    assert words in str(caught.value)


def test_a_study_over_start_values_of_other_kinds(counter: Model) -> None:
    study = planarc.sweep(counter, {"mode.start": ["slow", "fast"]}, "mode", workers=1)
    assert list(study["mode"]) == [2.0, 3.0]
    study = planarc.sweep(counter, {"i.start": [1.0, 2.5]}, "i", workers=1)
    assert [(f.index, f.reason) for f in study.failures] == [
        (1, "`i.start` takes an integer, not 2.5")
    ]


def sizes(model: Model, given: dict[str, Any]) -> tuple[int, ...]:
    """How many `z` the two parts have, and how many `y` the second of them."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", Recompiled)
        names = model.simulate(0, parameters=given).names
    return tuple(
        sum(n.startswith(f"{array}[") for n in names) for array in ("p[1].z", "p[2].z", "p[2].y")
    )


def test_one_element_of_a_structural_array_is_set_and_the_others_stay(kinds: Model) -> None:
    assert sizes(kinds, {}) == (1, 2, 2)
    assert sizes(kinds, {"p[2].n": 5}) == (1, 5, 2)
    assert sizes(kinds, {"p[2].order[2]": 4}) == (1, 2, 4)
    assert sizes(kinds, {"p.n": [3, 1], "p.order": [[1, 1], [1, 3]]}) == (3, 1, 3)


def test_elements_that_are_not_set_follow_what_is(kinds: Model) -> None:
    # p[2].n = 2*base, where p[1].n alone is set.
    assert sizes(kinds, {"p[1].n": 7, "base": 3}) == (7, 6, 2)


def test_an_element_computed_from_a_plain_parameter_is_not_frozen() -> None:
    text = (
        "model Frozen parameter Real a = 2; parameter Real c[2] = {1, a};"
        " parameter Integer n[2] = {1, 2}; Real x[n[1]] = fill(c[2], n[1]); end Frozen;"
    )
    model = planarc.load(text)
    with pytest.warns(Recompiled, match=r"`n\[1\]`"):
        result = model.simulate(0, parameters={"n[1]": 2, "a": 5})
    assert result["x[2]"][0] == 5.0


def test_names_of_arrays_reach_into_arrays_of_components() -> None:
    known = ("a[1].n[1]", "a[1].n[2]", "a[2].n[1]", "a[2].n[2]", "a.nn", "b[1,2]")
    assert elements_of("a.n", known) == {(i, j): f"a[{i}].n[{j}]" for i in (1, 2) for j in (1, 2)}
    assert elements_of("a[2].n", known) == {(1,): "a[2].n[1]", (2,): "a[2].n[2]"}
    assert elements_of("b", known) == {(1, 2): "b[1,2]"}
    assert elements_of("a", known) == {}


def test_a_study_and_sensitivities_of_another_structure(kinds: Model) -> None:
    with pytest.warns(Recompiled):
        study = planarc.sweep(
            kinds, {"one.mode": ["slow", "fast"]}, "one.z[3]", parameters={"one.n": 3}, workers=1
        )
    assert study.failures == ()
    assert list(study["one.z[3]"]) == [1.0, 1.0]
    text = "model Grows parameter Integer n = 1; parameter Real k = 1; Real x[n](each start=1,"
    model = planarc.load(f"{text} each fixed=true); equation der(x) = k*x; end Grows;")
    with pytest.warns(Recompiled):
        found = model.sensitivities(["k"], values={"n": 2}, stop_time=1)
    assert found["x[2]", "k"][-1] == pytest.approx(np.e, rel=1e-5)


def test_a_computed_parameter_names_those_that_may_be_set() -> None:
    text = "model Area parameter Real a = 2; parameter Real b = 3; final parameter Real c = a*b;"
    model = planarc.load(f"{text} Real x = c; end Area;")
    with pytest.raises(UsageError, match="`c` cannot be set: it is computed from `a` and `b`"):
        model.simulate(0, parameters={"c": 1.0})


def test_a_literal_of_a_predefined_enumeration() -> None:
    text = """model Asked
      parameter StateSelect choice = StateSelect.avoid;
      Real x(start=1, fixed=true, stateSelect=choice);
      Real y = 2*x;
    equation
      der(x) = -y;
    end Asked;"""
    with pytest.warns(Recompiled):
        result = planarc.load(text).simulate(1, parameters={"choice": "always"})
    assert result.parameters["choice"] == 5


def test_values_with_units_are_taken_everywhere() -> None:
    model = planarc.load(Path(__file__).parents[2] / "examples" / "pendulum.pmo")
    given = {"rod.m": "500g", "rod.r": ["20cm", 0]}
    start = {"hinge.phi": "45deg", "hinge.w.start": "60rpm"}
    run = model.simulate("500ms", interval="10ms", parameters=given, start=start)
    assert (run.time[-1], len(run)) == (0.5, 51)
    assert run.parameters["rod.m"] == 0.5
    assert run["hinge.phi"][0] == pytest.approx(np.pi / 4)
    assert run["hinge.w"][0] == pytest.approx(2 * np.pi)
    study = planarc.sweep(model, {"rod.m": ["500g", 1]}, workers=1, stop_time="10ms")
    assert study["rod.m"].tolist() == [0.5, 1.0]
    with pytest.raises(planarc.UsageError, match=r"C115.*`rod\.m` takes a value in `kg`"):
        model.simulate(parameters={"rod.m": "5m"})


FORMULAS = """model Formulas
  parameter Real a = 1;
  parameter Real b = 2*a;
  parameter Real v[2] = {a, 3*a};
  final parameter Real c = 4*a;
  Modelica.Blocks.Nonlinear.Limiter limiter(uMax=2);
  Real x(start=0, fixed=true);
protected
  parameter Real h = 5*a;
equation
  limiter.u = -9;
  der(x) = b;
end Formulas;"""


@pytest.fixture(scope="module")
def formulas() -> Model:
    return planarc.load(FORMULAS)


def test_a_number_takes_the_place_of_a_formula(formulas: Model) -> None:
    """Also one that the formula gives for the defaults: it is to stay, whatever `a` is."""
    for b in (5, 2):
        with pytest.warns(Recompiled, match="`b` is computed from others: the model is compiled"):
            result = formulas.simulate(1, parameters={"a": 3, "b": b})
        assert (result["a"][0], result["b"][0], result["x"][-1]) == (3, b, pytest.approx(b))
    with pytest.warns(Recompiled, match="`limiter.uMin`"):
        result = formulas.simulate(1, parameters={"limiter.uMin": -1, "v": [7, 8]})
    assert (result["limiter.y"][-1], result["v[2]"][0], result["b"][0]) == (-1, 8, 2)
    assert formulas.simulate(1, parameters={"a": 3})["b"][0] == 6


@pytest.mark.parametrize(
    ("name", "told"), [("c", "R405"), ("h", "R405"), ("v[1]", r"C205.*`v\[2\]` is computed")]
)
def test_not_every_formula_gives_way(formulas: Model, name: str, told: str) -> None:
    with pytest.raises(UsageError, match=f"(?s){told}"):
        formulas.simulate(1, parameters={name: 1})


def test_a_study_keeps_a_formula_that_it_does_not_vary(formulas: Model) -> None:
    with pytest.warns(Recompiled):
        table = planarc.sweep(formulas, {"a": [1, 2]}, metric=["b"], parameters={"b": 7})
    assert list(table["b"]) == [7, 7]
    with pytest.raises(UsageError, match=r"(?s)R405.*one value for all runs"):
        planarc.sweep(formulas, {"b": [1, 2]}, metric=["x"])


def test_a_result_is_read_with_the_number_in_the_place_of_a_formula(tmp_path: Path) -> None:
    file, table = tmp_path / "formulas.pmo", tmp_path / "formulas.csv"
    file.write_text(FORMULAS, "utf-8")
    given = ["--set", "a=3", "--set", "b=2", "--output", str(table), "--no-report"]
    assert run(["simulate", str(file), *given]) == 0
    found = planarc.read(table)
    assert (found["a"][0], found["b"][0], found["x"][-1]) == (3, 2, pytest.approx(2))
