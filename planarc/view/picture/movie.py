"""Images in files: `.png` (one), `.gif` (Pillow), `.mp4` (imageio-ffmpeg).

A .gif counts time in hundredths of a second and holds few colours: they are chosen once, from
frames all over the run, so that nothing flickers. Colours are not dithered, since the noise
would make the file large and drawings have few of them.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from planarc.core.diagnostic import usage_error

if TYPE_CHECKING:
    from PIL.Image import Image

_COLORS = 96


def write_gif(
    file: BinaryIO, images: Iterable[Image], samples: Sequence[Image], rate: float
) -> None:
    """Write `rate` images a second, shown again and again, in the colours of the samples."""
    from PIL import Image

    colors = _palette(samples)
    frames = (i.quantize(palette=colors, dither=Image.Dither.NONE) for i in images)
    first = next(frames)
    first.save(
        file,
        "GIF",
        save_all=True,
        append_images=frames,
        palette=colors.palette,  # of all frames: they are compared by its numbers
        optimize=True,  # what stays as it is in a frame is left out
        duration=max(20, 10 * round(100 / rate)),
        loop=0,
    )


def _palette(samples: Sequence[Image]) -> Image:
    """An image with the colours of all samples."""
    from PIL import Image

    width, height = samples[0].size
    sheet = Image.new("RGB", (width, height * len(samples)))
    for i, sample in enumerate(samples):
        sheet.paste(sample, (0, i * height))
    return sheet.quantize(_COLORS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)


def write_mp4(path: Path, images: Iterable[Image], size: tuple[int, int], rate: float) -> None:
    """Write H.264, as every player and browser shows it. Raises UsageError V704 where it fails.

    The film stands at `path` when it is whole: a broken one leaves what was there.
    """
    import imageio_ffmpeg

    new = path.with_name(f".{path.stem[:50]}.{os.getpid()}.new.mp4")
    film = imageio_ffmpeg.write_frames(
        str(new), size, fps=rate, codec="libx264", quality=8, macro_block_size=2,
        output_params=["-movflags", "+faststart", "-threads", "1"],
    )  # fmt: skip
    try:
        film.send(None)
        for image in images:
            film.send(image.tobytes())
        film.close()
        new.replace(path)
    except OSError as problem:
        reason = (problem.strerror or str(problem)).strip().splitlines()
        raise usage_error(
            "V704", f"ffmpeg cannot make the film: {reason[-1] if reason else 'it stopped'}"
        ) from None
    finally:
        film.close()
        with suppress(OSError):
            new.unlink()
