"""On a page that runs its model itself, start values follow a part that is dragged."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import atan2, hypot
from pathlib import Path
from typing import Any

import pytest

import planarc
from planarc.export.page.page import make_page
from tests.view.browser.conftest import DESKTOP, PHONE, PLACE, settle, until
from tests.view.browser.test_live import POSE, field

ROOT = Path(__file__).parents[3]
FOUR_BAR = str(ROOT / "examples" / "four_bar.pmo")
DOUBLE = str(ROOT / "examples" / "double_pendulum.pmo")

#: The place in the world of a point of the window.
WORLD = """([x, y]) => {
  const canvas = planarcPlayer.picture().getBoundingClientRect();
  const { view } = planarcPlayer;
  return [view.x + (x - canvas.left - canvas.width / 2) / view.scale,
          view.y - (y - canvas.top - canvas.height / 2) / view.scale];
}"""


@cache
def text_of(model: str) -> str:
    loaded = planarc.load(model)
    return make_page(loaded.compiled(), loaded.simulate().rows).text


@pytest.fixture
def open_model(open_page: Callable[..., Any], tmp_path: Path) -> Callable[..., Any]:
    """`open_model(text or path, size)` opens a page whose picture stands at its start."""

    def opened(model: str, size: tuple[int, int] = DESKTOP) -> Any:
        path = tmp_path / "page.html"
        path.write_text(text_of(model), "utf-8")
        page = open_page(path, size)
        settle(page)
        to_start(page)
        return page

    return opened


def to_start(page: Any, time: float = 0.0) -> None:
    page.evaluate(f"planarcPlayer.pause(); planarcPlayer.setTime({time})")
    until(page, f"Math.abs(planarcPlayer.time - {time}) < 1e-9")
    page.evaluate("new Promise((done) => requestAnimationFrame(() => setTimeout(done)))")


def pull(page: Any, component: str, u: float, way: tuple[float, float]) -> tuple[float, float]:
    """Drag a point of a component by so many pixels; gives where in the world the pointer ends,
    before the button is let go."""
    place = page.evaluate(PLACE, [u, component])
    page.mouse.move(place["x"], place["y"])
    page.mouse.down()
    for i in range(1, 11):
        page.mouse.move(place["x"] + way[0] * i / 10, place["y"] + way[1] * i / 10)
    until(page, "!planarcLive.busy")
    x, y = page.evaluate(WORLD, [place["x"] + way[0], place["y"] + way[1]])
    return float(x), float(y)


def drop(page: Any) -> None:
    page.mouse.up()
    settle(page)


def start_of(page: Any, name: str) -> float:
    found: float = page.evaluate(f"planarcLive.fields.values().starts[{name!r}]")
    return found


def test_the_start_value_follows_a_crank(
    open_model: Callable[..., Any], screenshot: Callable[..., Path]
) -> None:
    page = open_model(FOUR_BAR)
    view = page.evaluate("({ ...planarcPlayer.view })")
    x, y = pull(page, "crank", 0.3, (60, 30))
    assert page.evaluate("({ ...planarcPlayer.view })") == view  # the picture stays where it is
    screenshot(page, "own-page-dragged")
    drop(page)
    phi = start_of(page, "revA.phi")
    assert phi == pytest.approx(atan2(y, x), abs=0.01)
    assert field(page, "revA.phi.start").locator("input[type=text]").input_value() != "57.2958"
    result = planarc.load(FOUR_BAR).simulate(1.0, start={"revA.phi": phi}, tolerance=1e-10)
    told = page.evaluate(POSE, ["rocker", 1.0])["angle"]
    assert told == pytest.approx(float(result["revD.phi"][-1]), abs=1e-5)
    page.click("#reset")
    settle(page)
    assert page.evaluate(POSE, ["crank", 0.0])["angle"] == pytest.approx(1.0, abs=1e-9)


def test_two_joints_bring_a_point_to_the_pointer(open_model: Callable[..., Any]) -> None:
    """Taken on the way, the mechanism begins where it is seen."""
    page = open_model(DOUBLE)
    to_start(page, 0.2)
    target = pull(page, "lower", 0.3, (-40, -35))
    assert page.evaluate("planarcPlayer.time") == 0.0
    pose = page.evaluate("planarcPlayer.pose('lower')")
    drop(page)
    shoulder, elbow = (start_of(page, f"{name}.phi") for name in ("shoulder", "elbow"))
    result = planarc.load(DOUBLE).simulate(
        0.1, start={"shoulder.phi": shoulder, "elbow.phi": elbow}
    )
    frame = [float(result[f"lower.frame_a.{n}"][0]) for n in ("r[1]", "r[2]", "phi")]
    assert frame == pytest.approx([pose["x"], pose["y"], pose["angle"]], abs=1e-4)
    held = page.evaluate(PLACE.replace("planarcPlayer.pose(component)", "component"),
                         [0.3, dict(zip(("x", "y", "angle"), frame, strict=True))])  # fmt: skip
    x, y = page.evaluate(WORLD, [held["x"], held["y"]])
    assert hypot(x - target[0], y - target[1]) < 1e-3


def test_a_finger_drags_on_a_phone(open_model: Callable[..., Any]) -> None:
    """And the page does not scroll under it."""
    page = open_model(FOUR_BAR, PHONE)
    place = page.evaluate(PLACE, [0.3, "crank"])
    session = page.context.new_cdp_session(page)

    def touch(kind: str, *points: tuple[float, float]) -> None:
        told = [{"x": x, "y": y} for x, y in points]
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": told})

    touch("touchStart", (place["x"], place["y"]))
    for i in range(1, 9):
        touch("touchMove", (place["x"] + 2 * i, place["y"] + 5 * i))
    until(page, "!planarcLive.busy")
    touch("touchEnd")
    settle(page)
    assert start_of(page, "revA.phi") < 0.9
    assert page.evaluate("window.scrollY") == 0


def test_what_nothing_moves_cannot_be_taken(open_model: Callable[..., Any]) -> None:
    """A wheel that a drive turns has no start value: the picture moves instead."""
    text = """
    model Wheel
      inner PlanarMultiBody.World world;
      PlanarMultiBody.Joints.Revolute axis(drivenFlange=true);
      PlanarMultiBody.Parts.BodyShape spoke(r={0.5, 0}, m=1);
      Modelica.Mechanics.Rotational.Sources.Position motor(exact=true);
    equation
      motor.phi_ref = time;
      connect(motor.flange, axis.axis);
      connect(world.frame_b, axis.frame_a);
      connect(axis.frame_b, spoke.frame_a);
      annotation(experiment(StopTime=2));
    end Wheel;
    """
    page = open_model(text)
    before = page.evaluate("({ ...planarcPlayer.view })")
    pull(page, "spoke", 0.25, (30, 20))
    drop(page)
    assert page.evaluate("planarcPlayer.view.x") < before["x"]
    assert page.evaluate("planarcLive.fields.changes") == 0
    assert not page.locator("#reset").is_visible()
    assert "Drag a part" not in page.inner_text("footer")


def test_the_ground_cannot_be_taken(open_model: Callable[..., Any]) -> None:
    page = open_model(FOUR_BAR)
    before = page.evaluate("({ ...planarcPlayer.view })")
    pull(page, "groundA.shape", 0.0, (30, 20))
    drop(page)
    assert page.evaluate("planarcLive.fields.changes") == 0
    assert page.evaluate("planarcPlayer.view.x") < before["x"]


def test_an_input_coordinate_follows(open_page: Callable[..., Any], tmp_path: Path) -> None:
    text = """
    model Arm
      inner PlanarMultiBody.World world;
      input Real phi(start=0.5);
      PlanarMultiBody.Joints.Revolute axis(drivenFlange=true);
      PlanarMultiBody.Parts.BodyShape spoke(r={0.5, 0}, m=1);
      Modelica.Mechanics.Rotational.Sources.Position motor(exact=true);
    equation
      motor.phi_ref = phi;
      connect(motor.flange, axis.axis);
      connect(world.frame_b, axis.frame_a);
      connect(axis.frame_b, spoke.frame_a);
      annotation(experiment(StopTime=2));
    end Arm;
    """
    model = planarc.load(text)
    page = open_page(model.export_page(tmp_path / "arm.html"))
    settle(page)
    to_start(page)
    x, y = pull(page, "spoke", 0.3, (-60, -30))
    drop(page)
    given = page.evaluate("planarcLive.fields.values().values.phi")
    assert given == pytest.approx(atan2(y, x), abs=0.03)
    assert page.evaluate(POSE, ["spoke", 1.0])["angle"] == pytest.approx(given, abs=1e-9)


def test_with_shift_a_rod_gets_longer(open_model: Callable[..., Any]) -> None:
    page = open_model(FOUR_BAR)
    page.keyboard.down("Shift")
    pull(page, "crank", 0.35, (20, -31))
    drop(page)
    page.keyboard.up("Shift")
    values = page.evaluate("planarcLive.fields.values()")
    assert values["values"]["crank.r[1]"] > 0.42
    assert values["starts"] == {}
