"""Lengths that do not suit a mechanism are told, and no others."""

from __future__ import annotations

import pytest

import planarc

TEXT = """model Arm
  import PlanarMultiBody.*;
  inner World world;
  Joints.Revolute hinge(phi(start=0.5, fixed=true), w(fixed=true));
  Parts.FixedTranslation rod(r={%s,0});
  Parts.Body body(m=%s, I=%s);
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, rod.frame_a);
  connect(rod.frame_b, body.frame_a);
end Arm;
"""

OWN = """model Own
  model Ball
    extends PlanarMultiBody.Parts.PointMass;
    parameter Real R(unit="m") = %s;
    annotation(__planarc(size('radius R' = R)));
  end Ball;
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Parts.Fixed hook(r={0, 0.5});
  PlanarMultiBody.Forces.Spring spring(c=100);
  Ball ball(m=1, fixAngle=true);
equation
  connect(hook.frame_b, spring.frame_a);
  connect(spring.frame_b, ball.frame_a);
end Own;
"""


def told(text: str) -> list[str]:
    found = planarc.load(text).simulate(0.0).warnings
    return [w.message for w in found if w.code == "R441"]


@pytest.mark.parametrize(
    ("length", "m", "inertia", "count"),
    [
        (0.3, 1, 650, 1),
        (0.3, 1, 0.01, 0),
        (0.3, 0, 650, 0),  # without mass there is no radius
        (100, 1e4, 1e6, 0),
        (0.1, 1, 4.5, 0),  # a large rotor on a short arm
        (0, 1, 650, 0),  # all is in one place
    ],
)
def test_inertias_are_compared_with_the_mechanism(
    length: float, m: float, inertia: float, count: int
) -> None:
    found = told(TEXT % (length, m, inertia))
    assert len(found) == count
    if count:
        assert found == [
            "`body` has a radius of gyration sqrt(I/m) of 25.5 m, in a mechanism of 0.3 m"
        ]


def test_values_of_a_run_count() -> None:
    model = planarc.load(TEXT % (0.3, 1, 0.01))
    for inertia, count in ((650, 1), (0.02, 0), (1e3, 1)):
        found = model.simulate(0.0, parameters={"body.I": inertia}).warnings
        assert [w.code for w in found] == ["R441"] * count


def test_users_own_sizes_count() -> None:
    assert told(OWN % 20) == ["`ball` has a radius R of 20 m, in a mechanism of 0.5 m"]
    assert told(OWN % 2) == []


@pytest.mark.parametrize(
    ("place", "free", "message"),
    [
        (
            "500,0",
            0.4,
            "`spring` is 500 m long at the start, 1.25e+03 times its length s_unstretched",
        ),
        ("0.5,0", 0.4, None),
        ("0.5,0", 0, None),  # a spring without length is a common idea
    ],
)
@pytest.mark.parametrize("kind", ["Spring", "SpringDamperParallel", "SpringDamperSeries"])
def test_springs_are_compared_with_themselves(
    kind: str, place: str, free: float, message: str | None
) -> None:
    text = f"""model Hung
      import PlanarMultiBody.*;
      inner World world;
      Parts.Fixed hook(r={{{place}}});
      Joints.Prismatic rail(s(fixed=true), v(fixed=true));
      Parts.Body body(m=1);
      Forces.{kind} spring(c=100, {"" if kind == "Spring" else "d=1,"} s_unstretched={free});
    equation
      connect(world.frame_b, rail.frame_a);
      connect(rail.frame_b, body.frame_a);
      connect(body.frame_a, spring.frame_a);
      connect(hook.frame_b, spring.frame_b);
    end Hung;"""
    assert told(text) == ([] if message is None else [message])


def test_what_is_another_name_for_a_coordinate_counts() -> None:
    text = OWN.replace("size('radius R' = R)", "size('radius R'(of = -frame_a.r[2]) = R)")
    text = text.replace("fixAngle=true", "fixAngle=true, r(start={0,-500}, each fixed=true)")
    (message,) = told(text % 1)
    assert message.startswith("`ball` is 500 m long at the start, 500 times its radius R")


@pytest.mark.parametrize(
    ("annotation", "said"),
    [
        ("size = x", "say which size"),
        ("size('length' = x > 1)", "must be a number"),
        ("size('length')", "say how large"),
        ("size('length'(off = x) = x)", "did you mean `of`"),
        ("sizes('length' = x)", "did you mean `size`"),
    ],
)
def test_a_wrong_declaration_is_told(annotation: str, said: str) -> None:
    text = f"""model M Real x(start=1, fixed=true); equation der(x) = -x;
    annotation(__planarc({annotation})); end M;"""
    with pytest.raises(planarc.PlanarcError, match=said):
        planarc.load(text)
