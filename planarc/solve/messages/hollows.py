"""Rollers that are too big for the hollows of their cam, where a mechanism jams.

In:   Program, a kernel at the point where equations of a contact lose their solution, the last row
      before, as an integrator may have tried what is far behind that point
Out:  a sentence with both radii, or nothing

The curvature is that of the curves as they are drawn, by three neighbouring points each, and
counts as positive where a curve bulges out on the side that is touched. A circle of radius R fits
a hollow of the curvature -k as long as 1/R > k; where they are equal, the contact stops moving
along the cam at any finite speed.

Example: a roller of 0.08 m on a cam with waves, whose hollows have a radius of 0.015 m.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

from planarc.core.data import Data
from planarc.evaluate.value import evaluate
from planarc.ir.expr import Expr
from planarc.ir.kernel import Kernel
from planarc.ir.places import owner
from planarc.ir.program import Program
from planarc.solve.messages.sides import curves_of

#: Curvatures of a circle or a line differ by no more, as a part of the largest one.
_EVEN = 1e-3
#: The part of a curve, to both sides, that counts as near to the contact.
_NEAR = 0.03
_NO_ROW: Mapping[int, float] = {}


class _Curve(Data):
    name: str
    curvature: tuple[float, ...]  # from its first point to its last one but one
    near: tuple[float, ...]  # around the contact


def too_big(
    program: Program, kernel: Kernel, components: Iterable[str], row: Mapping[int, float] = _NO_ROW
) -> str:
    """What does not fit a hollow, of the contacts among components; empty where all does."""
    for contact in dict.fromkeys(components):
        names = curves_of(program, contact)
        found = [_curve(program, kernel, contact, name, row) for name in names]
        curves = [curve for curve in found if curve is not None]
        if len(curves) != 2:
            continue
        for roller, cam in (curves, curves[::-1]):
            if _is_even(roller, cam) and not _is_even(cam, cam) and _hits(roller, cam):
                return _told(roller, cam)
    return ""


def _is_even(curve: _Curve, beside: _Curve) -> bool:
    """Whether a curve is a circle or a line, beside another one."""
    most = max(_tiny(curve), _EVEN * _tiny(beside))  # the second one counts for lines only
    return max(curve.curvature) - min(curve.curvature) <= most


def _hits(roller: _Curve, cam: _Curve) -> bool:
    """Whether the roller does not fit the cam where it is."""
    return (
        roller.curvature[0] >= -_tiny(cam) and roller.curvature[0] + min(cam.near, default=0.0) <= 0
    )


def _tiny(curve: _Curve) -> float:
    return _EVEN * max(map(abs, curve.curvature))


def _told(roller: _Curve, cam: _Curve) -> str:
    least = -1 / min(cam.curvature)
    if roller.curvature[0] <= _tiny(cam):
        return (
            f"`{roller.name}` is straight and does not fit the hollows of `{cam.name}`: take a "
            f"roller with a radius below {least:.3g} m, or a cam that bulges out everywhere"
        )
    return (
        f"`{roller.name}` has a radius of {1 / roller.curvature[0]:.3g} m, and does not fit the "
        f"hollows of `{cam.name}`, of {least:.3g} m where they bend most: take a smaller roller, "
        "or make the hollows flatter"
    )


def _curve(
    program: Program, kernel: Kernel, contact: str, name: str, row: Mapping[int, float]
) -> _Curve | None:
    """A curve as it is drawn; None where it is not, or where its contact is not known."""
    drawn = next(
        (v for v in program.visuals if v.kind == "curve" and owner(v.component) == name), None
    )
    at = f"{contact}.{name.rpartition('.')[2].replace('curve', 's')}"
    columns = {c.name: c for c in program.columns}
    values = {p.name: float(kernel.w[p.slot]) for p in program.parameter_slots}
    first, last = (values.get(f"{name}.s_{end}") for end in ("min", "max"))
    if drawn is None or at not in columns or first is None or last is None:
        return None
    points = drawn.get("points")
    places = [
        (_value(values, p[0]), _value(values, p[1]))
        for p in (points if isinstance(points, tuple) else ())
        if isinstance(p, tuple) and len(p) == 2
    ]
    bends = _bends(places, bool(values.get(f"{name}.closed")))
    if not bends or last == first or not all(map(math.isfinite, bends)):
        return None
    side = -1.0 if values.get(f"{name}.switchSide") else 1.0
    bends = [side * k for k in bends]
    slot, sign = columns[at].slot, columns[at].sign
    reach = math.ceil(_NEAR * len(bends))
    near = [
        bends[(round((s - first) / (last - first) * len(bends)) + i) % len(bends)]
        for s in (sign * float(kernel.w[slot]), sign * row.get(slot, math.nan))
        if math.isfinite(s)
        for i in range(-reach, reach + 1)
    ]
    return _Curve(name, tuple(bends), tuple(near))


def _value(values: dict[str, float], value: object) -> float:
    try:
        return float(evaluate(value, lambda e: values[repr(e)])) if isinstance(value, Expr) else 0.0
    except (ArithmeticError, ValueError, KeyError):
        return math.nan


def _bends(points: Sequence[tuple[float, float]], closed: bool) -> list[float]:
    """The signed curvatures at points, of a turn to the left positive: of a closed curve from its
    first point on, else without its ends."""
    if len(points) == 2:
        return [0.0]
    if closed and len(points) > 3:
        points = [points[-2], *points]
    return [_bend(*three) for three in zip(points, points[1:], points[2:], strict=False)]


def _bend(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    """That of the circle through three points."""
    area = (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
    sides = math.dist(a, b) * math.dist(b, c) * math.dist(c, a)
    return 2 * area / sides if sides > 0 else math.nan
