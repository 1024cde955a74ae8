"""Pictures stay legible for whatever a mechanism is made of."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import planarc
from planarc.view.box import bounds
from planarc.view.item import Kind
from planarc.view.marks.draw import marks_of, visible
from planarc.view.marks.marks import Outline
from planarc.view.picture.camera import fit_camera
from planarc.view.picture.make import PictureOptions, write_picture
from planarc.view.picture.motion import still
from planarc.view.scene import make_scene

HEAD = "model M import PlanarMultiBody.*; inner World world; "
TAIL = " annotation(experiment(StopTime={stop})); end M;"
LONG = "a" * 200
MARKUP = "'</text><b onclick=x>&amp;\"'"

PENDULUM = """
  Joints.Revolute {pin};
  Parts.BodyShape {rod}(r={{{r}, 0}}, m={m}, I={i});
equation
  connect(world.frame_b, {pin}.frame_a);
  connect({pin}.frame_b, {rod}.frame_a);
"""
FREE = """
  Parts.Body {name}(
    m=1, enforceStates=true, r(start={{{x}, 0}}, each fixed=true),
    v(start={{{v}, 0}}, each fixed=true), phi(fixed=true), w(fixed=true));
"""
ZERO = """
  Joints.Revolute pin;
  Parts.FixedTranslation none(r={0, 0});
  Parts.Body a(m=1, r_CM={0.2, 0});
equation
  connect(world.frame_b, pin.frame_a);
  connect(pin.frame_b, none.frame_a);
  connect(none.frame_b, a.frame_a);
"""
CHAIN = """
  Joints.Revolute pin[100];
  Parts.BodyShape rod[100](each r={0.1, 0}, each m=0.1);
equation
  connect(world.frame_b, pin[1].frame_a);
  for i in 1:100 loop
    connect(pin[i].frame_b, rod[i].frame_a);
  end for;
  for i in 1:99 loop
    connect(rod[i].frame_b, pin[i + 1].frame_a);
  end for;
"""


def pendulum(pin: str = "pin", rod: str = "rod", r: float = 1.0, m: float = 1.0) -> str:
    return PENDULUM.format(pin=pin, rod=rod, r=r, m=m, i=m * r * r / 12)


def free(name: str = "a", x: float = 0, v: float = 0) -> str:
    return FREE.format(name=name, x=x, v=v)


CASES = {
    "bodies at a point": (free(), 0.01),
    "bodies apart": (free() + free("b", x=3), 0.1),
    "a link of no length": (ZERO, 1.0),
    "a hundred bodies": (CHAIN, 0.01),
    "long names": (pendulum(LONG, LONG + "b"), 0.5),
    "names with markup": (pendulum("'<i>p'", MARKUP), 0.5),
    "light": (pendulum(m=1e-9), 0.5),
    "heavy": (pendulum(m=1e9), 0.5),
    "micrometres": (pendulum(r=1e-6), 1e-3),
    "kilometres": (pendulum(r=2e3), 60.0),
    "a shot over kilometres": (free(v=800), 20.0),
}


def result_of(name: str) -> Any:
    text, stop = CASES[name]
    return planarc.load(HEAD + text + TAIL.format(stop=stop)).simulate().rows


@pytest.fixture(scope="module", params=sorted(CASES))
def rows(request: pytest.FixtureRequest) -> Any:
    return result_of(request.param)


def test_what_is_drawn_is_seen_and_covers_nothing(rows: Any) -> None:
    scene = make_scene(rows)
    assert scene.box is not None
    camera = fit_camera(scene.box, 640)
    for item in still(scene, float(scene.time[-1])).at(0):
        assert visible(item)
        if item.shape in ("plate", "mass", "pin"):
            assert 1.2 <= item.width * camera.scale <= 80
            marks = marks_of(item, 1.0 / camera.scale)
            assert marks
            for mark in marks:
                if isinstance(mark, Outline):
                    assert np.all(np.isfinite(mark.points))
    shown = bounds([i for i in scene.items if i.kind is Kind.SHAPE])
    assert shown is not None
    assert all(map(math.isfinite, shown))


def test_pictures_and_pages_are_whole_and_texts_are_only_texts(rows: Any, tmp_path: Path) -> None:
    from planarc.view.page.report import render_page

    write_picture(tmp_path / "a.svg", rows, PictureOptions(at=float(rows.time[-1])))
    picture = ElementTree.fromstring((tmp_path / "a.svg").read_text("utf-8"))
    tags = {node.tag.rpartition("}")[2] for node in picture.iter()}
    assert tags <= {"svg", "title", "style", "rect", "g", "polygon", "polyline", "circle", "text"}
    page = render_page(rows, make_scene(rows))
    assert "<b onclick" not in page
    assert len(page) < 1_500_000
