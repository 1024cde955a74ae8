"""SVG text of a motion: one picture, or one that moves by itself wherever it is shown.

A moving picture holds each item once. Its place and angle are animated (SMIL, which browsers
run also inside an image); of a spring or an arrow also its outline. Of each quantity only the
instants are written from which straight lines give all others within a quarter of a pixel.
Colours stand once as classes, with others for a reader whose screen is dark.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from html import escape as escape_html

import numpy as np

from planarc.core.arrays import Vector
from planarc.view.item import Item
from planarc.view.marks.draw import marks_of, visible
from planarc.view.marks.marks import Bar, Disc, Label, Mark, Outline, Paint, Style
from planarc.view.picture.camera import Camera
from planarc.view.picture.motion import Motion, item_at, thin_polyline

PAPER, DARK_PAPER = Paint(255, 255, 255), Paint(20, 23, 29)
escape = partial(escape_html, quote=False)
#: The greatest error (pixels) of a moving thing between the instants that are written.
TOLERANCE = 0.25


def render_svg(motion: Motion, camera: Camera, title: str, dark: bool | None = None) -> str:
    """The text of a picture on a dark or light ground; None leaves it to the reader's screen."""
    return _Drawing(motion, camera, dark).text(title)


class _Drawing:
    def __init__(self, motion: Motion, camera: Camera, dark: bool | None) -> None:
        self.motion, self.camera, self.dark = motion, camera, dark
        self.classes: dict[tuple[Style, Style], str] = {}

    def text(self, title: str) -> str:
        w, h = self.camera.width, self.camera.height
        body = [line for item in self.motion.items for line in self._item(item)]
        lines = [
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{w}" height="{h}" '
            f'viewBox="0 0 {w} {h}" role="img">',
            f"<title>{escape(title)}</title>",
            f"<style>{self._styles()}</style>",
            f'<rect class="paper" width="{w}" height="{h}" rx="8"/>',
            *body,
            "</svg>",
        ]
        return "\n".join(lines) + "\n"

    # Colours

    def _class(self, light: Style, dark: Style) -> str:
        """The name of the class of a mark."""
        if self.dark is not None:
            light = dark = dark if self.dark else light
        return self.classes.setdefault((light, dark), f"s{len(self.classes)}")

    def _styles(self) -> str:
        paper = DARK_PAPER if self.dark else PAPER
        common = "text{font-family:system-ui,sans-serif;text-anchor:middle;stroke:none;"
        common += "dominant-baseline:central}"
        shapes = "path,polyline,polygon{stroke-linecap:round;stroke-linejoin:round}"
        light = f".paper{{fill:{paper.code}}}" + "".join(
            f".{name}{{{self._css(pair[0])}}}" for pair, name in self.classes.items()
        )
        if self.dark is not None:
            return common + shapes + light
        dark = f".paper{{fill:{DARK_PAPER.code}}}" + "".join(
            f".{name}{{{_colors(pair[1])}}}"
            for pair, name in self.classes.items()
            if pair[0] != pair[1]
        )
        return f"{common}{shapes}{light}@media(prefers-color-scheme:dark){{{dark}}}"

    def _css(self, style: Style) -> str:
        width = f";stroke-width:{_short(style.width * self.camera.scale, 2)}" if style.line else ""
        return _colors(style) + width

    # Items

    def _item(self, item: Item) -> list[str]:
        frames = range(len(self.motion.times))
        poses = [item_at(item, f) for f in frames]
        pixel = 1.0 / self.camera.scale
        light = [marks_of(p, pixel) if visible(p) else () for p in poses]
        seen = [bool(marks) for marks in light]
        if not any(seen):
            return []
        # What is out of sight for a while keeps its form, and its place, from before.
        shown = _last_seen(seen)
        poses, light = [poses[f] for f in shown], [light[f] for f in shown]
        dark = marks_of(poses[0], pixel, dark=True)
        classes = [self._class(a.style, b.style) for a, b in zip(light[0], dark, strict=True)]
        places = self._places(poses, light)
        marks = [
            self._mark([m[i] for m in light], name, item, poses) for i, name in enumerate(classes)
        ]
        hidden = [] if all(seen) else [self._steps("visibility", seen)]
        return [f"<g{places[0]}>", *hidden, *places[1:], *marks, "</g>"]

    def _places(self, poses: Sequence[Item], marks: Sequence[Sequence[Mark]]) -> list[str]:
        """The attribute that places an item, and the animations of it."""
        x = np.array([self.camera(p.x, p.y) for p in poses])  # type: ignore[arg-type]
        turn = -np.degrees(np.array([p.angle for p in poses], dtype=float))
        reach = max(1.0, _reach(marks[0]) * self.camera.scale)
        digits = 1 if reach < 60 else 2
        if _round_only(marks[0]):
            turn = np.zeros_like(turn)
        angle = _short(turn[0], digits)
        place = f"translate({_pair(x[0])})" + (f"rotate({angle})" if float(angle) else "")
        lines = [f' transform="{place}"']
        turns = float(np.ptp(turn)) * reach > 57.3 * TOLERANCE
        moves = float(np.max(np.ptp(x, axis=0))) > TOLERANCE
        if moves or turns:
            # An animated translation takes the place of the whole attribute.
            lines.append(self._turn("translate", x, [_pair(p) for p in x], 1.0))
        if turns or (moves and float(angle)):
            texts = [_short(a, digits) for a in turn]
            lines.append(self._turn("rotate", turn[:, None], texts, reach / 57.3))
        return lines

    def _turn(self, kind: str, values: Vector, texts: Sequence[str], pixels: float) -> str:
        keep = thin_polyline(self._phase(), values * pixels, TOLERANCE)
        add = ' additive="sum"' if kind == "rotate" else ""
        return (
            f'<animateTransform attributeName="transform" type="{kind}"{add} '
            f"{self._timing(keep, texts)}/>"
        )

    def _mark(self, marks: Sequence[Mark], name: str, item: Item, poses: Sequence[Item]) -> str:
        """One mark, with an animation of each attribute that changes."""
        forms = [_form(m, self.camera.scale) for m in marks]
        tag, first, text = forms[0]
        stretch = self._stretched([f[1] for f in forms])
        if stretch:
            forms = forms[:1]
        inside = stretch
        for attribute in first:
            rows = [f[1][attribute] for f in forms]
            if all(r == rows[0] for r in rows):
                continue
            values = np.array(rows, dtype=float).reshape(len(rows), -1)
            if float(np.max(np.ptp(values, axis=0))) > TOLERANCE:
                keep = thin_polyline(self._phase(), values, TOLERANCE)
                texts = [_numbers(r) for r in rows]
                inside += f'<animate attributeName="{attribute}" {self._timing(keep, texts)}/>'
        inside += self._colors(item, marks)
        given = "".join(f' {a}="{_numbers(v)}"' for a, v in first.items())
        given += ' vector-effect="non-scaling-stroke"' if stretch else ""
        inside = escape(text) + inside
        return f'<{tag} class="{name}"{given}' + (f">{inside}</{tag}>" if inside else "/>")

    def _stretched(self, forms: Sequence[dict[str, tuple[float, ...]]]) -> str:
        """A mark that only grows along its length, such as a spring, written once and scaled."""
        if "points" not in forms[0]:
            return ""
        points = np.array([f["points"] for f in forms]).reshape(len(forms), -1, 2)
        far = int(np.argmax(np.abs(points[0, :, 0])))
        if not points[0, far, 0]:
            return ""
        scale = points[:, far, 0] / points[0, far, 0]
        off = points - points[0] * np.stack([scale, np.ones_like(scale)], axis=1)[:, None, :]
        if np.abs(off).max() > TOLERANCE or np.ptp(points[:, far, 0]) <= TOLERANCE:
            return ""
        keep = thin_polyline(self._phase(), points[:, far, :1], TOLERANCE)
        texts = [f"{_short(s, 4)},1" for s in scale]
        return (
            '<animateTransform attributeName="transform" type="scale" '
            f"{self._timing(keep, texts)}/>"
        )

    def _colors(self, item: Item, marks: Sequence[Mark]) -> str:
        """Animations of the colours of a mark, where they change."""
        if all(isinstance(c, (int, float)) for c in item.color):
            return ""
        text = ""
        for attribute, paints in (
            ("fill", [m.style.fill for m in marks]),
            ("stroke", [m.style.line for m in marks]),
        ):
            known = [p for p in paints if p is not None]
            if len(known) == len(marks) and len(set(known)) > 1:
                values = np.array([(p.red, p.green, p.blue) for p in known])
                keep = thin_polyline(self._phase(), values, 2.0)
                texts = [p.code for p in known]
                text += f'<animate attributeName="{attribute}" {self._timing(keep, texts)}/>'
        return text

    def _steps(self, attribute: str, seen: Sequence[bool]) -> str:
        """The animation of an attribute that changes at once, where it does."""
        keep = [0, *(i for i in range(1, len(seen)) if seen[i] != seen[i - 1])]
        texts = ["visible" if s else "hidden" for s in seen]
        return (
            f'<animate attributeName="{attribute}" calcMode="discrete" '
            f"{self._timing(keep, texts)}/>"
        )

    def _phase(self) -> Vector:
        """The phase of each frame, 0 to 1."""
        return np.linspace(0.0, 1.0, len(self.motion.times))

    def _timing(self, keep: Sequence[int], texts: Sequence[str]) -> str:
        phase = self._phase()
        times = "" if len(keep) == len(texts) else ";".join(_short(phase[i], 4) for i in keep)
        return (
            f'dur="{_short(self.motion.shown, 3)}s" repeatCount="indefinite" '
            + (f'keyTimes="{times}" ' if times else "")
            + f'values="{";".join(texts[i] for i in keep)}"'
        )


def _last_seen(seen: Sequence[bool]) -> list[int]:
    """The nearest frame that is seen: before each one, at the start after it."""
    last = seen.index(True)
    shown = []
    for frame, is_seen in enumerate(seen):
        last = frame if is_seen else last
        shown.append(last)
    return shown


def _reach(marks: Sequence[Mark]) -> float:
    """The reach of marks, in metres, from the origin of their item."""
    far = 0.0
    for mark in marks:
        match mark:
            case Outline():
                far = max(far, *((x * x + y * y) ** 0.5 for x, y in mark.points))
            case Bar():
                far = max(far, abs(mark.left), abs(mark.right), abs(mark.low), abs(mark.high))
            case Disc() | Label():
                far = max(far, (mark.x**2 + mark.y**2) ** 0.5)
    return far


def _round_only(marks: Sequence[Mark]) -> bool:
    """True where nobody sees that it turns."""
    return all(isinstance(m, Disc | Label) and m.x == m.y == 0.0 for m in marks)


def _form(mark: Mark, scale: float) -> tuple[str, dict[str, tuple[float, ...]], str]:
    """Element, attributes in pixels (y downwards), text."""
    k = scale
    form: dict[str, tuple[float, ...]]
    match mark:
        case Outline():
            points = tuple(v for x, y in mark.points for v in (k * x, -k * y))
            return "polygon" if mark.closed else "polyline", {"points": points}, ""
        case Bar():
            form = {
                "x": (k * mark.left,),
                "y": (-k * max(mark.low, mark.high),),
                "width": (k * (mark.right - mark.left),),
                "height": (k * abs(mark.high - mark.low),),
            }
            return "rect", form | ({"rx": (k * mark.radius,)} if mark.radius else {}), ""
        case Disc():
            form = {"cx": (k * mark.x,), "cy": (-k * mark.y,)} if mark.x or mark.y else {}
            return "circle", form | {"r": (k * mark.radius,)}, ""
        case Label():
            form = {"x": (k * mark.x,), "y": (-k * mark.y,), "font-size": (k * mark.height,)}
            return "text", form, mark.text


def _colors(style: Style) -> str:
    parts = [f"fill:{style.fill.code if style.fill else 'none'}"]
    if style.fill and style.fill.opacity < 1:
        parts.append(f"fill-opacity:{style.fill.opacity:g}")
    if style.line:
        parts.append(f"stroke:{style.line.code}")
        if style.line.opacity < 1:
            parts.append(f"stroke-opacity:{style.line.opacity:g}")
    return ";".join(parts)


def _short(value: float, digits: int) -> str:
    """A number in few letters."""
    text = f"{value:.{digits}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text in ("-0", "") else text


def _pair(point: Sequence[float]) -> str:
    return f"{_short(point[0], 1)},{_short(point[1], 1)}"


def _numbers(values: Sequence[float]) -> str:
    return " ".join(_short(v, 2) for v in values)
