"""Shapes: one knowledge for pictures and pages, measured by the item's length and width."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from planarc.view.item import Item, Kind
from planarc.view.marks.draw import marks_of
from planarc.view.marks.marks import Bar, Disc, Outline
from planarc.view.marks.measure import BASIS, HEAD, L, W, sizes_of
from planarc.view.marks.shapes import _ENDS, _SIDES, shape_of
from planarc.view.page import assets
from planarc.view.page.shapes import shape_data

RED = (214.0, 69.0, 65.0)


def item(shape: str = "box", kind: Kind = Kind.SHAPE, **more: Any) -> Item:
    given = {"length": 2.0, "width": 0.5, **more}
    return Item("a", kind, 0.0, 0.0, 0.0, color=RED, shape=shape, **given)


def test_a_measure_is_what_it_says() -> None:
    sizes = sizes_of(2.0, 0.1, 0.0, 0.01)
    assert (0.36 * W - 0.62 * L).of(sizes) == pytest.approx(-1.204)
    assert HEAD.of(sizes_of(-0.2, 0.1, 0.0, 0.01)) == -0.2  # as long as the arrow, and backwards
    assert HEAD.of(sizes_of(9.0, 0.0, 0.0, 0.01)) == pytest.approx(4.5 * 0.016)


@pytest.mark.parametrize("upright", [False, True])
@pytest.mark.parametrize("shape", sorted({*_SIDES, *_ENDS, "unknown"}))
def test_every_solid_lies_in_its_box(shape: str, upright: bool) -> None:
    for length in (2.0, -2.0):
        for mark in marks_of(item(shape, upright=upright, length=length, extra=0.6), 1e-6):
            match mark:
                case Outline():
                    far = [abs(y) for _, y in mark.points]
                case Bar():
                    far = [abs(mark.low), abs(mark.high)]
                    assert mark.left < mark.right
                case Disc():
                    far = [mark.radius]
            assert max(far) <= 0.25 + 1e-9 or (shape == "sphere" and not upright)


def test_equal_items_share_a_shape_and_a_pipe_is_measured_by_its_extra() -> None:
    assert shape_of(item("spring", extra=7.0)) is shape_of(item("spring", extra=7.0, length=1.0))
    thick, thin = (item("pipe", upright=True, extra=e) for e in (0.3, 0.9))
    assert shape_of(thick) is shape_of(thin)
    radii = [
        [m.radius for m in marks_of(i, 1e-6) if isinstance(m, Disc)][-1] for i in (thick, thin)
    ]
    assert radii == pytest.approx([0.3 * 0.25, 0.9 * 0.25])


def test_what_has_no_size_yet_is_not_drawn() -> None:
    assert not marks_of(item(length=0.0), 0.01)
    assert not marks_of(item(kind=Kind.ARROW, length=0.0), 0.01)
    assert marks_of(item(upright=True, length=0.0), 0.01)


def test_the_page_knows_every_kind_of_form_and_every_size() -> None:
    script = (Path(assets.__file__).parent / "paint.js").read_text(encoding="utf-8")
    sizes = re.search(r"return \{\s*(l: [^}]*?),?\s*\};", script)
    assert sizes is not None
    assert {part.split(":")[0].strip() for part in sizes[1].split(",")} == set(BASIS)
    for shape in {*_SIDES, *_ENDS, "ground"}:
        for upright in (False, True):
            for form in shape_data(shape_of(item(shape, upright=upright)))["forms"]:
                assert f"{form['kind']}(ctx" in script
