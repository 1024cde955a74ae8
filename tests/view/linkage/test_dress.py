"""Mechanisms as they are drawn: what becomes one shape, where it lies, what covers what."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np

import planarc
from planarc.view.item import Item, Kind
from planarc.view.linkage.groups import find_groups
from planarc.view.linkage.hatches import hatches
from planarc.view.linkage.palette import BED, BODIES, FORCE, JOINT
from planarc.view.marks.forms import EDGE
from planarc.view.scene import Scene, make_scene

EXAMPLES = Path(__file__).parents[3] / "examples"


def run(text: str, **more: Any) -> Any:
    return planarc.load(text, **more).simulate().rows


def scene_of(name: str) -> Scene:
    return make_scene(run(name))


def shapes(scene: Scene, *names: str) -> list[Item]:
    return [item for item in scene.items if item.shape in names]


def ends(item: Item) -> Any:
    """The corners of a plate in the world, over time."""
    c, s = np.cos(item.angle), np.sin(item.angle)
    return [(item.x + c * u - s * v, item.y + s * u + c * v) for u, v in item.points]


def test_a_rod_and_its_body_are_one_link_from_hinge_to_hinge() -> None:
    result = run("PlanarMultiBody.Examples.Loops.FourBar")
    plates = {item.component: item for item in shapes(make_scene(result), "plate")}
    assert set(plates) == {"crank", "coupler", "rocker"}
    for name, hinges in {"crank": ("A", "B"), "coupler": ("B", "C")}.items():
        for x, y in ends(plates[name]):
            off = [
                np.max(
                    np.hypot(x - result[f"rev{h}.frame_b.r[1]"], y - result[f"rev{h}.frame_b.r[2]"])
                )
                for h in hinges
            ]
            assert min(off) < 1e-6
    assert plates["crank"].parts == ("crank.frameTranslation", "crank.body")


def test_neighbours_have_different_quiet_colours_and_joints_none() -> None:
    scene = scene_of("PlanarMultiBody.Examples.Loops.AndrewsSqueezer")
    colors = [item.color for item in shapes(scene, "plate")]
    assert len(colors) == len(set(colors)) == 7
    assert set(colors) <= set(BODIES)
    assert {item.color for item in shapes(scene, "pin", "motor")} == {JOINT}


def test_colours_are_told_apart_in_grey_and_are_not_those_of_forces() -> None:
    grey = [0.3 * r + 0.59 * g + 0.11 * b for r, g, b in BODIES]
    assert all(abs(a - b) > 15 for a, b in itertools.pairwise(grey))
    for color in (*BODIES, JOINT):
        assert np.linalg.norm(np.subtract(color, FORCE)) > 90


#: What is left of linear red, green and blue without the cones for red, or for green (after
#: G. Machado, M. Oliveira, L. Fernandes, 2009).
EYES = {
    "all cones": np.eye(3),
    "no red": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
         [-0.003882, -0.048116, 1.051998]]
    ),
    "no green": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
         [-0.01182, 0.04294, 0.968881]]
    ),
}  # fmt: skip
TO_XYZ = np.array(
    [[0.4339, 0.3762, 0.1899], [0.2126, 0.7152, 0.0722], [0.0177, 0.1095, 0.8729]]
)  # over the white of daylight


def light(color: Any) -> Any:
    """Linear red, green and blue."""
    c = np.array(color) / 255
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def seen(color: Any, eye: Any) -> Any:
    """A colour as it is perceived: CIE L*a*b*, where a step of 2 is just seen."""
    xyz = TO_XYZ @ np.clip(eye @ light(color), 0, 1)
    x, y, z = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def test_eyes_without_red_or_green_tell_all_colours_apart() -> None:
    for eye in EYES.values():
        for a, b in itertools.combinations((*BODIES, FORCE, JOINT), 2):
            assert np.linalg.norm(seen(a, eye) - seen(b, eye)) > 14


def test_bodies_stand_out_from_light_and_dark_ground() -> None:
    """Of a body either its outline or what it is filled with has a contrast of 3 : 1."""

    def luminance(color: Any) -> float:
        return float(TO_XYZ[1] @ light(color)) + 0.05

    for color in BODIES:
        edge = np.array(color) * (1 + EDGE[0])
        assert luminance((255, 255, 255)) / luminance(edge) > 4
        assert luminance(color) / luminance((0x13, 0x17, 0x1D)) > 3


def test_links_lie_in_the_order_of_the_chain_and_pins_above_them() -> None:
    scene = scene_of("PlanarMultiBody.Examples.Elementary.DoublePendulum")
    heights = {item.component: item.height for item in scene.items}
    bars = sorted(item.height for item in shapes(scene, "plate"))
    pins = sorted(item.height for item in shapes(scene, "pin"))
    assert bars == [1.0, 2.0]
    assert all(b < p for b, p in zip(bars, pins, strict=True))
    assert min(heights.values()) == min(item.height for item in shapes(scene, "ground"))


def test_a_slide_in_the_ground_is_a_block_on_a_guide_as_long_as_its_travel() -> None:
    result = run("PlanarMultiBody.Examples.Loops.CrankSlider")
    scene = make_scene(result)
    (guide,), (block,) = shapes(scene, "guide"), shapes(scene, "block")
    s = result["dyad.s"]
    assert guide.length > np.ptp(s)
    along = block.x - guide.x
    assert np.all((along > block.length / 2) & (along < guide.length - block.length / 2))
    assert isinstance(guide.x, float)


def test_the_lever_of_a_quick_return_carries_a_block() -> None:
    scene = scene_of("PlanarMultiBody.Examples.Systems.QuickReturn")
    assert len(shapes(scene, "block")) == 2
    assert not shapes(scene, "barrel", "rod")


CYLINDER = """
model M
  import PlanarMultiBody.*;
  inner World world;
  Parts.Fixed a(r={0, 0});
  Parts.Fixed b(r={1, 0});
  Joints.Revolute low, arm, high;
  Joints.Prismatic piston(s(start=0.8, fixed=true));
  Parts.Body barrel(m=1, r_CM={0.2, 0}), rod(m=1, r_CM={-0.2, 0});
  Parts.BodyShape beam(r={0.8, 0.6}, m=2);
equation
  connect(a.frame_b, low.frame_a);
  connect(low.frame_b, piston.frame_a);
  connect(piston.frame_b, high.frame_a);
  connect(high.frame_b, beam.frame_b);
  connect(b.frame_b, arm.frame_a);
  connect(arm.frame_b, beam.frame_a);
  connect(barrel.frame_a, piston.frame_a);
  connect(rod.frame_a, piston.frame_b);
  annotation(experiment(StopTime=0.1));
end M;
"""


def test_a_slide_between_two_pivots_is_barrel_and_rod() -> None:
    result = run(CYLINDER)
    scene = make_scene(result)
    (barrel,), (rod,) = shapes(scene, "barrel"), shapes(scene, "rod")
    s = result["piston.s"]
    assert isinstance(barrel.length, float)
    assert isinstance(rod.length, float)
    inner = s + rod.length  # of the rod's inner end, from frame_a
    assert np.all((inner > 0) & (inner < barrel.length))
    assert rod.height < barrel.height


def test_bearings_stand_where_pins_are_in_the_ground_once() -> None:
    scene = scene_of("PlanarMultiBody.Examples.Loops.CrankSlider")
    assert len(shapes(scene, "ground")) == 1
    assert len(shapes(scene_of(str(EXAMPLES / "four_bar.pmo")), "ground")) == 2


def test_cams_are_filled_with_the_colour_of_their_body() -> None:
    scene = scene_of("PlanarMultiBody.Examples.CurveCurveJoint.CamFollower")
    (cam,) = shapes(scene, "cam")
    assert cam.color in BODIES


def test_sizes_and_colours_that_are_given_are_kept() -> None:
    result = run(
        "model M extends PlanarMultiBody.Examples.Elementary.Pendulum("
        "bob(sphereDiameter=0.2, sphereColor={1, 2, 3}), hinge(cylinderDiameter=0.1)); "
        "annotation(experiment(StopTime=0.1)); end M;"
    )
    scene = make_scene(result)
    (disc,), (pin,) = shapes(scene, "sphere"), shapes(scene, "pin")
    assert disc.width == 0.2
    assert disc.color == (1.0, 2.0, 3.0)
    assert pin.width == 0.1
    assert len(shapes(scene, "mass")) == 1


def test_the_unit_is_small_against_links_and_seen_in_the_picture() -> None:
    result = run("PlanarMultiBody.Examples.Loops.FourBar")
    groups = find_groups(result)
    assert groups is not None
    unit = groups.unit(groups.size)
    assert groups.size / 260 <= unit <= groups.size / 30
    assert unit < 0.4 / 5


def test_what_stands_in_the_ground_is_hatched_on_the_side_where_no_bodies_are() -> None:
    for name in ("RockingBlock", "OffTheLedge"):  # a floor, and a ledge with a width
        scene = scene_of(f"PlanarMultiBody.Examples.Contacts.{name}")
        (hatch,) = shapes(scene, "hatch")
        (curve,) = (
            i for i in scene.items if i.kind is Kind.CURVE and i.component == hatch.component
            and not i.shape
        )  # fmt: skip
        depth = ends(curve)[0][1] - np.array(ends(hatch))[:, 1]
        assert np.all(depth[1::2] > depth[::2]) and np.all(depth >= 0.5 * curve.width - 1e-12)
        for side in (-1.0, 1.0):
            upside = np.array(hatches(curve, ((0.0, side),), 0.1).points)
            assert np.all(side * np.diff(upside.reshape(-1, 2, 2)[:, :, 1]) < 0)


RING = """
model Ring
  import PlanarMultiBody.*;
  inner World world;
  Parts.Body disc(m=1, I=0.004, r(start={0.3, 0}, each fixed=true), animation=false);
  Contacts.Contact contact(redeclare Contacts.Circle contour1(R=0.1, filled=FILLED),
    redeclare Contacts.Circle contour2(R=0.6, inside=true));
equation
  connect(disc.frame_a, contact.frame_a);
  connect(world.frame_b, contact.frame_b);
  annotation(experiment(StopTime=0.1));
end Ring;
"""


def test_holes_and_what_is_not_filled_are_lines() -> None:
    for filled in (True, False):
        scene = make_scene(run(RING.replace("FILLED", str(filled).lower())))
        disc, wall = (
            next(i for i in scene.items if i.component == f"contact.contour{n}.line" and
                 i.shape != "hatch")
            for n in (1, 2)
        )  # fmt: skip
        assert disc.shape == ("cam" if filled else "")
        assert wall.shape == ""
        assert len(shapes(scene, "hatch")) == 1  # the solid side of the hole


DOOR = """
model Door
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Revolute hinge(drivenFlange=true);
  PlanarMultiBody.Parts.BodyShape door(r={1, 0}, m=1, I=1);
  Modelica.Mechanics.Rotational.Components.SpringDamper closer(c=2, d=1);
  Modelica.Mechanics.Rotational.Components.Inertia rotor(J=1);
  // drive
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, door.frame_a);
  connect(hinge.support, closer.flange_a);
  connect(closer.flange_b, hinge.axis);
  connect(hinge.axis, rotor.flange_a);
  // connect
end Door;
"""
DRIVE = "Modelica.Mechanics.Rotational.Sources.ConstantTorque drive(tau_constant=1);"


def test_a_motor_is_drawn_where_something_drives_and_a_pin_where_nothing_does() -> None:
    connected = "connect(drive.flange, rotor.flange_b);"
    driven = DOOR.replace("// drive", DRIVE).replace("// connect", connected)
    for text, shape in ((DOOR, "pin"), (driven, "motor")):
        assert [i.shape for i in shapes(make_scene(run(text)), "pin", "motor")] == [shape]


def test_stops_in_the_ground_have_no_colour_of_a_body() -> None:
    scene = scene_of("PlanarMultiBody.Examples.Contacts.SwingDoor")
    assert {i.color for i in scene.items if i.component.startswith("stops")} == {BED}


def test_gears_have_the_colours_of_their_arms_lie_below_them_and_teeth_by_the_ratio() -> None:
    gear = Path(planarc.__file__).parent / "catalog" / "handbook" / "models" / "gear.pmo"
    scene = make_scene(run(str(gear)))
    wheels, arms = shapes(scene, "gearwheel"), shapes(scene, "plate")
    assert [float(w.extra) for w in wheels] == [20.0, 40.0]
    assert {w.color for w in wheels} == {a.color for a in arms} and len(arms) == 2
    for wheel in wheels:
        (arm,) = (a for a in arms if a.color == wheel.color)
        assert wheel.height < arm.height
