"""Values with units, as a user writes them: `45deg`, `20cm`, `1.5 kN`, `500ms`.

In:   a text, and the unit in which a number is wanted
Out:  the number; None where the text is no number with a unit

Angles count here: `rad/s` is not `Hz`, and `N.m` is not `N.m/rad`. Decimals are exact.
Reference: SI brochure, 9th edition, tables 7 and 8.
"""

from __future__ import annotations

import re
from functools import lru_cache
from math import copysign, inf, isfinite, log10, pi
from typing import TYPE_CHECKING, Any

from planarc.core.diagnostic import UsageError, usage_error
from planarc.core.nearest import nearest
from planarc.core.prose import either
from planarc.core.unit import Dimension, factors, parse

if TYPE_CHECKING:
    from fractions import Fraction

_QUANTITY = r"((?>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?))(?:\s+(?=1)|\s*(?!1))([A-Za-z%(1]\S*)"
#: What keyboards and eyes prefer, in the place of what units are written with.
_SPELT = {
    "°": "deg",
    "µ": "u",
    "μ": "u",
    "Ω": "Ohm",
    "^": "",
    "*": ".",
    "·": ".",
    "²": "2",
    "³": "3",
}

_TENS = {
    "da": 1, "h": 2, "k": 3, "M": 6, "G": 9, "T": 12, "P": 15, "E": 18, "Z": 21, "Y": 24, "": 0,
    "d": -1, "c": -2, "m": -3, "u": -6, "n": -9, "p": -12, "f": -15, "a": -18, "z": -21, "y": -24,
}  # fmt: skip
#: Sizes of symbols that are no products of SI base units, as numerators and denominators.
_SIZES = {
    "%": (1, 100), "deg": (1, 180), "rev": (2, 1), "g": (1, 1000), "t": (1000, 1),
    "min": (60, 1), "h": (3600, 1), "d": (86400, 1), "bar": (100000, 1), "Wh": (3600, 1),
    "eV": (1602176634, 10**28), "l": (1, 1000),
}  # fmt: skip
_ANGLES = ("rad", "deg", "rev")  # the last two are counted in pi
#: The base units as pint calls their kinds.
_PINT = ("length", "mass", "time", "current", "temperature", "substance", "luminosity")
#: Where a unit's zero is, in SI base units.
_ZEROS = {"degC": "273.15"}
#: Units that a hint names, the plainest first.
_COMMON = """
m cm mm km um s ms us min h kg g mg t rad deg rev mrad rad/s deg/s rev/min rad/s2 deg/s2 m/s
km/h mm/s m/s2 mm/s2 N kN mN MN N.m kN.m N.mm N/m N/mm kN/m N.s/m N.s/mm N.m/rad N.m/deg
N.m.s/rad N.m.s/deg kg.m2 kg.mm2 g.cm2 Pa MPa bar J kJ W kW K degC Hz kHz V mV A mA Ohm kg/m
kg/m3 1 %
"""


def split(text: str) -> tuple[str, str] | None:
    """The number and the unit of a text; None where it is not of this form."""
    for sign, word in _SPELT.items():
        text = text.replace(sign, word)
    found = re.fullmatch(_QUANTITY, text.strip())
    return None if found is None else (found[1], re.sub(r"\brpm\b", "rev/min", found[2]))


def in_unit(name: str, text: str, unit: str) -> float | None:
    """The number of a text in a unit. Raises UsageError C115 for a unit that does not fit."""
    found = split(text)
    if found is None:
        return None
    number, given = found
    if factors(given) is None:
        raise _unfit(f"the unit `{given}` of `{name}` is not known", given, unit)
    if parse(unit) is None:
        plain = _in_si(float(number), given)
        same = plain == float(number) or not isfinite(plain)
        hint = f"write `{name}={number if same else f'{plain:.6g}'}`"
        hint += "" if same else ", which it is in units of the SI"
        raise usage_error("C115", f"`{name}` takes a number without unit, not `{text}`", hint=hint)
    if _kind(given) != _kind(unit):
        raise _unfit(f"`{name}` takes {_wanted(unit)}, not `{text}`", given, unit)
    size, turns = _size(given)
    wanted, counted = _size(unit)
    plain = float(number)
    if not isfinite(plain) or (plain == 0 and "degC" not in (given, unit)):
        return plain  # too large, or too small
    from fractions import Fraction

    absolute = Fraction(number) * size + _zero(given) - _zero(unit)
    try:
        return float(absolute / wanted) * pi ** (turns - counted)
    except OverflowError:
        return copysign(inf, plain)


def scale(unit: str) -> tuple[float, float]:
    """What a number in a known unit is multiplied by, and what is then added, for units of the SI
    (and radians)."""
    size, turns = _size(unit)
    return float(size) * pi**turns, float(_zero(unit))


def of_pint(name: str, value: Any, unit: str) -> float:
    """The number of a quantity of pint in a unit. Raises UsageError C115 where it does not fit."""
    plain, dimension = value.to_base_units(), parse(unit)
    found = tuple(float(plain.dimensionality.get(f"[{base}]", 0)) for base in _PINT)
    if dimension is None or tuple(map(float, dimension)) != found:
        raise _unfit(f"`{name}` takes {_wanted(unit)}, not `{value}`", "", unit)
    wanted, counted = _size(unit)
    return (float(plain.magnitude) - float(_zero(unit))) / (float(wanted) * pi**counted)


@lru_cache(maxsize=4096)
def measure(unit: str) -> Dimension | None:
    """The dimension of a unit and, behind it, the logarithm of its scale; None when the unit is
    empty or not known. Products of measures are those of dimensions: `km/h` has 1000/3600."""
    dimension = parse(unit)
    if dimension is None:
        return None
    size, turns = _size(unit)
    return (*dimension, log10(size) + turns * log10(pi))


def _wanted(unit: str) -> str:
    return f"a value in `{unit}`" if unit not in ("", "1") else "a number without unit"


def _unfit(message: str, given: str, unit: str) -> UsageError:
    fitting = [u for u in _COMMON.split() if _kind(u) == _kind(unit)] or [unit]
    near = nearest(given, fitting)
    likely = either([*dict.fromkeys([*near[:1], *fitting])][:3])
    hint = f"did you mean {likely}?" if near else f"give it in {likely}"
    return usage_error("C115", message, hint=hint if unit else "give a number without unit")


def _kind(unit: str) -> object:
    """The dimension of a unit, with the exponent of angles."""
    found = factors(unit) or ()
    return parse(unit), sum(e for _, symbol, e in found if symbol in _ANGLES)


def _zero(unit: str) -> Fraction:
    """Where the zero of a unit is, in SI base units."""
    from fractions import Fraction

    return Fraction(_ZEROS.get(unit, "0"))


def _in_si(number: float, unit: str) -> float:
    """A number of a unit in SI base units; infinite where that is too large."""
    size, turns = _size(unit)
    try:
        return number * float(size) * pi**turns
    except OverflowError:
        return inf


def _size(unit: str) -> tuple[Fraction, int]:
    """The size of a unit in SI base units, and the exponent of pi in it."""
    from fractions import Fraction

    size, turns = Fraction(1), 0
    for prefix, symbol, exponent in factors(unit) or ():
        size *= (Fraction(*_SIZES.get(symbol, (1, 1))) * Fraction(10) ** _TENS[prefix]) ** exponent
        turns += exponent * (symbol in _ANGLES[1:])
    return size, turns
