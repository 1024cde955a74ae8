"""The place of a point of the world on the picture.

The whole box is in view, with a margin around it; x runs to the right and y upwards in the
world, downwards on the picture. Sizes are in pixels and even, as films need them.
"""

from __future__ import annotations

from planarc.core.data import Data

#: The margin in pixels: as a share of the width, and for a label.
_MARGIN, _LABEL = 0.05, 20
#: The least and the greatest height of a picture, as shares of its width.
_HIGHEST, _LOWEST = 1.0, 0.4


class Camera(Data):
    width: int
    height: int
    scale: float  # pixels a metre
    x: float  # where the world's origin lies, in pixels
    y: float

    def __call__(self, x: float, y: float) -> tuple[float, float]:
        return self.x + self.scale * x, self.y - self.scale * y

    def back(self, x: float, y: float) -> tuple[float, float]:
        """The point of the world at a place of the picture."""
        return (x - self.x) / self.scale, (self.y - y) / self.scale

    def larger(self, factor: int) -> Camera:
        sizes = (self.width * factor, self.height * factor)
        return Camera(*sizes, self.scale * factor, self.x * factor, self.y * factor)


def fit_camera(box: tuple[float, float, float, float] | None, width: int, foot: int = 0) -> Camera:
    """A picture `width` pixels wide around (left, bottom, right, top), in metres.

    Below it are `foot` pixels, in which nothing of the world is.
    """
    left, bottom, right, top = box or (-1.0, -1.0, 1.0, 1.0)
    wide, high = right - left, top - bottom
    # A point, or a line, has no size of its own: it gets one that shows it in the middle.
    far = max(abs(left), abs(right), abs(bottom), abs(top))
    least = 1e-9 * far if far > 1e-100 else 1.0
    wide, high = max(wide, least, high / 1e3), max(high, least, wide / 1e3)
    width -= width % 2
    share = max(_MARGIN, min(_LABEL / width, 2 * _MARGIN))
    shape = (1.0 - 2 * share) * high / wide + 2 * share
    height = 2 * round(width * min(_HIGHEST, max(_LOWEST, shape)) / 2)
    margin = share * width
    scale = min((width - 2 * margin) / wide, (height - 2 * margin) / high)
    x = width / 2 - scale * (left + right) / 2
    y = height / 2 + scale * (bottom + top) / 2
    return Camera(width, height + foot, scale, x, y)
