"""Runs that start elsewhere: at rest, in another assembly, where another run ended."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import planarc
from planarc.cli.app import run

EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.fixture(scope="module")
def four_bar() -> planarc.Model:
    return planarc.load(EXAMPLES / "four_bar.pmo")


def test_a_run_goes_on_where_another_one_ended(four_bar: planarc.Model, tmp_path: Path) -> None:
    whole = four_bar.simulate(2, tolerance=1e-10)
    half = four_bar.simulate(1, tolerance=1e-10)
    rest = four_bar.simulate(1, tolerance=1e-10, start_from=half)
    for name in ("revA.phi", "revD.phi", "revC.w"):
        assert rest[name][0] == pytest.approx(half[name][-1], abs=1e-9)
        assert rest[name][-1] == pytest.approx(whole[name][-1], abs=1e-6)
    for file in (half.to_csv(tmp_path / "half.csv"), half.to_mat(tmp_path / "half.mat")):
        read = four_bar.simulate(0, start_from=str(file))
        assert read["revB.phi"][0] == pytest.approx(half["revB.phi"][-1], abs=1e-9)


def test_dry_friction_goes_on_as_it_was() -> None:
    model = planarc.load(EXAMPLES / "tutorial" / "08_dry_friction.pmo")
    whole, half = model.simulate(2), model.simulate(1)
    rest = model.simulate(1, start_from=half)
    name = next(iter(model.states))
    assert rest[name][-1] == pytest.approx(whole[name][-1], abs=1e-5)


def test_a_run_starts_at_rest_and_stays(four_bar: planarc.Model) -> None:
    result = four_bar.simulate(1, start_from="equilibrium")
    assert np.ptp(result["revA.phi"]) < 1e-6
    same = four_bar.simulate(0, start_from=four_bar.equilibrium())
    assert same["revA.phi"][0] == pytest.approx(result["revA.phi"][0], abs=1e-9)


def test_a_run_starts_in_any_assembly(four_bar: planarc.Model) -> None:
    ways = four_bar.assemble()
    for i, way in enumerate(ways, 1):
        for place in (f"assembly {i}", f"assembly:{i}", way):
            begun = four_bar.simulate(0, start_from=place)
            assert begun["revD.phi"][0] == pytest.approx(way["revD.phi"], abs=1e-7)


def test_given_start_values_count_first(four_bar: planarc.Model) -> None:
    result = four_bar.simulate(0, start_from="assembly 1", start={"revA.w": 3})
    assert result["revA.w"][0] == 3


@pytest.mark.parametrize(
    ("place", "told"),
    [
        ("equilibirum", r"C215.*`equilibirum`.*did you mean `equilibrium`"),
        ("assembly 9", r"C215.*no assembly 9: 2 ways are found"),
        ("assembly", r"C215"),
        (3, r"C215"),
        ("nosuch.csv", r"V503"),
    ],
)
def test_a_wrong_place_is_told(four_bar: planarc.Model, place: object, told: str) -> None:
    with pytest.raises(planarc.UsageError, match=f"(?s){told}"):
        four_bar.simulate(0, start_from=place)  # type: ignore[arg-type]


def test_a_result_of_another_model_is_refused(four_bar: planarc.Model) -> None:
    other = planarc.load(EXAMPLES / "pendulum.pmo")
    with pytest.raises(planarc.UsageError, match=r"C290.*`FourBar` is no result of `Pendulum`"):
        other.simulate(start_from=four_bar.simulate(0.1))


def test_what_has_no_state_of_rest_says_so() -> None:
    model = planarc.load("model Fall Real x(start=1, fixed=true); equation der(x) = -1; end Fall;")
    with pytest.raises(planarc.PlanarcError, match="R471"):
        model.simulate(start_from="equilibrium")


def test_the_command_starts_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    command = ["simulate", str(EXAMPLES / "four_bar.pmo"), "--no-report", "--stop", "0.1"]
    assert run([*command, "--start-from", "assembly 2", "--output", "two.csv"]) == 0
    assert run([*command, "--start-from", "two.csv", "--output", "three.csv"]) == 0
    begin = [float(x) for x in Path("two.csv").read_text("utf-8").splitlines()[-1].split(",")]
    after = [float(x) for x in Path("three.csv").read_text("utf-8").splitlines()[1].split(",")]
    assert after[1:] == pytest.approx(begin[1:], abs=1e-5)
    assert run([*command, "--start-from", "nothing"]) == 2
    assert "error[C215]" in capsys.readouterr().err


INITIAL = """
model Swing
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Revolute hinge;
  PlanarMultiBody.Parts.Body bob(m=1, I=0, r_CM={1, 0});
initial equation
  hinge.phi = 0.5;
  hinge.w = 0;
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, bob.frame_a);
end Swing;
"""


def test_a_start_that_initial_equations_overrule_is_told() -> None:
    model = planarc.load(INITIAL)
    result = model.simulate(0.1, start={"hinge.phi": 1.0})
    assert result["hinge.phi"][0] == pytest.approx(0.5)
    (found,) = [w for w in result.warnings if w.code == "R442"]
    assert "initial equations decide it" in found.message
    assert not [w for w in model.simulate(0.1).warnings if w.code == "R442"]


def test_a_place_counts_more_than_initial_equations() -> None:
    model = planarc.load(INITIAL)
    rest = model.equilibrium()
    for place in ("equilibrium", rest):
        hanging = model.simulate(1, start_from=place)
        assert np.ptp(hanging["hinge.phi"]) < 1e-6
        assert [w.code for w in hanging.warnings] == ["R451"]  # nothing moves
    half = model.simulate(1, tolerance=1e-10)
    after = model.simulate(1, tolerance=1e-10, start_from=half)
    whole = model.simulate(2, tolerance=1e-10)
    assert after["hinge.phi"][-1] == pytest.approx(whole["hinge.phi"][-1], abs=1e-7)
    kicked = model.simulate(0, start_from=half, start={"hinge.w": 2})
    assert kicked["hinge.w"][0] == 2
    assert kicked["hinge.phi"][0] == pytest.approx(half["hinge.phi"][-1])
    assert model.linearize(rest.start).A[1, 0] == pytest.approx(-9.81)
    stepper = model.stepper(0.1, start_from=half)
    assert stepper["hinge.phi"] == pytest.approx(half["hinge.phi"][-1])
    assert model.simulate(0)["hinge.phi"][0] == 0.5


SAMPLED = """
model Sampled
  Real x;
  parameter Real k(fixed=false);
  discrete Real z;
  discrete Integer n(start=3, fixed=true);
initial equation
  x = 1;
  der(x) = -2;
  z = 5*x;
equation
  der(x) = -k*x;
  when sample(0.4, 0.4) then
    z = pre(z) + 10;
    n = pre(n) + 1;
  end when;
end Sampled;
"""


def test_what_initial_equations_found_goes_on() -> None:
    """A parameter of theirs keeps its value, discrete variables theirs."""
    model = planarc.load(SAMPLED)
    first = model.simulate(1)
    after = model.simulate(0.1, start_from=first)
    assert [after[n][0] for n in ("k", "z", "n")] == [2, 25, 5]
    assert after["x"][0] == first["x"][-1] == pytest.approx(np.exp(-2), rel=1e-4)
    assert model.simulate(0, start_from="equilibrium")["z"][0] == 5


def test_a_place_that_tells_a_part_leaves_initial_equations(tmp_path: Path) -> None:
    """Else the others would start anywhere."""
    model = planarc.load(SAMPLED)
    table = model.simulate(1).to_csv(tmp_path / "half.csv", variables="x|z")
    found = model.simulate(0, start_from=table)
    assert (found["x"][0], found["k"][0]) == (1, 2)
    assert [w.code for w in found.warnings] == ["R442"]


def test_linear_models_of_a_state_of_rest_are_those_of_that_place() -> None:
    """Also where initial equations begin elsewhere: the pendulum hangs, w^2 = g/l."""
    found = planarc.load(INITIAL).linearize("equilibrium")
    assert sorted(found.eigenvalues.imag) == pytest.approx([-(9.81**0.5), 9.81**0.5], rel=1e-6)
