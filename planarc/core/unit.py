"""Units: their text as dimensions, and back.

A dimension is the exponents of the seven SI base units. Angles count as numbers, as in
SI, and scale factors are left out: `kN` and `N` have one dimension.

Example: `parse("kg.m2/s2")` and `parse("N.m")` and `parse("J")` are equal.

Reference: Modelica Language Specification 3.6, chapter 19.
"""

from __future__ import annotations

import re
from functools import lru_cache
from math import pi
from operator import add, sub
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from fractions import Fraction

#: exponents of m, kg, s, A, K, mol, cd; only those of roots are no integers. Where scales count
#: (see `quantity.measure`), the logarithm of the scale comes behind them.
Dimension: TypeAlias = "tuple[int | float | Fraction, ...]"

_BASE = ("m", "kg", "s", "A", "K", "mol", "cd")
NUMBER: Dimension = (0,) * len(_BASE)
#: A prefix (or nothing), a symbol, and its exponent: `mm2` is ("m", "m", 2).
Factor: TypeAlias = "tuple[str, str, int]"


def _of(**exponents: int) -> Dimension:
    return tuple(exponents.get(name, 0) for name in _BASE)


_SYMBOLS: dict[str, Dimension] = {
    name: dimension
    for names, dimension in {
        "1 % rad sr deg rev": NUMBER,
        "m": _of(m=1),
        "g t": _of(kg=1),
        "s min h d": _of(s=1),
        "A": _of(A=1),
        "K degC": _of(K=1),
        "mol": _of(mol=1),
        "cd lm": _of(cd=1),
        "Hz Bq": _of(s=-1),
        "N": _of(kg=1, m=1, s=-2),
        "Pa bar": _of(kg=1, m=-1, s=-2),
        "J Wh eV": _of(kg=1, m=2, s=-2),
        "W var VA": _of(kg=1, m=2, s=-3),
        "C": _of(A=1, s=1),
        "V": _of(kg=1, m=2, s=-3, A=-1),
        "F": _of(kg=-1, m=-2, s=4, A=2),
        "Ohm": _of(kg=1, m=2, s=-3, A=-2),
        "S": _of(kg=-1, m=-2, s=3, A=2),
        "Wb": _of(kg=1, m=2, s=-2, A=-1),
        "T": _of(kg=1, s=-2, A=-1),
        "H": _of(kg=1, m=2, s=-2, A=-2),
        "lx": _of(cd=1, m=-2),
        "Gy Sv": _of(m=2, s=-2),
        "kat": _of(mol=1, s=-1),
        "l": _of(m=3),
    }.items()
    for name in names.split()
}
_PREFIXES = ("da", *"yzafpnumcdhkMGTPEZY")
_TOKEN = re.compile(r"(?:[A-Za-z]+|1|%)(?:[+-]?\d+)?|.", re.DOTALL)
_FACTOR = re.compile(r"([A-Za-z]+|1|%)([+-]?\d+)?")


@lru_cache(maxsize=4096)
def parse(text: str) -> Dimension | None:
    """The dimension of a unit, None when it is empty or not known."""
    found = factors(text)
    if found is None:
        return None
    total = NUMBER
    for _, symbol, exponent in found:
        total = multiply(total, power(_SYMBOLS[symbol], exponent))
    return total


@lru_cache(maxsize=4096)
def factors(text: str) -> tuple[Factor, ...] | None:
    """The factors of a unit, None when it is empty or not known."""
    tokens = _TOKEN.findall(text.strip())[::-1]  # the next one stands last
    try:
        found = _quotient(tokens)
    except LookupError:
        return None
    return None if tokens else tuple(found)


def _quotient(tokens: list[str]) -> list[Factor]:
    """`numerator / denominator`, each a product with dots."""
    above = _product(tokens)
    below = _product(tokens) if _take(tokens, "/") else []
    return above + [(p, s, -e) for p, s, e in below]


def _product(tokens: list[str]) -> list[Factor]:
    total = _factor(tokens)
    while _take(tokens, "."):
        total += _factor(tokens)
    return total


def _factor(tokens: list[str]) -> list[Factor]:
    if _take(tokens, "("):
        inner = _quotient(tokens)
        if not _take(tokens, ")"):
            raise LookupError
        return inner
    factor = _FACTOR.fullmatch(tokens.pop())
    if factor is None:
        raise LookupError
    return [(*_symbol(factor[1]), int(factor[2] or 1))]


def _take(tokens: list[str], token: str) -> bool:
    """True where a token comes next, which then is taken."""
    return tokens[-1:] == [token] and bool(tokens.pop())


def _symbol(name: str) -> tuple[str, str]:
    """The prefix of a symbol, and what it stands before."""
    if name in _SYMBOLS:
        return "", name
    for prefix in _PREFIXES:
        rest = name[len(prefix) :]
        if name.startswith(prefix) and rest in _SYMBOLS and rest not in ("1", "%"):
            return prefix, rest
    raise LookupError


def multiply(a: Dimension, b: Dimension) -> Dimension:
    return tuple(map(add, a, b))


def divide(a: Dimension, b: Dimension) -> Dimension:
    return tuple(map(sub, a, b))


def power(a: Dimension, exponent: int | Fraction) -> Dimension:
    return tuple(x * exponent for x in a)


def unit_text(dimension: Dimension) -> str:
    """A dimension as engineers write it: `N/m`, `kg.m2`, `1/s`, `1`; a torque and an energy are
    `N.m`."""
    for name in ("F", "S"):
        if dimension == _SYMBOLS[name]:
            return name
    base = _powers(dimension)
    mass, time = dimension[_BASE.index("kg")], dimension[_BASE.index("s")]
    if abs(mass) != 1 or mass * time > -2 or not all(map(_is_whole, dimension)):
        return _quotient_text(base)  # kinematics, masses and momenta
    names = _ELECTRIC if dimension[_BASE.index("A")] else _MECHANIC
    named = ([(n, mass), *_powers(divide(dimension, power(_SYMBOLS[n], int(mass))))] for n in names)
    return _quotient_text(min((*named, base), key=_length))


_MECHANIC = ("N", "Pa", "W")
_ELECTRIC = ("V", "Ohm", "N", "Wb", "T", "H", "W")
#: Names and exponents, in the order in which they are written.
_Powers: TypeAlias = "list[tuple[str, int | float | Fraction]]"


def _powers(dimension: Dimension) -> _Powers:
    """Mass first, as units are usually written."""
    order = ("kg", "m", "s", "A", "K", "mol", "cd")
    exponents = dict(zip(_BASE, dimension, strict=True))
    return [(name, exponents[name]) for name in order if exponents[name]]


def _is_whole(exponent: float | Fraction) -> bool:
    return int(exponent) == float(exponent)


def _length(powers: _Powers) -> float:
    return sum(abs(float(e)) for _, e in powers)


def _quotient_text(powers: _Powers) -> str:
    above = [_with_exponent(n, e) for n, e in powers if e > 0]
    below = [_with_exponent(n, -e) for n, e in powers if e < 0]
    text = ".".join(above) or "1"
    if not below:
        return text
    return f"{text}/{below[0]}" if len(below) == 1 else f"{text}/({'.'.join(below)})"


def _with_exponent(name: str, exponent: float | Fraction) -> str:
    return name if exponent == 1 else f"{name}{exponent}"


def of_per_cent(number: float, limit: float | None, unit: str) -> float | None:
    """The share that was meant, where a number without unit lies above its limit only in per
    cent."""
    share = number / 100
    return share if unit == "1" and limit is not None and share <= limit < number else None


def looks_like_degrees(angle: float) -> bool:
    """Whether a number that is given in radian was meant in degrees: a round one of several turns.

    `45` and `22.5` are; `6`, `4*pi` and angles that a run came to are not, nor `-800` of a shaft
    before a gear.
    """
    size = abs(angle)
    round_one = (size > 4 * pi and size % 0.5 == 0) or (size > 2 * pi and size % 5 == 0)
    return round_one and size <= 2 * 360


#: The units of forces and torques.
LOADS = ("N", "N.m")

#: One turn a minute, in rad/s.
RPM = pi / 30


def looks_like_rpm(speed: float) -> bool:
    """Whether a number that is given in rad/s was meant in rpm: a round one of a fast machine, as
    `1500` and `3000`."""
    return 500 <= abs(speed) <= 50000 and speed % 50 == 0


def turns(angle: float) -> str:
    """The turns of an angle: `7.2 turns`."""
    return f"{angle / (2 * pi):.3g} turns"


_QUOTIENT = r"(?P<above>[^/]+)/(?:\((?P<several>[^()]+)\)|(?P<one>[^/()]+))"


def rate_text(unit: str) -> str:
    """The unit of a time derivative, as a person writes it: `m/s` as `m/s2`, `N/m` as `N/(m.s)`.

    Empty of an unknown unit.
    """
    if parse(unit) is None:
        return ""
    if "/" not in unit:
        return f"{unit}/s"
    quotient = re.fullmatch(_QUOTIENT, unit)
    if quotient is None:
        return ""
    below = (quotient["several"] or quotient["one"]).split(".")
    for i, factor in enumerate(below):
        if seconds := re.fullmatch(r"s(\d*)", factor):
            below[i] = f"s{int(seconds[1] or 1) + 1}"
            break
    else:
        below.append("s")
    text = ".".join(below)
    return f"{quotient['above']}/{f'({text})' if len(below) > 1 else text}"
