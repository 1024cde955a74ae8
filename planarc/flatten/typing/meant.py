"""What a user may have meant whose units do not agree: another coordinate of a joint, or a square.

In:   the units of a model's variables; two units that do not agree, and the expressions of which
      they are
Out:  a hint, or None
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import TypeAlias

from planarc.core import unit
from planarc.core.unit import NUMBER, Dimension
from planarc.ir import flat

#: A measure, see `quantity.measure`. None: not known, fits everything
Known: TypeAlias = "Dimension | None"

#: The two expressions whose units are compared, if each is one; or its unit as it was declared.
Sides: TypeAlias = "tuple[flat.Expression | str | None, flat.Expression | str | None]"

#: Difference of the logarithms of two scales that are one.
SAME_SCALE = 1e-9

#: How torques are called.
_TORQUE = r"(^|[._])(tau|torque|t)(\[\d+\])?$"
#: A unit of several, as those of coefficients.
_COMPOUND = "[./]"
#: How a joint's coordinate and its derivatives are called: those of a hinge, and of a slide.
_MOTIONS = ("phi", "w", "a", "s", "v")


def what_is_meant(
    units: Mapping[str, Known], differ: tuple[Dimension, Dimension], sides: Sides
) -> str | None:
    """The hint about one of two sides whose units differ by more than a scale."""
    both = [(differ, sides[0]), (differ[::-1], sides[1])]
    lacking = [(a, b, e) for (a, b), e in both if e is not None and not isinstance(e, str)]
    named = (e.name for e in sides if isinstance(e, flat.Reference))
    short = any(unit.divide(b, a)[:-1] == unit.parse("m") for a, b, _ in lacking)
    if short and any(re.search(_TORQUE, name) for name in named):
        return "a lever arm may be missing: a torque is a force times a length"
    for find in (_sibling, _square):
        for own, other, e in lacking:
            if hint := find(units, e, unit.divide(other, own)):
                return hint
    return None


def _sibling(units: Mapping[str, Known], e: flat.Expression, ratio: Dimension) -> str | None:
    """The hint at `hinge.w` where a product has `hinge.phi` as its factor, and the speed would give
    it the unit that it lacks."""
    for factor in factors(e):
        name = factor.name if isinstance(factor, flat.Reference) else ""
        owner, _, last = name.rpartition(".")
        own = units.get(name)
        if last not in _MOTIONS or not owner or own is None:
            continue
        for meant in _MOTIONS:
            known = units.get(f"{owner}.{meant}")
            if known is not None and agree(known, unit.multiply(own, ratio)):
                return f"perhaps `{owner}.{meant}` is meant, and not `{name}`"
    return None


def _square(units: Mapping[str, Known], e: flat.Expression, ratio: Dimension) -> str | None:
    """The hint at the one factor of a product whose square would give it the unit that it lacks, as
    in an energy."""
    every = [*factors(e)]
    named = [f for f in every if isinstance(f, flat.Reference) and len(every) > 1]
    fitting = [f for f in named if (k := units.get(f.name)) and agree(k, ratio)]
    if len(fitting) != 1 or ratio[:-1] == NUMBER:
        return None
    name = " ".join(fitting[0].span.text.split())
    return f"a square may be missing: `{name}^2` would make them agree"


def wrongly_declared(
    units: Mapping[str, Known],
    declared: Mapping[str, str],
    differ: tuple[Dimension, Dimension],
    sides: Sides,
) -> str | None:
    """The hint at the model's own coefficient in a product, as a stiffness in `N/m` for one in
    `N.m`, if there is one only."""
    found = []
    for side, ratio in ((sides[0], unit.divide(*differ[::-1])), (sides[1], unit.divide(*differ))):
        every = [] if side is None or isinstance(side, str) else [*factors(side)]
        for e in every if len(every) > 1 else ():
            name = e.name if isinstance(e, flat.Reference) and "." not in e.name else ""
            text, own = declared.get(name, ""), units.get(name)
            if own is not None and re.search(_COMPOUND, text):
                fitting = unit.unit_text(unit.multiply(own, ratio)[:-1])
                found.append(f"`{name}` is declared in `{text}`: `{fitting}` would make them agree")
    return found[0] if len(found) == 1 else None


def terms(e: flat.Expression) -> Iterator[flat.Expression]:
    """What a sum adds up, and takes away."""
    if isinstance(e, flat.Binary) and e.op in ("+", "-", ".+", ".-"):
        yield from terms(e.left)
        yield from terms(e.right)
    elif isinstance(e, flat.Unary):
        yield from terms(e.operand)
    else:
        yield e


def factors(e: flat.Expression) -> Iterator[flat.Expression]:
    """What a product multiplies, and not what it divides by."""
    if isinstance(e, flat.Binary) and e.op in ("*", ".*", "/", "./"):
        yield from factors(e.left)
        if e.op in ("*", ".*"):
            yield from factors(e.right)
    elif isinstance(e, flat.Unary):
        yield from factors(e.operand)
    else:
        yield e


def agree(a: Dimension, b: Dimension) -> bool:
    """Whether two measures are the same one, scales included."""
    return a[:-1] == b[:-1] and abs(scale(a) - scale(b)) < SAME_SCALE


def scale(known: Dimension) -> float:
    """The power of ten by which a measure differs from its unit of the SI."""
    return float(known[-1])
