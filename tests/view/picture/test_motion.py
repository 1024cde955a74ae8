"""Which instants a picture shows, and how fast."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planarc.core.diagnostic import UsageError
from planarc.view.picture.motion import When, choose_speed, sample_motion, still, thin_polyline
from planarc.view.scene import Scene, make_scene

TIME = np.linspace(0.0, 4.0, 401)


@pytest.fixture
def scene(table: Any, result_of: Callable[..., Any], shape_of: Callable[..., Any]) -> Scene:
    rod = shape_of(table, "rod", phi=table.symbol("phi"), length=1.0, width=0.1)
    return make_scene(result_of(table, TIME, {"phi": TIME**2}, (rod,)))


def test_frames_are_equally_far_apart_and_hold_the_values_of_their_time(scene: Scene) -> None:
    motion = sample_motion(scene, When(begin=1.0, end=3.0, speed=0.5, rate=10.0))
    assert motion.shown == 4.0
    np.testing.assert_allclose(motion.times, np.linspace(1.0, 3.0, 41))
    np.testing.assert_allclose(motion.items[0].angle, motion.times**2, atol=1e-4)
    assert motion.items[0].length == 1.0


def test_a_still_is_one_frame(scene: Scene) -> None:
    (rod,) = still(scene, 1.5).at(0)
    assert rod.angle == pytest.approx(2.25, abs=1e-4)


def test_times_outside_the_run_are_refused(scene: Scene) -> None:
    for when in (When(begin=-1.0), When(end=4.1), When(begin=3.0, end=2.0)):
        with pytest.raises(UsageError) as caught:
            sample_motion(scene, when)
        assert caught.value.diagnostics[0].code == "V703"


def test_a_film_of_too_many_frames_is_refused(scene: Scene) -> None:
    with pytest.raises(UsageError, match="V707"):
        sample_motion(scene, When(speed=1e-6))


@given(st.floats(1e-6, 1e9))
def test_every_run_can_be_watched(duration: float) -> None:
    speed = choose_speed(duration)
    assert 1.5 <= duration / speed <= 12.0 + 1e-6
    assert f"{speed:e}"[0] in "125"
    assert (speed == 1.0) == (2.0 <= duration <= 12.0)


@given(st.lists(st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)), min_size=2, max_size=60))
def test_thinned_lines_miss_no_point(points: list[tuple[float, float]]) -> None:
    times = np.linspace(0.0, 1.0, len(points))
    values = np.array(points)
    keep = thin_polyline(times, values, 0.5)
    assert keep[0] == 0
    assert keep[-1] == len(points) - 1
    back = np.column_stack([np.interp(times, times[keep], values[keep, i]) for i in (0, 1)])
    assert np.linalg.norm(back - values, axis=1).max() <= 0.5 + 1e-9


def test_a_straight_line_needs_its_ends_only() -> None:
    times = np.linspace(0.0, 1.0, 50)
    assert thin_polyline(times, np.column_stack([3 * times, -times]), 1e-6) == [0, 49]
