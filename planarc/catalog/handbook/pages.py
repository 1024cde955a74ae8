"""The contents of a handbook about each class: names, texts, numbers, no trees and no files."""

from __future__ import annotations

from planarc.core.data import Data

#: A point of an icon; y grows upwards, as in the language.
Point = tuple[float, float]
Color = tuple[int, int, int]


class Link(Data):
    """A text, and the full name of the class it leads to, None where there is none."""

    text: str
    target: str | None = None


class Graphic(Data):
    """One primitive of an icon, in the coordinates of its class.

    `shape` is `line`, `polygon`, `rectangle`, `ellipse` or `text`; a rectangle, an ellipse and
    a text have two points, the corners of their extent.
    """

    shape: str
    points: tuple[Point, ...]
    line: Color = (0, 0, 0)
    fill: Color | None = None
    width: float = 0.25  # mm, as the language counts
    dashed: bool = False
    radius: float = 0.0
    text: str = ""
    smooth: bool = False  # a line or polygon that is bent, its points pull at it
    arrows: tuple[bool, bool] = (False, False)  # heads at the begin and the end of a line


class Placed(Data):
    """The icon of a connector inside of an icon: its extent there, and a turn about a point."""

    graphics: tuple[Graphic, ...]
    extent: tuple[Point, Point]
    origin: Point = (0.0, 0.0)
    rotation: float = 0.0  # degrees, counter-clockwise


class Icon(Data):
    """The look of a class: inherited graphics first, then its own, then its connectors."""

    graphics: tuple[Graphic, ...] = ()
    connectors: tuple[Placed, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.graphics or self.connectors)


class Row(Data):
    """A component: `origin` is the base class that declares it, None for the class itself."""

    name: str
    type: Link
    value: str = ""
    unit: str = ""
    comment: str = ""
    origin: Link | None = None


class ClassPage(Data):
    """One class of the handbook."""

    name: str  # full
    kind: str  # `model`, `partial model`, `package` ...
    comment: str
    info: str  # HTML as the library wrote it; not to be trusted
    icon: Icon
    bases: tuple[Link, ...]
    children: tuple[str, ...]  # full names, in the order of the library
    tables: tuple[tuple[str, tuple[Row, ...]], ...]  # heading and rows
    equations: tuple[str, ...]
    source: str
    file: str
    head: tuple[tuple[str, str], ...] = ()  # `Law`, `Sign`, `Valid` ... and what they say
    inherited: tuple[tuple[Link, tuple[str, ...]], ...] = ()  # base classes with equations

    @property
    def is_example(self) -> bool:
        """True for a model to run, in the package of a library's examples."""
        return ".Examples." in self.name
