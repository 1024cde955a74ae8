"""Components that carry nothing: by their own equations no force passes any of their frames.

In:   Dae, frames
Out:  the names of the components, each with the frames that a user connects

A part that gives coordinates, as `FreeMotion`, carries nothing either, but it says how its ends may
move: it is no sensor. It is known by variables that are to be states, or begin where the user says.

Example: `frame_a.f = {0, 0}`, `frame_a.t = 0`, and so for `frame_b`, of a sensor of positions. A
body that hangs on such a sensor only is joined to nothing. Its hidden frame, which gives the axes,
is that to which its `frame_resolve` is connected.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from planarc.insight.connectors import FRAME, grouped, owner
from planarc.ir.dae import Dae
from planarc.ir.expr import Expr
from planarc.ir.flat import StateSelect


def find_sensors(dae: Dae, frames: Sequence[str]) -> dict[str, list[str]]:
    """The components that carry nothing, and do not say how their frames may move; those of the
    given frames that are theirs, but for those that only give axes."""
    zero = zeros(dae)
    bare = {f for f in frames if all(f"{f}.{flow}" in zero for flow, _ in FRAME)}
    if not bare:
        return {}
    moved = {
        v.component
        for v in dae.variables
        if v.start_written or v.state_select >= StateSelect.PREFER
    }
    ends = find_ends(dae, frames)
    return {c: e for c, e in ends.items() if c not in moved and bare.issuperset(e)}


def find_ends(dae: Dae, frames: Iterable[str]) -> dict[str, list[str]]:
    """Those of the given frames that a user connects, of each component, but for those that only
    give axes."""
    hidden = hidden_connectors(dae)
    axes = {
        name
        for names in dae.connections
        for inner in hidden.intersection(names)
        for name in names
        if owner(name) == owner(inner)
    }
    return grouped((f for f in frames if f not in hidden and f not in axes), owner)


def hidden_connectors(dae: Dae) -> set[str]:
    """The connectors that are protected, so that their components themselves connect them."""
    return {owner(v.name) for v in dae.variables if v.protected}


def zeros(dae: Dae) -> set[str]:
    """The unknowns that a component's own equation says to be 0."""
    return {
        e.left.name
        for e in dae.equations
        if e.right is dae.table.zero and e.left.is_symbol and not e.generated
    }


def are_passed(dae: Dae, component: str, frames: Sequence[str]) -> bool:
    """Whether a component's own equations make two frames one, in place and angle: it is put into
    a connection, to measure what passes."""
    own = [e for e in dae.equations if e.component == component and not e.generated]
    equal = {frozenset((e.left.name, e.right.name)) for e in own if _are_symbols(e.left, e.right)}
    return len(frames) == 2 and all(
        frozenset(f"{frame}.{place}" for frame in frames) in equal for _, place in FRAME
    )


def _are_symbols(*sides: Expr) -> bool:
    return all(side.is_symbol for side in sides)
