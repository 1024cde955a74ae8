"""Bars whose centre of mass or inertia hardly suits their length.

In:   Dae
Out:  warnings S326, at the user's part

These slips are told for certain enough:

    far centre       the centre of mass lies on the bar's line, but far beyond its end, and the
                     inertia is that of a small thing there, or of a rod of the bar's length: a
                     decimal is at the wrong place, or the centre is seen from elsewhere
    centre aside     it is half a length from the near end, but at a right angle to the bar, whose
                     inertia is that of a rod: the two coordinates are exchanged
    inertia of end   the inertia that is written is m*L^2/3 to the last digit, with the centre of
                     mass half-way: that of a rod about its end, where the one about its centre of
                     mass is asked for; a round number is so by chance
    mass in grams    the inertia is that of a rod of a thousandth of its mass

Example: `BodyShape(r={0.028, 0}, r_CM={0.14, 0})`, where 0.014 was meant.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from math import hypot, isclose

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Severity
from planarc.evaluate.declared import DeclaredValues
from planarc.ir.dae import Dae
from planarc.ir.places import declared_part

_NUMBERS = ("r[1]", "r[2]", "r_CM[1]", "r_CM[2]", "m", "I")
#: The centre of mass is beyond the end by this number of lengths, at least; and the inertia is at
#: most this part of the mass times the square of its distance.
_BEYOND, _SMALL = 3.0, 0.02
#: The same of a bar whose inertia is that of a rod, to this part of it.
_OFF, _ROD = 1.2, 0.1
#: The sine of an angle that is none.
_STRAIGHT = 1e-6
_ROD_ABOUT_END, _ROD_ABOUT_CENTRE = 3.0, 12.0
_EXACT = 1e-6
#: An inertia that is written.
_INERTIA = r"\bI\s*="
_Vector = tuple[float, float]


class _Bar(Data):
    """A body with two ends, in SI units: the ways to its other end and to its centre of mass."""

    name: str
    r: _Vector
    centre: _Vector
    m: float
    inertia: float

    def is_rod(self, m: float) -> bool:
        """Whether the inertia is that of a slender rod of some mass, nearly."""
        about_centre = m * hypot(*self.r) ** 2 / _ROD_ABOUT_CENTRE
        return isclose(self.inertia, about_centre, rel_tol=_ROD)


def odd_proportions(dae: Dae) -> Iterator[Diagnostic]:
    turning = [
        p.name.removesuffix(".r_CM[1]") for p in dae.parameters if p.name.endswith(".r_CM[1]")
    ]
    value = DeclaredValues(dae)
    for name in turning:
        part = declared_part(dae, name)
        numbers = value.named(*(f"{name}.{n}" for n in _NUMBERS)) if part is not None else None
        if part is None or numbers is None:
            continue
        x, y, *centre, m, inertia = numbers
        bar = _Bar(name, (x, y), (centre[0], centre[1]), m, inertia)
        told = _far_centre(bar) or _centre_aside(bar)
        if told is None and re.search(_INERTIA, part.span.text):
            told = _about_end(bar) or _in_grams(bar)
        if told is not None:
            message, hint = told
            yield Diagnostic("S326", message, part.span, Severity.WARNING, hint=hint)


def _far_centre(bar: _Bar) -> tuple[str, str] | None:
    """The sentence about a bar whose centre of mass is far beyond its end, and what to do."""
    length, distance = hypot(*bar.r), hypot(*bar.centre)
    far = distance > _BEYOND * length and bar.inertia < _SMALL * bar.m * distance**2
    of_rod = distance > _OFF * length and bar.is_rod(bar.m)
    if not (_lies_along(bar) and bar.m > 0 and (far or of_rod)):
        return None
    return (
        f"the centre of mass of `{bar.name}` is {distance:.3g} m along its line, "
        f"{distance / length:.3g} times as far as its other end",
        f"look at `{bar.name}.r_CM`, which is in m and seen from `frame_a`; where none is given it "
        f"is half-way, at {length / 2:.3g} m",
    )


def _centre_aside(bar: _Bar) -> tuple[str, str] | None:
    (x, y), (across, along) = bar.r, bar.centre
    length = hypot(x, y)
    if abs(x * across + y * along) > _STRAIGHT * length**2 or not (bar.m > 0 < length):
        return None
    if not (isclose(hypot(across, along), length / 2, rel_tol=_EXACT) and bar.is_rod(bar.m)):
        return None
    return (
        f"the centre of mass of `{bar.name}` is {length / 2:.3g} m beside it, at a right angle to "
        "the way to its other end",
        f"write `{bar.name}(r_CM={{{x / 2:.6g}, {y / 2:.6g}}})` for its middle, which it is where "
        "none is given",
    )


def _about_end(bar: _Bar) -> tuple[str, str] | None:
    """The sentence about a bar whose inertia is that of a rod about its end, and what to do."""
    m, inertia, length = bar.m, bar.inertia, hypot(*bar.r)
    about_end = m * length**2 / _ROD_ABOUT_END
    if not (_has_centre_half_way(bar) and m > 0 and isclose(inertia, about_end, rel_tol=_EXACT)):
        return None
    if float(f"{inertia:.1g}") == inertia:
        return None
    return (
        f"`{bar.name}.I` = {inertia:.3g} kg.m2 is that of a rod about its end, m*L^2/3; `I` is "
        "about the centre of mass",
        f"write `{bar.name}(I=m*L^2/12)`, which is "
        f"{m * length**2 / _ROD_ABOUT_CENTRE:.3g} kg.m2, if it is a rod",
    )


def _in_grams(bar: _Bar) -> tuple[str, str] | None:
    kilograms = bar.m / 1000
    if not (_has_centre_half_way(bar) and bar.m > 0 and bar.is_rod(kilograms)):
        return None
    return (
        f"`{bar.name}` has a mass of {bar.m:.4g} kg, and the inertia of a rod of "
        f"{kilograms:.4g} kg",
        f"masses are in kg: write `{bar.name}(m={kilograms:.6g})`",
    )


def _has_centre_half_way(bar: _Bar) -> bool:
    distance = hypot(*bar.centre)
    return _lies_along(bar) and isclose(distance, hypot(*bar.r) / 2, rel_tol=_EXACT)


def _lies_along(bar: _Bar) -> bool:
    """Whether the centre of mass is on the bar's line, on the side of its other end."""
    r, centre = bar.r, bar.centre
    across = r[0] * centre[1] - r[1] * centre[0]
    along = r[0] * centre[0] + r[1] * centre[1]
    return along > 0 and abs(across) <= _STRAIGHT * hypot(*r) * hypot(*centre)
