"""A spring through whose end its load goes is told, unless it is meant to draw them together."""

from __future__ import annotations

import planarc

STRUT = """model Strut
  import PlanarMultiBody.{Forces, Joints, Parts};
  inner PlanarMultiBody.World world;
  Joints.Prismatic guide(n={0, 1}, s(start=0.3, fixed=true), v(fixed=true));
  Parts.Body load(m=1, I=0.1);
  Forces.Spring spring(c=200SPRING);
equation
  connect(world.frame_b, guide.frame_a);
  connect(guide.frame_b, load.frame_a);
  connect(world.frame_b, spring.frame_a);
  connect(spring.frame_b, load.frame_a);
end Strut;
"""


def told(spring: str) -> list[str | None]:
    run = planarc.load(STRUT.replace("SPRING", spring)).simulate(1)
    return [w.hint for w in run.warnings if w.code == "R447"]


def test_a_length_of_zero_is_told_where_it_is_the_default() -> None:
    (hint,) = told("")
    assert hint == (
        "its length without load is 0, so that it draws its ends together: give "
        "`spring.s_unstretched`"
    )


def test_a_length_of_zero_that_is_written_is_meant() -> None:
    assert told(", s_unstretched=0") == told(", s_unstretched=0.0") == []


def test_a_spring_with_a_length_is_told() -> None:
    assert len(told(", s_unstretched=0.02")) == 1
