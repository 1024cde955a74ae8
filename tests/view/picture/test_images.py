"""Images: the colours lie where the formulas say, and files hold all frames."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from math import cos, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planarc.core.diagnostic import UsageError
from planarc.view.picture.camera import fit_camera
from planarc.view.picture.furniture import FOOT
from planarc.view.picture.make import PictureOptions, write_picture
from planarc.view.picture.motion import When
from planarc.view.scene import make_scene

pillow = pytest.importorskip("PIL.Image")


def red_middle(image: Any) -> Any:
    """The middle of all red pixels."""
    r, g, b = np.moveaxis(np.asarray(image.convert("RGB"), dtype=float), -1, 0)
    rows, columns = np.nonzero((r > 150) & (g < 90) & (b < 90))
    return columns.mean() + 0.5, rows.mean() + 0.5


@pytest.mark.parametrize("time", [0.0, 1.3, 3.9])
def test_a_still_shows_the_pin_where_it_is(swing: Any, tmp_path: Path, time: float) -> None:
    write_picture(tmp_path / "a.png", swing, PictureOptions(at=time, width=400))
    image = pillow.open(tmp_path / "a.png")
    camera = fit_camera(make_scene(swing).box, 400, FOOT)
    assert image.size == (camera.width, camera.height)
    assert red_middle(image) == pytest.approx(camera(cos(sin(time)), sin(sin(time))), abs=0.5)


def test_edges_are_smooth(swing: Any, tmp_path: Path) -> None:
    write_picture(tmp_path / "a.png", swing, PictureOptions(width=300))
    colors = pillow.open(tmp_path / "a.png").getcolors(100_000)
    assert len(colors) > 40  # with steps there would be the twelve of the drawing


def test_the_ground_may_be_dark(swing: Any, tmp_path: Path) -> None:
    for dark in (False, True):
        write_picture(tmp_path / "a.png", swing, PictureOptions(dark=dark, width=100))
        corner = pillow.open(tmp_path / "a.png").getpixel((1, 1))
        assert (sum(corner) < 100) is dark


def test_a_gif_holds_all_frames_at_their_pace(swing: Any, tmp_path: Path) -> None:
    made = write_picture(tmp_path / "a.gif", swing, PictureOptions(When(rate=10), width=200))
    gif = pillow.open(tmp_path / "a.gif")
    assert (made.frames, gif.n_frames, gif.info["duration"], gif.info["loop"]) == (41, 41, 100, 0)
    camera = fit_camera(make_scene(swing).box, 200)
    for frame in (0, 17, 40):
        gif.seek(frame)
        angle = sin(frame / 10)
        assert red_middle(gif) == pytest.approx(camera(cos(angle), sin(angle)), abs=1.0)


def test_a_gif_has_one_table_of_colours(swing: Any, tmp_path: Path) -> None:
    write_picture(tmp_path / "a.gif", swing, PictureOptions(When(rate=10), width=200))
    data = (tmp_path / "a.gif").read_bytes()
    heads = [m.end() for m in re.finditer(rb"\x21\xf9\x04.{4}\x00\x2c.{8}", data, re.DOTALL)]
    assert len(heads) == 41
    assert not any(data[at] & 0x80 for at in heads)  # no table of a frame's own


def test_a_film_holds_all_frames(swing: Any, tmp_path: Path) -> None:
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    path = tmp_path / "a.mp4"
    made = write_picture(path, swing, PictureOptions(When(rate=20), width=200))
    frames, seconds = ffmpeg.count_frames_and_secs(str(path))
    assert frames == made.frames == 81
    assert seconds == pytest.approx(81 / 20, abs=0.06)


def test_a_broken_film_leaves_what_was_there(
    swing: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    path = tmp_path / "a.mp4"
    path.write_bytes(b"old")

    def breaks(name: str, *_: Any, **__: Any) -> Iterator[None]:
        Path(name).write_bytes(b"half a film")
        yield
        raise OSError("the pipe is broken")

    monkeypatch.setattr(ffmpeg, "write_frames", breaks)
    with pytest.raises(UsageError) as caught:
        write_picture(path, swing, PictureOptions(When(rate=20), width=200))
    assert caught.value.diagnostics[0].code == "V704"
    assert path.read_bytes() == b"old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.mp4"]


def test_a_missing_package_is_named(
    swing: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module, name, suffix in (
        ("imageio_ffmpeg", "imageio-ffmpeg", "mp4"),
        ("PIL.Image", "pillow", "gif"),
    ):
        monkeypatch.setitem(sys.modules, module, None)
        with pytest.raises(UsageError) as caught:
            write_picture(tmp_path / f"a.{suffix}", swing, PictureOptions())
        (found,) = caught.value.diagnostics
        assert found.code == "C221"
        assert f"`{name}`" in found.message
        assert found.hint == "install it with `pip install 'planarc[pictures]'`"
    monkeypatch.setitem(sys.modules, "PIL", None)
    assert write_picture(tmp_path / "a.svg", swing, PictureOptions()).frames == 201


def test_the_font_has_every_sign_of_a_label() -> None:
    from planarc.view.page.typeset import number, unit
    from planarc.view.picture.furniture import length_text
    from planarc.view.picture.raster import _PLAIN, _font

    texts = (length_text(5e-5), unit("N.m/s2"), number(-1.5e-12), "3×2 → 6", "45°")
    font = _font(20)
    box = bytes(font.getmask("\uffff"))
    assert bytes(font.getmask("²")) == box
    for sign in "".join(texts).translate(_PLAIN).replace(" ", ""):
        assert bytes(font.getmask(sign)) != box, sign
