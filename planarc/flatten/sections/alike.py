"""Equal parts once: a component like one beside it gives the same pieces with other names.

In:   an Instance of a model, met by the walk over the tree; what the last one of its kind gave
Out:  Copied, the same with the names changed, or None where it is not like that one

Two components of one owner are of a kind when their classes are the same and their modifiers
say something of the same names. They are alike when, besides, each question that was asked of
the variables of one while it was opened has the same answer in the other: the sizes,
conditions and choices that shape it are the same then, whatever they depend on.

Of a copy are opened: its components, with their connections; the variables of its connectors,
which are joined to others; and what is modified from outside, which has values of its own. All
other variables stay closed until somebody asks for them (`lookup.leaf_named`).

Example: of `Revolute rev[80](phi(each start=0))` all is opened of `rev[1]`; of the others the
frames and `phi`. The law of `rev[2]` is that of `rev[1]` with other names.

Promises:  the flat model, and every message, are those of components opened one by one; where an
           error is found, they are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import takewhile
from typing import Any, TypeAlias

from msgspec import Struct, field

from planarc.core.diagnostic import PlanarcError
from planarc.core.source import Span
from planarc.flatten.refusal import TooLarge
from planarc.flatten.sections.home import ToldAtHome
from planarc.flatten.sections.visuals import visual_of
from planarc.flatten.terms.constant import NotConstant
from planarc.flatten.tree.demand import node_of
from planarc.flatten.tree.lookup import declared, leaf_named
from planarc.flatten.tree.nodes import (
    Element,
    Family,
    Instance,
    Leaf,
    Mod,
    Node,
    Question,
    Scope,
    Session,
)
from planarc.flatten.tree.redeclare import inner_half
from planarc.flatten.values.evaluator import Evaluator
from planarc.ir import flat, syntax
from planarc.ir.renaming import Repeater, Unrepeatable

_MODELS = (syntax.ClassKind.MODEL, syntax.ClassKind.BLOCK, syntax.ClassKind.CLASS)


class Likeness(Struct, eq=False):
    """A component, or one in it, and its counterpart; the names of both begin with prefixes."""

    first: Instance
    old: str
    new: str

    def name(self, old: str) -> str:
        return self.new + old[len(self.old) :]


class Twin(Struct, eq=False):
    """A variable of a copy, whose pieces are those of another one with other names."""

    first: Variable
    name: str
    parent: Instance
    likeness: Likeness
    element: Element  # of the first one

    @property
    def leaf(self) -> Leaf:
        found = leaf_named(self.parent.session, self.name)
        assert found is not None
        return found

    @property
    def known(self) -> Leaf | None:
        """The variable where it is open."""
        return self.parent.session.leaves.get(self.name)

    @property
    def span(self) -> Span:
        return self.element.definition.span


Variable: TypeAlias = "Leaf | Twin"


class Drawing(Struct, eq=False):
    """A visual, the instance that it is declared in, and its name there."""

    visual: flat.Visual
    parent: Instance
    element: Element


class Parts(Struct, eq=False):
    """What the walk finds in the model, or in one component of it."""

    instances: list[Instance] = field(default_factory=list)
    leaves: list[Variable] = field(default_factory=list)
    drawings: list[Drawing] = field(default_factory=list)


class Opened(Struct, eq=False):
    """A component that was opened, and all that was found in it."""

    root: Instance
    parts: Parts
    questions: list[tuple[Leaf, bool]]
    count: int  # of the components made
    #: variables and visuals of which somebody outside says something: each copy has its own
    given: set[str]
    joined: set[str]  # variables that are opened in each copy, too


# Components of one kind -----------------------------------------------------------------


def kind_of(node: Instance) -> Any:
    """What components that may be alike have in common; None for what is opened by itself."""
    element = node.element
    if element is None or node.parent is None or node.prefix is None or node.drawn:
        return None
    if node.layout.dimensions:
        return None  # its class gives each member values of its own, as `S[2](x={1, 2})`
    prefixes = element.definition.prefixes
    if node.layout.kind not in _MODELS or prefixes.inner or prefixes.outer:
        return None
    own = (id(node.parent), id(node.cls), node.variability, node.hidden, prefixes.final)
    return own, _shape(node.mod, node.session.inner_classes)


def _shape(mod: Mod, classes: set[str], of_class: bool = False) -> Any:
    """A modifier without the values that it gives. Those that it gives to `classes` belong to it:
    whatever is made of the class may have them, under any name."""
    binding, new = mod.binding, mod.redeclaration
    value = binding and (
        binding.each_height,
        binding.final,
        binding.default,
        binding.beaten,
        id(binding.scope.instance),
        of_class and (id(binding.expression), binding.subscripts),
    )
    redeclared = new and (
        id(new.element),
        id(new.scope),
        new.each_height,
        new.final,
        new.subscripts,
        _shape(new.inside, classes, of_class),
    )
    subs = tuple([(n, _shape(m, classes, of_class or n in classes)) for n, m in mod.subs.items()])
    return value, redeclared, mod.final, mod.broken, subs


class Opening(Struct, eq=False):
    """A component that is being opened: where its parts begin."""

    root: Instance
    begin: tuple[int, int, int, int, int, int]

    @classmethod
    def of(cls, root: Instance, parts: Parts) -> Opening:
        return cls(root, _counts(parts, root.session))

    def close(self, parts: Parts) -> Opened | None:
        """What was found since; None where copies could differ from it."""
        session = self.root.session
        instance, leaf, drawing, question, errors, count = self.begin
        asked = session.asked[question:]
        if len(session.errors) > errors or None in asked:
            return None
        found = Parts(parts.instances[instance:], parts.leaves[leaf:], parts.drawings[drawing:])
        if any(i.layout.kind is syntax.ClassKind.EXPANDABLE_CONNECTOR for i in found.instances):
            return None
        inside = within(asked, self.root.name)
        members: list[tuple[str, Variable | Drawing]] = [(v.name, v) for v in found.leaves]
        members += [(d.visual.component, d) for d in found.drawings]
        given = {n for n, m in members if _is_given(m.parent, m.element.name, self.root.depth)}
        joined = {v.name for v in found.leaves if _is_joined(v)}
        return Opened(self.root, found, inside, session.component_count - count, given, joined)


def _counts(parts: Parts, session: Session) -> tuple[int, int, int, int, int, int]:
    return (
        len(parts.instances),
        len(parts.leaves),
        len(parts.drawings),
        len(session.asked),
        len(session.errors),
        session.component_count,
    )


def _is_joined(variable: Variable) -> bool:
    """A variable that others may be connected to, or find by its name alone."""
    while isinstance(variable, Twin):
        variable = variable.first
    owner = next((i for i in variable.parent.outwards() if not i.is_record), variable.parent)
    return (
        owner.is_connector
        or variable.is_connector
        or variable.causality is not syntax.Causality.NONE
        or variable.flow is not syntax.Flow.NONE
        or variable.element.definition.prefixes.inner
    )


# Copies ---------------------------------------------------------------------------------


class Copies(Struct, eq=False):
    """The components of a model that are like others, and what was opened last of each kind."""

    last: dict[Any, Opened | None] = field(default_factory=dict)
    likeness: dict[Instance, Likeness] = field(default_factory=dict)
    repeat: Repeater = field(default_factory=Repeater)
    #: components, variables and visuals whose pieces are those of others with other names
    repeated: set[str] = field(default_factory=set)
    #: variables of copies that have values of their own, and those of the first ones
    given: list[tuple[str, str]] = field(default_factory=list)

    def copy(self, node: Instance, kind: Any) -> Parts | None:
        """The parts of a component that is like an earlier one; None for another one."""
        first = self.last.get(kind)
        if first is None:
            return None
        session = node.session
        count = session.component_count
        counterparts = _counterparts(node, first)
        if counterparts is None:
            return None

        def own(leaf: Leaf) -> Node | None:
            parent = counterparts.get(leaf.parent)
            return None if parent is None else _open(parent, leaf.element.name)

        if not are_answered_alike(first.questions, own):
            return None
        parts = self._parts(first, node, counterparts)
        if parts is not None:
            session.component_count = count + first.count
        return parts

    def _parts(
        self, first: Opened, node: Instance, counterparts: dict[Instance, Instance]
    ) -> Parts | None:
        likenesses = {i: Likeness(i, first.root.name, node.name) for i in counterparts}
        found = Parts(list(counterparts.values()))
        for variable in first.parts.leaves:
            parent, element = counterparts[variable.parent], variable.element
            given = variable.name in first.given
            if given or variable.name in first.joined:
                leaf = _open(parent, element.name)
                if not isinstance(leaf, Leaf) or not _is_same(leaf, variable):
                    return None
                if given:
                    self.given.append((leaf.name, variable.name))
                    found.leaves.append(leaf)
                    continue
            likeness = likenesses[variable.parent]
            name = likeness.name(variable.name)
            node.session.closed[name] = parent, element.name
            found.leaves.append(Twin(variable, name, parent, likeness, element))
        for drawing in first.parts.drawings:
            parent, likeness = counterparts[drawing.parent], likenesses[drawing.parent]
            visual = self._visual(drawing, parent, likeness, first)
            if visual is None:
                return None
            found.drawings.append(Drawing(visual, parent, drawing.element))
        self.likeness |= zip(counterparts.values(), likenesses.values(), strict=True)
        return found

    def _visual(
        self, drawing: Drawing, parent: Instance, likeness: Likeness, first: Opened
    ) -> flat.Visual | None:
        name = drawing.visual.component
        if name in first.given:
            own = _member(parent, drawing.element.name, likeness.name(name))
            return None if own is None else visual_of(own)
        try:
            visual = self.repeat(name, drawing.visual, likeness.old, likeness.new)
        except Unrepeatable:
            return None
        self.repeated.add(visual.component)
        return visual


def _counterparts(node: Instance, first: Opened) -> dict[Instance, Instance] | None:
    """The components in a component by those of the first one, each after what it is in."""
    found = {first.root: node}
    likeness = Likeness(first.root, first.root.name, node.name)
    for old in first.parts.instances[1:]:
        owner = None if old.parent is None else found.get(old.parent)
        if owner is None or old.element is None:
            return None
        new = _member(owner, old.element.name, likeness.name(old.name))
        if new is None or not _is_of_kind(old, new):
            return None
        found[old] = new
    return found


def _is_of_kind(old: Instance, new: Instance) -> bool:
    return (
        new.cls is old.cls
        and new.variability is old.variability
        and new.hidden is old.hidden
        and new.causality is old.causality
        and new.flow is old.flow
    )


def _member(owner: Instance, element: str, name: str) -> Instance | None:
    """A component in another one, maybe in an array of such."""
    node = _open(owner, element)
    if isinstance(node, Family):
        node = next((item for item in node.items if item.name == name), None)
    return node if isinstance(node, Instance) and node.name == name else None


def _open(owner: Instance, name: str) -> Node | None:
    try:
        with ToldAtHome(owner):
            return node_of(inner_half(declared(owner, name)))
    except TooLarge:
        raise
    except PlanarcError as problem:
        owner.session.keep(problem)
        return None


def _is_same(leaf: Leaf, first: Variable) -> bool:
    other = first if isinstance(first, Leaf) else first.leaf
    return leaf.type == other.type and leaf.variability is other.variability


def _is_given(instance: Instance, name: str, depth: int) -> bool:
    """Whether somebody outside of the component of that depth says something of a member."""
    if _is_from_outside(instance.mod.sub(name), depth):
        return True
    around = takewhile(lambda i: i.depth >= depth, instance.outwards())
    return any(i.mod.binding is not None and _is_outer(i.mod.binding.scope, depth) for i in around)


def _is_from_outside(mod: Mod, depth: int) -> bool:
    said = (mod.binding, mod.redeclaration)
    if any(s is not None and _is_outer(s.scope, depth) for s in said):
        return True
    if mod.redeclaration is not None and _is_from_outside(mod.redeclaration.inside, depth):
        return True
    return any(_is_from_outside(sub, depth) for sub in mod.subs.values())


def _is_outer(scope: Scope, depth: int) -> bool:
    return scope.instance.prefix is not None and scope.instance.depth < depth


# Questions ------------------------------------------------------------------------------


def within(asked: Iterable[Question], component: str) -> list[tuple[Leaf, bool]]:
    """Questions to the variables of a component, each once."""
    prefix = component + "."
    return [q for q in dict.fromkeys(asked) if q is not None and q[0].name.startswith(prefix)]


def are_answered_alike(
    questions: Iterable[tuple[Leaf, bool]], counterpart: Callable[[Leaf], Node | None]
) -> bool:
    """Whether the counterparts of variables have the same values, as far as was asked."""
    for leaf, mark in questions:
        own = counterpart(leaf)
        if not isinstance(own, Leaf) or _answer(own, mark) != _answer(leaf, mark):
            return False
    return True


def _answer(leaf: Leaf, mark: bool) -> str | None:
    """The value as it is shown, which tells 1 from 1.0 and 0.0 from -0.0; None: it has none."""
    session = leaf.parent.session
    try:
        with ToldAtHome(leaf.parent):
            return repr(Evaluator(session, mark).leaf_value(leaf))
    except NotConstant:
        return None
    except PlanarcError as problem:
        session.keep(problem)
        return "an error"
