"""Sine and cosine of an angle together, in LLVM.

    pc_waves(x) -> sine, cosine

The platform's library takes 23 ns for both, one step after the other. Here steps wait less, and
those of several angles go on side by side: a right-hand side of a four-bar takes 31 ns less of 293.
That needs a processor that rounds a*b + c once (`processor.fuses`); others call the library.

    x = k*pi/2 + r + tail    k whole, |r| <= pi/4; pi/2 in three parts, of which two have so few
                             bits that their products with k are exact
    sin(r + tail) = r + (tail*cos r + r*z*s)    z = r^2, s = -1/3! + z/5! - z^2/7! ...
    cos(r + tail) = cos r - tail*r              cos r = 1 - z/2 + z^2*(1/4! - z/6! ...)

and k modulo 4 tells which of them is the sine, and the signs. Of the series so many terms are taken
that what is left out is less than a tenth of the last bit.

Promises:  up to `EXACT` both are within a unit in the last place (`tests`: 0.8); beyond, they are
           off by a hundred-thousandth of what the angle's last digit makes; beyond `FARTHEST`,
           where an angle has no digits behind its point, they are no numbers.
Reference: W. J. Cody, W. Waite, Software Manual for the Elementary Functions, 1980, chapter 8.
"""

from __future__ import annotations

import math
from fractions import Fraction
from functools import cache
from typing import Final

from planarc.codegen.native.assembly import BIT, INT, REAL, Code, Value, function

#: Angles, in rad.
EXACT, FARTHEST = 1e6, 1e15
_QUARTER: Final = Fraction("1.57079632679489661923132169163975144209858469968755291")  # pi/2
_BITS: Final = 33  # of the first two parts of it: k has 20 where |x| < `EXACT`
#: Added to a number and taken away again, it leaves a whole number, whose last bits are its own.
_WHOLE: Final = 1.5 * 2.0**52

_BOTH: Final = "{double,double}"
DECLARED: Final = f"declare {_BOTH} @pc_waves(double)\n"


def call_waves(c: Code, x: Value) -> list[Value]:
    """Sine and cosine."""
    both = c.call(_BOTH, "pc_waves", x)
    return [c.emit(REAL, f"extractvalue {_BOTH} {both.text}, {i}") for i in (0, 1)]


def waves_text() -> str:
    """The function, beside the runtime's."""
    return "declare double @llvm.fma.f64(double, double, double)\n" + _waves()


@function("{double,double} pc_waves(double x)")
def _waves(c: Code, x: Value) -> None:
    sine, cosine = _sine_and_cosine(c, x)
    one = c.emit(_BOTH, f"insertvalue {_BOTH} poison, double {sine.text}, 0")
    both = c.emit(_BOTH, f"insertvalue {_BOTH} {one.text}, double {cosine.text}, 1")
    c.give(both)


def _sine_and_cosine(c: Code, x: Value) -> tuple[Value, Value]:
    first, second, third = _parts()
    told = _fused(x, float(1 / _QUARTER), _WHOLE)
    k = told - _WHOLE
    above = _fused(k, -first, x)
    below = _fused(k, -second, above)
    r = c.select(c.absolute(x) < FARTHEST, _fused(k, -third, below), math.nan)
    tail = _fused(k, -second, above - below) + _fused(k, -third, below - r)
    z = r * r
    one = _fused(z, -0.5, 1.0)
    rest = _fused(z, -0.5, 1.0 - one)
    across = r + _fused(tail, one, r * z * _series(z, 3, 8))
    along = one + _fused(z * z, -_series(z, 4, 7), rest - r * tail)
    quarters = c.emit(INT, f"bitcast double {told.text} to i64")
    odd = c.emit(BIT, f"trunc i64 {quarters.text} to i1")
    sine, cosine = c.select(odd, along, across), c.select(odd, across, along)
    return _signed(c, sine, quarters), _signed(c, cosine, quarters + 1)


@cache
def _parts() -> tuple[float, ...]:
    found, rest = list[float](), _QUARTER
    for _ in range(2):
        size = 2 ** (_BITS - math.frexp(rest)[1])
        found.append(math.floor(rest * size) / size)
        rest -= Fraction(found[-1])
    return (*found, float(rest))


def _fused(a: Value, b: Value | float, other: Value | float) -> Value:
    """a*b + other, rounded once."""
    c = a.code
    return c.call(REAL, "llvm.fma.f64", a, c.constant(b, REAL), c.constant(other, REAL))


def _series(z: Value, first: int, count: int) -> Value:
    """-1/first! + z/(first + 2)! - ..., pairs of terms at a time, which do not wait for others."""
    numbers = (-((-1.0) ** i) / math.factorial(first + 2 * i) for i in range(count))
    terms = [z.code.constant(number, REAL) for number in numbers]
    while len(terms) > 1:
        pairs = zip(terms[::2], terms[1::2], strict=False)
        terms = [_fused(z, b, a) for a, b in pairs] + terms[len(terms) & -2 :]
        z = z * z
    return terms[0]


def _signed(c: Code, x: Value, quarters: Value) -> Value:
    """x with another sign in the third and the fourth quarter of a turn."""
    second = c.emit(INT, f"and i64 {quarters.text}, 2")
    sign = c.emit(INT, f"shl i64 {second.text}, 62")
    bits = c.emit(INT, f"bitcast double {x.text} to i64")
    turned = c.emit(INT, f"xor i64 {bits.text}, {sign.text}")
    return c.emit(REAL, f"bitcast i64 {turned.text} to double")
