"""Inheritance: what a class consists of, its base classes taken in.

In:   Class
Out:  Layout   parts (the class and its bases), members in order of declaration

Base classes cannot be replaced, so a layout is the same for all instances of a
class and is made once. Modifiers of extends clauses are not applied here; each
part remembers its own, and an instance resolves them (`modify.part_mod`).

Example:
    model B  extends A(x=1); Real y; end B;      parts 0: B, 1: A (derived by 0)
    type Angle = Real(unit="rad");               parts 0: Angle, 1: Real; builtin Real

Promises:  a cyclic `extends` is refused; one name from two bases must have one
           declaration.
Reference: Modelica Language Specification 3.6, sections 4.5 and 7.1.
"""

from __future__ import annotations

from typing import cast

from msgspec.structs import replace

from planarc.core.diagnostic import Related, error
from planarc.core.nearest import nearest
from planarc.core.source import Span
from planarc.flatten.tree import lookup
from planarc.flatten.tree.demand import layout_of, session_of, static_instance
from planarc.flatten.tree.environment import check_alike
from planarc.flatten.tree.naming import name_span, not_modifiable
from planarc.flatten.tree.nodes import Class, Layout, Part, Scope
from planarc.ir import flat, syntax

MAX_PARTS = 2000
#: Classes whose text does not know `time` (3.6.7), and may call something of their own so.
TIMELESS = (syntax.ClassKind.RECORD, syntax.ClassKind.CONNECTOR, syntax.ClassKind.FUNCTION)


def make_layout(cls: Class) -> Layout:
    """Fill in the layout of a class."""
    cls.layout = Layout([], {}, kind=cls.definition.kind)
    try:
        _fill(cls.layout, cls)
    except BaseException:
        cls.layout = None
        cls.static = None
        raise
    cls.layout.done = True
    session = session_of(cls)
    session.opened.append(cls)
    if cls.layout.kind is not syntax.ClassKind.PACKAGE:
        members = cls.layout.members.items()
        session.inner_classes |= {n for n, (_, d) in members if isinstance(d, syntax.ClassDef)}
    return cls.layout


def _fill(layout: Layout, cls: Class) -> None:
    part = Part(cls, 0, {})
    layout.parts.append(part)
    body = cls.definition.body
    match body:
        case syntax.Composition():
            _take_composition(layout, part, body)
        case syntax.ExtendsClass():
            _take_class_extends(layout, part, body)
        case syntax.ShortClass():
            _take_short_class(layout, part, body)
        case syntax.Enumeration():
            names = _literal_names(body)
            layout.builtin = flat.Type(flat.Base.ENUMERATION, (), cls.name, names)
        case syntax.DerivativeClass():
            assert cls.parent is not None
            layout.derivative = (body, cls.parent)


def _take_composition(layout: Layout, part: Part, body: syntax.Composition) -> None:
    entry = part.cls.entry
    if entry is not None and entry.open:
        part.entries.append(entry)
    imports = []
    redeclarations: list[syntax.Declaration] = []
    for element in body.elements:
        if isinstance(element, syntax.Import):
            imports.append(element)
        elif isinstance(element, syntax.Extends):
            continue
        elif element.prefixes.redeclare or (
            isinstance(element, syntax.ClassDef) and isinstance(element.body, syntax.ExtendsClass)
        ):
            redeclarations.append(element)
        else:
            _check_single(part, element)
            part.own[element.name] = element
            part.visible.add(element.name)
    part.imports = tuple(imports)
    part.redeclarations = tuple(redeclarations)
    for element in body.elements:
        if isinstance(element, syntax.Extends):
            scope = static_instance(part.cls).scope()
            base = lookup.find_class(scope, element.base)
            _check_base(part, element, scope)
            modification = element.modification
            _take_base(layout, part, base, modification, None, element.protected, element.span)
        elif not isinstance(element, syntax.Import) and part.own.get(element.name) is element:
            _add_member(layout, element.name, part.index, element)
    for definition in redeclarations:
        _check_redeclared(layout, part, definition)


def _check_base(part: Part, clause: syntax.Extends, scope: Scope) -> None:
    """A base class is always the same one: not replaceable, nor in a package that is, nor inherited
    itself (7.1.4)."""
    name = clause.base.names[0]
    for step, cls in zip(
        clause.base.names, lookup.classes_of_path(scope, clause.base), strict=True
    ):
        if cls.definition.prefixes.replaceable:
            message = f"`{clause.base}` is no base class: `{step}` is replaceable"
            if step == clause.base.names[-1]:
                message = f"`{clause.base}` is replaceable, and so no base class"
            raise error("F238", message, clause.span, related=[Related("declared here", cls.span)])
    if not clause.base.absolute and name in part.visible and name not in part.own:
        message = f"`{name}` is inherited itself, and so no base class of `{part.cls.name}`"
        raise error("F238", message, clause.span, hint="write its full name")


def _check_single(part: Part, element: syntax.Declaration) -> None:
    if element.name == "time" and part.definition.kind not in TIMELESS:
        message = "`time` is the time of the run, which every model has: it cannot be declared"
        hint = "choose another name, or leave the declaration out and read `time`"
        raise error("F229", message, name_span(element), hint=hint)
    if element.name in part.own:
        message = f"`{element.name}` is declared twice in `{part.cls.name}`"
        related = [Related("first here", name_span(part.own[element.name]))]
        meant = _section_meant(element)
        raise error("F231", message, name_span(element), hint=meant, related=related)


#: Letters that a misspelt section shares with the one that is meant.
_ALMOST = 0.8


def _section_meant(element: syntax.Declaration) -> str | None:
    """What is meant by `equations`, of which the line below makes the type of a variable."""
    if not isinstance(element, syntax.Component) or len(element.type.names) > 1:
        return None
    word = element.type.names[0]
    alone = element.type.span.line != name_span(element).line
    near = nearest(word.lower(), ("equation", "algorithm"), 1, _ALMOST) if alone else []
    return f"write `{near[0]}`, if that is what `{word}` means" if near else None


def _take_base(
    layout: Layout,
    part: Part,
    base: Class,
    modification: syntax.Modification | None,
    mod_scope: Scope | None,
    protected: bool,
    span: Span,
) -> None:
    """Append the parts of a base class, which keep their order, behind those here."""
    known = layout_of(base)
    if not known.done:
        hint = None
        if base is part.cls:
            hint = f"name another class in full, as in `extends Package.{base.definition.name}`"
        raise error("F232", f"`{base.name}` extends itself", span, hint=hint)
    if modification is not None:
        modification, left_out, cut = _deselected(modification, known, base)
    else:
        left_out, cut = frozenset[str](), ()
    offset = len(layout.parts)
    if offset + len(known.parts) > MAX_PARTS:
        raise error("F230", f"`{part.cls.name}` has too many base classes", span)
    for inner in known.parts:
        first = inner.derived is None
        copy = replace(
            inner,
            index=inner.index + offset,
            derived=part.index if first else cast(int, inner.derived) + offset,
            protected=inner.protected or protected,
            visible=inner.visible - left_out,
            left_out=inner.left_out | left_out,
            cut=(*inner.cut, *cut),
        )
        if first:
            copy.modification, copy.mod_scope, copy.base_at = modification, mod_scope, span
        layout.parts.append(copy)
    for name, (index, element) in known.members.items():
        if name not in left_out:
            _add_member(layout, name, index + offset, element)
    _check_names(modification, known, base)
    part.visible |= known.parts[0].visible - left_out
    part.entries += known.parts[0].entries
    if known.builtin is not None:
        _take_builtin(layout, known, span)
    layout.dimensions += known.dimensions
    if layout.causality is syntax.Causality.NONE:
        layout.causality = known.causality
    if layout.flow is syntax.Flow.NONE:
        layout.flow = known.flow
    if layout.kind in _OPEN_KINDS and known.kind not in _OPEN_KINDS:
        layout.kind = known.kind
    layout.derivative = layout.derivative or known.derivative


def _deselected(
    modification: syntax.Modification, known: Layout, base: Class
) -> tuple[syntax.Modification, frozenset[str], tuple[syntax.Connect, ...]]:
    """What is not inherited of a base class (7.4): components, with all that is connected to
    them, and single connections; and the rest of the modification."""
    left_out: set[str] = set()
    cut: list[syntax.Connect] = []
    rest: list[syntax.Argument] = []
    for argument in modification.arguments:
        if not isinstance(argument, syntax.Deselection):
            rest.append(argument)
        elif isinstance(argument.target, syntax.Connect):
            if argument.target not in _connections(known):
                text = argument.target.span.text
                message = f"`{base.name}` has no `{text}` to leave out"
                raise error("F222", message, argument.span)
            cut.append(argument.target)
        elif isinstance(known.members.get(argument.target, (0, None))[1], syntax.Component):
            left_out.add(argument.target)
        else:
            raise not_modifiable(base.name, argument.target, argument.span, known.members)
    return replace(modification, arguments=tuple(rest)), frozenset(left_out), tuple(cut)


def _connections(known: Layout) -> list[syntax.Equation]:
    sections = (s for part in known.parts for s in part.definition.sections)
    return [e for s in sections if isinstance(s, syntax.EquationSection) for e in s.equations]


def _check_names(modification: syntax.Modification | None, known: Layout, base: Class) -> None:
    """Refuse modifiers of elements that the base class does not have."""
    if modification is None or known.builtin is not None:
        return
    for argument in modification.arguments:
        if isinstance(argument, syntax.ElementModification):
            name = argument.name[0]
        elif isinstance(argument, syntax.ElementRedeclaration):
            name = argument.element.name
        else:
            continue
        if name not in known.members and not known.parts[0].is_in_file(name):
            raise not_modifiable(base.name, name, argument.span, known.members)


#: a class of these kinds that extends one of a more special kind is of that kind
_OPEN_KINDS = (syntax.ClassKind.CLASS, syntax.ClassKind.MODEL, syntax.ClassKind.TYPE)


def _take_class_extends(layout: Layout, part: Part, body: syntax.ExtendsClass) -> None:
    """`redeclare model extends M(...)`: the inherited `M` is the first base."""
    original = part.cls.original
    name = part.cls.definition.name
    if original is None:
        raise error("F233", f"there is no inherited class `{name}` to extend", part.cls.span)
    _take_base(layout, part, original, body.modification, None, False, part.cls.span)
    _take_composition(layout, part, body.composition)


def _take_short_class(layout: Layout, part: Part, body: syntax.ShortClass) -> None:
    scope = part.cls.parent
    assert scope is not None
    base = lookup.find_class(scope, body.base)
    if base.definition is part.cls.definition:
        if part.cls.original is None:
            raise error("F232", f"`{base.name}` is defined as itself", body.span)
        base = part.cls.original
    layout.dimensions += tuple((d, scope) for d in body.dimensions)
    layout.causality, layout.flow = body.causality, body.flow
    _take_base(layout, part, base, body.modification, scope, False, body.span)


def _literal_names(body: syntax.Enumeration) -> tuple[str, ...]:
    names: dict[str, None] = {}
    for literal in body.literals or ():
        if literal.name in names:
            raise error("F231", f"the literal `{literal.name}` is declared twice", literal.span)
        names[literal.name] = None
    return tuple(names)


def _take_builtin(layout: Layout, known: Layout, span: Span) -> None:
    if layout.builtin is not None and layout.builtin != known.builtin:
        raise error("F234", "a class cannot extend two different built-in types", span)
    layout.builtin = known.builtin


def _add_member(layout: Layout, name: str, index: int, element: syntax.Declaration) -> None:
    slot = layout.members.get(name)
    if slot is None:
        layout.members[name] = (index, element)
        return
    if slot[1] is element or _without_text(slot[1]) == _without_text(element):
        check_alike(layout, element, slot[0], index)
        return
    message = f"`{layout.parts[0].cls.name}` gets two different declarations of `{name}`"
    hint = "declare it in one class only, or make both declarations equal"
    hint = _as_modifier(layout, (slot, (index, element))) or hint
    related = [Related("the other one", name_span(slot[1]))]
    raise error("F235", message, name_span(element), related=related, hint=hint)


def _as_modifier(layout: Layout, both: tuple[tuple[int, syntax.Declaration], ...]) -> str | None:
    """The hint where a class declares again what it inherits, only to give it a value."""
    (index, inherited), (own_index, own) = sorted(both, key=lambda slot: slot[0] == 0)
    if own_index != 0 or index == 0:
        return None
    if not isinstance(own, syntax.Component) or not isinstance(inherited, syntax.Component):
        return None
    value = own.modification.binding if own.modification is not None else None
    if value is None or str(own.type) != str(inherited.type):
        return None
    base = layout.parts[index].cls.name.rpartition(".")[2]
    return (
        f"`{own.name}` is inherited: to give it another value, leave the declaration out and write "
        f"`extends {base}({own.name} = {' '.join(value.span.text.split())})`"
    )


def _without_text(element: syntax.Declaration) -> syntax.Declaration:
    """A declaration without what does not tell two apart: description and annotation (7.1)."""
    if isinstance(element, syntax.Component):
        return replace(element, comment="", annotation=None)
    return element


def _check_redeclared(layout: Layout, part: Part, definition: syntax.Declaration) -> None:
    name = definition.name
    _, old = layout.members.get(name, (0, None))
    if old is not None and _is_protected(layout, name) != definition.prefixes.protected:
        was, now = (
            ("protected", "public") if _is_protected(layout, name) else ("public", "protected")
        )
        message = f"`{name}` is {was} and cannot be redeclared as {now}"
        related = [Related("declared here", name_span(old))]
        raise error("F242", message, name_span(definition), related=related)
    if name in layout.members or part.is_in_file(name):
        return
    message = f"no base class of `{part.cls.name}` declares `{name}` to be redeclared"
    raise error("F236", message, name_span(definition))


def _is_protected(layout: Layout, name: str) -> bool:
    index, element = layout.members[name]
    return element.prefixes.protected or layout.parts[index].protected
