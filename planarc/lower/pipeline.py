"""The flat model as a scalar hybrid system.

In:   FlatModel   arrays, functions, relations where they were written
Out:  Dae         scalar equations over one expression table; events taken out

    classify      what each name is; parameters in evaluation order
    equations     array equations entry by entry; when-clauses
    algorithms    statements run on expressions

Needs:     a checked flat model (types, dimensions, names).
Promises:  every name in an equation is a variable or parameter of the Dae, or reserved.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from msgspec.structs import replace

from planarc.core.data import nested_deeply
from planarc.core.diagnostic import PlanarcError, error
from planarc.core.source import Span
from planarc.ir import dae, flat
from planarc.ir.expr import Expr, Exprs, symbols
from planarc.ir.given import Given
from planarc.ir.places import is_own, own_part, owner
from planarc.lower.classify import classify, is_text_parameter
from planarc.lower.equations import Lowered, lower_equations, lower_initial
from planarc.lower.free_parameters import release_parameters
from planarc.lower.free_starts import release_starts
from planarc.lower.functions import inline
from planarc.lower.lefts import Moving
from planarc.lower.scalar import lower_expression
from planarc.lower.scope import Model, Scope
from planarc.lower.starts import know_before, start_discretes
from planarc.lower.unassigned import warn_of_unassigned
from planarc.lower.values import Text, Value, fixed_dims, scalar_names
from planarc.runtime.tensor import Tensor

if TYPE_CHECKING:
    from planarc.lower.clocks.parts import Parting


def lower(source: flat.FlatModel, blended: bool = False, placed: bool = False) -> dae.Dae:
    """The scalar model; a `blended` one goes from `simplified` to `actual` of each `homotopy` with
    the parameter `dae.HOMOTOPY`; a `placed` one begins where its states are given, so that of its
    initial equations those alone count that are start values of discrete variables. Raises
    PlanarcError (codes L3xx)."""
    try:
        with nested_deeply():
            return _of_source(source, blended, placed)
    except RecursionError:
        raise error(
            "L300", "an expression is nested too deeply", source.span, hint="split the expression"
        ) from None


def _of_source(source: flat.FlatModel, blended: bool, placed: bool) -> dae.Dae:
    source = release_parameters(source)
    functions = {f.name: f for f in source.functions}
    given, moving = Given(source), Moving(source)
    model = Model(
        Exprs(), functions, inline, given, given.called, blended=blended, is_moving=moving
    )
    try:
        return _lower(model, source, placed)
    except PlanarcError as problem:
        from planarc.lower.refuted import at_home

        raise at_home(problem, model, source) from None


def _lower(model: Model, source: flat.FlatModel, placed: bool) -> dae.Dae:
    way = _way(model) if model.blended else ()
    parting = _parting(source)
    if parting is not None:
        source = parting.continuous
    classified = classify(model, source, _clocked(parting))
    starts = _starts(model, (*classified.variables, *classified.discretes))
    classified, hanging = release_starts(model, source, classified)
    into = Lowered()
    lower_equations(model, (*classified.bindings, *source.equations), into)
    if source.algorithms or source.initial_algorithms:
        from planarc.lower.algorithms import lower_algorithm, lower_initial_algorithm
    for algorithm in source.algorithms:
        lower_algorithm(model, algorithm, starts, into)
    clocks: tuple[dae.Clock, ...] = ()
    kept: tuple[dae.Variable, ...] = ()
    if parting is not None:
        from planarc.lower.clocks.ticks import lower_clocks

        clocks, kept = lower_clocks(model, parting, into)
    ticking = frozenset(name for c in clocks for name in c.variables)
    continuous, discrete = into.parted(model, ticking)
    initial = lower_initial(model, source.initial_equations)
    for algorithm in source.initial_algorithms:
        initial.extend(lower_initial_algorithm(model, algorithm, starts))
    initial.extend(hanging.held)
    equations = (*discrete, *(e for _, e in model.auxiliaries))
    whens = tuple(into.whens)
    initial, discretes, found = start_discretes(
        model, initial, hanging.loose, classified.discretes, equations, into
    )
    if not placed:
        whens = tuple(into.whens)  # with those of initial equations
    values = [v.start for v in discretes] + [p.value for p in classified.parameters]
    values += [s.start for s in model.samplers]
    start_time = _start_time(model, source.experiment.start, values)
    triggers = [v for v, _ in model.auxiliaries]
    lowered = dae.Dae(
        name=source.name,
        table=model.table,
        variables=(*classified.variables, *(v for v, _ in model.added)),
        parameters=(*way, *start_time, *_freeze(model, classified.parameters)),
        equations=(*continuous, *(e for _, e in model.added)),
        discretes=(*discretes, *kept, *triggers),
        inputs=classified.inputs,
        initial_equations=() if placed else tuple(initial),
        discrete_equations=(*discrete, *(e for _, e in model.auxiliaries)),
        relations=tuple(model.relations),
        samplers=tuple(model.samplers),
        delays=tuple(model.delays),
        whens=whens,
        clocks=clocks,
        assertions=tuple(model.assertions),
        visuals=tuple(lower_visual(model, v) for v in source.visuals),
        declared=tuple(lower_declared(model, d) for d in source.declared),
        parts=source.parts,
        start_places=tuple(_start_places(source)),
        connections=source.connections,
        connects=source.connects,
        signals=source.signals,
        experiment=source.experiment,
        description=source.description,
        span=source.span,
        warnings=(*source.warnings, *model.warnings, *warn_of_unassigned(source)),
        texts=tuple(v.name for v in source.variables if is_text_parameter(v)),
        simplified=model.simplified,
    )
    return know_before(lowered, found)


def _parting(source: flat.FlatModel) -> Parting | None:
    """The clocked parts of a model that has such."""
    if not source.clocked:
        return None
    from planarc.lower.clocks.parts import part

    return part(source)


def _clocked(parting: Parting | None) -> frozenset[str]:
    parts = () if parting is None else parting.parts
    return frozenset(name for part in parts for name in part.variables)


def _start_places(source: flat.FlatModel) -> Iterator[tuple[str, Span]]:
    """The user's start values in other lines than where the declarations of their parts begin."""
    for v in source.variables:
        start = v.attributes.start
        if not v.attributes.start_written or start is None or not is_own(source, start.span):
            continue
        part = own_part(source, owner(v.name))
        if part is not None and part.span.line != start.span.line:
            yield from ((name, start.span) for name in scalar_names(v.name, fixed_dims(v.type)))


def _starts(model: Model, variables: Sequence[dae.Variable]) -> dict[str, Value]:
    t = model.table
    default = {dae.Kind.BOOLEAN: t.false}
    return {
        v.name: v.start if v.start is not None else default.get(v.kind, t.zero) for v in variables
    }


def _freeze(model: Model, parameters: Sequence[dae.Parameter]) -> Iterator[dae.Parameter]:
    """Parameters whose values shaped the equations cannot be set any more."""
    for p in parameters:
        frozen = p.name in model.frozen
        yield replace(p, structural=True, settable=False) if frozen else p


def _way(model: Model) -> tuple[dae.Parameter, ...]:
    """The parameter `dae.HOMOTOPY`."""
    model.parameters.add(dae.HOMOTOPY)
    return (dae.Parameter(dae.HOMOTOPY, dae.Kind.REAL, model.table.one, settable=True),)


def _start_time(
    model: Model, default: float, values: Sequence[Expr | None]
) -> tuple[dae.Parameter, ...]:
    """The parameter `$start`, where a start value or another parameter depends on it."""
    symbol = model.table.symbol(dae.START_TIME)
    if symbol not in symbols(*(v for v in values if v is not None)):
        return ()
    value = model.table.const(default)
    return (dae.Parameter(dae.START_TIME, dae.Kind.REAL, value, settable=True, protected=True),)


# What is drawn and declared -----------------------------------------------------------


def lower_visual(model: Model, visual: flat.Visual) -> dae.Visual:
    """A visual with every number in its attributes as an expression."""
    model.component = visual.component
    scope = Scope(model, events=False)
    attributes = tuple(
        (name, _plain(lower_expression(scope, value), visual.span))
        for name, value in visual.attributes
    )
    return dae.Visual(visual.component, visual.kind, attributes)


def lower_declared(model: Model, declared: flat.Declared) -> dae.Declared:
    """What a component says of itself, its value as an expression."""
    model.component = declared.component
    value = lower_expression(Scope(model, events=False), declared.value)
    plain = _plain(value, declared.value.span)
    return dae.Declared(declared.component, declared.kind, declared.name, plain, declared.foreign)


def _plain(value: Value, span: Span) -> dae.VisualValue:
    if isinstance(value, Tensor):
        return tuple(_plain(row, span) for row in value.rows())
    if isinstance(value, Text):
        text = value.constant
        if text is None:
            raise error("L360", "a drawn text cannot change while running", span)
        return text
    if not isinstance(value, Expr):
        raise error("L361", "a visual's attribute must be a number, a text or an array", span)
    return value
