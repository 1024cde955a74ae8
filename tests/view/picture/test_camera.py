"""Where things lie on a picture."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from planarc.view.picture.camera import fit_camera

lengths = st.floats(-1e6, 1e6)
sizes = st.floats(0, 1e6)


@given(lengths, lengths, sizes, sizes, st.integers(64, 2000))
def test_the_whole_box_is_in_view(
    left: float, bottom: float, wide: float, high: float, width: int
) -> None:
    camera = fit_camera((left, bottom, left + wide, bottom + high), width)
    assert camera.width % 2 == camera.height % 2 == 0
    for x, y in ((left, bottom), (left + wide, bottom + high)):
        px, py = camera(x, y)
        assert -1 <= px <= camera.width + 1
        assert -1 <= py <= camera.height + 1


def test_it_fills_the_picture_but_for_a_margin() -> None:
    camera = fit_camera((-1.0, 0.0, 1.0, 1.0), 1000)
    assert camera(-1.0, 0.0) == (50.0, camera.height - 50.0)
    assert camera(1.0, 1.0) == (950.0, 50.0)


def test_nothing_to_show_still_has_a_view() -> None:
    assert fit_camera(None, 640)(0.0, 0.0) == (320.0, 320.0)
