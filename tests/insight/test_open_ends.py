"""A rod whose end was to carry what hangs elsewhere is told, and no rod that is open on purpose."""

from __future__ import annotations

import pytest

import planarc

CLOCK = """model Clock
  import PlanarMultiBody.*;
  inner World world;
  Joints.Revolute hinge(phi(start=-1.3, fixed=true), w(fixed=true));
  Parts.FixedTranslation rod(r={1, 0});
  Parts.Body bob(BOB);
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, rod.frame_a);
  connect(WHERE, bob.frame_a);
end Clock;
"""
DECK = """model Deck
  import PlanarMultiBody.*;
  inner World world;
  Parts.Fixed left(r={-0.5, 0}), right(r={0.5, 0});
  Parts.Body deck(m=60, I=8, r(start={0, 0.4}, each fixed=true), v(each fixed=true),
    phi(fixed=true), w(fixed=true));
  Parts.FixedTranslation front(r={0.5, 0}), rear(r={-0.5, 0});
  Forces.Spring one(c=8e3, s_unstretched=0.4), two(c=8e3, s_unstretched=0.4);
equation
  connect(deck.frame_a, front.frame_a);
  connect(deck.frame_a, rear.frame_a);
  connect(right.frame_b, one.frame_a);
  connect(one.frame_b, front.frame_b);
  connect(left.frame_b, two.frame_a);
  connect(two.frame_b, WHERE);
end Deck;
"""


def told(text: str) -> list[str]:
    warnings = planarc.load(text).warnings
    return [f"{w.message}; {w.hint}" for w in warnings if w.code == "S323"]


def clock(where: str = "hinge.frame_b", bob: str = "m=2, I=0.003") -> list[str]:
    return told(CLOCK.replace("WHERE", where).replace("BOB", bob))


def test_a_bob_on_the_axis_beside_an_open_rod_is_told() -> None:
    (text,) = clock()
    assert text == (
        "`rod` changes nothing: it has no mass, and `rod.frame_b` is connected to nothing; write "
        "`connect(rod.frame_b, bob.frame_a);`: `bob` is on the axis of `hinge`"
    )


@pytest.mark.parametrize(
    ("where", "bob"),
    [
        ("rod.frame_b", "m=2, I=0.003"),
        ("hinge.frame_b", "m=2, I=0.9"),  # a disc, and the rod its pointer
        ("hinge.frame_b", "m=2, I=0.003, r_CM={1, 0}"),  # a body with a length of its own
    ],
)
def test_a_pointer_is_not_told(where: str, bob: str) -> None:
    assert clock(where, bob) == []


def test_an_inertia_below_zero_is_told_as_that() -> None:
    (text,) = clock(bob="m=2, I=-0.003")
    assert text.startswith("`rod` changes nothing")
    text = CLOCK.replace("WHERE", "hinge.frame_b").replace("BOB", "m=2, I=-0.003")
    assert "F265" in {w.code for w in planarc.load(text).warnings}


def test_two_springs_on_one_of_two_arms_are_told() -> None:
    (text,) = told(DECK.replace("WHERE", "front.frame_b"))
    assert text.endswith(
        "`one` and `two` are both connected to `front.frame_b`: connect one of them to "
        "`rear.frame_b` instead"
    )
    assert told(DECK.replace("WHERE", "rear.frame_b")) == []
