"""What declarations and extends clauses say of a member that is inherited in two ways.

In:   a Layout, a member with the two parts that bring it
Out:  error F235 where both do not say the same

Compared is what is written: `extends A(k=2)` and `extends B(k=3)`, where both have their `k` of one
class. Of two ways only one could count, and nobody would see which.

Reference: Modelica Language Specification 3.6, section 7.1.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeAlias

from planarc.core.diagnostic import Related, error
from planarc.core.source import Span
from planarc.flatten.tree.nodes import Layout, Part
from planarc.ir import syntax

#: What is said of a member and of what is in it, by its path, with the place.
Said: TypeAlias = "dict[tuple[str, ...], tuple[object, Span]]"


def check_alike(layout: Layout, element: syntax.Declaration, first: int, second: int) -> None:
    """Refuse a member that two ways bring with different modifiers."""
    one, other = _said(layout, element, first), _said(layout, element, second)
    for path in dict.fromkeys((*one, *other)):
        a, b = one.get(path), other.get(path)
        if (a and a[0]) == (b and b[0]):
            continue
        name, own = element.name, layout.parts[0].cls
        ways = f"{_told(a)} from `{_way(layout, first).cls.name}`, "
        ways += f"{_told(b)} from `{_way(layout, second).cls.name}`"
        cure = "extend only one of them" if first and second else "leave the declaration out"
        raise error(
            "F235",
            f"`{own.name}` inherits `{name}` twice and not alike: {ways}",
            _way(layout, second).base_at or _way(layout, first).base_at or own.span,
            related=[Related("said here", said[1]) for said in (a, b) if said],
            hint=f"let both say the same of `{name}`, or {cure}",
        )


def _told(said: tuple[object, Span] | None) -> str:
    return f"`{' '.join(said[1].text.split())}`" if said else "unmodified"


def _way(layout: Layout, index: int) -> Part:
    """The base class, named by the class itself, through which a part comes."""
    part = layout.parts[index]
    while part.derived:
        part = layout.parts[part.derived]
    return part


def _said(layout: Layout, element: syntax.Declaration, index: int) -> Said:
    """All that is said of a member on its way, the outermost last."""
    said: Said = {}
    if isinstance(element, syntax.Component) and element.modification is not None:
        said |= _of_modification(element.modification, (element.name,), False, element.span)
    part = layout.parts[index]
    while part.derived is not None:
        clause, deriving = part.modification, layout.parts[part.derived]
        for argument in () if clause is None else clause.arguments:
            said |= _of_argument(argument, (), element.name)
        for definition in deriving.redeclarations:
            if definition.name == element.name:
                said[(element.name, "redeclare")] = definition, definition.span
        part = deriving
    return said


def _of_modification(
    modification: syntax.Modification, path: tuple[str, ...], final: bool, span: Span
) -> Iterator[tuple[tuple[str, ...], tuple[object, Span]]]:
    if modification.binding is not None or modification.broken:
        yield path, ((modification.binding, final), span)
    for argument in modification.arguments:
        yield from _of_argument(argument, path)


def _of_argument(
    argument: syntax.Argument, path: tuple[str, ...], only: str | None = None
) -> Iterator[tuple[tuple[str, ...], tuple[object, Span]]]:
    match argument:
        case syntax.ElementRedeclaration(element=element) if only in (None, element.name):
            yield (*path, element.name, "redeclare"), (element, argument.span)
        case syntax.ElementModification(name=name, modification=syntax.Modification() as value):
            if only in (None, name[0]):
                whole = (*path, *name)
                yield from _of_modification(value, whole, argument.final, argument.span)
