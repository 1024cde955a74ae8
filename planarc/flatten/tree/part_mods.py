"""Modifiers that reach the parts of a class: those of extends clauses and of types.

Reference: Modelica Language Specification 3.6, section 7.2.
"""

from __future__ import annotations

from planarc.flatten.tree.demand import static_instance
from planarc.flatten.tree.modify import compile_modification, merge
from planarc.flatten.tree.nodes import NO_MOD, Instance, Layout, Mod, Part, Redeclaration, Scope


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
        if part.modification is not None or deriving.redeclarations:
            found = merge(found, _extends_mod(part, deriving, scope))
        found = merge(merge(found, deriving.cls.under), part.cls.mod)
        instance.part_mods[index] = found
    return found


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
