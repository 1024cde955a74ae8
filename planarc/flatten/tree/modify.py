"""Modifiers: from their text to a tree, merged so that the outer one wins.

In:   syntax.Modification, the Scope it is written in
Out:  Mod, each expression kept with its scope

Example, with `model A  Real x(start=1, min=0); end A;`

    A a(x(start=2))     the outer `x(start=2)` merged over `x(start=1, min=0)`
                        gives x(start=2, min=0); `2` belongs to the scope of `a`

A part of a class gets the modifier of the part that derives from it, over that of the extends
clause; a type those of its definition, `Real(unit="m")`.

Promises:  nothing is resolved here; a final modifier that is overridden is refused.
Reference: Modelica Language Specification 3.6, section 7.2.
"""

from __future__ import annotations

import re

from msgspec.structs import replace

from planarc.core.diagnostic import Related, error
from planarc.core.prose import ticked
from planarc.core.source import Span
from planarc.flatten.tree.demand import layout_of, static_instance
from planarc.flatten.tree.naming import name_span
from planarc.flatten.tree.nodes import (
    NO_MOD,
    Binding,
    Class,
    Instance,
    Layout,
    Mod,
    Part,
    Redeclaration,
    Scope,
)
from planarc.ir import syntax


def compile_modification(
    modification: syntax.Modification | None, scope: Scope, default: bool = False
) -> Mod:
    """The modifier of a declaration or an extends clause."""
    if modification is None:
        return NO_MOD
    return _compile(modification, scope, each=None, final=False, default=default)


def _compile(
    modification: syntax.Modification,
    scope: Scope,
    each: int | None,
    final: bool,
    default: bool = False,
) -> Mod:
    binding = None
    if modification.binding is not None:
        binding = Binding(
            modification.binding, scope, modification.binding.span, each, final, default=default
        )
    return Mod(
        binding,
        compile_arguments(modification.arguments, scope, each),
        None,
        final,
        modification.span,
        modification.broken,
    )


def compile_arguments(
    arguments: tuple[syntax.Argument, ...], scope: Scope, each: int | None = None
) -> dict[str, Mod]:
    """The arguments by the member that they modify; `each` is where it stands above."""
    subs: dict[str, Mod] = {}
    for argument in arguments:
        if isinstance(argument, syntax.ElementModification):
            name = argument.name[0]
            mod = _compile_element(argument, scope, _height(argument.each, each))
        else:
            assert isinstance(argument, syntax.ElementRedeclaration)  # `inherit` took the others
            name = argument.element.name
            mod = Mod(
                redeclaration=Redeclaration(
                    argument.element, scope, _height(argument.each, each), argument.final
                ),
                final=argument.final,
                span=argument.span,
            )
        subs[name] = _combine(subs[name], mod, name) if name in subs else mod
    return subs


def _height(written: bool, above: int | None) -> int | None:
    """The height of `each` above a modifier, one level further inside."""
    if written:
        return 0
    return None if above is None else above + 1


def _compile_element(argument: syntax.ElementModification, scope: Scope, each: int | None) -> Mod:
    if each is not None and not argument.each:  # written, it stands before the last name (7.2.4)
        each += len(argument.name) - 1
    if argument.modification is None:
        if not argument.final and argument.span.source.name in scope.session.own_files():
            message = f"the modifier `{argument.name[-1]}` has no value, and says nothing"
            hint = f"write `{argument.span.text} = ...`"
            scope.session.warn("F225", message, argument.span, hint)
        mod = Mod(final=argument.final, span=argument.span)
    else:
        mod = _compile(argument.modification, scope, each, argument.final)
        mod.span = argument.span
    for name in reversed(argument.name[1:]):
        mod = Mod(subs={name: mod}, span=argument.span)
    return mod


def _combine(first: Mod, second: Mod, name: str) -> Mod:
    """Two arguments for one element in one modifier: allowed when they do not overlap."""
    if (first.binding and second.binding) or (first.redeclaration and second.redeclaration):
        message = f"`{name}` is modified twice in one modifier"
        raise error("F220", message, second.span, related=[Related("first here", first.span)])
    subs = dict(first.subs)
    for key, mod in second.subs.items():
        subs[key] = _combine(subs[key], mod, key) if key in subs else mod
    return Mod(
        first.binding or second.binding,
        subs,
        first.redeclaration or second.redeclaration,
        first.final or second.final,
        first.span,
        first.broken or second.broken,
    )


def merge(outer: Mod, inner: Mod, name: str = "") -> Mod:
    """`outer` over `inner`; refuses to override what `inner` says is final."""
    if not inner:
        return outer
    if not outer:
        return inner
    if inner.final and outer is not inner:
        raise final_error(name, outer.span, inner.span)
    new, old = outer.redeclaration, inner.redeclaration
    if new is not None and (old is None or old.element is not new.element):
        return replace(outer, redeclaration=_redeclared(new, inner, name))
    if outer.binding is not None and inner.subs:
        inner = _beaten(inner)
    if not inner.subs:
        subs = outer.subs
    elif not outer.subs:
        subs = inner.subs
    else:
        subs = dict(inner.subs)
        for key, mod in outer.subs.items():
            subs[key] = merge(mod, subs[key], key) if key in subs else mod
    binding = outer.binding or (None if outer.broken else inner.binding)
    return Mod(
        binding,
        subs,
        new or old,
        outer.final or inner.final,
        outer.span or inner.span,
        outer.broken or inner.broken,
    )


def _redeclared(new: Redeclaration, inner: Mod, name: str) -> Redeclaration:
    """A redeclaration over what stands further inside, which its own modifiers override. An
    earlier one must have left the element replaceable (7.3)."""
    if inner.redeclaration is not None and new.inside.redeclaration is None:
        _check_left_replaceable(new.element, inner.redeclaration.element)
    return replace(new, inside=merge(new.inside, inner, name))


def _check_left_replaceable(new: syntax.Declaration, old: syntax.Declaration) -> None:
    if not old.prefixes.replaceable:
        message = (
            f"`{old.name}` was redeclared without `replaceable`, and cannot be redeclared again"
        )
        related = [Related("redeclared here", name_span(old))]
        hint = "write `redeclare replaceable` there"
        raise error("F241", message, name_span(new), related=related, hint=hint)


def _beaten(mod: Mod) -> Mod:
    """A modifier whose parts yield to a value of the whole that stands further outside."""
    subs = {name: sub if sub.final else _yielding(sub) for name, sub in mod.subs.items()}
    return replace(mod, subs=subs)


def _yielding(mod: Mod) -> Mod:
    """A modifier that yields itself, with its parts."""
    binding, redeclaration = mod.binding, mod.redeclaration
    if binding is not None:
        binding = replace(binding, beaten=True)
    if redeclaration is not None:
        redeclaration = replace(redeclaration, inside=_yielding(redeclaration.inside))
    return replace(_beaten(mod), binding=binding, redeclaration=redeclaration)


_MOST_FREE = 4


def final_error(name: str, outer: Span | None, inner: Span | None) -> Exception:
    message = f"`{name}` is final and cannot be modified"
    follows = re.search(r"=\s*([A-Za-z_]\w*)$", inner.text) if inner else None
    formula = re.search(r"=\s*([^=\"]*[A-Za-z_][^=\"]*)$", inner.text) if inner else None
    hint = f"set `{follows[1]}`, which it follows from" if follows else "remove the modifier"
    if formula and not follows:
        from planarc.flatten.tree.computed import settable

        shown = " ".join(formula[1].split())
        free = ticked(settable(formula[1], inner)[:_MOST_FREE]) if inner else ""
        hint = f"it is computed there, as `{shown:.60}`: set what it follows from"
        hint += f" ({free}), or " if free else ", or "
        hint += f"take a part in which `{name}` is free"
    unit = re.search(r'\bunit\s*=\s*"(.*)"$', inner.text) if inner and name == "unit" else None
    if unit:
        hint = f"values are in `{unit[1]}` here: turn yours into it, and choose what is shown by "
        hint += "`displayUnit`"
        if unit[1] == "rad":
            hint += "; `Modelica.Units.Conversions.from_deg(30)` is 30 degrees"
    return error("F221", message, outer, hint=hint, related=[Related("declared final here", inner)])


def subscript(mod: Mod, indices: tuple[int, ...], sizes: tuple[int, ...], level: int = 0) -> Mod:
    """The modifier of one member of an array of components: values are indexed, but
    for those below an `each`. `level` counts from the array."""
    if not mod:
        return mod
    binding = mod.binding
    if binding is not None and _is_split(binding.each_height, level):
        binding = replace(binding, typed=None, **_within(binding, indices, sizes))
    redeclaration = mod.redeclaration
    if redeclaration is not None:
        inside = subscript(redeclaration.inside, indices, sizes, level)
        redeclaration = replace(redeclaration, inside=inside)
        if _is_split(redeclaration.each_height, level):
            redeclaration = replace(redeclaration, **_within(redeclaration, indices, sizes))
    subs = {name: subscript(sub, indices, sizes, level + 1) for name, sub in mod.subs.items()}
    return Mod(binding, subs, redeclaration, mod.final, mod.span, mod.broken)


def _within(
    outer: Binding | Redeclaration, indices: tuple[int, ...], sizes: tuple[int, ...]
) -> dict[str, tuple[int, ...]]:
    return {"subscripts": outer.subscripts + indices, "sizes": outer.sizes + sizes}


def _is_split(each_height: int | None, level: int) -> bool:
    return each_height is None or each_height >= level


# Modifiers of parts and types ---------------------------------------------------------


def part_mod(instance: Instance, index: int) -> Mod:
    """The modifier that reaches a part: of the deriving part, over its extends clause."""
    if index == 0:
        return instance.mod
    found = instance.part_mods.get(index)
    if found is None:
        part = instance.layout.parts[index]
        assert part.derived is not None
        deriving = instance.layout.parts[part.derived]
        found = part_mod(instance, part.derived)
        scope = part.mod_scope or instance.scope(part.derived)
        place = instance.indices, instance.sizes
        if part.modification is not None or deriving.redeclarations:
            own = _extends_mod(part, deriving, scope)
            found = merge(found, member_mod(own, deriving.cls, *place))
        found = merge(found, member_mod(deriving.cls.under, deriving.cls, *place))
        found = merge(found, member_mod(part.cls.mod, part.cls, *place))
        instance.part_mods[index] = found
    return found


def member_mod(mod: Mod, cls: Class, indices: tuple[int, ...], sizes: tuple[int, ...]) -> Mod:
    """The modifier of a class for one member of an array of components: it is split over the
    sizes of the class, as in `S[3](x={1, 2, 3})`, and not over those of the component (7.2.5)."""
    count = len(layout_of(cls).dimensions) if mod and indices else 0
    return subscript(mod, indices[-count:], sizes[-count:]) if count else mod


def _extends_mod(part: Part, deriving: Part, scope: Scope) -> Mod:
    own = compile_modification(part.modification, scope)
    if not deriving.redeclarations:
        return own
    subs = dict(own.subs)
    for definition in deriving.redeclarations:
        redeclaration = Redeclaration(definition, scope, final=definition.prefixes.final)
        mod = Mod(
            redeclaration=redeclaration, final=definition.prefixes.final, span=definition.span
        )
        name = definition.name
        subs[name] = merge(mod, subs[name], name) if name in subs else mod
    return Mod(own.binding, subs, None, own.final, own.span, own.broken)


def type_mod(layout: Layout) -> Mod:
    """The modifiers of a type's own definition, `Real(unit="m")`, the outermost first."""
    if layout.type_mod is None:
        merged = NO_MOD
        mods: dict[int, Mod] = {0: NO_MOD}
        for part in layout.parts[1:]:
            assert part.derived is not None
            above = mods[part.derived]
            scope = part.mod_scope
            if scope is None:
                scope = static_instance(layout.parts[part.derived].cls).scope()
            own = compile_modification(part.modification, scope)
            own = merge(own, layout.parts[part.derived].cls.under)
            mods[part.index] = merge(merge(above, own, part.cls.name), part.cls.mod)
            merged = merge(merged, mods[part.index], part.cls.name)
        layout.type_mod = merged
    return layout.type_mod
