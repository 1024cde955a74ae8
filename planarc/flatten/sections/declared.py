"""What components declare of themselves: energies, sizes, points worth showing, points of contact.

In:   Instance of a class with `annotation(__planarc(...))`
Out:  flat.Declared, one for each expression, typed in the component's own scope

    energy(kinetic = E, potential = E)           stored, in J
    energy(potential(rate = P))                  stored, told by what flows in, in W
    energy(potential(rate = P) = E)              E counts where it changes by P, else P does
    energy(lossPower = P, suppliedPower = P)     turned into heat; put in from outside; in W
    size('radius of gyration' = k)               a length beside that of a mechanism, in m
    size('length without load'(of = s) = L)      the same, of what is as long as s
    point(centre = r), point = r                 a point of the plane that moves, in m
    line = d                                     from one end of a force to the other, in m
    contact = r                                  where a joint's force acts, in m
    force(normal(at = r) = f)                    a force and where it acts, in N and m; a row each
    event('sticks' = locked)                     what happens when a condition becomes true
    event('sticks'(from = sliding) = locked)     the same, where another one was true before

Example: `annotation(__planarc(energy(potential = c*s^2/2)))` in the class of `spring` becomes
    Declared("spring", "energy", "potential", spring.c*spring.s^2/2)

A class inherits what its bases declare, and what it declares itself takes the place of that.
"""

from __future__ import annotations

from collections.abc import Iterator

from planarc.core.diagnostic import PlanarcError, error
from planarc.core.nearest import did_you_mean
from planarc.core.prose import ticked
from planarc.flatten.tree.annotation import arguments_of, binding_of, find_argument, inside
from planarc.flatten.tree.nodes import Env, Instance, Layout, Part, Scope, Session
from planarc.flatten.typing.expressions import type_expression
from planarc.ir import flat, syntax

_WORD = "__planarc"
_ENERGIES = {"kinetic": "J", "potential": "J", "lossPower": "W", "suppliedPower": "W"}
_STORED = ("kinetic", "potential")
_KINDS = ("visual", "energy", "size", "point", "line", "contact", "force", "event")
_NUMBER = ("energy", "size")
_NUMBERS = (flat.Base.REAL, flat.Base.INTEGER)


def declared_of(instance: Instance) -> Iterator[flat.Declared]:
    """What the class of an instance declares; errors are kept in the session."""
    session = instance.session
    for index, foreign, kind, name, value in _told(instance.layout, session):
        try:
            typed = _typed(value, instance.scope(index), foreign)
            bases, dims = (
                ((flat.Base.BOOLEAN,), ())
                if kind == "event"
                else (_NUMBERS, () if kind in _NUMBER else (2,))
            )
            if kind == "force" and typed.type.dims[:1] == (0,):
                continue  # there are no places
            rows = kind == "force" and len(typed.type.dims) == 2
            if typed.type.base not in bases or typed.type.dims[rows:] != dims:
                raise _wrong_type(kind, name, value)
        except PlanarcError as problem:
            if not foreign:  # a library in another version may have other variables
                session.keep(problem)
            continue
        unit = unit_of(kind, name)
        yield flat.Declared(instance.prefix or "", kind, name, unit, typed, foreign)


def _typed(value: syntax.Expression, scope: Scope, foreign: bool) -> flat.Expression:
    scope.session.doubted = scope if foreign else None
    try:
        return type_expression(value, Env(scope))
    finally:
        scope.session.doubted = None


def unit_of(kind: str, name: str) -> str:
    """The unit in which something is declared."""
    if kind != "energy":
        force = kind == "force" and not name.endswith(".at")
        return "" if kind == "event" else "N" if force else "m"
    return "W" if name.endswith(".rate") else _ENERGIES[name]


def _wrong_type(kind: str, name: str, value: syntax.Expression) -> PlanarcError:
    what = "a number" if kind in _NUMBER else "a vector of two numbers"
    what = "true or false" if kind == "event" else what
    return error("F267", f"`{name or kind}` of `{_WORD}` must be {what}", value.span)


# Reading --------------------------------------------------------------------------------------

_Told = tuple[int, bool, str, str, syntax.Expression]


def _told(layout: Layout, session: Session) -> tuple[_Told, ...]:
    """Read once a class: (part, foreign, kind, name, expression)."""
    if layout.told is None:
        layout.told = ()  # its errors are told once
        found: dict[tuple[str, str], list[_Told]] = {}
        for part in layout.parts:
            for foreign, kind, name, value in _of_part(part, session):
                others = found.setdefault((kind, name), [])
                if not any(_derives(layout, o[0], part) for o in others):
                    others.append((part.index, foreign, kind, name, value))
        layout.told = tuple(told for several in found.values() for told in several)
    return layout.told


def _derives(layout: Layout, index: int, base: Part) -> bool:
    """Whether a part extends another, directly or not."""
    current: int | None = base.index
    while current is not None:
        if current == index:
            return True
        current = layout.parts[current].derived
    return False


def _of_part(part: Part, session: Session) -> Iterator[tuple[bool, str, str, syntax.Expression]]:
    arguments = arguments_of(part.definition.annotation, _WORD, session)
    foreign = False
    if not arguments:
        hidden = session.library.declaring(part.cls.name)
        arguments, foreign = arguments_of(hidden, _WORD, session), True
    for argument in inside(find_argument(arguments, _WORD)):
        try:
            for kind, name, value in _read(argument):
                yield foreign, kind, name, value
        except PlanarcError as problem:
            session.keep(problem)


def _read(argument: syntax.Argument) -> Iterator[tuple[str, str, syntax.Expression]]:
    """(kind, name, expression) of an argument of the annotation."""
    argument = _modification(argument)
    kind = _name(argument)
    if kind not in _KINDS:
        raise _unknown(kind, _KINDS, argument)
    if kind == "visual":
        return
    value = binding_of(argument)
    if value is not None:
        if kind == "energy":
            raise error("F267", "say which energy: `energy(kinetic = ...)`", argument.span)
        if kind == "event":
            raise error("F267", "say what happens: `event('sticks' = ...)`", argument.span)
        if kind == "size":
            raise error("F267", "say which size: `size('length L' = ...)`", argument.span)
        yield kind, "", value
    for inner in map(_modification, inside(argument)):
        name = _name(inner)
        if kind == "energy":
            yield from _energy(name, inner)
        elif kind in _WORDED:
            yield from _worded(kind, name.strip("'"), inner)
        elif kind == "force":
            yield from _force(name, inner)
        elif own := binding_of(inner):
            yield kind, name, own


def _energy(
    name: str, argument: syntax.ElementModification
) -> Iterator[tuple[str, str, syntax.Expression]]:
    if name not in _ENERGIES:
        raise _unknown(name, tuple(_ENERGIES), argument)
    value = binding_of(argument)
    if value is not None:
        yield "energy", name, value
    for inner in map(_modification, inside(argument)):
        rate = binding_of(inner)
        if name not in _STORED or _name(inner) != "rate" or rate is None:
            raise _unknown(_name(inner), ("rate",) if name in _STORED else (), inner)
        yield "energy", f"{name}.rate", rate


def _force(
    name: str, argument: syntax.ElementModification
) -> Iterator[tuple[str, str, syntax.Expression]]:
    force = binding_of(argument)
    inner = map(_modification, inside(argument))
    places = [place for i in inner if _name(i) == "at" and (place := binding_of(i))]
    if force is None or not places:
        raise error("F267", f"say what acts where: `force({name}(at = ...) = ...)`", argument.span)
    yield from (("force", name, force), ("force", f"{name}.at", places[0]))


#: What is told in words: what is asked where a value is missing, and what else may be said.
_WORDED = {"event": ("say when", "from"), "size": ("say how large", "of")}


def _worded(
    kind: str, text: str, argument: syntax.ElementModification
) -> Iterator[tuple[str, str, syntax.Expression]]:
    missing, other = _WORDED[kind]
    value = binding_of(argument)
    if value is None:
        raise error("F267", f"{missing}: `{kind}('{text}' = ...)`", argument.span)
    yield kind, text, value
    for inner in map(_modification, inside(argument)):
        more = binding_of(inner)
        if _name(inner) != other or more is None:
            raise _unknown(_name(inner), (other,), inner)
        yield kind, f"{text}.{other}", more


def _modification(argument: syntax.Argument) -> syntax.ElementModification:
    if isinstance(argument, syntax.ElementModification):
        return argument
    hint = "write `name = value`"
    raise error("F267", f"`{_WORD}` takes no redeclaration", argument.span, hint=hint)


def _name(argument: syntax.ElementModification) -> str:
    return ".".join(argument.name)


def _unknown(name: str, known: tuple[str, ...], argument: syntax.Argument) -> PlanarcError:
    hint = did_you_mean(name, known) or (f"it knows {ticked(known)}" if known else "leave it out")
    return error("F267", f"`{_WORD}` knows no `{name}` here", argument.span, hint=hint)
