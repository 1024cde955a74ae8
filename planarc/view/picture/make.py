"""Pictures of a run in files, still or moving, by the ending of their names.

.svg          moves by itself in a browser; needs nothing but planarc
.gif          needs Pillow
.mp4          needs Pillow and imageio-ffmpeg
.png          one instant; needs Pillow
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec import field
from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import usage_error
from planarc.core.extras import need
from planarc.ir.insight import Layer
from planarc.ir.result import Result
from planarc.view.picture import movie
from planarc.view.picture.camera import Camera, fit_camera
from planarc.view.picture.furniture import FOOT, NARROW, furnish
from planarc.view.picture.motion import Motion, When, sample_motion, still, thinned
from planarc.view.picture.names import place_tags
from planarc.view.picture.overlays import trace_items, with_layers
from planarc.view.picture.raster import render_images
from planarc.view.picture.svg import render_svg
from planarc.view.scene import Scene, make_scene
from planarc.view.storage import known_ending, replacing, write_text

if TYPE_CHECKING:
    from PIL.Image import Image


SUFFIXES = (".svg", ".gif", ".mp4", ".png")
EXTRA = "pictures"
#: A .svg is thinned afterwards, so that many frames cost it little.
_SVG_RATE = 50.0
#: The most frames from which the colours of a .gif are chosen.
_SAMPLES = 6
_NARROWEST, _WIDEST = 64, 4096


class PictureOptions(Data):
    """The choices for a picture. `at`: one instant (s) instead of a motion. `width` in pixels; the
    height follows.

    `dark`: the ground; None is light, and in a .svg as the reader's screen is. `traces` names
    points whose paths are drawn: see `overlays`. `layers` are ids of those of the report
    (`forces`, `contacts`, `velocities`, `accelerations`, `paths`, `masses`, `names`).
    """

    when: When = field(default_factory=When)
    at: float | None = None
    width: int = 640
    dark: bool | None = None
    traces: tuple[str, ...] = ()
    layers: tuple[str, ...] = ()


class Made(Data):
    """Instants and pace that a picture shows."""

    frames: int
    seconds: float  # how long it lasts
    speed: float  # s of the run in a second of the picture
    notes: tuple[str, ...]


def write_picture(
    path: Path, result: Result, options: PictureOptions, layers: Sequence[Layer] = ()
) -> Made:
    """Write a picture to `path`. `layers` are those of the run's insight. Raises UsageError V701
    (ending), V702 (size, pace), V703 (times), V705 (nothing to draw)."""
    suffix = check_suffix(path)
    _check_pace(options.when)
    if not _NARROWEST <= options.width <= _WIDEST:
        raise usage_error(
            "V702",
            f"a picture {options.width} pixels wide cannot be made",
            hint=f"choose a width from {_NARROWEST} to {_WIDEST}",
        )
    scene, keys = with_layers(_scene(result, options.traces), layers, options.layers)
    foot = FOOT if options.width >= NARROW else 0
    camera = fit_camera(scene.box, options.width, foot)
    motion = _motion(scene, options, suffix)
    shown = furnish(place_tags(motion, camera, foot), camera, scene, keys)
    if suffix == ".svg":
        write_text(path, render_svg(shown, camera, result.program.name, options.dark))
    else:
        _write_images(path, suffix, shown, camera, options)
    span = float(motion.times[-1] - motion.times[0])
    frames = len(motion.times)
    return Made(frames, motion.shown, span / motion.shown if motion.shown else 1.0, scene.notes)


def _check_pace(when: When) -> None:
    speed = 1.0 if when.speed is None else when.speed
    for value, name, least, most in (
        (speed, "speed", 1e-9, 1e9),
        (when.rate, "number of frames a second", 1.0, 240.0),
    ):
        if not least <= value <= most:  # also refuses what is no number
            raise usage_error(
                "V702",
                f"the {name} cannot be {value:g}",
                hint=f"choose one from {least:g} to {most:g}",
            )


def check_suffix(path: Path) -> str:
    return known_ending(path, SUFFIXES, "V701", "of a picture")


def check_installed(suffix: str) -> None:
    """Refuse, with UsageError C221, a picture that needs what is not installed."""
    if suffix != ".svg":
        need("PIL.Image", EXTRA)
    if suffix == ".mp4":
        need("imageio_ffmpeg", EXTRA)


def _scene(result: Result, traces: Sequence[str]) -> Scene:
    if not len(result.time):
        raise usage_error("V705", "the result has no rows, so there is nothing to draw")
    scene = make_scene(result)
    if not scene.items:
        raise usage_error(
            "V705",
            f"`{result.program.name}` has nothing that can be drawn",
            hint="pictures show the parts of `PlanarMultiBody`; curves are drawn by `planarc plot`",
        )
    paths = trace_items(result, traces)
    return replace(scene, items=(*paths, *scene.items)) if paths else scene


def _motion(scene: Scene, options: PictureOptions, suffix: str) -> Motion:
    if suffix == ".png" or options.at is not None:
        return still(scene, float(scene.time[0]) if options.at is None else options.at)
    if suffix == ".svg":
        return sample_motion(scene, replace(options.when, rate=_SVG_RATE))
    return sample_motion(scene, options.when)


def _write_images(
    path: Path,
    suffix: str,
    motion: Motion,
    camera: Camera,
    options: PictureOptions,
) -> None:
    check_installed(suffix)

    def images(of: Motion) -> Iterator[Image]:
        return render_images(of, camera, bool(options.dark))

    if suffix == ".mp4":
        movie.write_mp4(path, images(motion), (camera.width, camera.height), options.when.rate)
        return
    with replacing(path) as file:
        if suffix == ".png" or len(motion.times) == 1:
            next(images(motion)).save(file, "PNG" if suffix == ".png" else "GIF")
        else:
            samples = list(images(thinned(motion, max(1, len(motion.times) // _SAMPLES))))
            movie.write_gif(file, images(motion), samples, options.when.rate)
