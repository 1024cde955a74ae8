"""The whole front end: from the name of a class to its flat model.

In:   Library, the full name of a model
Out:  FlatModel

    instance tree  ->  gather (variables, equations, connections, visuals)
                   ->  connection sets  ->  checks  ->  FlatModel

The rooms stand on each other in this order: library and terms, tree, values, typing,
functions, instances, connect, sections, checks. What a lower one needs of a higher one it
asks for through the session (`tree.demand`), which gets the passes from here.

Promises:  all errors found are raised together, once each, in the order of the source.
Reference: Modelica Language Specification 3.6, section 5.6.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TypeVar

from msgspec.structs import replace

from planarc.core.data import nested_deeply, without_collection
from planarc.core.diagnostic import Diagnostic, Once, PlanarcError, Severity, Varies, error
from planarc.core.nearest import did_you_mean
from planarc.core.source import NOWHERE
from planarc.flatten.checks.assertions import check_assertions
from planarc.flatten.checks.assigned import check_assigned
from planarc.flatten.checks.balance import Imbalance, check_balance, names_in_equations
from planarc.flatten.checks.connectors import Lopsided, check_connectors
from planarc.flatten.checks.discretes import check_discretes
from planarc.flatten.checks.each import check_each
from planarc.flatten.checks.exchanged import check_exchanged
from planarc.flatten.checks.kinds import check_classes
from planarc.flatten.checks.obsolete import check_obsolete
from planarc.flatten.checks.parameters import check_parameters, check_ranges
from planarc.flatten.checks.prefixes import check_prefixes
from planarc.flatten.checks.reached import check_reached
from planarc.flatten.checks.reinits import check_reinits
from planarc.flatten.checks.slips import find_slips
from planarc.flatten.checks.tables import check_tables
from planarc.flatten.checks.unheeded import check_unheeded
from planarc.flatten.checks.unused import check_unused
from planarc.flatten.checks.waiting import check_waiting
from planarc.flatten.connect.connect import Connection
from planarc.flatten.connect.expand import check_absent, is_expandable
from planarc.flatten.connect.rooting import redundant_unknowns
from planarc.flatten.connect.sets import Connected, connect_all
from planarc.flatten.functions.calls import type_call
from planarc.flatten.functions.functions import find_function, with_functions
from planarc.flatten.functions.overloads import operate
from planarc.flatten.instances.bindings import make_attributes, make_binding
from planarc.flatten.instances.instantiate import check_modifier, instantiate_model, make_node
from planarc.flatten.library.library import Library, split_name
from planarc.flatten.sections.alike import Copies
from planarc.flatten.sections.annotations import experiment_of, figures_of
from planarc.flatten.sections.gather import Gathered, gather, variables_of
from planarc.flatten.tree.demand import class_of, layout_of, static_instance
from planarc.flatten.tree.inherit import make_layout
from planarc.flatten.tree.lookup import member
from planarc.flatten.tree.nodes import (
    NO_MOD,
    Class,
    Element,
    Instance,
    Layout,
    Leaf,
    Makers,
    Node,
    Part,
    Scope,
    Session,
)
from planarc.flatten.tree.redeclare import make_class
from planarc.flatten.typing.expressions import type_expression
from planarc.flatten.typing.units import UnitCheck, check_units
from planarc.ir import flat, syntax
from planarc.ir.flatwalk import assigned_in, expressions_in, expressions_of_variable
from planarc.runtime.external import is_of_files

_MODEL_KINDS = (syntax.ClassKind.MODEL, syntax.ClassKind.BLOCK, syntax.ClassKind.CLASS)


#: Passes that need each other, and therefore ask for each other through the session.
MAKERS = Makers(
    layout=make_layout,
    cls=make_class,
    node=make_node,
    binding=make_binding,
    attributes=make_attributes,
    typed=type_expression,
    call=type_call,
    function=find_function,
    operate=operate,
)


def flatten(
    library: Library,
    class_name: str,
    units: UnitCheck = UnitCheck.WARN,
    watch: Callable[[], None] | None = None,
) -> flat.FlatModel:
    """Flatten a model. Raises PlanarcError with all errors found, and what `watch` raises, which is
    called for each component."""
    session = open_session(library, MAKERS if watch is None else _watched(watch))
    try:
        with _large_work():
            model, distinct, imbalance = _flatten(session, class_name)
            if not session.errors and units is not UnitCheck.OFF:
                _compare_units(model, distinct, units, session)
    except PlanarcError as problem:
        raise PlanarcError(_ordered([*session.errors, *problem.diagnostics])) from None
    except RecursionError:
        raise error("F251", f"`{class_name}` is nested too deeply") from None
    finally:
        session.take_apart()
    if imbalance is not None:
        session.errors.append(imbalance.problem)
        if len(session.errors) == 1:
            raise Unbalanced(model, imbalance, _lopsided(session))
    if session.errors:
        raise PlanarcError(_ordered(session.errors))
    called = (f.external for f in model.functions if f.external)
    library.looked.open_questions = any(map(is_of_files, called))
    return replace(model, warnings=_ordered([*session.warnings, *library.remarks]))


def _watched(watch: Callable[[], None]) -> Makers:
    def node(element: Element) -> Node:
        watch()
        return make_node(element)

    return replace(MAKERS, node=node)


def _compare_units(
    model: flat.FlatModel, distinct: flat.FlatModel, units: UnitCheck, session: Session
) -> None:
    files = session.own_files()
    session.warnings += find_slips(model, files, distinct)
    differing = check_units(model, files, distinct)
    if units is UnitCheck.ERROR:
        session.errors += [replace(d, severity=Severity.ERROR) for d in differing]
    else:
        session.warnings += differing


class Unbalanced(PlanarcError):
    """Equations and unknowns differ in number; all else is right, so that `structure` can say which
    of them are too many or missing."""

    def __init__(
        self, model: flat.FlatModel, imbalance: Imbalance, reasons: tuple[Diagnostic, ...]
    ) -> None:
        super().__init__(reasons or imbalance.problem)
        self.model, self.imbalance, self.reasons = model, imbalance, reasons


def _lopsided(session: Session) -> tuple[Diagnostic, ...]:
    """Connectors that have too few flows: what is wrong with the count is theirs."""
    found = (w for w in session.warnings if isinstance(w, Lopsided))
    return tuple(replace(w, severity=Severity.ERROR) for w in found)


def open_session(library: Library, makers: Makers = MAKERS) -> Session:
    """A run with its outermost scope, in which all top-level classes are found."""
    session = Session(library, makers)
    definition = syntax.ClassDef(
        NOWHERE, "", syntax.ClassKind.PACKAGE, syntax.Composition(NOWHERE), NOWHERE
    )
    cls = Class(definition, None, "", NO_MOD, library)
    part = Part(cls, 0, {}, entries=[library])
    cls.layout = Layout([part], {}, kind=syntax.ClassKind.PACKAGE, done=True)
    cls.static = Instance(cls, cls.layout, None, NO_MOD, None, session)
    session.root_scope = Scope(cls.static, part)
    return session


@contextmanager
def _large_work() -> Iterator[None]:
    """A while in which deep recursion is allowed, and Python's search for cycles waits."""
    with nested_deeply(), without_collection():
        yield


def _ordered(diagnostics: list[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Each message once, in the order of the source; those without a place last."""
    seen: dict[tuple[object, ...], Diagnostic] = {}
    for d in diagnostics:
        if isinstance(d, Varies):
            seen.setdefault(("", d.kind), d)
        elif isinstance(d, Once):
            seen.setdefault((d.code, d.kind), d)
        else:
            seen.setdefault((d.code, d.span) if d.span else (d.code, d.message), d)
    varying = [d.span for d in diagnostics if isinstance(d, Varies) and d.span is not None]
    for key, d in list(seen.items()):  # what depends on it has no value, either
        if d.code == "F305" and d.span and any(map(d.span.covers, varying)):
            del seen[key]
    first_seen: dict[str, int] = {}
    for d in seen.values():
        if d.span is not None:
            first_seen.setdefault(d.span.source.name, len(first_seen))

    def place(d: Diagnostic) -> tuple[int, int]:
        return (
            (len(first_seen), 0)
            if d.span is None
            else (first_seen[d.span.source.name], d.span.start)
        )

    return tuple(sorted(seen.values(), key=place))


# The model -----------------------------------------------------------------------------------


def find_model(session: Session, class_name: str) -> Class:
    """The class to flatten, by its full name."""
    instance = session.root_scope.instance
    cls: Class | None = None
    for name in split_name(class_name):
        element = member(instance, name)
        if element is None or not element.is_class:
            near = did_you_mean(name, session.library.class_names(instance.cls.name))
            raise error("F200", f"there is no class `{class_name}`", None, hint=near)
        cls = class_of(element)
        instance = static_instance(cls)
    assert cls is not None
    return cls


def _check_kind(cls: Class) -> None:
    kind = layout_of(cls).kind
    if kind not in _MODEL_KINDS:
        raise error("F201", f"`{cls.name}` is a {kind.value}, not a model", cls.span)
    if cls.definition.partial:
        message = f"`{cls.name}` is partial and cannot be used by itself"
        hint = "use a model that extends it"
        raise error("F254", message, cls.span, hint=hint)


def _flatten(
    session: Session, class_name: str
) -> tuple[flat.FlatModel, flat.FlatModel, Imbalance | None]:
    """The model, what is distinct in it, and whether its equations are too many or too few."""
    cls = find_model(session, class_name)
    _check_kind(cls)
    root = instantiate_model(session, cls)
    check_modifier(root)
    found = gather(root)
    connections = found.joined.connections
    experiment = experiment_of(root, session)
    buses = any(is_expandable(i) for i in found.instances)
    statements = [s for a in (*found.algorithms, *found.initial_algorithms) for s in a.statements]
    used = {*names_in_equations(found.equations), *assigned_in(statements)} if buses else set()
    connected = connect_all(connections, found.open_leaves(), found.rooting, used, session)
    kept = [leaf for leaf in found.leaves if leaf.name not in connected.unused]
    pairs = variables_of(kept, found.copies, session)
    variables = [v for _, v in pairs if v is not None]
    for i, v in enumerate(variables):
        leaf = session.leaves.get(v.name)
        if leaf is not None and leaf.structural != v.structural:  # found since
            variables[i] = replace(v, structural=True)
    equations = [*found.equations, *connected.equations]
    if connected.unused:
        said = [e for v in variables for e in expressions_of_variable(v)]
        said += [*expressions_in(equations), *expressions_in(found.initial_equations)]
        check_absent(connected.unused, (*said, *expressions_in(statements)), session)
    check_reached(found.instances, session)
    check_classes(session)
    leaves = [leaf for leaf in found.open_leaves() if leaf.name not in connected.unused]
    check_prefixes(found.instances, leaves, session)
    check_each(found.instances, session)
    check_parameters(pairs, session)
    check_assigned(found.algorithms, variables, session)
    check_reinits(found.equations, session)
    check_discretes(found.equations, found.algorithms, variables, session)
    imbalance = None
    if not session.errors:
        check_ranges(pairs, session)
        check_tables(pairs, session)
        check_connectors(found.instances, session)
        check_unheeded(root, found.instances, connections, session)
        check_exchanged(connections, session)
        check_unused(root, connections, session)
        check_waiting(pairs, session)
        check_obsolete(found.instances, session)
        redundant = redundant_unknowns(found.instances, leaves, found.rooting)
        imbalance = check_balance(found, variables, equations, session, redundant)
    model = _model(root, found, connected, variables, equations, experiment)
    distinct = _distinct(model, found.copies)
    model = with_functions(model, session, distinct)
    check_assertions(model, session)
    return model, distinct, imbalance


def _distinct(model: flat.FlatModel, copies: Copies) -> flat.FlatModel:
    """The model without what is repeated with other names; all of it where variables of copies
    have other units."""
    units = {v.name: v.attributes.unit for v in model.variables}
    repeated = copies.repeated
    if not repeated or any(units.get(own) != units.get(first) for own, first in copies.given):
        return model

    def left(pieces: tuple[Piece, ...]) -> tuple[Piece, ...]:
        return tuple([p for p in pieces if p.component not in repeated])

    return replace(
        model,
        variables=tuple([v for v in model.variables if v.name not in repeated]),
        equations=left(model.equations),
        initial_equations=left(model.initial_equations),
        algorithms=left(model.algorithms),
        initial_algorithms=left(model.initial_algorithms),
        visuals=left(model.visuals),
        declared=left(model.declared),
    )


Piece = TypeVar("Piece", flat.Equation, flat.Algorithm, flat.Visual, flat.Declared)


def _model(
    root: Instance,
    found: Gathered,
    connected: Connected,
    variables: list[flat.Variable],
    equations: list[flat.Equation],
    experiment: flat.Experiment,
) -> flat.FlatModel:
    definition = root.cls.definition
    parts = tuple(_part(i) for i in found.instances if i.prefix)
    return flat.FlatModel(
        root.cls.name,
        tuple(variables),
        tuple(equations),
        tuple(found.initial_equations),
        tuple(found.algorithms),
        tuple(found.initial_algorithms),
        (),
        tuple(d.visual for d in found.drawings),
        tuple(found.declared),
        parts,
        tuple(connected.physical),
        experiment,
        definition.comment,
        definition.name_span,
        figures=figures_of(root, root.session),
        connects=_connects(found.joined.connections, Instance),
        signals=_connects(found.joined.connections, Leaf),
        clocked=root.session.clocked,
    )


def _connects(connections: Iterable[Connection], kind: type[Node]) -> tuple[flat.Connect, ...]:
    return tuple(
        flat.Connect(c.left.name, c.right.name, c.span)
        for c in connections
        if isinstance(c.left.node, kind)
    )


def _part(instance: Instance) -> flat.Part:
    """What stands in the model as `outer` was made up for want of an inner one."""
    prefixes = (
        syntax.Prefixes() if instance.element is None else instance.element.definition.prefixes
    )
    shared = prefixes.inner or prefixes.outer
    return flat.Part(instance.name, instance.cls.name, instance.span, shared)
