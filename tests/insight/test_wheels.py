"""A wheel on the standing side of its hinge is told, and one that is meant to stand is not."""

from __future__ import annotations

import pytest

from planarc.probe.check import check_model
from planarc.request.request import Request

DRIVE = """model Drive
  import PlanarMultiBody.*;
  inner World world;
  Parts.FixedTranslation ground(r={0.5, 0});
  Joints.Revolute ja(phi(fixed=true), w(start=1, fixed=true)), jb(phi(fixed=true), w(fixed=true));
  Parts.Body ba(m=1, I=0.01), bb(m=1, I=0.01);
  Contacts.Belt belt(Ra=0.05, Rb=0.1);
equation
  connect(world.frame_b, ja.frame_a);
  connect(world.frame_b, ground.frame_a);
  connect(ground.frame_b, jb.frame_a);
  connect(ja.frame_b, ba.frame_a);
  connect(jb.frame_b, bb.frame_a);
  connect(%s, belt.frame_a);
  connect(%s, belt.frame_b);
end Drive;
"""
#: A planet on a carrier rolls about a sun that stands.
PLANET = """model Planet
  import PlanarMultiBody.*;
  inner World world;
  Joints.Revolute axis(phi(fixed=true), w(start=1, fixed=true)), pin;
  Parts.BodyShape carrier(r={0.15, 0}, m=1);
  Parts.Body planet(m=1, I=0.01);
  Contacts.GearPair gear(Ra=0.1, Rb=0.05);
equation
  connect(world.frame_b, axis.frame_a);
  connect(axis.frame_b, carrier.frame_a);
  connect(carrier.frame_b, pin.frame_a);
  connect(pin.frame_b, planet.frame_a);
  connect(axis.frame_a, gear.frame_a);
  connect(pin.frame_b, gear.frame_b);
end Planet;
"""


#: A planet between a sun that stands and a ring that turns.
RING = PLANET.replace("gear(Ra=0.1, Rb=0.05)", "gear(Ra=0.1, Rb=0.05), mesh(Ra=-0.2, Rb=0.05)")
RING = RING.replace("pin;", "pin, around;").replace("planet(m=1, I=0.01)", "planet(m=1), ring(m=1)")
RING = RING.replace(
    "end Planet;",
    "connect(world.frame_b, around.frame_a); connect(around.frame_b, ring.frame_a);"
    "connect(around.frame_b, mesh.frame_a); connect(pin.frame_b, mesh.frame_b); end Planet;",
)
#: The same with the ring held and the sun turning, as in a gearbox.
HELD = RING.replace("connect(axis.frame_a, gear.frame_a)", "connect(around.frame_b, gear.frame_a)")
HELD = HELD.replace("connect(around.frame_b, mesh", "connect(world.frame_b, mesh")


def told(text: str) -> list[str]:
    found = check_model(Request(text=text)).warnings
    return [f"{w.message}; {w.hint}" for w in found if w.code == "S323"]


@pytest.mark.parametrize("at", ["ja.frame_a", "world.frame_b"])
def test_beside_its_hinge(at: str) -> None:
    assert told(DRIVE % (at, "jb.frame_b")) == [
        "`belt.frame_a` is on the side of `ja` that stands still; "
        "write `connect(ja.frame_b, belt.frame_a);`, so that it turns"
    ]


def test_the_other_end() -> None:
    assert told(DRIVE % ("ja.frame_b", "jb.frame_a")) == [
        "`belt.frame_b` is on the side of `jb` that stands still; "
        "write `connect(jb.frame_b, belt.frame_b);`, so that it turns"
    ]


@pytest.mark.parametrize("text", [DRIVE % ("ja.frame_b", "jb.frame_b"), PLANET, RING, HELD])
def test_what_turns_is_not_told(text: str) -> None:
    assert told(text) == []
