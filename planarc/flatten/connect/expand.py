"""Expandable connectors: members come into being by being connected.

In:   all connect equations, before they are resolved
Out:  the members added to expandable connectors, as new nodes of the instance tree

`connect(bus.speed, sensor.w)` gives `bus` a variable `speed` of the type of `sensor.w`,
and so every expandable connector that `bus` is connected to, in the whole hierarchy.

Reference: Modelica Language Specification 3.6, section 9.1.3.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import product
from typing import TypeGuard

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError, Related, error
from planarc.core.disjoint import DisjointSets
from planarc.core.source import Span
from planarc.flatten.connect.connect import Member, member_nodes
from planarc.flatten.connect.inputs import connectors_around, is_public_input
from planarc.flatten.refusal import unsupported
from planarc.flatten.tree.lookup import member
from planarc.flatten.tree.nodes import (
    NO_MOD,
    Absent,
    Element,
    Env,
    Family,
    Instance,
    Leaf,
    Mod,
    Node,
    Session,
    State,
)
from planarc.flatten.typing.references import View, resolve
from planarc.ir import flat, syntax
from planarc.ir.flatwalk import nodes_of


class Statement(Data):
    """One connect equation, with its iterators replaced."""

    node: syntax.Connect
    env: Env


class Wish(Data):
    """A member that an expandable connector does not have yet."""

    bus: Instance
    name: str
    span: Span


def expand_connectors(statements: Sequence[Statement], instances: Sequence[Instance]) -> list[Node]:
    """Add the members that connections ask for; gives the new nodes."""
    buses = {i.name: i for i in instances if is_expandable(i)}
    if not buses:
        return []
    made: list[Node] = []
    open_ = list(statements)
    while True:
        groups = _groups(statements, buses)
        before = len(made)
        made += _share(groups, buses)
        open_ = [s for s in open_ if not _fulfil(s, made)]
        for node in made[before:]:
            if _is_bus(node):
                buses[node.name] = node
        if len(made) == before:
            break
    return made


def is_expandable(instance: Instance) -> bool:
    return instance.layout.kind is syntax.ClassKind.EXPANDABLE_CONNECTOR


def _side(ref: syntax.Ref, env: Env) -> View | Wish | None:
    """The nodes or the wish that one side means, None when that cannot be told."""
    if len(ref.parts) > 1:
        bus = _resolved(syntax.Ref(ref.span, ref.parts[:-1], ref.absolute), env)
        last = ref.parts[-1]
        if _is_bus(bus) and member(bus, last.name) is None:
            if last.subscripts:
                what = "entries of arrays as new members of expandable connectors"
                raise unsupported(what, "9.1.3", ref.span)
            return Wish(bus, last.name, ref.span)
    return _resolved(ref, env)


def _resolved(ref: syntax.Ref, env: Env) -> View | None:
    try:
        return resolve(ref, env)
    except PlanarcError:
        return None  # reported when the connection is collected


def _groups(statements: Sequence[Statement], buses: dict[str, Instance]) -> DisjointSets[str]:
    """Expandable connectors that are connected with each other."""
    groups: DisjointSets[str] = DisjointSets()
    for name in buses:
        groups.add(name)
    for statement in statements:
        left = _resolved(statement.node.left, statement.env)
        right = _resolved(statement.node.right, statement.env)
        if _is_bus(left) and _is_bus(right):
            groups.join(left.name, right.name)
    return groups


def _is_bus(view: View | None) -> TypeGuard[Instance]:
    return isinstance(view, Instance) and is_expandable(view)


def _share(groups: DisjointSets[str], buses: dict[str, Instance]) -> list[Node]:
    """Every expandable connector of a group gets the members of the others."""
    made: list[Node] = []
    for group in groups.sets():
        members: dict[str, Node] = {}
        for name in group:
            for inner, node in member_nodes(buses[name]):
                members.setdefault(inner, node)
        for name in group:
            bus = buses[name]
            for inner, template in members.items():
                if member(bus, inner) is None and not isinstance(template, Absent):
                    span = template.element.definition.span if template.element else bus.span
                    made.append(add_member(Wish(bus, inner, span), template))
    return made


def _fulfil(statement: Statement, made: list[Node]) -> bool:
    """Add the member that a connection asks for; True when nothing is left to do."""
    left = _side(statement.node.left, statement.env)
    right = _side(statement.node.right, statement.env)
    wish, template = (left, right) if isinstance(left, Wish) else (right, left)
    if not isinstance(wish, Wish):
        return True
    found = None if isinstance(template, Wish | None) else _template(template, statement.env)
    if found is None:
        return False
    made.append(add_member(wish, found))
    return True


def _template(view: View, env: Env) -> Leaf | Instance | Family | None:
    """What a new member is like: a connector, an array of them, or one in each component of an
    array."""
    if isinstance(view, flat.Reference):
        return _entry_template(view, env)
    if isinstance(view, list):
        found = [_template(v, env) for v in view]
        known = [node for node in found if node is not None]
        return _array_template([node or known[0] for node in found] if known else [])
    return view if isinstance(view, Leaf | Instance | Family) else None


def _array_template(nodes: Sequence[Leaf | Instance | Family]) -> Leaf | Family | None:
    """The connectors that the members of an array of components have, as one array."""
    if not nodes:
        return None
    first, size = nodes[0], len(nodes)
    if isinstance(first, Leaf):
        type_ = first.type.with_dims((size, *first.type.dims))
        mod = Mod(subs={k: v for k, v in first.mod.subs.items() if k in _OF_ALL})
        return replace(first, type=type_, mod=mod)
    families = [node for node in nodes if isinstance(node, Family)]
    items = [node for node in nodes if isinstance(node, Instance)]
    items += [item for family in families for item in family.items]
    dims = (size, *(first.dims if isinstance(first, Family) else ()))
    element = first.element
    assert element is not None
    return Family(first.name, dims, items, first.cls, element)


#: Attributes that are texts, and alike for all entries of an array.
_OF_ALL = ("unit", "displayUnit", "quantity")


def _entry_template(reference: flat.Reference, env: Env) -> Leaf | None:
    """An entry of an array of scalar connectors, as a template for one of them."""
    whole = env.session.leaves.get(reference.name)
    if whole is None:
        return None
    return replace(whole, type=reference.type, flow=syntax.Flow.NONE)


def add_member(wish: Wish, template: Node) -> Node:
    """A new member of an expandable connector, like the node that it is connected to."""
    bus = wish.bus
    name = bus.full_name(wish.name)
    type_ref = syntax.Ref(wish.span, (syntax.RefPart(wish.span, wish.name),))
    definition = syntax.Component(wish.span, wish.name, type_ref)
    element = Element(wish.name, definition, bus.scope(), NO_MOD)
    element.node = _copy(template, name, bus, element)
    element.state = State.DONE
    bus.elements[wish.name] = element
    return element.node


def _copy(template: Node, name: str, bus: Instance, element: Element) -> Node:
    if isinstance(template, Leaf):
        mod = Mod(subs=template.mod.subs)
        leaf = Leaf(name, template.type, template.variability, element, bus, mod, template.layout)
        leaf.flow = template.flow
        leaf.is_connector = True
        bus.session.leaves[name] = leaf
        return leaf
    if isinstance(template, Instance):
        return _copy_instance(template, name, bus, element)
    if isinstance(template, Family):
        places = product(*(range(1, size + 1) for size in template.dims))
        items = []
        for item, place in zip(template.items, places, strict=True):
            full = f"{name}[{','.join(map(str, place))}]"
            made = _copy_instance(item, full, bus, element)
            made.indices, made.sizes = place, template.dims
            items.append(made)
        return Family(name, template.dims, items, template.cls, element)
    raise error("F311", f"`{template.name}` is no connector", element.definition.span)


def _copy_instance(template: Instance, name: str, bus: Instance, element: Element) -> Instance:
    mod = Mod(subs=template.mod.subs)
    made = Instance(
        template.cls, template.layout, name, mod, bus, bus.session, template.variability, element
    )
    made.indices, made.sizes = template.indices, template.sizes
    return made


def unused_members(
    leaves: Sequence[Leaf], used: set[str], sets: Sequence[Sequence[Leaf]]
) -> set[str]:
    """Variables of expandable connectors that nothing gives or reads: they are not there."""
    if not any(in_expandable(leaf) for leaf in leaves):
        return set()
    groups: DisjointSets[str] = DisjointSets()  # one variable may be in two connection sets
    for leaf in leaves:
        groups.add(leaf.name)
    for joined in sets:
        for leaf in joined[1:]:
            groups.join(joined[0].name, leaf.name)
    alive = {
        groups.find(leaf.name) for leaf in leaves if leaf.name in used or not in_expandable(leaf)
    }
    return {leaf.name for leaf in leaves if groups.find(leaf.name) not in alive}


def check_absent(
    unused: set[str], expressions: Iterable[flat.Expression], session: Session
) -> None:
    """Report a variable of a bus that expressions use though nothing gives it (9.1.3)."""
    for node in nodes_of(expressions):
        if isinstance(node, flat.Reference) and node.name in unused:
            declared = [Related("declared here", session.leaves[node.name].span)]
            message = f"`{node.name}` is not there: no connection and no equation gives it"
            session.keep(error("F215", message, node.span, related=declared))


def outside_signals(sets: Sequence[Sequence[Member]], used: set[str]) -> list[Leaf]:
    """Variables of the model's own buses that components only read: they come from outside.

    `used` are names in equations, which may give a variable its value (9.1.3).
    """
    groups: DisjointSets[str] = DisjointSets()  # one variable may be in two connection sets
    members: dict[str, list[Member]] = {}
    for joined in sets:
        if joined[0].is_flow or not any(in_expandable(m.leaf) for m in joined):
            continue
        for m in joined:
            groups.join(_signal(joined[0]), _signal(m))
            members.setdefault(_signal(m), []).append(m)
    found = []
    for names in groups.sets():
        joined = [m for name in names for m in members[name]]
        own = [m.leaf for m in joined if in_expandable(m.leaf) and _is_of_model(m.leaf)]
        if own and all(_only_reads(m, used) for m in joined):
            found.append(own[0])
    return found


def _signal(member: Member) -> str:
    """A variable, or an entry of one; of a bus the whole, of which connections may name the
    entries or none."""
    return member.leaf.name if in_expandable(member.leaf) else member.key[0]


def _only_reads(member: Member, used: set[str]) -> bool:
    leaf = member.leaf
    if in_expandable(leaf):
        return leaf.name not in used
    return not member.outside and is_public_input(leaf)


def _is_of_model(leaf: Leaf) -> bool:
    """True for a variable in a public connector of the model itself."""
    around, owner = connectors_around(leaf)
    hidden = any(c.element is not None and c.element.protected for c in around)
    return owner is not None and owner.depth == 0 and not hidden


def in_expandable(leaf: Leaf) -> bool:
    return any(map(is_expandable, connectors_around(leaf)[0]))


def is_added(leaf: Leaf) -> bool:
    """Whether it lies in what an expandable connector does not declare, but got."""
    around = connectors_around(leaf)[0]
    names = [leaf.element.name, *(c.element.name for c in around if c.element is not None)]
    return any(
        is_expandable(bus) and name not in bus.layout.members
        for name, bus in zip(names, around, strict=False)
    )
