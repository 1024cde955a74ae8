"""Bars whose centre of mass or inertia hardly suits their length.

In:   Dae
Out:  warnings S326, at the user's part

Two slips are told for certain enough. The centre of mass lies on the bar's line, but far beyond its
end, and the inertia is that of a small thing there, or of a rod of the bar's length: a decimal is
at the wrong place, or the centre is seen from elsewhere. Or the inertia that is written is
m*L^2/3 to the last digit, with the centre of mass half-way: that of a rod about its end, where the
one about its centre of mass is asked for. A round number is so by chance.

Example: `BodyShape(r={0.028, 0}, r_CM={0.14, 0})`, where 0.014 was meant.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from math import hypot, isclose

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
_INERTIA = re.compile(r"\bI\s*=")
_Vector = tuple[float, float]


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
        told = _far_centre(name, (x, y), (centre[0], centre[1]), m, inertia)
        if told is None and _INERTIA.search(part.span.text):
            told = _about_end(name, (x, y), (centre[0], centre[1]), m, inertia)
        if told is not None:
            message, hint = told
            yield Diagnostic("S326", message, part.span, Severity.WARNING, hint=hint)


def _far_centre(
    name: str, r: _Vector, centre: _Vector, m: float, inertia: float
) -> tuple[str, str] | None:
    """The sentence about a bar whose centre of mass is far beyond its end, and what to do."""
    length, distance = hypot(*r), hypot(*centre)
    about_centre = m * length**2 / _ROD_ABOUT_CENTRE
    far = distance > _BEYOND * length and inertia < _SMALL * m * distance**2
    of_rod = distance > _OFF * length and isclose(inertia, about_centre, rel_tol=_ROD)
    if not (_lies_along(r, centre) and m > 0 and (far or of_rod)):
        return None
    return (
        f"the centre of mass of `{name}` is {distance:.3g} m along its line, "
        f"{distance / length:.3g} times as far as its other end",
        f"look at `{name}.r_CM`, which is seen from `frame_a`; where none is given it is half-way, "
        f"at {length / 2:.3g} m",
    )


def _about_end(
    name: str, r: _Vector, centre: _Vector, m: float, inertia: float
) -> tuple[str, str] | None:
    """The sentence about a bar whose inertia is that of a rod about its end, and what to do."""
    length, distance = hypot(*r), hypot(*centre)
    about_end = m * length**2 / _ROD_ABOUT_END
    if not _lies_along(r, centre) or not isclose(distance, length / 2, rel_tol=_EXACT):
        return None
    if not (m > 0 and isclose(inertia, about_end, rel_tol=_EXACT)):
        return None
    if float(f"{inertia:.1g}") == inertia:
        return None
    return (
        f"`{name}.I` = {inertia:.3g} kg.m2 is that of a rod about its end, m*L^2/3; `I` is "
        "about the centre of mass",
        f"write `{name}(I=m*L^2/12)`, which is "
        f"{m * length**2 / _ROD_ABOUT_CENTRE:.3g} kg.m2, if it is a rod",
    )


def _lies_along(r: _Vector, centre: _Vector) -> bool:
    """Whether the centre of mass is on the bar's line, on the side of its other end."""
    across = r[0] * centre[1] - r[1] * centre[0]
    along = r[0] * centre[0] + r[1] * centre[1]
    return along > 0 and abs(across) <= _STRAIGHT * hypot(*r) * hypot(*centre)
