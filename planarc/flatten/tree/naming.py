"""Messages about names: what is not there, and what the user may have meant."""

from __future__ import annotations

from collections.abc import Iterable

from planarc.core.diagnostic import Once, PlanarcError, error
from planarc.core.nearest import did_you_mean
from planarc.core.source import Span
from planarc.flatten.tree import predefined
from planarc.flatten.tree.demand import static_instance
from planarc.flatten.tree.nodes import Class, Instance, Scope
from planarc.ir import syntax


def name_span(element: syntax.Declaration) -> Span:
    """The place of a declared name."""
    return element.name_span if isinstance(element, syntax.ClassDef) else element.span


def unknown(scope: Scope, name: str, span: Span, what: str = "name") -> PlanarcError:
    where = scope.instance.cls.name
    hint = did_you_mean(name, names_in_sight(scope))
    return error(
        "F210",
        f"unknown {what} `{name}`" + (f" in `{where}`" if where else ""),
        span,
        hint=f"write `{_CONSTANTS[name]}`" if name in _CONSTANTS else hint,
    )


#: Names that need their package before them.
_CONSTANTS = {"pi": "Modelica.Constants.pi", "PI": "Modelica.Constants.pi"}


def missing_member(cls: Class, name: str, span: Span) -> PlanarcError:
    message = f"`{cls.name}` has no element `{name}`"
    if (cls.name, name) == ("Modelica.Mechanics", "MultiBody"):
        hint = (
            "mechanisms are planar here: write `PlanarMultiBody` for `Modelica.Mechanics.MultiBody`"
        )
        return PlanarcError(Once("F213", message, span, hint=hint, kind="MultiBody"))
    return error("F213", message, span, hint=did_you_mean(name, member_names(static_instance(cls))))


def not_modifiable(owner: str, name: str, span: Span | None, names: Iterable[str]) -> PlanarcError:
    message = f"`{owner}` has no element `{name}` to modify"
    return error("F222", message, span, hint=did_you_mean(name, names))


def names_in_sight(scope: Scope) -> list[str]:
    names: list[str] = []
    current: Scope | None = scope
    while current is not None:
        names += sorted(current.part.visible)
        for clause in current.part.imports:
            names += clause.names or ([] if clause.wildcard else [clause.alias or clause.path[-1]])
        for entry in current.part.entries:
            names += entry.child_names()
        current = None if current.part.definition.encapsulated else current.parent
    return [*names, *predefined.NAMES]


def member_names(instance: Instance) -> list[str]:
    names = list(instance.layout.members)
    if instance.layout.builtin is not None:
        names += instance.layout.builtin.literals
    for part in instance.layout.parts:
        if part.cls.entry is not None and part.cls.entry.open:
            names += part.cls.entry.child_names()
    return names
