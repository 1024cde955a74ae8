"""Rows of pixels that are drawn anew are all that change."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from planarc.view.picture import raster
from planarc.view.picture.make import PictureOptions, write_picture
from planarc.view.picture.motion import When

pillow = pytest.importorskip("PIL.Image")

places = st.floats(-50, 400)


@given(st.lists(st.tuples(places, places).map(lambda pair: (min(pair), max(pair)))))
def test_strips_hold_all_spans_and_no_row_twice(spans: list[tuple[float, float]]) -> None:
    rows = [row for begin, end in raster._strips(spans, 300) for row in range(begin, end)]
    assert rows == sorted(set(rows))
    assert all(0 <= row < 300 for row in rows)
    reached = {row for top, low in spans for row in range(300) if top < row + 1 and row < low}
    assert reached <= set(rows)


def test_frames_are_those_of_images_scaled_down_whole(
    swing: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def frames(name: str) -> list[bytes]:
        write_picture(tmp_path / name, swing, PictureOptions(When(rate=5), width=200))
        gif, found = pillow.open(tmp_path / name), []
        for frame in range(gif.n_frames):
            gif.seek(frame)
            found.append(gif.convert("RGB").tobytes())
        return found

    few = frames("strips.gif")
    monkeypatch.setattr(raster, "_strips", lambda spans, height: [(0, height)])
    assert frames("whole.gif") == few
