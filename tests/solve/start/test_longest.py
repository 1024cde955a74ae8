"""One part that is far longer than all others is told; machines that are large are not."""

from __future__ import annotations

import pytest

import planarc

ARM = """model Arm
  import PlanarMultiBody.*;
  inner World world;
  Parts.Fixed column(r={0,%s});
  Joints.Revolute shoulder(phi(start=0.2, fixed=true), w(fixed=true));
  Parts.BodyShape upper(r={%s,0}, m=1);
  Joints.Revolute elbow(phi(start=0.5, fixed=true), w(fixed=true));
  Parts.BodyShape lower(r={0,%s}, m=1);
equation
  connect(column.frame_b, shoulder.frame_a);
  connect(shoulder.frame_b, upper.frame_a);
  connect(upper.frame_b, elbow.frame_a);
  connect(elbow.frame_b, lower.frame_a);
end Arm;
"""


def told(*lengths: float, arm: str = ARM) -> list[str]:
    found = planarc.load(arm % lengths).simulate(0.0).warnings
    return [w.message for w in found if w.code == "R441"]


@pytest.mark.parametrize(
    ("lengths", "message"),
    [
        (
            (0.2, 0.5, 400),
            "`lower` is 400 m long, and nothing else in its mechanism more than 0.5 m",
        ),
        (
            (0.8, 300, 0.5),
            "`upper` is 300 m long, and nothing else in its mechanism more than 0.8 m",
        ),
    ],
)
def test_one_part_in_mm(lengths: tuple[float, ...], message: str) -> None:
    assert told(*lengths) == [message]


def test_all_in_mm() -> None:
    assert told(500, 600, 400) == [
        "`upper` is 600 m long, and has a radius of gyration of no more than 0.0316 m"
    ]


@pytest.mark.parametrize(
    "lengths",
    [
        pytest.param((0.2, 60, 0.5), id="a crane with a hook"),
        pytest.param((400, 0.4, 0.5), id="a machine on a tower"),
        pytest.param((0.02, 5, 0.01), id="of lengths that are plausible"),
    ],
)
def test_large_machines_are_not_told(lengths: tuple[float, ...]) -> None:
    assert told(*lengths, arm=ARM.replace("m=1", "m=1, I=5")) == []


def test_a_boom_with_the_inertia_of_the_library() -> None:
    (message,) = told(0.2, 3.5, 0.5)
    assert message.startswith("`upper` has the inertia of bodies where none is given, 0.001 kg.m2")
    assert told(0.2, 0.8, 0.5) == []


@pytest.mark.parametrize(
    ("arm", "centre", "message"),
    [
        (None, 150, "150 m long up to its `centre`, and has a radius of gyration of no more than"),
        (0.4, 150, "150 m long up to its `centre`, and nothing else in its mechanism more than"),
        (None, 50, None),
        (0.4, 0.2, None),
    ],
)
def test_a_centre_of_mass_in_mm(arm: float | None, centre: float, message: str | None) -> None:
    rod = "" if arm is None else f"Parts.FixedTranslation rod(r={{{arm},0}});"
    end = "hinge.frame_b" if arm is None else "rod.frame_b"
    text = f"""model Arm
      import PlanarMultiBody.*;
      inner World world;
      Joints.Revolute hinge(phi(start=0.2, fixed=true), w(fixed=true));
      {rod}
      Parts.Body bob(m=1, I=0.01, r_CM={{{centre},0}});
    equation
      connect(world.frame_b, hinge.frame_a);
      {"connect(hinge.frame_b, rod.frame_a);" if rod else ""}
      connect({end}, bob.frame_a);
    end Arm;"""
    found = [w.message for w in planarc.load(text).simulate(0.0).warnings if w.code == "R441"]
    if message is None:
        assert found == []
    else:
        assert len(found) == 1 and message in found[0]
