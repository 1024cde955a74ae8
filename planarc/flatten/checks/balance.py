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
from collections.abc import Collection, Iterable, Sequence
from typing import TYPE_CHECKING

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Miscounted, Related, Undecided
from planarc.core.disjoint import DisjointSets
from planarc.core.prose import both, counted, shortened
from planarc.core.source import Span
from planarc.flatten.connect.connect import Connection, Member, match_leaves
from planarc.flatten.connect.inputs import is_public_input, owner_of
from planarc.flatten.sections.equations import count_equations
from planarc.flatten.sections.gather import Gathered
from planarc.flatten.terms.conform import scalar_count
from planarc.flatten.tree.lookup import leaf_named
from planarc.flatten.tree.nodes import Instance, Leaf, Session
from planarc.ir import flat, syntax
from planarc.ir.flatwalk import assigned_in, expressions_in, names_in

if TYPE_CHECKING:
    from planarc.flatten.checks.passed_over import Absent


class Lack(Data):
    """A component whose class has too few equations, `missing` of them. `flows` are those of its
    own connectors; `given` is what these, and inputs, have from others; `free` are connectors that
    nothing inside of it uses."""

    component: str
    class_name: str
    class_span: Span
    span: Span
    missing: int
    flows: frozenset[str]
    given: frozenset[str]
    free: tuple[str, ...] = ()


class Imbalance(Data):
    """The message by counting; inputs that nothing is connected to; the count as a clause; the
    component that lacks equations, and the one that has too many, where it is one; and what
    stands in branches that parameters pass over."""

    problem: Diagnostic
    inputs: tuple[str, ...]
    sizes: str
    lack: Lack | None = None
    suspect: str | None = None
    absent: tuple[Absent, ...] = ()


#: Equations less unknowns of each component, scalars each.
Excess = Counter[str]


def is_unknown(variable: flat.Variable) -> bool:
    """A variable that an equation must determine, and no input of the model."""
    varies = variable.variability > flat.Variability.PARAMETER
    return varies and variable.binding is None and variable.causality != _INPUT


_INPUT = syntax.Causality.INPUT.value


def names_in_equations(equations: Iterable[flat.Equation]) -> set[str]:
    """The variables that equations name, those of asserts left out."""
    real = (e for e in equations if not isinstance(e, flat.Assert | flat.Terminate))
    return names_in(expressions_in(real))


def check_balance(
    found: Gathered,
    variables: list[flat.Variable],
    equations: list[flat.Equation],
    session: Session,
    redundant: int,
) -> Imbalance | None:
    """An error that names the components whose count is off, None when all is well.
    `redundant` unknowns of the model's own connectors are fixed by a root outside."""
    targets = ((a.component, n) for a in found.algorithms for n in assigned_in(a.statements))
    found_leaves = ((component, leaf_named(session, name)) for component, name in targets)
    assigned = [(component, leaf) for component, leaf in found_leaves if leaf is not None]
    unknown = [v for v in variables if is_unknown(v)]
    unknowns = sum(scalar_count(v.type) for v in unknown) - redundant
    known = count_equations(tuple(equations))
    known += sum(scalar_count(leaf.type) for _, leaf in assigned)
    if unknowns == known:
        return None
    excess: Excess = Counter()
    leaves = {
        name: leaf
        for name in (*session.closed, *session.leaves)
        if (leaf := leaf_named(session, name))
    }
    for variable in variables:
        _count_variable(variable, leaves[variable.name], excess)
    for equation in equations:
        if not (isinstance(equation, flat.Equality) and equation.generated):
            excess[equation.component] += count_equations((equation,))
    for component, leaf in assigned:
        excess[component] += scalar_count(leaf.type)
    connections = found.joined.connections
    _count_connections(connections, excess)
    related = [r for i in found.instances if (r := _off(i, excess)) is not None]
    inputs: list[flat.Variable] = []
    if known < unknowns:
        named = names_in_equations(equations).union(leaf.name for _, leaf in assigned)
        sides = (side for c in connections for side in (c.left, c.right))
        connected = {side.name for side in sides if not side.outside}
        is_input = (leaves[v.name].causality is syntax.Causality.INPUT for v in unknown)
        pairs = zip(unknown, is_input, strict=True)
        inputs = [v for v, given in pairs if given and v.name not in connected]
        nameless = [v for v in unknown if v.name not in named and v not in inputs]
        related += [Related(f"no equation names `{v.name}`", v.span) for v in nameless[:MAX_NAMED]]
        message = "the input `{}` is not connected"
        related += [Related(message.format(v.name), v.span) for v in inputs[:MAX_NAMED]]
    kind = "many" if known > unknowns else "few"
    root = found.instances[0]
    wanted = counted(unknowns, "unknown")
    name = root.cls.name
    message = f"`{name}` has too {kind} equations: {known} for {wanted}"
    problem = Miscounted("F320", message, root.cls.span, related=tuple(related))
    sentence = f"`{name}` has {counted(known, 'equation')} for {wanted}"
    off = [i for i in found.instances if _off(i, excess) is not None]
    lack = None
    kinds = {(i.cls.name, excess[i.prefix or ""]) for i in off}  # two of one class are one mistake
    if len(kinds) == 1 and excess[off[0].prefix or ""] < 0:
        written = (e for e in equations if not (isinstance(e, flat.Equality) and e.generated))
        used = names_in_equations(written).union(
            side.name
            for c in connections
            if c.component == off[0].name
            for side in (c.left, c.right)
        )
        ends = [i for i in found.instances if i.is_connector and i.parent is off[0]]
        free = tuple(
            i.element.name
            for i in ends
            if i.element
            and i.name not in used
            and not any(n.startswith(f"{i.name}.") for n in used)
        )
        lack = _lack(off[0], -excess[off[0].prefix or ""], leaves.values(), free)
    suspect = None
    if len(kinds) == 1 and excess[off[0].prefix or ""] > 0:
        suspect = off[0].prefix or None
    absent: tuple[Absent, ...] = ()
    if kind == "few":
        from planarc.flatten.checks.passed_over import passed_over

        absent = tuple(passed_over(session.chosen))
    return Imbalance(problem, tuple(v.name for v in inputs), sentence, lack, suspect, absent)


def _lack(instance: Instance, missing: int, leaves: Iterable[Leaf], free: tuple[str, ...]) -> Lack:
    own = [x for x in leaves if owner_of(x) is instance]
    flows = frozenset(x.name for x in own if x.flow is syntax.Flow.FLOW)
    given = frozenset(
        x.name
        for x in own
        if is_public_input(x)
        or (x.parent.is_connector and x.causality is not syntax.Causality.OUTPUT)
    )
    name, cls = instance.prefix or "", instance.cls
    return Lack(name, cls.name, cls.span, instance.span, missing, flows, given - flows, free)


def lacking(
    lack: Lack, names: Sequence[str], flows: bool, inputs: Collection[str] = ()
) -> Diagnostic:
    """The message about a class that leaves `names` open, all of them flows or not; `inputs` are
    those of its parts that are connected to nothing."""
    few = counted(lack.missing, "equation")
    message = f"`{lack.class_name}` has {few} too few"
    hint = "write what ties the ends of it together"
    unheard = [n for n in names if n in inputs]
    if lack.free:
        message += f": nothing inside of it is connected to {both(lack.free)}"
        hint = f"connect `{lack.free[0]}` to a part of it, or leave it out"
    elif len(unheard) == lack.missing:
        several = len(unheard) > 1
        message += f": nothing gives the {'inputs' if several else 'input'} {both(unheard)}"
        each = "each of them" if several else "it"
        hint = f"connect a signal to {each}, or write `{unheard[0]} = ...`"
    elif names:
        shown = shortened([f"`{n}`" for n in names], MAX_NAMED)
        message += f": none of its equations decides {shown}"
        hint = f"write an equation for `{names[0]}`"
        if flows and len(names) > lack.missing:
            hint = "write how its flows depend on each other: of rigid parts they add up to zero, "
            hint += f"`{' + '.join(names)} = 0`"
    note = Related(f"`{lack.component}` is one of it", lack.span)
    related = (note,) if lack.component else ()
    open_ones = () if lack.free or len(unheard) == lack.missing else tuple(names)
    return Undecided("F320", message, lack.class_span, hint=hint, related=related, names=open_ones)


def _off(instance: Instance, excess: Excess) -> Related | None:
    """The note about a component whose own count is off."""
    name = instance.prefix or ""
    difference = excess[name]
    if not difference or instance.is_connector or instance.is_record:
        return None
    what = f"the component `{name}` (a `{instance.cls.name}`)" if name else "the model itself"
    few = "too many" if difference > 0 else "too few"
    return Related(f"{what} has {counted(abs(difference), 'equation')} {few}", instance.span)


MAX_NAMED = 5


def _count_variable(variable: flat.Variable, leaf: Leaf, excess: Excess) -> None:
    owner = owner_of(leaf)
    name = owner.prefix or ""
    size = scalar_count(leaf.type)
    if leaf.flow is syntax.Flow.FLOW:
        excess[name] += size
    if variable.variability <= flat.Variability.PARAMETER or variable.binding is not None:
        return
    if is_public_input(leaf):
        if owner.parent is not None:  # must be given by the component around
            excess[owner.parent.prefix or ""] -= size
        return
    excess[name] -= size


def _count_connections(connections: list[Connection], excess: Excess) -> None:
    by_component: dict[str, list[Connection]] = {}
    for connection in connections:
        by_component.setdefault(connection.component, []).append(connection)
    told: set[tuple[str, bool]] = set()
    beyond: dict[tuple[str, bool], Member] = {}
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
                outer = {m.key: m for m in joined if m.outside and _owner(m) != component}
                excess[component] += size * (int(not outer) - inside)
                beyond |= outer
                if not outer:
                    told |= {*keys}
            else:
                excess[component] += size * (len(joined) - 1)
    for key, member in beyond.items():
        if key not in told:  # the sum of what parts connect to it through `outer`
            excess[_owner(member)] += scalar_count(member.type)


def _owner(member: Member) -> str:
    """The component that a variable of a connector belongs to."""
    return owner_of(member.leaf).prefix or ""
