"""Local balance: which component has too many or too few equations.

In:   the instances, unknowns and equations of each, connections of each
Out:  one diagnostic that names the components whose count is off

Asked only when the model as a whole does not balance. A component is balanced when
its own unknowns equal its own equations, one for each flow variable of its own
connectors, and those that its connect equations stand for (4.7).

Reference: Modelica Language Specification 3.6, section 4.7.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from msgspec import Struct, field

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Related
from planarc.core.disjoint import DisjointSets
from planarc.core.prose import counted
from planarc.flatten.connect.connect import Connection, match_leaves
from planarc.flatten.connect.inputs import is_given, is_public_input, owner_of
from planarc.flatten.sections.equations import count_equations
from planarc.flatten.terms.conform import scalar_count
from planarc.flatten.tree.nodes import Instance, Leaf
from planarc.ir import flat, syntax
from planarc.ir.flatwalk import assigned_in, expressions_in, names_in


class Imbalance(Data):
    """The message by counting; inputs that nothing is connected to; the count as a clause."""

    problem: Diagnostic
    inputs: tuple[str, ...]
    sizes: str


class Count(Struct):
    """Unknowns and equations of one component, scalars each."""

    unknowns: Counter[str] = field(default_factory=Counter)
    equations: Counter[str] = field(default_factory=Counter)


def is_unknown(variable: flat.Variable, leaf: Leaf) -> bool:
    """A variable that an equation must determine."""
    return (
        variable.variability > flat.Variability.PARAMETER
        and variable.binding is None
        and not is_given(leaf)
    )


def names_in_equations(equations: Iterable[flat.Equation]) -> set[str]:
    """The variables that equations name, those of asserts left out."""
    real = (e for e in equations if not isinstance(e, flat.Assert | flat.Terminate))
    return names_in(expressions_in(real))


def assigned_count(algorithms: list[flat.Algorithm], leaves: dict[str, Leaf]) -> int:
    """The scalars that algorithm sections determine."""
    return sum(len_of(name, leaves) for a in algorithms for name in assigned_in(a.statements))


def len_of(name: str, leaves: dict[str, Leaf]) -> int:
    leaf = leaves.get(name)
    return 0 if leaf is None else scalar_count(leaf.type)


def check_balance(
    instances: list[Instance],
    variables: list[flat.Variable],
    equations: list[flat.Equation],
    algorithms: list[flat.Algorithm],
    connections: list[Connection],
    leaves: dict[str, Leaf],
    redundant: int,
) -> Imbalance | None:
    """An error that names the components whose count is off, None when all is well.
    `redundant` unknowns of the model's own connectors are fixed by a root outside."""
    unknown = [v for v in variables if is_unknown(v, leaves[v.name])]
    unknowns = sum(scalar_count(v.type) for v in unknown) - redundant
    known = count_equations(tuple(equations)) + assigned_count(algorithms, leaves)
    if unknowns == known:
        return None
    count = Count()
    for variable in variables:
        leaf = leaves.get(variable.name)
        if leaf is not None:
            _count_variable(variable, leaf, count)
    for equation in equations:
        if not (isinstance(equation, flat.Equality) and equation.generated):
            count.equations[equation.component] += count_equations((equation,))
    for algorithm in algorithms:
        for name in assigned_in(algorithm.statements):
            count.equations[algorithm.component] += len_of(name, leaves)
    _count_connections(connections, count)
    related = [r for i in instances if (r := _off(i, count)) is not None]
    inputs: list[flat.Variable] = []
    if known < unknowns:
        nameless, inputs = _idle(unknown, equations, algorithms, connections, leaves)
        related += [Related(f"no equation names `{v.name}`", v.span) for v in nameless[:MAX_NAMED]]
        message = "the input `{}` is not connected"
        related += [Related(message.format(v.name), v.span) for v in inputs[:MAX_NAMED]]
    kind = "many" if known > unknowns else "few"
    root = instances[0]
    sizes = f"{known} for {counted(unknowns, 'unknown')}"
    return Imbalance(
        Diagnostic(
            "F320",
            f"`{root.cls.name}` has too {kind} equations: {sizes}",
            root.cls.span,
            related=tuple(related),
        ),
        tuple(v.name for v in inputs),
        f"`{root.cls.name}` has {counted(known, 'equation')} for {counted(unknowns, 'unknown')}",
    )


def _off(instance: Instance, count: Count) -> Related | None:
    """The note about a component whose own count is off."""
    name = instance.prefix or ""
    difference = count.equations[name] - count.unknowns[name]
    if not difference or instance.is_connector or instance.is_record:
        return None
    what = f"the component `{name}` (a `{instance.cls.name}`)" if name else "the model itself"
    few = "too many" if difference > 0 else "too few"
    span = instance.element.definition.span if instance.element else instance.cls.span
    return Related(f"{what} has {counted(abs(difference), 'equation')} {few}", span)


MAX_NAMED = 5


def _idle(
    unknown: list[flat.Variable],
    equations: list[flat.Equation],
    algorithms: list[flat.Algorithm],
    connections: list[Connection],
    leaves: dict[str, Leaf],
) -> tuple[list[flat.Variable], list[flat.Variable]]:
    """Unknowns that no equation names, and inputs that nothing is connected to."""
    named = names_in_equations(equations)
    for algorithm in algorithms:
        named.update(assigned_in(algorithm.statements))
    connected = {side.name for c in connections for side in (c.left, c.right)}
    nameless = [v for v in unknown if v.name not in named]
    inputs = [
        v
        for v in unknown
        if leaves[v.name].causality is syntax.Causality.INPUT and v.name not in connected
    ]
    return [v for v in nameless if v not in inputs], inputs


def _count_variable(variable: flat.Variable, leaf: Leaf, count: Count) -> None:
    owner = owner_of(leaf)
    name = owner.prefix or ""
    size = scalar_count(leaf.type)
    if leaf.flow is syntax.Flow.FLOW:
        count.equations[name] += size
    if variable.variability <= flat.Variability.PARAMETER or variable.binding is not None:
        return
    if is_public_input(leaf):
        if owner.parent is not None:  # must be given by the component around
            count.unknowns[owner.parent.prefix or ""] += size
        return
    count.unknowns[name] += size


def _count_connections(connections: list[Connection], count: Count) -> None:
    by_component: dict[str, list[Connection]] = {}
    for connection in connections:
        by_component.setdefault(connection.component, []).append(connection)
    for component, own in by_component.items():
        sets: DisjointSets[tuple[str, bool]] = DisjointSets()
        members = {}
        for connection in own:
            for a, b in match_leaves(connection.left, connection.right, connection.span):
                members[a.key], members[b.key] = a, b
                sets.join(a.key, b.key)
        for keys in sets.sets():
            joined = [members[k] for k in keys]
            if joined[0].leaf.variability <= flat.Variability.PARAMETER:
                continue
            size = scalar_count(joined[0].type)
            if joined[0].is_flow:
                # the flow of each inside connector was credited to its own component
                inside = sum(not m.outside for m in joined)
                count.equations[component] += size * (1 - inside)
            else:
                count.equations[component] += size * (len(joined) - 1)
