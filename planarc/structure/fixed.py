"""Ends that are both fixed in space, though they are connected: the world and a post elsewhere.

In:   Dae, a part of the user's of which an equation determines nothing
Out:  the message that names both ends, where they are, and what brings them together

Example: `connect(world.frame_b, post.frame_b)`, where `post` stands at {1, 0}. Each of the two says
by itself where its frame is. In place of the post there may be a wheel that rolls on the ground: it
says how its frame moves.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Related
from planarc.core.disjoint import DisjointSets
from planarc.evaluate.value import evaluate
from planarc.ir.dae import Dae
from planarc.ir.expr import Expr, Op, symbols
from planarc.ir.flat import Connect, Part
from planarc.ir.places import is_own, own_part, owner

#: Where the ends of connectors are, by what they are of: frames, shafts, rods.
_PLACES = (("r[1]", "r[2]", "phi"), ("phi",), ("s",))


class _End(Data):
    name: str
    place: str


def fixed_together(dae: Dae, part: Part, held: Sequence[Part]) -> Diagnostic | None:
    """The message where an end of a part is connected to another one, and both are fixed; that one
    is of none of the parts that are held too much, where there is such a one."""
    for names in dae.connections:
        if all(own_part(dae, owner(name)) != part for name in names):
            continue
        ends = [end for name in names if (end := _fixed(dae, name)) is not None]
        if len(ends) > 1 and any(own_part(dae, owner(end.name)) == part for end in ends):
            spare = {p.name for p in held}
            return _message(dae, part, sorted(ends, key=lambda e: _own(dae, e) in spare))
    return None


def fixed_by_its_end(dae: Dae, part: Part) -> Diagnostic | None:
    """The message where the only end of a part that is connected stands still by that, though
    the part itself says how it may move, as a wheel that rolls."""
    connects = [c for c in dae.connects if part.name in (owner(c.left), owner(c.right))]
    ends = {end for c in connects for end in (c.left, c.right) if owner(end) == part.name}
    for connect in connects if len(ends) == 1 else ():
        (other,) = {connect.left, connect.right} - ends or ends
        place = _fixed(dae, other) if is_own(dae, connect.span) else None
        if place is not None and place.place.startswith("{"):  # a frame
            return Diagnostic(
                "S301",
                f"`{other}` stands still, but `{part.name}` says by itself how `{min(ends)}` moves",
                connect.span,
                hint=f"remove this connection: `{part.name}` needs none to what stands still",
                related=(Related(f"`{part.name}` is declared here", part.span),),
            )
    return None


def _own(dae: Dae, end: _End) -> str:
    part = own_part(dae, owner(end.name))
    return part.name if part else ""


def _message(dae: Dae, part: Part, ends: Sequence[_End]) -> Diagnostic:
    own = next(end for end in ends if own_part(dae, owner(end.name)) == part)
    other = next(end for end in ends if end is not own)
    where = f"`{other.name}` at {other.place} and `{own.name}` at {own.place} are both fixed"
    if own.place.startswith("{"):
        where += " to the ground"
    connect = _joining(dae, own.name, other.name)
    if connect is None or not is_own(dae, connect.span):
        return Diagnostic("S301", where, part.span, hint=_otherwise(part))
    if {connect.left, connect.right} == {own.name, other.name}:
        return Diagnostic(
            "S301",
            where,
            connect.span,
            hint=f"remove this connection: `{part.name}` is fixed by itself",
            related=(Related(f"`{part.name}` is declared here", part.span),),
        )
    return Diagnostic(
        "S301",
        f"{where}, and connected to each other",
        part.span,
        hint=_otherwise(part),
        related=(Related("they are brought together here", connect.span),),
    )


def _otherwise(part: Part) -> str:
    return f"remove `{part.name}`, or put a joint between it and what it is connected to"


def _joining(dae: Dae, one: str, other: str) -> Connect | None:
    """The connection that brings two ends together: those inside of parts come first, then the
    order of the text counts."""
    joined = DisjointSets((one, other))
    for connect in sorted(dae.connects, key=_depth, reverse=True):
        joined.join(connect.left, connect.right)
        if joined.find(one) == joined.find(other):
            return connect
    return None


def _depth(connect: Connect) -> int:
    return max(connect.left.count("."), connect.right.count("."))


def _fixed(dae: Dae, end: str) -> _End | None:
    """An end that its own component puts to a place by parameters alone."""
    known = {v.name for v in dae.variables if v.name.startswith(f"{end}.")}
    names = next((p for p in _PLACES if known.issuperset(f"{end}.{n}" for n in p)), None)
    if names is None:
        return None
    values = [_given(dae, owner(end), f"{end}.{name}") for name in names]
    numbers = [f"{value:.4g}" for value in values if value is not None]
    if len(numbers) < len(names):
        return None
    return _End(end, f"{{{numbers[0]}, {numbers[1]}}}" if len(numbers) > 1 else numbers[0])


def _given(dae: Dae, component: str, name: str) -> float | None:
    """The value that a component gives a variable, where it takes parameters only."""
    parameters = {p.name: p.value for p in dae.parameters}

    def value(e: Expr) -> Any:
        if e.op is not Op.SYMBOL:
            raise LookupError
        return evaluate(parameters[e.name], value)

    own = [e for e in dae.equations if e.component == component and not e.generated]
    for side, other in [p for e in own for p in ((e.left, e.right), (e.right, e.left))]:
        if (
            side.is_symbol
            and side.name == name
            and all(s.name in parameters for s in symbols(other))
        ):
            try:
                return float(evaluate(other, value))
            except (ArithmeticError, ValueError, LookupError, TypeError):
                return None
    return None
