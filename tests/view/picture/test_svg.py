"""Moving SVG pictures: what a browser would show at any time is what the result says."""

from __future__ import annotations

import re
from math import cos, degrees, sin
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from planarc.core.diagnostic import UsageError
from planarc.view.picture.camera import Camera, fit_camera
from planarc.view.picture.furniture import FOOT
from planarc.view.picture.make import PictureOptions, write_picture
from planarc.view.picture.motion import When
from planarc.view.scene import make_scene

SVG = "{http://www.w3.org/2000/svg}"


def draw(path: Path, result: Any, **options: Any) -> Any:
    write_picture(path, result, PictureOptions(**options))
    return ElementTree.fromstring(path.read_text("utf-8"))


def camera_of(result: Any, width: int = 640) -> Camera:
    return fit_camera(make_scene(result).box, width, FOOT)


def groups(svg: Any) -> list[Any]:
    return svg.findall(f"{SVG}g")


def animated(node: Any, share: float, **attributes: str) -> list[float]:
    """The value of an animation after a share of its duration."""
    (found,) = [
        a for a in node.iter() if all(a.get(k) == v for k, v in attributes.items()) and a.get("dur")
    ]
    rows = [[float(n) for n in re.split("[ ,]", v)] for v in found.get("values").split(";")]
    times = found.get("keyTimes")
    keys = [float(t) for t in times.split(";")] if times else np.linspace(0, 1, len(rows))
    assert keys[0] == 0
    assert keys[-1] == 1
    return [float(np.interp(share, keys, column)) for column in zip(*rows, strict=True)]


@pytest.mark.parametrize("time", [0.0, 0.77, 2.0, 3.1, 4.0])
def test_a_moving_picture_shows_each_time_as_the_result_does(
    swing: Any, tmp_path: Path, time: float
) -> None:
    svg = draw(tmp_path / "a.svg", swing)
    spring, rod, pin = groups(svg)[:3]
    camera, angle = camera_of(swing), sin(time)
    turn = animated(rod, time / 4, type="rotate")
    assert turn[0] == pytest.approx(-degrees(angle), abs=0.15)
    place = animated(pin, time / 4, type="translate")
    assert place == pytest.approx(camera(cos(angle), sin(angle)), abs=0.4)
    # The spring's last point, stretched, turned and moved, is the pin.
    stretch, _ = animated(spring, time / 4, type="scale")
    *_, u, v = (float(n) for n in spring.find(f"{SVG}polyline").get("points").split())
    lean = animated(spring, time / 4, type="rotate")[0]
    x0, y0 = animated(spring, time / 4, type="translate")
    c, s = np.cos(np.radians(lean)), np.sin(np.radians(lean))
    u *= stretch
    end = (x0 + c * u - s * v, y0 + s * u + c * v)
    assert end == pytest.approx(camera(cos(angle), sin(angle)), abs=1.0)


def test_what_has_no_place_is_hidden(swing: Any, tmp_path: Path) -> None:
    svg = draw(tmp_path / "a.svg", swing)
    (shown,) = [a for a in groups(svg)[3] if a.get("attributeName") == "visibility"]
    assert shown.get("values") == "visible;hidden"
    assert float(shown.get("keyTimes").split(";")[1]) == pytest.approx(0.5, abs=0.01)


def test_a_still_does_not_move(swing: Any, tmp_path: Path) -> None:
    text = draw(tmp_path / "a.svg", swing, at=1.0)
    assert not [n for n in text.iter() if "animate" in n.tag]
    pin = next(g for g in groups(text) if g[0].tag == f"{SVG}circle")
    numbers = [float(n) for n in re.findall(r"-?[\d.]+", pin.get("transform"))]
    assert numbers == pytest.approx(camera_of(swing)(cos(sin(1.0)), sin(sin(1.0))), abs=0.1)


def test_the_reader_chooses_the_ground_unless_it_is_given(swing: Any, tmp_path: Path) -> None:
    for dark, asks in ((None, True), (True, False), (False, False)):
        path = tmp_path / f"{dark}.svg"
        draw(path, swing, dark=dark)
        assert ("prefers-color-scheme" in path.read_text("utf-8")) is asks


def test_the_part_of_a_run_and_its_pace(swing: Any, tmp_path: Path) -> None:
    path = tmp_path / "a.svg"
    made = write_picture(path, swing, PictureOptions(When(begin=1, end=2, speed=0.25)))
    assert (made.seconds, made.speed) == pytest.approx((4.0, 0.25))
    assert 'dur="4s"' in path.read_text("utf-8")


def test_texts_of_a_model_are_escaped(
    table: Any, result_of: Any, visual_of: Any, tmp_path: Path
) -> None:
    evil = '</text><script>alert(1)</script>"&'
    text = visual_of(
        table, "a", "text", r=(0.0, 0.0), phi=0.0, text=evil, width=0.1, heightShift=0.0,
        color=(0.0, 0.0, 0.0),
    )  # fmt: skip
    svg = draw(tmp_path / "a.svg", result_of(table, [0.0, 1.0], {"x": [0, 1]}, (text,), evil))
    assert not list(svg.iter(f"{SVG}script"))
    assert svg.find(f"{SVG}title").text == evil
    assert next(svg.iter(f"{SVG}text")).text == evil


def test_paths_of_points_are_drawn(swing: Any, tmp_path: Path) -> None:
    svg = draw(tmp_path / "a.svg", swing, traces=("pin",))
    (line,) = groups(svg)[0]
    points = np.array([float(n) for n in line.get("points").split()]).reshape(-1, 2)
    camera = camera_of(swing)
    # All of them lie on the circle of the rod.
    assert np.hypot(*points.T) == pytest.approx(camera.scale * np.ones(len(points)), rel=1e-3)
    with pytest.raises(UsageError, match="no point `pinn`") as caught:
        draw(tmp_path / "a.svg", swing, traces=("pinn",))
    assert "did you mean `pin.r`" in str(caught.value.diagnostics[0].hint)


def test_pictures_that_cannot_be_made_say_why(
    swing: Any, table: Any, result_of: Any, tmp_path: Path
) -> None:
    empty = result_of(table, [0.0, 1.0], {"x": [0, 1]})
    for name, result, options, code in (
        ("a.bmp", swing, {}, "V701"),
        ("a.svg", swing, {"width": 3}, "V702"),
        ("a.svg", swing, {"when": When(speed=-1.0)}, "V702"),
        ("a.svg", swing, {"when": When(rate=float("nan"))}, "V702"),
        ("a.svg", swing, {"at": 9.0}, "V703"),
        ("a.svg", empty, {}, "V705"),
    ):
        with pytest.raises(UsageError) as caught:
            draw(tmp_path / name, result, **options)
        assert caught.value.diagnostics[0].code == code
    assert not list(tmp_path.iterdir())
