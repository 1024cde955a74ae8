"""Outlines by law: areas, distances from true curves, orientation, units, from SVG and DXF."""

from __future__ import annotations

from math import acos, ceil, pi
from pathlib import Path

import numpy as np
import pytest

import planarc
from planarc.catalog.outline.choose import choose
from planarc.catalog.outline.corners import Polygon, hollow, polygon
from planarc.catalog.outline.piece import Drawing, Outline, arc, line
from planarc.catalog.outline.text import class_name
from planarc.cli.app import run
from planarc.core.diagnostic import UsageError

SVG = '<svg xmlns="http://www.w3.org/2000/svg" {}>{}</svg>'
SIZE = 'width="100mm" height="50mm" viewBox="0 0 200 100"'


def from_svg(tmp_path: Path, body: str, head: str = SIZE) -> Drawing:
    pytest.importorskip("svgelements")
    from planarc.catalog.outline.svg import read_svg

    path = tmp_path / "part.svg"
    path.write_text(SVG.format(head, body), "utf-8")
    return read_svg(path)


def only(drawing: Drawing, tolerance: float | None = None, wanted: str | None = None) -> Polygon:
    assert drawing.metre is not None
    return polygon(choose(drawing, "part", wanted), drawing.metre, tolerance)


def through(*corners: complex, closed: bool = True) -> Outline:
    ends = (*corners[1:], corners[0]) if closed else corners[1:]
    pieces = tuple(line(a, b) for a, b in zip(corners, ends, strict=False))
    return Outline("", pieces, closed)


def test_a_circle_is_cut_as_finely_as_the_tolerance_asks(tmp_path: Path) -> None:
    """A chord of the angle 2*a is off by r*(1 - cos(a))."""
    drawing = from_svg(tmp_path, '<circle cx="40" cy="30" r="20"/>')
    for tolerance in (1e-3, 1e-5, 1e-7):
        found = only(drawing, tolerance)
        r = np.hypot(*(found.corners - [0.02, -0.015]).T)
        np.testing.assert_allclose(r, 0.01, atol=1e-15)
        chords = (found.corners + np.roll(found.corners, 1, axis=0)) / 2
        off = 0.01 - np.hypot(*(chords - [0.02, -0.015]).T)
        assert off.max() <= tolerance
        assert len(found.corners) <= 1.1 * ceil(pi / acos(1 - tolerance / 0.01)) + 4
    assert found.area == pytest.approx(pi * 1e-4, rel=1e-4)
    assert found.centre == pytest.approx((0.02, -0.015))


@pytest.mark.parametrize(
    ("path", "true"),
    [("M0,0 C0,40 60,40 60,0 Z", lambda t: (180 * t**2 - 120 * t**3, 120 * t * (1 - t))),
     ("M0,0 Q30,80 60,0 Z", lambda t: (60 * t, 160 * t * (1 - t)))],
)  # fmt: skip
def test_sides_are_no_further_from_a_curve_than_the_tolerance(
    path: str, true: object, tmp_path: Path
) -> None:
    found = only(from_svg(tmp_path, f'<path d="{path}"/>'), 1e-5)
    assert callable(true)
    x, y = true(np.linspace(0, 1, 20001))
    curve = 0.5e-3 * (x - 1j * y)
    z = found.corners @ np.array([1, 1j])
    middles = (z + np.roll(z, -1)) / 2
    away = np.abs(middles[:, None] - curve[None, :]).min(axis=1)
    assert np.sort(away)[-2] < 1.01e-5  # the last side is the straight one
    assert len(z) > 20


def test_units_flips_and_transforms(tmp_path: Path) -> None:
    box = '<g transform="translate(10,10) scale(2)"><path id="a" d="M0,0 H10 V5 H5 H0 Z"/></g>'
    found = only(from_svg(tmp_path, box))
    assert found.area == pytest.approx(0.01 * 0.005)
    corners = {(round(x, 12), round(y, 12)) for x, y in found.corners.tolist()}
    assert corners == {(0.005, -0.005), (0.015, -0.005), (0.015, -0.01), (0.005, -0.01)}
    assert from_svg(tmp_path, box, 'width="100" height="50"').metre is None
    assert from_svg(tmp_path, box, 'width="2in"').metre == pytest.approx(0.0254 / 96)


@pytest.mark.parametrize("turn", [1, -1])
def test_outlines_become_counter_clockwise(turn: int) -> None:
    found = polygon(through(*[0j, 1 + 0j, 1 + 1j, 1j][::turn]), 1e-3, None)
    assert found.area == pytest.approx(1e-6)
    assert found.tolerance == 1e-6


def test_repeated_and_straight_corners_are_left_out() -> None:
    found = polygon(through(0, 0, 1, 2, 2 + 1e-12j, 2 + 2j, 1 + 2j, 2j, 1j), 1.0, None)
    assert sorted(map(tuple, np.round(found.corners).tolist())) == [(0, 0), (0, 2), (2, 0), (2, 2)]


@pytest.mark.parametrize(
    ("corners", "place"),
    [((0, 2 + 2j, 2, 2j), "(1, 1)"),
     ((0, 4, 4 + 4j, 2 + 0j, 4j), "(2, 0)"),  # a corner on a side
     ((0, 4, 4 + 2j, 4 - 2j, -4 - 2j), "(4, 2)"),  # sides that lie on each other
     ((0, 4, 4 + 4j, 8 + 4j, 8 + 8j, 4 + 4j, 4j), "(4, 4)")],
)  # fmt: skip
def test_a_crossing_is_refused_with_its_place(corners: tuple[complex, ...], place: str) -> None:
    with pytest.raises(UsageError, match="C175"):
        polygon(through(*corners), 1.0, None)
    with pytest.raises(UsageError) as told:
        polygon(through(*corners), 1.0, None)
    assert f"itself at {place} m" in str(told.value)


def test_a_hollow_corner_is_told_and_others_are_not() -> None:
    notched = through(0, 4, 4 + 4j, 2 + 1j, 4j)
    warning = hollow(polygon(notched, 1.0, None), notched)
    assert warning is not None and "(2, 1) m, is hollow" in warning.message
    disc = Outline("", (arc(-1, 1, 1.0), arc(1, -1, 1.0)), True)
    assert hollow(polygon(disc, 1.0, 1e-6), disc) is None


@pytest.mark.parametrize("bulge", [0.2, 1.0, -0.4])
def test_an_arc_bulges_by_its_number(bulge: float) -> None:
    """Its middle lies `bulge` half chords beside the chord, to the right where it is positive."""
    assert arc(-1, 1, bulge).at(0.5) == pytest.approx(-1j * bulge)
    assert arc(-1, 1, bulge).at(1.0) == pytest.approx(1)


def test_a_dxf_gives_polylines_circles_and_units(tmp_path: Path) -> None:
    ezdxf = pytest.importorskip("ezdxf")
    from planarc.catalog.outline.dxf import read_dxf

    document = ezdxf.new(units=4)  # mm
    space = document.modelspace()
    slot = [(0, 0, 0), (40, 0, 1), (40, 20, 0), (0, 20, 1)]  # x, y, bulge
    space.add_lwpolyline(slot, format="xyb", close=True)
    space.add_circle((100, 0), 5)
    space.add_polyline2d([(0, 0), (30, 0), (0, 40)], close=True)
    space.add_lwpolyline([(-z, y, -b) for z, y, b in slot], format="xyb", close=True,
                         dxfattribs={"extrusion": (0, 0, -1)})  # fmt: skip
    space.add_lwpolyline([(0, 0), (1, 0), (1, 1)])
    document.saveas(tmp_path / "part.dxf")
    drawing = read_dxf(tmp_path / "part.dxf")
    assert drawing.metre == pytest.approx(1e-3)
    areas = [only(drawing, 1e-8, str(n)).area for n in (1, 2, 3, 4)]
    whole = 40e-3 * 20e-3 + pi * 1e-4
    assert areas == pytest.approx([whole, pi * 25e-6, 6e-4, whole], rel=1e-5)
    np.testing.assert_allclose(
        only(drawing, 1e-5, "1").centre, only(drawing, 1e-5, "4").centre, atol=1e-9
    )
    with pytest.raises(UsageError, match="C174"):
        only(drawing, None, "5")
    (tmp_path / "bad.dxf").write_text("nothing", "utf-8")
    with pytest.raises(UsageError, match="C171"):
        read_dxf(tmp_path / "bad.dxf")


def test_a_drawn_wheel_rolls_like_a_polygon_that_was_typed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("svgelements")
    monkeypatch.chdir(tmp_path)
    Path("box.svg").write_text(SVG.format(SIZE, '<rect x="-20" y="-20" width="40" height="40"/>'))
    assert run(["import", "outline", "box.svg", "-o", "Box.pmo", "-q"]) == 0
    text = """model Falls
  import PlanarMultiBody.*;
  inner World world;
  Parts.Body body(m=1, I=1e-4, r(start={0, 0.05}, each fixed=true), phi(start=0.3, fixed=true),
    v(each fixed=true), w(fixed=true));
  Contacts.Contact contact(redeclare Contacts.Polygon contour1(vertices=VERTICES), mu=0.3, e=0.2);
equation
  connect(body.frame_a, contact.frame_a);
  connect(world.frame_b, contact.frame_b);
end Falls;
"""
    typed = "{{-0.01, -0.01}, {0.01, -0.01}, {0.01, 0.01}, {-0.01, 0.01}}"
    Path("typed.pmo").write_text(text.replace("VERTICES", typed), "utf-8")
    Path("drawn.pmo").write_text(text.replace("VERTICES", "Box.vertices"), "utf-8")
    found = [
        planarc.load(name, libraries=["."]).simulate(stop_time=0.5)["body.phi"][-1]
        for name in ("typed.pmo", "drawn.pmo")
    ]
    assert found[0] == pytest.approx(found[1], abs=1e-9)
    assert abs(found[0]) < 1e-6


def test_names_of_files_become_names_of_classes() -> None:
    assert [class_name(s) for s in ("rocker", "2-cam", "my part")] == [
        "Rocker", "Outline_2_cam", "My_part",
    ]  # fmt: skip


def test_without_its_packages_the_command_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import sys

    for module, name in (("svgelements", "a.svg"), ("ezdxf", "a.dxf")):
        monkeypatch.setitem(sys.modules, module, None)
        (tmp_path / name).write_text("", "utf-8")
        assert run(["import", "outline", str(tmp_path / name)]) == 2
        told = capsys.readouterr().err
        assert f"C221]: this needs `{module}`" in told and "planarc[cad]" in told
