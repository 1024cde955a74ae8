"""Bars whose centre of mass or inertia hardly suits their length.

In:   Dae
Out:  warnings S326, at the user's part

Two slips are told for certain enough. The centre of mass lies on the bar's line, but far beyond its
end, and the inertia is that of a small thing there: a decimal point is at the wrong place. The
inertia is m*L^2/3 to the last digit, with the centre of mass half-way: that of a rod about its end,
where the one about its centre of mass is asked for.

Example: `BodyShape(r={0.028, 0}, r_CM={0.14, 0})`, where 0.014 was meant.
"""

from __future__ import annotations

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
#: The sine of an angle that is none.
_STRAIGHT = 1e-6
_ROD_ABOUT_END, _ROD_ABOUT_CENTRE = 3.0, 12.0
_EXACT = 1e-6


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
        told = _told(name, (x, y), (centre[0], centre[1]), m, inertia)
        if told is not None:
            message, hint = told
            yield Diagnostic("S326", message, part.span, Severity.WARNING, hint=hint)


def _told(
    name: str, r: tuple[float, float], centre: tuple[float, float], m: float, inertia: float
) -> tuple[str, str] | None:
    """The sentence about one bar, and what to do."""
    length, distance = hypot(*r), hypot(*centre)
    if not (length > 0 and distance > 0 and m > 0):
        return None
    across = r[0] * centre[1] - r[1] * centre[0]
    along = r[0] * centre[0] + r[1] * centre[1]
    if along <= 0 or abs(across) > _STRAIGHT * length * distance:
        return None
    if distance > _BEYOND * length and inertia < _SMALL * m * distance**2:
        return (
            f"the centre of mass of `{name}` is {distance:.3g} m along its line, "
            f"{distance / length:.3g} times as far as its other end",
            f"look at `{name}.r_CM`; where none is given it is half-way, at {length / 2:.3g} m",
        )
    half = isclose(distance, length / 2, rel_tol=_EXACT)
    if half and isclose(inertia, m * length**2 / _ROD_ABOUT_END, rel_tol=_EXACT):
        return (
            f"`{name}.I` = {inertia:.3g} kg.m2 is that of a rod about its end, m*L^2/3; `I` is "
            "about the centre of mass",
            f"write `{name}(I=m*L^2/12)`, which is "
            f"{m * length**2 / _ROD_ABOUT_CENTRE:.3g} kg.m2, if it is a rod",
        )
    return None
