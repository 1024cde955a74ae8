"""Gathering: a walk over the instance tree that collects the flat model's parts.

In:   the root Instance
Out:  Gathered   variables, equations, connections, visuals, ..., in order of declaration

A visual is an instance that is drawn and not simulated: its class says so, by
`annotation(__planarc(visual="kind"))`, and its components are the attributes.

The walk opens every component, so all errors of a model are found, not only the first.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from msgspec import field

from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError, Varies, error
from planarc.flatten.connect.inputs import is_given
from planarc.flatten.connect.joining import Joined, join
from planarc.flatten.connect.rooting import Rooting, find_roots
from planarc.flatten.functions.statements import type_statements
from planarc.flatten.refusal import TooLarge
from planarc.flatten.sections.alike import (
    Copies,
    Drawing,
    Opening,
    Parts,
    Twin,
    Variable,
    are_answered_alike,
    kind_of,
    within,
)
from planarc.flatten.sections.declared import declared_of
from planarc.flatten.sections.home import ToldAtHome, homewards
from planarc.flatten.sections.inherited import Known, type_once
from planarc.flatten.sections.visuals import visual_of
from planarc.flatten.terms.constant import NotConstant
from planarc.flatten.tree import annotation
from planarc.flatten.tree.demand import attributes_of, leaf_binding, node_of
from planarc.flatten.tree.lookup import components, leaf_named
from planarc.flatten.tree.nodes import (
    Absent,
    Element,
    Env,
    Family,
    Instance,
    Leaf,
    Mod,
    Node,
    Question,
    Session,
    State,
)
from planarc.flatten.tree.redeclare import inner_half
from planarc.flatten.values.evaluator import Evaluator
from planarc.flatten.values.variability import cure_of_discrete, variability_of
from planarc.ir import flat, syntax
from planarc.ir.renaming import Unrepeatable


class Sections(Data):
    """The equations and algorithms of an instance, and what it declares of itself."""

    equations: tuple[flat.Equation, ...]
    initial_equations: tuple[flat.Equation, ...]
    algorithms: tuple[flat.Algorithm, ...]
    initial_algorithms: tuple[flat.Algorithm, ...]
    declared: tuple[flat.Declared, ...]


class Gathered(Parts):
    """The parts of a flat model, as they are found."""

    copies: Copies = field(default_factory=Copies)
    equations: list[flat.Equation] = field(default_factory=list)
    initial_equations: list[flat.Equation] = field(default_factory=list)
    algorithms: list[flat.Algorithm] = field(default_factory=list)
    initial_algorithms: list[flat.Algorithm] = field(default_factory=list)
    joined: Joined = field(default_factory=Joined)
    rooting: Rooting = field(default_factory=Rooting)
    declared: list[flat.Declared] = field(default_factory=list)

    def open_leaves(self) -> list[Leaf]:
        """The variables that are open."""
        known = (v if isinstance(v, Leaf) else v.known for v in self.leaves)
        return [leaf for leaf in known if leaf is not None]


def gather(root: Instance) -> Gathered:
    """Open the whole tree, find all connections, then type the equations."""
    session = root.session
    found = Gathered()
    _walk(root, found)
    walked = 0
    while walked < len(session.defaults):  # inner components that had to be made up
        _walk(list(session.defaults.values())[walked], found)
        walked += 1
    found.joined = join(found.instances, session)
    for node in found.joined.added:
        _walk(node, found)
    found.rooting = session.rooting = find_roots(found.joined)
    session.cardinalities = found.joined.cardinalities()
    _add_sections(found)
    return found


def _walk(root: Node, found: Gathered) -> None:
    stack: list[Node | Opening] = [root]
    copies = found.copies
    while stack:
        node = stack.pop()
        if isinstance(node, Leaf):
            found.leaves.append(node)
        elif isinstance(node, Family):
            stack.extend(reversed(node.items))
        elif isinstance(node, Opening):
            copies.last[kind_of(node.root)] = node.close(found)
        elif isinstance(node, Instance):
            if node.drawn:
                assert node.parent is not None and node.element is not None
                with ToldAtHome(node.parent):
                    visual = visual_of(node)
                found.drawings.append(Drawing(visual, node.parent, node.element))
                continue
            if (kind := kind_of(node)) is not None:
                if (parts := copies.copy(node, kind)) is not None:
                    found.instances += parts.instances
                    found.leaves += parts.leaves
                    found.drawings += parts.drawings
                    continue
                if not node.elements:
                    stack.append(Opening.of(node, found))
            found.instances.append(node)
            stack.extend(reversed(_children(node)))


def _children(instance: Instance) -> list[Node]:
    nodes: list[Node] = []
    for _, element in components(instance):
        try:
            with ToldAtHome(instance):
                node = node_of(inner_half(element))
        except TooLarge:
            raise  # going on would find the same again and again
        except PlanarcError as problem:
            instance.session.keep(problem)
            continue
        if _is_here(element, node):
            nodes.append(node)
    return nodes


def _is_here(element: Element, node: Node) -> bool:
    """False for an outer component, which belongs to another place."""
    prefixes = element.definition.prefixes
    return not isinstance(node, Absent) and (not prefixes.outer or prefixes.inner)


# Equations ------------------------------------------------------------------------------------


def _add_sections(found: Gathered) -> None:
    """The sections of all instances; those of copies are repeated where they would be the same."""
    known: dict[Instance, tuple[Sections, list[Question]]] = {}
    for instance in found.instances:
        session = instance.session
        errors, asked = len(session.errors), len(session.asked)
        sections = _repeated(instance, found.copies, known) or _sections(instance)
        questions = session.asked[asked:]
        if len(session.errors) == errors and None not in questions:
            known[instance] = sections, questions
        found.equations += sections.equations
        found.initial_equations += sections.initial_equations
        found.algorithms += sections.algorithms
        found.initial_algorithms += sections.initial_algorithms
        found.declared += sections.declared


def _repeated(
    instance: Instance, copies: Copies, known: dict[Instance, tuple[Sections, list[Question]]]
) -> Sections | None:
    """The sections of an instance that is like one whose sections are known."""
    likeness = copies.likeness.get(instance)
    if likeness is None or likeness.first not in known:
        return None
    sections, asked = known[likeness.first]
    questions = within(asked, likeness.old)
    if not are_answered_alike(
        questions, lambda leaf: leaf_named(instance.session, likeness.name(leaf.name))
    ):
        return None
    try:
        repeated = copies.repeat(likeness.first.name, sections, likeness.old, likeness.new)
    except Unrepeatable:
        return None
    copies.repeated.add(instance.name)
    return repeated


def _sections(instance: Instance) -> Sections:
    equations, initial = list[flat.Equation](), list[flat.Equation]()
    algorithms, at_start = list[flat.Algorithm](), list[flat.Algorithm]()
    known: Known = {}
    with ToldAtHome(instance):
        for index, part in enumerate(instance.layout.parts):
            env = Env(instance.scope(index))
            for section in part.definition.sections:
                if isinstance(section, syntax.EquationSection):
                    typed = type_once(section, env, known)
                    (initial if section.initial else equations).extend(typed)
                else:
                    (at_start if section.initial else algorithms).extend(_algorithm(section, env))
    declared = tuple(declared_of(instance))
    return Sections(tuple(equations), tuple(initial), tuple(algorithms), tuple(at_start), declared)


def _algorithm(section: syntax.AlgorithmSection, env: Env) -> Iterator[flat.Algorithm]:
    inner = Env(env.scope, in_algorithm=True)
    try:
        statements = type_statements(section.statements, inner)
    except PlanarcError as problem:
        env.session.keep(problem)
        return
    yield flat.Algorithm(section.span, env.component, statements)


# Variables --------------------------------------------------------------------------------------


def variables_of(
    leaves: Iterable[Variable], copies: Copies, session: Session
) -> list[tuple[Variable, flat.Variable | None]]:
    """The flat variables, those of copies with the names of theirs."""
    made: dict[str, flat.Variable] = {}  # that copies may have, too
    pairs: list[tuple[Variable, flat.Variable | None]] = []
    for leaf in leaves:
        variable, lasting = None, True
        if isinstance(leaf, Twin):
            variable = _twin(leaf, made, copies)
        if variable is None:
            own = leaf if isinstance(leaf, Leaf) else leaf.leaf
            untouched = own.binding_state is State.NEW and own.attributes is None
            asked = len(session.asked)
            variable = variable_of(own, session)
            lasting = untouched and len(session.asked) == asked
        if variable is not None and lasting and not variable.structural:
            made[leaf.name] = variable
        pairs.append((leaf, variable))
    return pairs


def _twin(twin: Twin, made: dict[str, flat.Variable], copies: Copies) -> flat.Variable | None:
    """The variable of a copy; None where it is not that of the first one with other names."""
    first, known = made.get(twin.first.name), twin.known
    if first is None or (known is not None and known.structural):
        return None
    try:
        variable = copies.repeat(twin.first.name, first, twin.likeness.old, twin.likeness.new)
    except Unrepeatable:
        return None
    copies.repeated.add(twin.name)
    return variable


def variable_of(leaf: Leaf, session: Session) -> flat.Variable | None:
    """The flat variable of a leaf; None when its declaration is wrong, which is reported."""
    try:
        with ToldAtHome(leaf.parent):
            attributes = attributes_of(leaf)
            binding = leaf_binding(leaf)
            if binding is not None:
                _check_variability(leaf, binding, session)
            if _is_evaluated(leaf, session) and _has_value(leaf):
                leaf.structural = True
    except PlanarcError as problem:
        session.keep(problem)
        return None
    definition = leaf.element.definition
    assert isinstance(definition, syntax.Component)
    return flat.Variable(
        leaf.name,
        leaf.type,
        leaf.variability,
        definition.span,
        binding,
        attributes,
        _causality_of_model(leaf),
        leaf.element.protected or leaf.parent.hidden,
        _is_final(leaf),
        leaf.structural,
        definition.comment,
        leaf.parent.prefix or "",
    )


def _declarations(leaf: Leaf) -> Iterator[tuple[syntax.Component, Mod]]:
    """A variable's own declaration, then those of the records around it that are parameters."""
    nodes: tuple[Leaf | Instance, ...] = (leaf, *leaf.parent.outwards())
    for node in nodes:
        if node is not leaf and node.variability is not flat.Variability.PARAMETER:
            return
        definition = None if node.element is None else node.element.definition
        if not isinstance(definition, syntax.Component):
            return
        yield definition, node.mod


def _is_evaluated(leaf: Leaf, session: Session) -> bool:
    """`Evaluate=true` of a parameter, or of a record that it belongs to."""
    return any(annotation.is_evaluated(d.annotation, session) for d, _ in _declarations(leaf))


def _is_final(leaf: Leaf) -> bool:
    return any(mod.final or d.prefixes.final for d, mod in _declarations(leaf))


def _has_value(leaf: Leaf) -> bool:
    """True when the value is known before the run: `fixed = false` gives one at the start."""
    try:
        Evaluator(leaf.parent.session).leaf_value(leaf)
    except NotConstant:
        return False
    return True


def _causality_of_model(leaf: Leaf) -> str:
    """Inputs of the model itself, also those in its connectors and records; its outputs, also
    those that are records."""
    if is_given(leaf):
        return leaf.causality.value
    holder, hidden = leaf.parent, leaf.element.protected
    while holder.has_value and holder.causality is leaf.causality and holder.parent is not None:
        hidden = hidden or (holder.element is not None and holder.element.protected)
        holder = holder.parent
    return leaf.causality.value if holder.depth == 0 and not hidden else ""


def _check_variability(leaf: Leaf, binding: flat.Expression, session: Session) -> None:
    allowed = leaf.variability
    actual = variability_of(binding, session)
    if actual <= allowed:
        return
    if allowed is flat.Variability.CONSTANT and actual is flat.Variability.PARAMETER:
        message = f"the constant `{leaf.name}` is bound to a parameter"
        raise error("F284", message, binding.span, hint="declare it as a parameter")
    kind = {
        flat.Variability.CONSTANT: "constant",
        flat.Variability.PARAMETER: "parameter",
        flat.Variability.DISCRETE: "discrete variable",
    }[allowed]
    message = f"the {kind} `{leaf.name}` is bound to an expression that changes with time"
    if isinstance(binding, flat.Reference) and allowed is flat.Variability.PARAMETER:
        told = f"declare `{binding.name}` as a parameter, too"
        told += "" if leaf.parent.depth else f", or `{leaf.name}` without the prefix"
        raise PlanarcError(Varies("F284", message, binding.span, hint=told, kind=binding.name))
    if allowed is flat.Variability.DISCRETE:
        refused = error("F284", message, binding.span, hint=cure_of_discrete(leaf.type))
        moved = PlanarcError(homewards(d, leaf.parent) for d in refused.diagnostics)
        session.unsettled.append((leaf.name, moved))  # it may tick with a clock
        return
    raise error(
        "F284",
        message,
        binding.span,
        hint=f"a {kind} of `{leaf.parent.cls.name}` keeps its value while the model runs: give it "
        "numbers and parameters"
        if leaf.parent.depth and allowed is flat.Variability.PARAMETER
        else "declare it without the prefix, or bind it to constants and parameters",
    )
