"""Inner and outer: one component that many places inside share.

In:   Element declared `outer`
Out:  the node of the nearest enclosing `inner` component of that name

When there is none, a default instance is made at the top of the model and a
warning says so, as Modelica tools do.

An `inner outer` component is two: the names of its own model mean the outer one, and what
stands inside gets the inner one, to which its modifiers and its binding belong.

Reference: Modelica Language Specification 3.6, section 5.4.
"""

from __future__ import annotations

from planarc.core.diagnostic import Diagnostic, PlanarcError, Related, Severity, Ungiven, error
from planarc.core.mend import Declare, MakeInner, Mend
from planarc.core.source import Span
from planarc.flatten.instances.shape import family_dims
from planarc.flatten.tree.demand import layout_of, node_of
from planarc.flatten.tree.lookup import find_class, inner_elements
from planarc.flatten.tree.nodes import NO_MOD, Element, Family, Instance, Layout, Leaf, Node
from planarc.flatten.tree.redeclare import inner_half, written_dims
from planarc.ir import syntax


def inner_node(element: Element) -> Node:
    """The node that an outer element stands for."""
    definition = element.definition
    assert isinstance(definition, syntax.Component)
    if (definition.modification is not None or element.mod) and not definition.prefixes.inner:
        message = f"the outer component `{element.name}` cannot have a modifier"
        hint = "modify the `inner` component"
        raise error("F260", message, element.mod.span or definition.span, hint=hint)
    around = inner_elements(element)
    found = next(around, None)
    if found is not None and _is_new(found):
        _warn_twins(element, found.scope.instance)
        _warn_shadow(found, next(around, None))
    if found is None and definition.prefixes.inner and element.scope.instance.parent is None:
        return node_of(inner_half(element))  # the model itself: nothing is outside
    node = _default_node(element, definition) if found is None else node_of(inner_half(found))
    _check_compatible(element, definition, node, found)
    return node


def _warn_twins(element: Element, owner: Instance) -> None:
    """Another inner component of the same class: one of them is likely a mistake."""
    session = element.scope.session
    members = owner.layout.members
    definition = members[element.name][1]
    if not isinstance(definition, syntax.Component):
        return
    for name, (_, other) in members.items():
        if name == element.name or not other.prefixes.inner:
            continue
        if isinstance(other, syntax.Component) and str(other.type) == str(definition.type):
            session.warn(
                "F264",
                f"`{name}` and `{element.name}` are both `inner {definition.type}`: what is "
                f"declared `outer {definition.type} {element.name}` uses `{element.name}` only",
                other.span,
                f"remove one of them: keep `{element.name}`",
            )


def _warn_shadow(near: Element, far: Element | None) -> None:
    """An inner component of a library's class hides another one, that of the model around it, which
    has other values: there is one world, as a rule."""
    ours, theirs = near.definition, None if far is None else far.definition
    if not isinstance(ours, syntax.Component) or not isinstance(theirs, syntax.Component):
        return
    owner, session = near.scope.instance, near.scope.session
    alike = str(ours.type) == str(theirs.type) and _values(ours) != _values(theirs)
    told = any(w.code == "F264" and w.span == ours.span for w in session.warnings)
    if not alike or ours.prefixes.outer or told:
        return
    cls = find_class(near.scope, ours.type)
    own = cls.definition.span.source.name in session.library.user_files()
    if own or layout_of(cls).builtin is not None:
        return
    message = f"`{owner.cls.name}` has an `inner {ours.type} {near.name}` of its own: inside of "
    message += f"`{owner.name}` that of the model around it, `{theirs.span.text}`, counts nowhere"
    hint = f"write `outer {ours.type} {near.name};`, if both are to be the same"
    related = (Related(f"this `{near.name}` is hidden", theirs.span),)
    session.warnings.append(Diagnostic("F264", message, ours.span, Severity.WARNING, hint, related))


def _values(definition: syntax.Component) -> str:
    """The text of a component's modifiers."""
    return "" if definition.modification is None else definition.modification.span.text


def _is_new(inner: Element) -> bool:
    """Whether an inner component is met for the first time."""
    met, key = inner.scope.session.met, (inner.scope.instance, inner.name)
    if key in met:
        return False
    met.add(key)
    return True


def _default_node(element: Element, definition: syntax.Component) -> Node:
    session = element.scope.session
    known = session.defaults.get(element.name)
    if known is not None:
        return known
    root = session.root
    assert root is not None  # what stands in a component has a model around it
    cls = find_class(element.scope, definition.type)
    layout = layout_of(cls)
    taken = _is_taken(root, element.name)
    if taken or layout.builtin is not None or cls.definition.partial:
        raise _missing(element, definition, root)
    made = Instance(cls, layout, element.name, cls.mod, root, session, element=element)
    session.defaults[element.name] = made
    message = f"no `inner {definition.type} {element.name}` is declared: a default one is used"
    inner = f"inner {definition.type} {element.name};"
    hint = f"declare `{inner}` in `{root.cls.name}`"
    mend: Mend | None = Declare(inner)
    span = root.cls.definition.name_span
    if (own := root.layout.members.get(element.name)) is not None and own[1].prefixes.outer:
        span, mend = own[1].span, None
        hint = f"write `inner` for `outer`, unless `{root.cls.name}` is a part of other models"
    for name, (_, other) in root.layout.members.items():
        if not isinstance(other, syntax.Component) or not other.prefixes.inner:
            continue
        if other.type.names[-1] == definition.type.names[-1]:
            span, mend = other.span, None
            hint = f"rename `{name}` to `{element.name}`: parts ask for that name"
    told = Ungiven("F262", message, span, Severity.WARNING, hint, mend=mend)
    session.warnings.append(told)
    return made


def _is_taken(root: Instance, name: str) -> bool:
    """The model has an element of that name already, other than an outer one."""
    slot = root.layout.members.get(name)
    return slot is not None and not slot[1].prefixes.outer


def _missing(element: Element, definition: syntax.Component, root: Instance) -> PlanarcError:
    variability = definition.variability.value
    inner = f"inner {variability} {definition.type} {element.name};".replace("  ", " ")
    asked = (Related("it is asked for here", definition.span),)
    if _is_taken(root, element.name):
        message = (
            f"`{element.name}` is declared without `inner`: the parts of the model do not find it"
        )
        place = root.layout.members[element.name][1].span
        own = " ".join(place.text.split())  # with its modifiers
        hint = f"write `{inner.removesuffix(f'{element.name};')}{own or element.name};`"
        return error("F261", message, place, hint=hint, related=asked, mend=MakeInner())
    message = f"no `{inner[:-1]}` is declared, which a part of the model asks for"
    hint, place = f"declare `{inner}` in `{root.cls.name}`", root.cls.definition.name_span
    if variability in ("parameter", "constant"):
        hint += ", with a value"
    return error("F261", message, place, hint=hint, related=asked, mend=Declare(inner))


def _check_compatible(
    element: Element, definition: syntax.Component, node: Node, found: Element | None
) -> None:
    """The inner component has all that the outer's class declares (6.3)."""
    if found is None:
        return
    cls = find_class(element.scope, definition.type)
    layout = layout_of(cls)
    place: Span = found.definition.span
    if isinstance(node, Leaf):
        fits = layout.builtin is not None and layout.builtin.base is node.type.base
    else:
        have = node.cls if isinstance(node, Instance | Family) else None
        fits = have is not None and layout.builtin is None
        fits = fits and layout_of(have).members.keys() >= layout.members.keys() if have else fits
    if fits and isinstance(node, Leaf | Family):
        _check_sizes(element, definition, layout, node, found)
    if not fits:
        message = f"the inner `{element.name}` is no `{definition.type}`"
        known = layout_of(have).members if not isinstance(node, Leaf) and have else {}
        lacking = [n for n in layout.members if n not in known] if known else []
        hint = f"declare it as `inner {definition.type} {element.name}`"
        if lacking:
            message += f": it has no `{lacking[0]}`"
        related = [Related("it is asked for here", definition.span)]
        raise error("F263", message, place, hint=hint, related=related)


def _check_sizes(
    element: Element,
    definition: syntax.Component,
    layout: Layout,
    node: Leaf | Family,
    inner: Element,
) -> None:
    """Both are arrays of the same sizes; `:` suits any."""
    written = written_dims(element, layout)
    have = node.type.dims if isinstance(node, Leaf) else node.dims
    closed = not any(isinstance(e, syntax.Colon) for e, _ in written)
    sizes = family_dims(written, element, NO_MOD, element.name) if closed else have
    if len(written) != len(have) or sizes != have:
        message = f"the inner `{element.name}` is an array of other sizes than the outer one"
        related = [Related("the inner one", inner.definition.span)]
        raise error("F263", message, definition.span, related=related)
