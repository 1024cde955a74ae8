"""The order in which the variables of a function get their first values.

The text gives none: a value may be written with variables that are declared later, as
long as they do not depend on each other (specification 12.4.4).

Example:  protected Real a = 2*b;  Real b = x + 1;     b before a

A function gives its outputs their first values before its locals. An output that is
written with a local, and a local with such an output, get them by assignments instead,
which stand before the first statement.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from msgspec.structs import replace

from planarc.core.diagnostic import Related, error
from planarc.core.order import Circle, in_order
from planarc.core.prose import both
from planarc.flatten.tree import lookup, redeclare
from planarc.flatten.tree.nodes import Binding, Instance, Mod
from planarc.ir import flat, flatwalk, syntax
from planarc.ir.syntaxwalk import nodes_of, references_in


def names_in_order(instance: Instance) -> list[str]:
    """The variables of a function, each after those with which its size and value are written.

    Raises PlanarcError F207 where some depend on each other.
    """
    members = instance.layout.members.items()
    names = [n for n, (_, d) in members if not isinstance(d, syntax.ClassDef)]
    try:
        return in_order(names, lambda name: _written_with(instance, name, names))
    except Circle as circle:
        raise _circle(circle.names, instance) from None


def _circle(names: Sequence[str], instance: Instance) -> Exception:
    spans = [instance.layout.members[n][1].span for n in names]
    verb = "depends on itself" if len(names) == 1 else "depend on each other"
    message = f"the first value{'s' if len(names) > 1 else ''} of {both(names)} {verb}"
    hint = "give one of them its value in the algorithm"
    related = [Related("and on this one", s) for s in spans[1:]]
    return error("F207", message, spans[0], related=related, hint=hint)


def _written_with(instance: Instance, name: str, names: Sequence[str]) -> Iterator[str]:
    """The names among these that stand in the sizes and the value of a variable of the function."""
    element = lookup.declared(instance, name)
    definition, scope, mod = redeclare.effective_component(element)
    sizes = names_in((definition.dimensions, definition.type_dimensions))
    yield from (n for n in sizes if n != name and n in names)  # as in `A[:, size(A, 1)]`
    for binding in _bindings(mod):  # of the variable, or of its fields
        if binding.scope is scope:
            yield from (n for n in names_in(binding.expression) if n in names)


def _bindings(mod: Mod) -> Iterator[Binding]:
    if mod.binding is not None:
        yield mod.binding
    for sub in mod.subs.values():
        yield from _bindings(sub)


def names_in(tree: object) -> list[str]:
    """First names of all references in an expression, without those of its iterators."""
    own = {node.name for node in nodes_of(tree) if isinstance(node, syntax.Iterator)}
    names = dict.fromkeys(ref.names[0] for ref in references_in(tree) if not ref.absolute)
    return [name for name in names if name not in own]


def assigned_first(
    outputs: Sequence[flat.Variable],
    locals_: Sequence[flat.Variable],
    order: Sequence[str],
    fields: Mapping[str, Sequence[flat.Statement]],
) -> tuple[list[flat.Variable], list[flat.Variable], list[flat.Statement]]:
    """Outputs and locals, and assignments in the place of values that come too late; among them
    are those to the fields of variables."""
    variables = {v.name: v for v in (*outputs, *locals_)}
    late = {v.name for v in locals_}
    moved: list[flat.Statement] = []
    set_late: set[str] = set()  # by these assignments
    for name in order:
        variable = variables.get(name)
        if fields.get(name):
            moved += fields[name]
            set_late.add(name)
        if variable is None or variable.binding is None:
            continue
        used = flatwalk.names_in((variable.binding,))
        if used.isdisjoint(set_late) and (name in late or used.isdisjoint(late)):
            continue
        target = flat.Reference(variable.type, variable.span, name)
        moved.append(flat.Assignment(variable.span, "", target, variable.binding))
        variables[name] = replace(variable, binding=None)
        set_late.add(name)
    return [variables[v.name] for v in outputs], [variables[v.name] for v in locals_], moved
