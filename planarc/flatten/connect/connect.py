"""Connect equations: which connectors they join, and whether these fit together.

In:   syntax.Connect, Env
Out:  Connection   pairs of single connectors; `sets` makes equations of them

Example: with `Link link[3];` the equation `connect(link[1:2].b, link[2:3].a)` gives
the pairs (link[1].b, link[2].a) and (link[2].b, link[3].a).

A connector of a component counts positive (inside), a connector of the class that
holds the connect equation negative (outside).

Reference: Modelica Language Specification 3.6, chapter 9.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Iterator

from planarc.core.data import Data
from planarc.core.diagnostic import Once, PlanarcError, Related, error
from planarc.core.prose import either
from planarc.core.source import Span
from planarc.flatten.connect.kinds import other_kind
from planarc.flatten.connect.sides import Side, both_sides, entry_name, warn_absent
from planarc.flatten.terms.conform import base_conforms, type_text
from planarc.flatten.tree.demand import node_of
from planarc.flatten.tree.lookup import declared
from planarc.flatten.tree.nodes import Absent, Env, Family, Instance, Leaf, Node
from planarc.ir import flat, syntax


class Connection(Data):
    """A pair of single connectors, joined in an instance."""

    left: Side
    right: Side
    span: Span
    component: str


def collect_connection(node: syntax.Connect, env: Env) -> list[Connection]:
    """The pairs of single connectors of one connect equation."""
    left, right = both_sides(node, env)
    if left is None or right is None:
        neither = left is None and right is None
        if not neither or len(node.left.parts) == len(node.right.parts) == 2:
            warn_absent(node.left if left is None else node.right, env)
        return []  # a conditional connector is not there
    pairs: list[tuple[object, object]] = [(left, right)]
    found: list[Connection] = []
    while pairs:
        a, b = pairs.pop(0)
        if a is None or b is None:  # a member whose connector is switched off
            continue
        if isinstance(a, list) and isinstance(b, list):
            if len(a) != len(b):
                both = f"`{node.left}` and `{node.right}` are arrays of different size"
                raise error("F310", f"{both}: {len(a)} and {len(b)}", node.span)
            pairs = list(zip(a, b, strict=True)) + pairs
        elif isinstance(a, Side) and isinstance(b, Side):
            deque(match_leaves(a, b, node.span), 0)  # raises where they do not fit
            found.append(Connection(a, b, node.span, env.component))
        else:
            many, one = (node.left, node.right) if isinstance(a, list) else (node.right, node.left)
            message = f"`{many}` is an array of connectors, `{one}` is a single one"
            hint = f"connect it to one of them: `{many}[1]`"
            given = a if isinstance(a, list) else b
            assert isinstance(given, list)
            if any(_takes(side) for side in given[1:]):
                hint += ", and give the others a value, too"
            raise error("F310", message, node.span, hint=hint)
    return found


def _takes(side: Side | list[Side]) -> bool:
    """Whether it is an input of a component, which needs a value."""
    node = side.node if isinstance(side, Side) else None
    return isinstance(node, Leaf) and node.causality is syntax.Causality.INPUT


# Matching ----------------------------------------------------------------------------------


class Member(Data):
    """One variable of a connector, seen from inside or outside."""

    leaf: Leaf
    outside: bool
    entry: flat.Expression | None = None

    @property
    def key(self) -> tuple[str, bool]:
        if self.entry is None:
            return self.leaf.name, self.outside
        assert isinstance(self.entry, flat.Reference)
        return entry_name(self.entry), self.outside

    @property
    def type(self) -> flat.Type:
        return self.leaf.type if self.entry is None else self.entry.type

    @property
    def is_flow(self) -> bool:
        return self.leaf.flow is syntax.Flow.FLOW

    def reference(self, span: Span) -> flat.Expression:
        if self.entry is not None:
            return self.entry
        return flat.Reference(self.leaf.type, span, self.leaf.name)


def match_leaves(left: Side, right: Side, span: Span) -> Iterator[tuple[Member, Member]]:
    """The pairs of variables that a connection joins."""
    stack: list[tuple[Node, Node]] = [(left.node, right.node)]
    while stack:
        a, b = stack.pop()
        if isinstance(a, Leaf) and isinstance(b, Leaf):
            entry_a = left.entry if a is left.node else None
            entry_b = right.entry if b is right.node else None
            first, second = Member(a, left.outside, entry_a), Member(b, right.outside, entry_b)
            _check_leaves(first, second, left, right, span)
            yield first, second
        elif isinstance(a, Instance) and isinstance(b, Instance):
            stack += reversed(_match_members(a, b, left, right, span))
        elif isinstance(a, Family) and isinstance(b, Family) and a.dims == b.dims:
            stack += reversed(list(zip(a.items, b.items, strict=True)))
        elif not (isinstance(a, Absent) and isinstance(b, Absent)):
            raise _unlike(left, right, _different(a, b), span)


def _match_members(
    a: Instance, b: Instance, left: Side, right: Side, span: Span
) -> list[tuple[Node, Node]]:
    names = component_names(a)
    others = component_names(b)
    missing = [n for n in names if n not in others] or [n for n in others if n not in names]
    if missing:
        owner = b if missing[0] in names else a
        known = _kind(a) and _kind(b)
        why = _different(a, b) if known else f"`{owner.name}` has no `{missing[0]}`"
        raise _unlike(left, right, why, span)
    nodes = dict(member_nodes(b))
    return [(node, nodes[name]) for name, node in member_nodes(a)]


def member_nodes(instance: Instance) -> list[tuple[str, Node]]:
    """The components of a connector by name."""
    return [(name, node_of(declared(instance, name))) for name in component_names(instance)]


def component_names(instance: Instance) -> list[str]:
    """The components of a connector; those that an expandable one got come last."""
    declared = instance.layout.members
    names = [n for n, (_, d) in declared.items() if isinstance(d, syntax.Component)]
    if instance.layout.kind is syntax.ClassKind.EXPANDABLE_CONNECTOR:
        names += [n for n, e in instance.elements.items() if n not in declared and e.node]
    return names


def _check_leaves(a: Member, b: Member, left: Side, right: Side, span: Span) -> None:
    if a.is_flow != b.is_flow:
        flow = a if a.is_flow else b
        why = f"`{flow.leaf.name}` is a flow variable, its counterpart is not"
        raise _unlike(left, right, why, span)
    if a.leaf.variability is not b.leaf.variability:
        fixed = min(a.leaf, b.leaf, key=lambda leaf: leaf.variability)
        if fixed.variability <= flat.Variability.PARAMETER:
            kind = fixed.variability.name.lower()
            raise _unlike(left, right, f"`{fixed.name}` is a {kind}, its counterpart is not", span)
    same = base_conforms(a.type, b.type) and base_conforms(b.type, a.type)  # no Integer to a Real
    if not same or a.type.dims != b.type.dims:
        why = f"`{a.leaf.name}` is {type_text(a.type)}, `{b.leaf.name}` is {type_text(b.type)}"
        raise _unlike(left, right, why, span, _converter(a, b) or _converter(b, a))


def _converter(source: Member, target: Member) -> str | None:
    """The block that makes one kind of signal of another."""
    kinds = [m.type.base.value for m in (source, target)]
    if source.leaf.causality is not syntax.Causality.OUTPUT or kinds[0] == kinds[1]:
        return None
    if not {*kinds} <= {"Real", "Integer", "Boolean"}:
        return None
    block = f"Modelica.Blocks.Math.{kinds[0]}To{kinds[1]}"
    return f"put a block between them that makes one of the other: `{block}`"


def _unlike(left: Side, right: Side, why: str, span: Span, hint: str | None = None) -> PlanarcError:
    hint = (
        hint or _flange_hint(left, right) or _flange_hint(right, left) or _kinds_hint(left, right)
    )
    sides = (left, right)
    found = Once(
        "F312",
        f"`{left.name}` and `{right.name}` cannot be connected: {why}",
        span,
        hint=hint,
        related=tuple(Related(f"`{s.name}` is declared here", s.node.span) for s in sides),
        kind=hint or f"{left.name} {right.name}",  # once for both ends of a damper
    )
    kinds = [_kind(side.node) or "" for side in sides]
    mixed = {*kinds} == {"turns", "slides"}
    return PlanarcError(other_kind(found, sides, kinds) if mixed else found)


def _of_the_other_kind(connector: Leaf | Instance) -> str:
    """The source that pushes where one turns, or the other way round, to take in its place."""
    part = connector.parent
    name = part.cls.name if part is not None else ""
    for kind, pairs in _OTHER_KIND.items():
        if f".{kind}.Sources." in name and part is not None:
            for old, new in pairs:
                name = name.replace(old, new)
            if part.session.library.entry(name) is not None:
                return f"take `{name}` for `{part.name}`, or "
    return ""


#: The words by which names of sources for what turns and for what slides differ.
_OTHER_KIND = {
    "Rotational": (("Rotational", "Translational"), ("Torque", "Force")),
    "Translational": (("Translational", "Rotational"), ("Force", "Torque")),
}


def _kinds_hint(left: Side, right: Side) -> str | None:
    """What stands between connectors of two kinds."""
    for connector, signal in ((left.node, right), (right.node, left)):
        part = connector.parent
        if isinstance(signal.node, Leaf) and isinstance(connector, Instance) and part is not None:
            # A sensor's frame in the place of what it measures.
            leaves = [e.node for e in part.elements.values() if isinstance(e.node, Leaf)]
            given = [n.name for n in leaves if n.causality is syntax.Causality.OUTPUT]
            if given:
                return f"`{signal.name}` is a signal: connect {either(given)} to it"
            taken = [n.name for n in leaves if n.causality is syntax.Causality.INPUT]
            if len(taken) == 1 and signal.node.causality is syntax.Causality.OUTPUT:
                return f"write `connect({signal.name}, {taken[0]});` to give the signal to it"
    kinds = {_kind(side.node) or side.name: side.name for side in (left, right)}
    if kinds.keys() == {"turns", "slides"}:
        other = _of_the_other_kind(left.node) or _of_the_other_kind(right.node)
        return (
            f"`{kinds['turns']}` turns and `{kinds['slides']}` slides: {other}put a rack and "
            "pinion between them, `Modelica.Mechanics.Rotational.Components.IdealGearR2T`"
        )
    if "signal" in kinds and kinds.keys() & {"turns", "slides"}:
        library = "Rotational" if "turns" in kinds else "Translational"
        return (
            f"`{kinds['signal']}` is a signal: put a source, which makes it a torque, a force or a "
            f"motion, or a sensor between them, of `Modelica.Mechanics.{library}`"
        )
    if kinds.keys() == {"signal", "frame"}:
        return (
            f"`{kinds['signal']}` is a signal: a sensor of `PlanarMultiBody.Sensors` makes one of "
            f"`{kinds['frame']}`, and a force of `PlanarMultiBody.Forces` takes one"
        )
    return None


def _kind(connector: Leaf | Instance) -> str | None:
    if isinstance(connector, Leaf):
        return "signal"
    return _KINDS.get(frozenset(component_names(connector)))


#: What connectors of these kinds are, in words.
_WORDS = {"signal": "a signal", "turns": "a shaft", "slides": "a slide", "frame": "a frame"}


def _different(a: Node, b: Node) -> str:
    kinds = [_kind(node) if isinstance(node, Leaf | Instance) else None for node in (a, b)]
    first, second = (_WORDS.get(kind or "") for kind in kinds)
    if first is None or second is None:
        return f"`{a.name}` and `{b.name}` are of different kind"
    return f"the first is {first}, the second {second}"


_KINDS = {
    frozenset(("phi", "tau")): "turns",
    frozenset(("s", "f")): "slides",
    frozenset(("r", "phi", "f", "t")): "frame",
}


#: Classes of what acts between the two parts of a joint.
_BETWEEN = r"Spring|Damper|Friction|Clutch|Backlash|Gap"


def _flange_hint(flange: Side, frame: Side) -> str | None:
    """What a user means who connects a shaft or slide with a frame: the joint's own flange."""
    if not (isinstance(flange.node, Instance) and isinstance(frame.node, Instance)):
        return None
    joint = frame.node.parent
    if _kind(flange.node) not in ("turns", "slides") or _kind(frame.node) != "frame":
        return None
    if joint is None:
        return None
    name, part = joint.name, flange.node.parent
    of_part = (e.node for e in part.elements.values()) if part else ()
    kinds = [_kind(n) for n in of_part if isinstance(n, Instance)]
    two = kinds.count(_kind(flange.node)) > 1  # a damper, say, between a joint's two parts
    if "drivenFlange" not in joint.layout.members:
        if two and part is not None and re.search(_BETWEEN, part.cls.name):
            return (
                f"`{part.name}` turns or slides alone: connect its ends to `axis` and `support` of "
                "the joint between the two parts, which are there with `drivenFlange=true`"
            )
        return (
            f"connect `{flange.name}` to the `axis` of the joint that is to move `{name}`, which "
            "is there with `drivenFlange=true`"
        )
    there = "axis" in joint.elements  # it is switched on
    if two:
        switch = "" if there else f": both are there with `{name}(drivenFlange=true)`"
        return (
            f"connect it to `{name}.axis`, which moves with `{name}.frame_b`, or `{name}.support`, "
            f"which stays with `{name}.frame_a`{switch}"
        )
    switch = "" if there else f", and `{name}(drivenFlange=true)`"
    return f"write `connect({flange.name}, {name}.axis)`{switch}"
