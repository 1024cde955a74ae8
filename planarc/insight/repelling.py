"""Control laws that drive away from where they are to go: the force on a shaft or slide grows with
its own coordinate.

In:   Dae
Out:  warnings S325, at the user's equation

A law is an equation of the user's for what a force or torque takes. It may go by way of further
variables of his own, but it asks for nothing that moves beside the shaft: a pole on a cart is held
by a force that does grow with the cart's position. It is linear, so that its slope is a number, and
it has a difference in it: a spring that pushes, and a magnet, have none.

Example: `motor.f = k*(rail.s - s_ref) - d*rail.v;`, where `s_ref - rail.s` was meant.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

from planarc.core.data import Data
from planarc.core.diagnostic import Repelling, Severity
from planarc.evaluate.declared import DeclaredValues
from planarc.evaluate.value import evaluate
from planarc.insight.connectors import owner
from planarc.ir.dae import Dae, Equation
from planarc.ir.expr import Expr, Op, postorder, symbols
from planarc.ir.places import is_own

#: What acts by the signal that it takes, and how this is called.
_ACTING = {".Sources.Torque": "tau", ".Sources.Force": "f"}
_SOURCES = ".Sources."
#: The coordinates of a shaft and of a slide, with how their speeds are called.
_SPEEDS = {"phi": "w", "s": "v"}
#: Variables between the law and the coordinate, at most.
_DEEPEST = 6
#: Coordinates at which a law is tried; others than those that are natural for some.
_TRIED = (-1.3, 0.4, 1.9)
_SAME = 1e-9


class _Shaft(Data):
    """All names of the coordinate of what a drive acts on, and of its speed."""

    coordinates: frozenset[str]
    speeds: frozenset[str]


def repelling_laws(dae: Dae) -> Iterator[Repelling]:
    classes = {p.name: p.class_name for p in dae.parts}
    acting = {
        f"{part}.{i}" for part, of in classes.items() for c, i in _ACTING.items() if of.endswith(c)
    }
    laws = [(e, n) for e in dae.equations if acting and (n := _acting(dae, e, acting))]
    if not laws:
        return
    given = {e.left.name: e for e in dae.equations if _is_given(dae, e)}
    values = DeclaredValues(dae)
    fixed = {p.name for p in dae.parameters}
    for law, name in laws:
        shaft = _shaft(dae, owner(name))
        value = law.right if law.left.is_symbol and law.left.name == name else law.left
        inside = _inside(value, given, shaft)
        read = {s.name for e in inside for s in symbols(e)}
        moving = read - fixed - given.keys() - shaft.coordinates - shaft.speeds
        if any(_SOURCES not in classes.get(owner(n), "") for n in moving):
            continue
        here = sorted(read & shaft.coordinates)
        if here and any(_is_difference(e, shaft) for e in inside):
            slope = _slope(value, given, shaft, values)
            if slope is not None and slope > 0:
                yield Repelling(
                    "S325",
                    f"`{name}` drives `{here[0]}` away from where it is to go: it grows with "
                    f"`{here[0]}`",
                    law.span,
                    Severity.WARNING,
                    hint=f"turn the difference round, so that `{here[0]}` is subtracted from what "
                    "it is to be",
                )


def _acting(dae: Dae, e: Equation, inputs: Collection[str]) -> str:
    """The input of a force or torque to which an equation of the user's gives a value, or ""."""
    for side in () if e.generated else (e.left, e.right):
        if side.is_symbol and side.name in inputs and is_own(dae, e.span):
            return side.name
    return ""


def _is_given(dae: Dae, e: Equation) -> bool:
    """Whether an equation gives a variable of the user's own its value."""
    return not e.generated and e.left.is_symbol and not e.left.order and is_own(dae, e.span)


def _shaft(dae: Dae, drive: str) -> _Shaft:
    flange = f"{drive}.flange"
    joined = next((names for names in dae.connections if flange in names), (flange,))
    parts = [*joined, *(owner(n) for n in joined if owner(n) != drive)]
    return _Shaft(
        frozenset(f"{part}.{c}" for part in parts for c in _SPEEDS),
        frozenset(f"{part}.{c}" for part in parts for c in _SPEEDS.values()),
    )


def _inside(value: Expr, given: Mapping[str, Equation], shaft: _Shaft) -> list[Expr]:
    """A value, and those of the variables that it goes by."""
    found, read = [value], {value}
    for _ in range(_DEEPEST):
        names = {s.name for e in found for s in symbols(e)} - shaft.coordinates
        new = [given[n].right for n in sorted(names & given.keys()) if given[n].right not in read]
        if not new:
            break
        found += new
        read |= {*new}
    return found


def _is_difference(e: Expr, shaft: _Shaft) -> bool:
    """Whether it has a sum of the coordinate and of what is not its speed."""
    for node in postorder((e,)):
        if node.op is Op.ADD:
            read = [{s.name for s in symbols(a)} for a in node.args]
            own = [names & shaft.coordinates for names in read]
            others = [names for names in read if not names & (shaft.coordinates | shaft.speeds)]
            if any(own) and others:
                return True
    return False


def _slope(
    value: Expr, given: Mapping[str, Equation], shaft: _Shaft, parameters: DeclaredValues
) -> float | None:
    """How a law grows with the coordinate; None where this is no number."""

    def at(coordinate: float) -> float:
        def leaf(e: Expr, depth: int = 0) -> float:
            if not e.is_symbol or depth > _DEEPEST:
                return parameters(e)  # KeyError: a truth, or a value at the last event
            if e.name in shaft.coordinates:
                return coordinate
            if e.name in given:
                return float(evaluate(given[e.name].right, lambda s: leaf(s, depth + 1)))
            try:
                return parameters(e)
            except KeyError:
                return 0.0  # a speed, or what a source gives

        return float(evaluate(value, lambda e: 0.0 if e.op is Op.TIME else leaf(e)))

    try:
        first, second, third = (at(x) for x in _TRIED)
    except (KeyError, ArithmeticError, ValueError):
        return None
    a, b, c = _TRIED
    one, two = (second - first) / (b - a), (third - second) / (c - b)
    return one if abs(one - two) <= _SAME * max(abs(one), abs(two)) else None
