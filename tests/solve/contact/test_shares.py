"""Contacts at rest whose forces are not determined are named, and no others."""

from __future__ import annotations

import numpy as np
import pytest

import planarc
from planarc.solve.contact.shares import find_open


def test_a_third_column_that_the_others_make() -> None:
    """A bar of mass 1 and inertia 1 on supports at -1, 0 and 1 m, whichever of them press."""
    j = np.array([[1.0, -1.0], [1.0, 0.0], [1.0, 1.0]])
    a = j @ j.T
    for force in ([0, 9.81, 0], [4.9, 0, 4.9], [3.27, 3.27, 3.27]):
        assert find_open(a, np.array(force), ["a", "b", "c"]) == [0, 1, 2]
    assert find_open(a[:2, :2], np.array([4.9, 4.9]), ["a", "b"]) == []


def test_a_load_that_one_support_alone_can_carry_is_its_own() -> None:
    """Beyond the others: these would have to pull."""
    j = np.array([[1.0, -1.0], [1.0, 0.0], [1.0, 1.0]])
    assert find_open(j @ j.T, np.array([9.81, 0, 0]), ["a", "b", "c"]) == []


def test_points_of_one_contact_share_as_they_like() -> None:
    """As the corners of two boxes of one width; on another width the sums hang on it, too."""
    j = np.array([[1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [1.0, 1.0]])
    force = np.array([4.9, 0, 4.9, 0])
    wide = np.array([[1.0, -1.0], [1.0, 0.3], [1.0, 1.0]])
    assert find_open(wide @ wide.T, np.array([4.9, 0, 4.9]), ["a", "b", "b"]) == [0, 1, 2]
    assert find_open(j @ j.T, force, ["a", "a", "b", "b"]) == []


BAR = """
model Bar
  import PlanarMultiBody.*;
  inner World world;
  parameter Real at[:]={{{AT}}};
  Parts.Body bar(m=4, I=1, r(start={0, -1}, each fixed=true), v(each fixed=true), phi(fixed=true),
    w(fixed=true));
  Parts.Fixed hook[size(at, 1)](r={{x, 0} for x in at});
  Parts.FixedTranslation eye[size(at, 1)](r={{x, 0} for x in at});
  Contacts.Rope rope[size(at, 1)];
equation
  for i in 1:size(at, 1) loop
    connect(bar.frame_a, eye[i].frame_a);
    connect(eye[i].frame_b, rope[i].frame_b);
    connect(hook[i].frame_b, rope[i].frame_a);
  end for;
end Bar;
"""
BLOCKS = """
model Blocks "A slab on bricks, all with corners on each other"
  import PlanarMultiBody.*;
  inner World world;
  parameter Real at[:]={{{AT}}};
  model Block = Contacts.Polygon(vertices=[-0.1, -0.1; 0.1, -0.1; 0.1, 0.1; -0.1, 0.1]);
  model Top = Contacts.Polygon(vertices=[-1, -0.1; 1, -0.1; 1, 0.1; -1, 0.1]);
  Parts.Body brick[size(at, 1)](each m=1, each I=0.01, r(start={{x, 0.1} for x in at},
    each fixed=true), v(each fixed=true), phi(each fixed=true), w(each fixed=true));
  Parts.Body slab(m=3, I=1, r(start={0, 0.3}, each fixed=true), v(each fixed=true),
    phi(fixed=true), w(fixed=true));
  Contacts.Contact floor[size(at, 1)](redeclare each Block contour1, each mu=0.3);
  Contacts.Contact under[size(at, 1)](redeclare each Block contour1, redeclare each Top contour2,
    each mu=0.3);
equation
  connect(brick.frame_a, floor.frame_a);
  connect(brick.frame_a, under.frame_a);
  for i in 1:size(at, 1) loop
    connect(floor[i].frame_b, world.frame_b);
    connect(under[i].frame_b, slab.frame_a);
  end for;
end Blocks;
"""


def notes(text: str, at: str) -> list[str]:
    model = planarc.load(text.replace("{{AT}}", at))
    return [w.message for w in model.simulate(stop_time=0.5).warnings if w.code == "R416"]


def test_three_ropes_are_told_and_two_are_not() -> None:
    assert notes(BAR, "-1, 1") == []
    (told,) = notes(BAR, "-1, 0, 1")
    assert told.startswith("`rope[1]`, `rope[2]` and `rope[3]` carry at t = 0.5 s what fewer")


def test_a_slab_on_one_brick_or_on_two_is_not_told() -> None:
    """All corners touch, those of the slab's bricks from both sides."""
    assert notes(BLOCKS, "0") == []
    assert notes(BLOCKS, "-0.8, 0.8") == []


@pytest.mark.parametrize("name", ["gripper", "dominoes", "ratchet_and_pawl", "geneva_drive"])
def test_examples_are_not_told(name: str) -> None:
    run = planarc.load(f"examples/{name}.pmo").simulate()
    assert "R416" not in {w.code for w in run.warnings}
