"""The connectors that a connect equation names, and what is said where it names none.

In:   syntax.Connect, Env
Out:  Side   a connector, or lists of them for arrays; None for each that is switched off

Reference: Modelica Language Specification 3.6, section 9.1.
"""

from __future__ import annotations

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, PlanarcError, Severity, error
from planarc.core.prose import either
from planarc.flatten.refusal import NotThere, for_each
from planarc.flatten.terms.select import element_at
from planarc.flatten.tree.demand import layout_of, node_of
from planarc.flatten.tree.lookup import declared, find, member
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


def both_sides(node: syntax.Connect, env: Env) -> tuple[object | None, object | None]:
    """Both sides; what is wrong with either is told."""
    try:
        left, right = for_each((node.left, node.right), lambda ref: _sides(ref, env))
    except PlanarcError as refused:
        if _gives_nothing(node.left, node.right, env) or _gives_nothing(node.right, node.left, env):
            return None, None
        found = [d for d in refused.diagnostics if isinstance(d, _NoConnector)]
        if len(found) == 1 and not found[0].hint and not found[0].is_part:
            raise PlanarcError(replace(found[0], hint=_hint_of_signals(node, env))) from None
        if len(found) < 2:
            raise
        message = f"neither `{node.left}` nor `{node.right}` is a connector"
        hint = _hint_of_connectors(node, env)
        hint = hint or f"write the equation `{node.left} = {node.right};`"
        if any(d.is_part for d in found):
            hint = "; ".join(d.hint for d in found if d.hint) or "connect connectors of them"
        raise error("F311", message, node.span, hint=hint) from None
    return left, right


def _gives_nothing(ref: syntax.Ref, other: syntax.Ref, env: Env) -> bool:
    """Whether what is not there, or an array without members, would give a bus a new element."""
    return _is_new(other, env) and _is_nothing(ref, env)


def _is_new(ref: syntax.Ref, env: Env) -> bool:
    """An element that an expandable connector does not have (9.1.3)."""
    try:
        bus = resolve(replace(ref, parts=ref.parts[:-1]), env) if len(ref.parts) > 1 else None
    except PlanarcError:
        return False
    if not isinstance(bus, Instance):
        return False
    is_bus = bus.layout.kind is syntax.ClassKind.EXPANDABLE_CONNECTOR
    return is_bus and member(bus, ref.parts[-1].name) is None


def _is_nothing(ref: syntax.Ref, env: Env) -> bool:
    try:
        view = resolve(ref, env)
    except PlanarcError as problem:
        return isinstance(problem, NotThere)
    if isinstance(view, list | Family):
        return not (view if isinstance(view, list) else view.items) or _is_absent(view)
    return _is_absent(view) or (isinstance(view, flat.Array) and not view.items)


def _hint_of_connectors(node: syntax.Connect, env: Env) -> str | None:
    """What to write where variables of connectors were connected: `pin.frame_b.r`."""
    owners = [
        replace(ref, parts=ref.parts[:-1]) for ref in (node.left, node.right) if len(ref.parts) > 1
    ]
    views = [resolve(owner, env) for owner in owners]
    if len(views) < 2 or not all(isinstance(v, Instance) and v.is_connector for v in views):
        return None
    return f"connectors are connected as a whole: write `connect({owners[0]}, {owners[1]});`"


def _hint_of_signals(node: syntax.Connect, env: Env) -> str | None:
    """What to write where a variable was connected to a signal."""
    views = [resolve(ref, env) for ref in (node.left, node.right)]
    leaves = [env.session.leaves.get(v.name) if isinstance(v, flat.Reference) else v for v in views]
    if not all(isinstance(leaf, Leaf) for leaf in leaves):
        return None
    given, taken = (node.left, node.right)
    first = leaves[0]
    if isinstance(first, Leaf) and first.is_connector:
        given, taken = taken, given
    return f"write the equation `{taken} = {given};`"


class _NoConnector(Diagnostic):
    """What is connected is a variable or a component: one message is enough for both sides."""

    is_part: bool = False


def warn_absent(ref: syntax.Ref, env: Env) -> None:
    """A connector of a component, switched off there, is connected to that of another one.

    A class's own conditional connectors are connected to its inside without a word, and what a
    library connects its user cannot change.
    """
    if ref.span.source.name not in env.session.own_files():
        return
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
        each = "each " if ref.parts[0].subscripts else ""
        hint = f"switch it on: `{owner}({each}{condition} = true)`"
        if any(isinstance(w, flat.LeftOut) and w.hint == hint for w in env.session.warnings):
            return  # `support` beside `axis`: one switch is left off
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
    """Outside: the first identifier is a connector of this class itself (9.1.2), or a component's
    connector is `outer`, so that it is one of a class around (9.2)."""
    found = find(env.scope, ref.parts[0].name, ref.span)
    if found is None or found[0].is_class:
        return False
    node = node_of(found[0])
    return _is_connector(node) or (len(ref.parts) > 1 and _holds_outer(node, ref.parts[1].name))


def _holds_outer(node: Node, name: str) -> bool:
    """Whether what a component, or each of an array of them, calls `name` is `outer` there."""
    if not isinstance(node, Instance | Family):
        return False
    layout = node.layout if isinstance(node, Instance) else layout_of(node.cls)
    slot = layout.members.get(name)
    return slot is not None and slot[1].prefixes.outer


def _is_connector(node: Node) -> bool:
    if isinstance(node, Leaf | Instance):
        return node.is_connector
    if isinstance(node, Family):
        return layout_of(node.cls).kind in CONNECTOR_KINDS
    return False


def _as_sides(view: View, ref: syntax.Ref, outside: bool, env: Env) -> object:
    if isinstance(view, list):  # some of them may be switched off (4.4.5)
        return [None if _is_absent(v) else _as_sides(v, ref, outside, env) for v in view]
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
    if isinstance(view, Class):
        raise error("F311", f"`{ref}` is no connector, but a class", ref.span)
    hint = _offered(ref, view) if isinstance(view, Instance) else None
    raise _no_connector(ref, hint, isinstance(view, Instance))


def _no_connector(ref: syntax.Ref, hint: str | None = None, is_part: bool = False) -> PlanarcError:
    message = f"`{ref}` is no connector, but a {'component' if is_part else 'variable'}"
    return PlanarcError(_NoConnector("F311", message, ref.span, hint=hint, is_part=is_part))


def _offered(ref: syntax.Ref, view: Instance) -> str | None:
    """The connectors of a component that was connected itself."""
    nodes = ((name, definition) for name, (_, definition) in view.layout.members.items())
    names = [
        f"{ref}.{name}"
        for name, definition in nodes
        if isinstance(definition, syntax.Component)
        and not definition.prefixes.outer
        and definition.condition is None
        and _is_connector(node_of(declared(view, name)))
    ]
    return f"connect {either(names[:3])}" if names else None


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
    return Side(entry_name(reference), outside, leaf, entry)


def entry_name(reference: flat.Reference) -> str:
    label = ",".join(str(s.value) for s in reference.subscripts if isinstance(s, flat.Literal))
    return f"{reference.name}[{label}]" if label else reference.name


def _entry_sides(view: flat.Reference, ref: syntax.Ref, outside: bool, env: Env) -> object:
    leaf = env.session.leaves.get(view.name)
    if leaf is None or not leaf.is_connector:
        raise _no_connector(ref)
    return _entries(leaf, view, outside)
