"""Events in words of the components at which they happen."""

from __future__ import annotations

from pathlib import Path

import pytest

import planarc

EXAMPLES = Path(__file__).parents[2] / "examples"
DOOR = """package Doors
  model Door "Falls to and springs back"
    Real s(start=1, fixed=true);
    Real v(start=0, fixed=true);
    Boolean shut = s < 0;
    Real load = if s < 0.5 then 1 else 0;
  equation
    der(s) = v;
    der(v) = if shut then -400*s else -1 - 0*load;
    annotation(__planarc(event('falls to' = shut, 'springs open'(from = shut) = not shut)));
  end Door;

  model House
    Door front, back(s(start=2));
    annotation(experiment(StopTime=2.5));
  end House;
end Doors;"""


def causes(model: planarc.Model) -> list[str]:
    return [c for e in model.simulate().events for c in e.causes]


def test_components_say_what_happens_to_them() -> None:
    told = causes(planarc.load(DOOR))
    assert [c for c in told if c.startswith("`front` ")] == [
        "`front` falls to",
        "`front` springs open",
    ]
    assert "`back` falls to" in told
    # Of a relation without a word the component is told.
    assert "`front`: s < 0.5" in told
    assert not any("s < 0" in c and "0.5" not in c for c in told)


def test_friction_sticks_breaks_away_and_turns_round() -> None:
    cam = causes(planarc.load(EXAMPLES / "tutorial" / "10_driven_cam_with_friction.pmo"))
    assert "`bearing` sticks" in cam
    assert "`bearing` breaks away forwards" in cam
    slide = causes(planarc.load(EXAMPLES / "tutorial" / "08_dry_friction.pmo"))
    assert "`friction` turns round, and slides forwards" in slide
    assert "`friction` turns round, and slides backwards" in slide
    assert "`friction` sticks" in slide


def test_a_gap_says_when_it_touches() -> None:
    text = """model Bump
      Modelica.Mechanics.Translational.Components.Mass mass(
        m=1, s(start=0.1, fixed=true), v(start=-1, fixed=true));
      Modelica.Mechanics.Translational.Components.ElastoGap stop(c=1e4, d=1);
      Modelica.Mechanics.Translational.Components.Fixed wall;
    equation
      connect(wall.flange, stop.flange_a);
      connect(stop.flange_b, mass.flange_a);
      annotation(experiment(StopTime=1));
    end Bump;"""
    assert causes(planarc.load(text)) == ["`stop` touches", "`stop` lets go"]


def test_a_mass_says_at_which_stop_it_is() -> None:
    text = """model Bump
      Modelica.Mechanics.Translational.Components.MassWithStopAndFriction mass(
        m=1, L=0.1, smax=1, smin=-1, F_Coulomb=1, F_prop=1, F_Stribeck=0,
        v(start=3, fixed=true), s(start=0, fixed=true));
      annotation(experiment(StopTime=2));
    end Bump;"""
    assert causes(planarc.load(text)) == ["`mass` meets the stop ahead", "`mass` sticks"]


def test_relations_of_a_model_without_words_stay_as_they_are() -> None:
    text = """model Fall Real x(start=1, fixed=true); equation der(x) = if x > 0.5 then -1 else -2;
    annotation(experiment(StopTime=1)); end Fall;"""
    assert causes(planarc.load(text)) == ["x > 0.5"]


@pytest.mark.parametrize(
    ("annotation", "told"),
    [
        ("event = x > 0", "say what happens"),
        ("event('moves')", "say when"),
        ("event('moves' = x)", "must be true or false"),
        ("event('moves'(form = x > 0) = x > 1)", "did you mean `from`"),
        ("event('moves'(from = x) = x > 1)", "must be true or false"),
        ("event('moves' = y > 1)", "F210"),
        ("events('moves' = x > 1)", "did you mean `event`"),
    ],
)
def test_a_wrong_declaration_is_told(annotation: str, told: str) -> None:
    text = f"""model M Real x(start=1, fixed=true); equation der(x) = -x;
    annotation(__planarc({annotation})); end M;"""
    with pytest.raises(planarc.PlanarcError, match=told):
        planarc.load(text)
