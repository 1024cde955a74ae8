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

from collections import deque
from collections.abc import Iterator

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError, Related, Severity, error
from planarc.core.source import Span
from planarc.flatten.refusal import NotThere, for_each
from planarc.flatten.terms.conform import base_conforms, type_text
from planarc.flatten.terms.select import element_at
from planarc.flatten.tree.demand import layout_of, node_of
from planarc.flatten.tree.lookup import declared, find
from planarc.flatten.tree.nodes import (
    CONNECTOR_KINDS,
    Absent,
    Class,
    Env,
    Family,
    Instance,
    Leaf,
    Node,
)
from planarc.flatten.typing.references import View, resolve
from planarc.ir import flat, syntax


class Side(Data):
    """One connector, or entry of an array of connectors, as a connect names it."""

    name: str
    outside: bool
    node: Leaf | Instance
    entry: flat.Expression | None = None  # of an array of scalar connectors


class Connection(Data):
    """A pair of single connectors, joined in an instance."""

    left: Side
    right: Side
    span: Span
    component: str


def collect_connection(node: syntax.Connect, env: Env) -> list[Connection]:
    """The pairs of single connectors of one connect equation."""
    left, right = _both(node, env)
    if left is None or right is None:
        neither = left is None and right is None
        if not neither or len(node.left.parts) == len(node.right.parts) == 2:
            _warn_absent(node.left if left is None else node.right, env)
        return []  # a conditional connector is not there
    pairs: list[tuple[object, object]] = [(left, right)]
    found: list[Connection] = []
    while pairs:
        a, b = pairs.pop(0)
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
            raise error("F310", message, node.span, hint=f"connect it to one of them: `{many}[1]`")
    return found


def _both(node: syntax.Connect, env: Env) -> tuple[object | None, object | None]:
    """Both sides; what is wrong with either is told."""
    left, right = for_each((node.left, node.right), lambda ref: _sides(ref, env))
    return left, right


def _warn_absent(ref: syntax.Ref, env: Env) -> None:
    """A connector of a component, switched off there, is connected to that of another one.

    A class's own conditional connectors are connected to its inside without a word.
    """
    try:
        view = resolve(ref, env) if len(ref.parts) == 2 else None
    except PlanarcError:  # its component is not there itself
        return
    if not isinstance(view, Absent) or view.element.name != ref.parts[1].name:
        return
    definition = view.element.definition
    condition = definition.condition if isinstance(definition, syntax.Component) else None
    owner = ref.parts[0].name
    hint = "remove the connection, or make the condition of the connector true"
    if isinstance(condition, syntax.Ref):
        hint = f"switch it on: `{owner}({condition} = true)`"
    message = f"`{ref}` is not there, so its connection is left out"
    env.session.warnings.append(flat.LeftOut("F314", message, ref.span, Severity.WARNING, hint))


def _sides(ref: syntax.Ref, env: Env) -> object | None:
    """The connectors that a reference in a connect equation means; None when absent."""
    outside = _is_outside(ref, env)
    try:
        view = resolve(ref, env)
        for count in range(2, len(ref.parts)):
            _check_inner(resolve(replace(ref, parts=ref.parts[:count]), env), ref)
    except NotThere:
        return None
    return None if _is_absent(view) else _as_sides(view, ref, outside, env)


def _check_inner(view: View, ref: syntax.Ref) -> None:
    """Behind the first name of a connector stand connectors only (9.1)."""
    while isinstance(view, list) and view:
        view = view[0]
    if isinstance(view, Instance) and not view.is_connector and not view.is_record:
        owner = view.parent.cls.name if view.parent is not None else view.name
        message = f"`{ref}` reaches into `{owner}`: only its own connectors can be connected"
        hint = f"give `{owner}` a connector, and connect `{view.name}` to it there"
        raise error("F311", message, ref.span, hint=hint)


def _is_absent(view: View) -> bool:
    """A conditional connector, or that of each member of an array of components."""
    if isinstance(view, list):
        return bool(view) and all(map(_is_absent, view))
    return isinstance(view, Absent)


def _is_outside(ref: syntax.Ref, env: Env) -> bool:
    """Outside: the first identifier is a connector of this class itself (9.1.2)."""
    found = find(env.scope, ref.parts[0].name)
    if found is None or found[0].is_class:
        return False
    if found[0].definition.prefixes.outer:
        return False
    return _is_connector(node_of(found[0]))


def _is_connector(node: Node) -> bool:
    if isinstance(node, Leaf | Instance):
        return node.is_connector
    if isinstance(node, Family):
        return layout_of(node.cls).kind in CONNECTOR_KINDS
    return False


def _as_sides(view: View, ref: syntax.Ref, outside: bool, env: Env) -> object:
    if isinstance(view, list):
        return [_as_sides(v, ref, outside, env) for v in view]
    if isinstance(view, Family):
        return _nest([_as_sides(i, ref, outside, env) for i in view.items], view.dims)
    if _is_of_class(view):
        raise error("F311", f"`{ref}` is part of a class, not of a component", ref.span)
    if isinstance(view, Instance) and view.is_connector:
        return Side(view.name, outside, view)
    if isinstance(view, Leaf) and view.is_connector:
        return _entries(view, flat.Reference(view.type, ref.span, view.name), outside)
    if isinstance(view, flat.Reference):
        return _entry_sides(view, ref, outside, env)
    if isinstance(view, flat.Array):
        return [_as_sides(i, ref, outside, env) for i in view.items]
    what = "class" if isinstance(view, Class) else "component"
    raise error("F311", f"`{ref}` is no connector, but a {what}", ref.span)


def _is_of_class(view: View) -> bool:
    """Reached through a class name: it is declared, but nowhere there."""
    owner = view.parent if isinstance(view, Leaf) else view
    return isinstance(owner, Instance) and owner.prefix is None


def _nest(items: list[object], dims: tuple[int, ...]) -> list[object]:
    for size in reversed(dims[1:]):
        items = [items[k : k + size] for k in range(0, len(items), size)]
    return items


def _entries(leaf: Leaf, reference: flat.Expression, outside: bool) -> object:
    """A scalar connector; an array of them entry by entry."""
    if reference.type.dims:
        size = reference.type.dims[0] or 0
        return [_entries(leaf, element_at(reference, i), outside) for i in range(1, size + 1)]
    assert isinstance(reference, flat.Reference)
    entry = reference if reference.subscripts else None
    return Side(_entry_name(reference), outside, leaf, entry)


def _entry_name(reference: flat.Reference) -> str:
    label = ",".join(str(s.value) for s in reference.subscripts if isinstance(s, flat.Literal))
    return f"{reference.name}[{label}]" if label else reference.name


def _entry_sides(view: flat.Reference, ref: syntax.Ref, outside: bool, env: Env) -> object:
    leaf = env.session.leaves.get(view.name)
    if leaf is None or not leaf.is_connector:
        raise error("F311", f"`{ref}` is no connector, but a variable", ref.span)
    return _entries(leaf, view, outside)


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
        return _entry_name(self.entry), self.outside

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
            raise _unlike(left, right, f"`{a.name}` and `{b.name}` are of different kind", span)


def _match_members(
    a: Instance, b: Instance, left: Side, right: Side, span: Span
) -> list[tuple[Node, Node]]:
    names = component_names(a)
    others = component_names(b)
    missing = [n for n in names if n not in others] or [n for n in others if n not in names]
    if missing:
        owner = b if missing[0] in names else a
        raise _unlike(left, right, f"`{owner.name}` has no `{missing[0]}`", span)
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
    if not (base_conforms(a.type, b.type) or base_conforms(b.type, a.type)) or (
        a.type.dims != b.type.dims
    ):
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
    return error(
        "F312",
        f"`{left.name}` and `{right.name}` cannot be connected: {why}",
        span,
        related=[
            Related(f"`{side.name}` is declared here", side.node.span) for side in (left, right)
        ],
        hint=hint
        or _flange_hint(left, right)
        or _flange_hint(right, left)
        or _kinds_hint(left, right),
    )


def _kinds_hint(left: Side, right: Side) -> str | None:
    """What stands between connectors of two kinds."""
    kinds = {_kind(side): side.name for side in (left, right)}
    if kinds.keys() == {"turns", "slides"}:
        return (
            f"`{kinds['turns']}` turns and `{kinds['slides']}` slides: put a rack and pinion "
            "between them, `Modelica.Mechanics.Rotational.Components.IdealGearR2T`"
        )
    if "signal" in kinds and kinds.keys() & {"turns", "slides"}:
        library = "Rotational" if "turns" in kinds else "Translational"
        return (
            f"`{kinds['signal']}` is a signal: put a source, which makes it a torque, a force or a "
            f"motion, or a sensor between them, of `Modelica.Mechanics.{library}`"
        )
    return None


def _kind(side: Side) -> str:
    if isinstance(side.node, Leaf):
        return "signal"
    kinds = {frozenset(("phi", "tau")): "turns", frozenset(("s", "f")): "slides"}
    return kinds.get(frozenset(component_names(side.node)), side.name)


def _flange_hint(flange: Side, frame: Side) -> str | None:
    """What a user means who connects a shaft or slide with a frame: the joint's own flange."""
    if not (isinstance(flange.node, Instance) and isinstance(frame.node, Instance)):
        return None
    if set(component_names(flange.node)) not in ({"phi", "tau"}, {"s", "f"}):
        return None
    joint = frame.node.parent
    if not {"r", "phi", "f", "t"} <= set(component_names(frame.node)) or joint is None:
        return None
    if "drivenFlange" not in joint.layout.members:
        return f"connect `{flange.name}` to the `axis` of a joint with `drivenFlange=true`"
    name = joint.name
    return f"write `connect({flange.name}, {name}.axis)`, and `{name}(drivenFlange=true)`"
