"""Connection sets: connections joined over the whole hierarchy, as equations.

In:   Connection of all instances, all flow variables of connectors
Out:  generated flat.Equality, sets of physical connectors

Example: `connect(a.frame_b, b.frame_a); connect(b.frame_a, c.frame_a);` gives

    a.frame_b.r = b.frame_a.r;  a.frame_b.r = c.frame_a.r;      and
    a.frame_b.f + b.frame_a.f + c.frame_a.f = {0, 0};

Inside connectors count positive, outside ones negative. A flow variable that no
connection joins from its outside is zero, without a message.

Reference: Modelica Language Specification 3.6, sections 9.1 to 9.3.
"""

from __future__ import annotations

from collections.abc import Sequence

from msgspec import Struct, field

from planarc.core.diagnostic import PlanarcError, Related, error
from planarc.core.disjoint import DisjointSets
from planarc.core.prose import both
from planarc.core.source import NOWHERE, Span
from planarc.flatten.connect.connect import Connection, Member, match_leaves
from planarc.flatten.connect.expand import (
    in_expandable,
    is_added,
    outside_signals,
    unused_members,
)
from planarc.flatten.connect.inputs import is_public_input
from planarc.flatten.connect.rooting import Pair, Rooting, equality_of
from planarc.flatten.connect.sides import Side
from planarc.flatten.functions.variables import result_type
from planarc.flatten.terms.conform import expect
from planarc.flatten.terms.select import all_indices, array, integer, pick, string
from planarc.flatten.tree.nodes import Env, Instance, Leaf, Session
from planarc.flatten.typing.references import node_value
from planarc.ir import flat, syntax


class Connected(Struct):
    """The equations and sets that all connections of a model give."""

    equations: list[flat.Equality | flat.Assert] = field(default_factory=list)
    physical: list[tuple[str, ...]] = field(default_factory=list)
    #: variables of expandable connectors that nothing uses, which are therefore not there
    unused: set[str] = field(default_factory=set)


def connect_all(
    connections: list[Connection],
    leaves: Sequence[Leaf],
    rooting: Rooting,
    used: set[str],
    session: Session,
) -> Connected:
    """The equations of all connection sets; `used` are names in other equations."""
    sets: DisjointSets[tuple[str, bool]] = DisjointSets()
    members: dict[tuple[str, bool], Member] = {}
    spans: dict[tuple[str, bool], Span] = {}
    physical: DisjointSets[str] = DisjointSets()
    result = Connected()
    for connection in connections:
        for a, b in match_leaves(connection.left, connection.right, connection.span):
            if rooting.broken and rooting.is_broken(connection, a.leaf):
                continue
            for side in (a, b):
                members.setdefault(side.key, side)
                spans.setdefault(side.key, connection.span)
            sets.join(a.key, b.key)
        if _is_physical(connection.left):
            physical.join(connection.left.name, connection.right.name)
    for leaf in leaves:
        if leaf.flow is not syntax.Flow.FLOW or not (leaf.is_connector or _in_connector(leaf)):
            continue
        for lone in _lone_members(leaf, used):
            sets.add(lone.key)
            members[lone.key] = lone
    grouped = [[members[key] for key in keys] for keys in sets.sets()]
    result.unused = unused_members(leaves, used, [[m.leaf for m in g] for g in grouped])
    for leaf in outside_signals(grouped, used):
        leaf.causality = syntax.Causality.INPUT
        session.warn("F316", f"no component gives `{leaf.name}`: it is an input", leaf.span)
    for joined in grouped:
        if joined[0].leaf.name in result.unused:
            continue
        places = (spans[m.key] for m in joined if m.key in spans)
        span = min(places, key=lambda s: (s.source.name, s.start), default=NOWHERE)
        try:
            _check_sources(joined, connections)
            result.equations += set_equations(joined, span)
        except PlanarcError as problem:
            session.keep(problem)
    for pair in rooting.broken:
        result.equations.append(broken_equation(pair, session))
    result.physical = [tuple(names) for names in physical.sets()]
    return result


def _in_connector(leaf: Leaf) -> bool:
    """A variable of a connector, or of a record in one."""
    owner = next((i for i in leaf.parent.outwards() if not i.is_record), leaf.parent)
    return owner.is_connector


def broken_equation(pair: Pair, session: Session) -> flat.Equality:
    """`zeros(n) = equalityConstraint(a, b)`, in place of a connection's equality."""
    span = pair.connection.span
    info = equality_of(pair.left)
    env = Env(session.root_scope)
    arguments = [node_value(node, span, env) for node in (pair.left, pair.right)]
    for variable, argument in zip(info.signature.inputs, arguments, strict=True):
        expect(variable.type, argument, f"the input `{variable.name}` of `{info.name}`")
    type_ = result_type(info.signature, 0, arguments, span, session)
    residual = flat.Call(type_, span, info.signature.name, tuple(arguments))
    return flat.Equality(span, "", _zero(type_, span), residual, generated=True)


def _lone_members(leaf: Leaf, used: set[str]) -> list[Member]:
    """A flow variable seen from its outside, whole, or the entries not connected; that of a bus
    from its inside, too, unless equations there may give it."""
    if not leaf.is_connector or not leaf.type.dims:
        in_bus = is_added(leaf) or (in_expandable(leaf) and leaf.name not in used)
        return [Member(leaf, outside) for outside in ((False, True) if in_bus else (False,))]
    whole = flat.Reference(leaf.type, leaf.span, leaf.name)
    indices = all_indices(tuple(d or 0 for d in leaf.type.dims))
    return [Member(leaf, False, pick(whole, i)) for i in indices]


def _is_physical(side: Side) -> bool:
    """The connector has a flow variable."""
    stack: list[object] = [side.node]
    while stack:
        node = stack.pop()
        if isinstance(node, Leaf) and node.flow is syntax.Flow.FLOW:
            return True
        if isinstance(node, Instance):
            stack += [e.node for e in node.elements.values() if e.node is not None]
    return False


def set_equations(joined: list[Member], span: Span) -> Sequence[flat.Equality | flat.Assert]:
    """The equations of one set."""
    if joined[0].leaf.variability <= flat.Variability.PARAMETER:
        return _same_values(joined, span)
    if joined[0].is_flow:
        return [_flow_equation(joined, span if span is not NOWHERE else joined[0].leaf.span)]
    first = joined[0].reference(span)
    names = {joined[0].key[0]}
    equations = []
    for other in joined[1:]:
        if other.key[0] in names:
            continue  # one connector seen from inside and from outside
        names.add(other.key[0])
        equations.append(flat.Equality(span, "", first, other.reference(span), generated=True))
    return equations


def _same_values(joined: list[Member], span: Span) -> list[flat.Assert]:
    """Parameters and constants of connectors that are connected must agree (9.2)."""
    first, *others = ((m.leaf.name, m.reference(span)) for m in joined)
    asserts = []
    for name, value in others:
        message = string(
            f"`{first[0]}` and `{name}` are connected, but have different values", span
        )
        for index in all_indices(tuple(d or 0 for d in value.type.dims)):
            pair = (pick(v, index) for v in (first[1], value))
            condition = flat.Binary(flat.BOOLEAN, span, "==", *pair)
            asserts.append(flat.Assert(span, "", condition, message))
    return asserts


def _flow_equation(joined: list[Member], span: Span) -> flat.Equality:
    total: flat.Expression | None = None
    for each in sorted(joined, key=lambda m: m.outside):
        term = each.reference(span)
        if total is None:
            total = flat.Unary(term.type, span, "-", term) if each.outside else term
        else:
            total = flat.Binary(total.type, span, "-" if each.outside else "+", total, term)
    assert total is not None
    return flat.Equality(span, "", total, _zero(total.type, span), generated=True)


def _zero(type_: flat.Type, span: Span) -> flat.Expression:
    value: flat.Expression = integer(0, span)
    for size in reversed(type_.dims):
        value = array([value] * (size or 0), value.type, span)
    return value


def _check_sources(joined: list[Member], connections: Sequence[Connection]) -> None:
    """Refuse two members that give the value: each an output of a component inside, or
    an input of the class itself."""
    sources = [m for m in joined if _is_source(m)]
    if len(sources) > 1:
        names = both(m.key[0] for m in sources[:2])
        span = _where_joined(sources[0].key, sources[1].key, connections)
        message = f"{names} are connected, but both give the value"
        related = [Related(f"`{m.key[0]}` is declared here", m.leaf.span) for m in sources[:2]]
        hint = _open_input(sources, joined, connections)
        raise error("F313", message, span, hint=hint, related=related)


def _open_input(
    sources: Sequence[Member], joined: Sequence[Member], connections: Sequence[Connection]
) -> str:
    """What to connect instead: the input of a component whose outputs are joined to others."""
    connected = {side.name for c in connections for side in (c.left, c.right)}
    taken = (m for m in joined if m.leaf.causality is syntax.Causality.INPUT and not m.outside)
    for source in (*reversed(sources), *taken):
        part = source.leaf.parent
        nodes = (e.node for e in part.elements.values())
        inputs = [
            n.name
            for n in nodes
            if isinstance(n, Leaf) and n.causality is syntax.Causality.INPUT and n.is_connector
        ]
        free = [name for name in inputs if name not in connected]
        if free and source not in sources:
            return f"connect one of them to `{free[0]}`, which is open"
        if free and not source.outside:
            return f"connect to `{free[0]}` instead of `{source.key[0]}`: it is an input, and open"
        for connection in connections if source in sources and not source.outside else ():
            sides = (connection.left, connection.right)
            exchanged = [side.name for side in sides if side.name in inputs]
            if exchanged and all(_takes(side) for side in sides):
                wrong, right = source.key[0], exchanged[0]
                return f"exchange `{wrong}` and `{right}`: `{right}` is the input"
    return "connect each to inputs only, or put a block between them, such as a sum or a switch"


def _takes(side: Side) -> bool:
    """Whether it is an input of a component, to which others give the value."""
    node = side.node
    return isinstance(node, Leaf) and node.causality is syntax.Causality.INPUT and not side.outside


def _where_joined(
    one: tuple[str, bool], other: tuple[str, bool], connections: Sequence[Connection]
) -> Span:
    """The connection that brings two members of a set together, in the order of the text."""
    sets = DisjointSets((one, other))
    for connection in connections:
        for a, b in match_leaves(connection.left, connection.right, connection.span):
            sets.join(a.key, b.key)
        if sets.find(one) == sets.find(other):
            return connection.span
    return NOWHERE


def _is_source(member: Member) -> bool:
    causality = member.leaf.causality
    if causality is syntax.Causality.OUTPUT:
        return not member.outside
    return causality is syntax.Causality.INPUT and member.outside and is_public_input(member.leaf)
