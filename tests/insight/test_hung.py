"""A body on the standing side of a joint is told, and none that moves or is a base of its own."""

from __future__ import annotations

import pytest

import planarc
from planarc.core.diagnostic import Severity

CART = """model Cart
  import PlanarMultiBody.*;
  inner World world;
  Joints.Prismatic rail(s(fixed=true), v(fixed=true));
  Parts.Body cart(m=2, I=0.05);
  Joints.Revolute hinge(phi(start=-1.2, fixed=true), w(fixed=true));
  Parts.BodyShape pole(r={0.8, 0}, m=0.3, I=0.016);
  MORE
equation
  connect(world.frame_b, rail.frame_a);
  connect(rail.frame_b, hinge.frame_a);
  connect(hinge.frame_b, pole.frame_a);
  CONNECT
end Cart;
"""


def told(connect: str, more: str = "") -> list[tuple[Severity, str]]:
    text = CART.replace("CONNECT", connect).replace("MORE", more)
    found = [w for w in planarc.load(text).warnings if w.code == "S323"]
    return [(w.severity, f"{w.message} {w.hint}") for w in found]


@pytest.mark.parametrize(
    "connect", ["connect(rail.frame_a, cart.frame_a);", "connect(cart.frame_a, rail.frame_a);"]
)
def test_a_cart_on_the_standing_side_is_told(connect: str) -> None:
    ((severity, text),) = told(connect)
    assert severity is Severity.WARNING
    assert text.startswith("`cart` moves nothing by its mass: it is fastened to the ground")
    assert "`connect(rail.frame_b, cart.frame_a);`" in text


def test_a_body_on_the_world_is_a_note_where_a_carriage_has_no_mass() -> None:
    ((severity, text),) = told("connect(world.frame_b, cart.frame_a);")
    assert severity is Severity.NOTE
    assert text.startswith("`cart` moves nothing by its mass")


@pytest.mark.parametrize(
    ("connect", "more"),
    [
        ("connect(rail.frame_b, cart.frame_a);", ""),
        (  # a base beside a carriage with a mass
            "connect(rail.frame_a, cart.frame_a); connect(rail.frame_b, carriage.frame_a);",
            "Parts.Body carriage(m=1, I=0.01);",
        ),
    ],
)
def test_what_moves_or_stands_beside_it_is_not_told(connect: str, more: str) -> None:
    assert told(connect, more) == []
