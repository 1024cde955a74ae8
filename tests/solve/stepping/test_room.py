"""Contacts between motions that are given: refused where there is no room, and only there."""

from __future__ import annotations

import numpy as np
import pytest

import planarc
from planarc.core.data import Data
from planarc.solve.stepping import moreau


class Looks(Data):
    """How often contacts without room were looked for."""

    found: list[list[int]]


@pytest.fixture
def looks(monkeypatch: pytest.MonkeyPatch) -> Looks:
    made = Looks([])
    pinched = moreau.Struck.pinched

    def look(self: moreau.Struck, *given: object) -> list[int]:
        made.found.append(pinched(self, *given))  # type: ignore[arg-type]
        return made.found[-1]

    monkeypatch.setattr(moreau.Struck, "pinched", look)
    return made


CAM = """
model Cam "An eccentric disc, driven, in a yoke without play"
  import PlanarMultiBody.*;
  parameter Real w=3;
  inner World world;
  Joints.Revolute shaft(drivenFlange=true, phi(fixed=true));
  Modelica.Mechanics.Rotational.Sources.ConstantSpeed drive(w_fixed=w);
  Joints.Prismatic way(n={1, 0}, s(start=0.1, fixed=true), v(fixed=true));
  Parts.Body yoke(m=2, I=0.1);
  Contacts.Contact left(redeclare Contacts.Circle contour1(R=0.2, r={0.1, 0}),
    redeclare Contacts.HalfPlane contour2(r={-0.2, 0}, angle=-Modelica.Constants.pi/2), mu=0.1);
  Contacts.Contact right(redeclare Contacts.Circle contour1(R=0.2, r={0.1, 0}),
    redeclare Contacts.HalfPlane contour2(r={0.2, 0}, angle=Modelica.Constants.pi/2), mu=0.1);
equation
  connect(world.frame_b, shaft.frame_a);
  connect(drive.flange, shaft.axis);
  connect(world.frame_b, way.frame_a);
  connect(way.frame_b, yoke.frame_a);
  connect(shaft.frame_b, left.frame_a);
  connect(shaft.frame_b, right.frame_a);
  connect(yoke.frame_a, left.frame_b);
  connect(yoke.frame_a, right.frame_b);
end Cam;
"""


def test_a_cam_without_play_turns_in_its_yoke(looks: Looks) -> None:
    """s = r*cos(w*t) to the first order of the step, for two turns; nothing is refused."""
    r = planarc.load(CAM).simulate(stop_time=4.2, contact="stepping")
    np.testing.assert_allclose(r["way.s"], 0.1 * np.cos(3 * r.time), atol=2e-3)
    assert not any(looks.found)


LID = """
model Lid "A driven lid closes a box that its balls fill"
  import PlanarMultiBody.*;
  parameter Real depth=0.1;
  inner World world;
  Joints.Prismatic way(n={0, 1}, drivenFlange=true);
  Modelica.Mechanics.Translational.Sources.Position motion(exact=true);
  Modelica.Blocks.Sources.KinematicPTP2 way_down(q_begin={0.5}, q_end={0.5 - depth}, qd_max={1},
    qdd_max={10});
  Parts.Body ball[4](each m=1, each I=0.01,
    r(start={{0.1, 0.1}, {0.3, 0.1}, {0.1, 0.3}, {0.3, 0.3}}, each fixed=true),
    v(each fixed=true), phi(each fixed=true), w(each fixed=true));
  Contacts.Crowd crowd(n=5, R={0.1, 0.1, 0.1, 0.1, 0.05}, length={0, 0, 0, 0, 0.4}, mu=0.3,
    walls=[0, 0, 0.4, 0; 0, 0, 0, 1; 0.4, 0, 0.4, 1]);
  Parts.FixedTranslation lid(r={0.2, 0.05});
equation
  connect(world.frame_b, way.frame_a);
  connect(motion.flange, way.axis);
  connect(way_down.q[1], motion.s_ref);
  connect(way.frame_b, lid.frame_a);
  connect(ball.frame_a, crowd.frame_a[1:4]);
  connect(lid.frame_b, crowd.frame_a[5]);
  connect(world.frame_b, crowd.frame_b);
end Lid;
"""


def test_a_lid_may_close_a_full_box(looks: Looks) -> None:
    """It comes to rest where the balls fill the box: they are not pressed, and the floor carries
    their weight."""
    r = planarc.load(LID).simulate(stop_time=1, fixed_step=1e-3)
    assert not any(looks.found)
    assert r["crowd.f_b[2]"][-1] == pytest.approx(-4 * 9.81, rel=0.01)


def test_a_lid_that_goes_on_is_refused() -> None:
    with pytest.raises(planarc.PlanarcError, match=r"press against each other, and nothing"):
        planarc.load(LID).simulate(stop_time=1, fixed_step=1e-3, parameters={"depth": 0.11})


def test_a_heap_is_not_refused(looks: Looks) -> None:
    r = planarc.load("PlanarMultiBody.Examples.Contacts.FullBox").simulate(stop_time=1)
    assert r.time[-1] == 1.0 and not any(looks.found)


def test_a_heavy_ram_throws_the_ball_aside() -> None:
    """A ball off the middle between round ends leaves sideways: impulses grow, none is refused."""
    text = """
model Aside
  import PlanarMultiBody.*;
  inner World world(gravityType=Types.GravityTypes.NoGravity);
  Joints.Prismatic ram(n={1, 0}, drivenFlange=true);
  Modelica.Mechanics.Translational.Sources.ConstantSpeed drive(v_fixed=1);
  Parts.Body ball(m=1, I=0.004, r(start={0.5, 0.01}, each fixed=true), v(each fixed=true),
    phi(fixed=true), w(fixed=true));
  Parts.Fixed anvil(r={1, 0});
  Contacts.Contact behind(redeclare Contacts.Circle contour1(R=0.1),
    redeclare Contacts.Circle contour2(R=0.1));
  Contacts.Contact ahead(redeclare Contacts.Circle contour1(R=0.1),
    redeclare Contacts.Circle contour2(R=0.1));
equation
  connect(world.frame_b, ram.frame_a);
  connect(drive.flange, ram.axis);
  connect(ram.frame_b, behind.frame_a);
  connect(ball.frame_a, behind.frame_b);
  connect(ball.frame_a, ahead.frame_a);
  connect(anvil.frame_b, ahead.frame_b);
end Aside;
"""
    r = planarc.load(text).simulate(stop_time=0.8, contact="stepping")
    assert r["ball.r[2]"][-1] > 0.1
    for contact in ("behind", "ahead"):
        assert r[f"{contact}.gap[1]"].min() > -2e-3
