"""Variables told apart: parameters, discrete ones, continuous unknowns, inputs.

In:   the variables of a flat model
Out:  every name with its value in `Model.values`; parameters in evaluation order

Constants, final and structural parameters whose value is known are put in as
numbers wherever they are used; other parameters stay symbols, so that a new value
needs no new compilation.

Needs:     distinct names; dimensions known.
Promises:  a parameter's value refers to parameters before it only.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from math import prod

from planarc.core.data import Data
from planarc.core.diagnostic import Related, error
from planarc.core.order import Circle, in_order
from planarc.core.prose import ticked
from planarc.ir import dae, flat
from planarc.ir.expr import Expr, Substitution
from planarc.ir.flat import Base, Variability
from planarc.ir.flatwalk import inside, nodes_of, set_by
from planarc.lower.assignment import zero_of
from planarc.lower.scalar import lower_expression
from planarc.lower.scope import Model, Scope
from planarc.lower.texts import held, number
from planarc.lower.values import Text, Value, expr, fixed_dims, scalar_names
from planarc.runtime.tensor import Tensor, each, elements

KINDS = {
    Base.REAL: dae.Kind.REAL,
    Base.INTEGER: dae.Kind.INTEGER,
    Base.BOOLEAN: dae.Kind.BOOLEAN,
    Base.ENUMERATION: dae.Kind.ENUMERATION,
    Base.STRING: dae.Kind.STRING,
}
# Where it counts: an enumeration looks up its members by a function.
_REAL, _STRING = Base.REAL, Base.STRING
_PARAMETER, _DISCRETE = Variability.PARAMETER, Variability.DISCRETE


class Classified(Data):
    """Scalars by what they are; `bindings` are the equations that declarations hold."""

    parameters: tuple[dae.Parameter, ...]
    variables: tuple[dae.Variable, ...]
    discretes: tuple[dae.Variable, ...]
    inputs: tuple[dae.Variable, ...]
    bindings: tuple[flat.Equality, ...]


def is_parameter(v: flat.Variable) -> bool:
    return v.variability <= _PARAMETER


def classify(
    model: Model, source: flat.FlatModel, clocked: frozenset[str] = frozenset()
) -> Classified:
    """Enter all variables into `model` and give their scalar descriptions. What is `clocked`
    changes at ticks only."""
    set_at_events = frozenset(_assigned_in_whens(source))
    for v in source.variables:
        dims = fixed_dims(v.type)
        names = scalar_names(v.name, dims)
        if is_parameter(v):
            model.parameters.update(names)
        elif _is_discrete(v, set_at_events):
            model.discretes.update(names)
        elif clocked:
            model.discretes.update(clocked.intersection(names))
        model.values[v.name] = _symbols(model, v, dims, names)
    parameters = _parameters(model, source)
    variables: list[dae.Variable] = []
    discretes: list[dae.Variable] = []
    inputs: list[dae.Variable] = []
    bindings: list[flat.Equality] = []
    for v in source.variables:
        if is_parameter(v) or _is_given_text(v):
            continue
        scalars = list(_describe(model, v))
        if clocked:
            discretes.extend(s for s in scalars if s.name in model.discretes)
            scalars = [s for s in scalars if s.name not in model.discretes]
        if _is_discrete(v, set_at_events):
            discretes.extend(scalars)
        elif v.causality == "input" and v.binding is None:
            inputs.extend(scalars)
        else:
            variables.extend(scalars)
        if v.binding is not None:
            _know(model, v, v.binding)
            own = flat.Reference(v.type, v.span, v.name)
            bindings.append(flat.Equality(v.binding.span, v.component, own, v.binding))
    for e in source.equations:
        if isinstance(e, flat.Equality) and isinstance(e.left, flat.Reference):
            _know(model, e.left, e.right)
    return Classified(
        tuple(parameters), tuple(variables), tuple(discretes), tuple(inputs), tuple(bindings)
    )


def _know(model: Model, v: flat.Variable | flat.Reference, value: flat.Expression) -> None:
    """Enter an Integer that equals an expression of parameters: ranges may hang on it."""
    if v.type.base is not Base.INTEGER or v.type.dims:
        return
    for e in nodes_of((value,)):
        if isinstance(e, flat.Reference) and e.name not in model.parameter_values:
            return
        if not isinstance(e, flat.Reference | flat.Literal | flat.Unary | flat.Binary):
            return
    model.parameter_values[v.name] = expr(lower_expression(Scope(model, events=False), value))


def _is_discrete(v: flat.Variable, set_at_events: frozenset[str]) -> bool:
    return v.variability is _DISCRETE or v.type.base is not _REAL or v.name in set_at_events


def _is_given_text(v: flat.Variable) -> bool:
    """True for an input of the model itself that nobody can give: it stays empty."""
    return v.type.base is _STRING and v.causality == "input" and v.binding is None


def is_text_parameter(v: flat.Variable) -> bool:
    return v.type.base is _STRING and v.variability is flat.Variability.PARAMETER


def _symbols(model: Model, v: flat.Variable, dims: tuple[int, ...], names: Sequence[str]) -> Value:
    symbols: tuple[Value, ...] = tuple(map(model.table.symbol, names))
    if v.type.base is _STRING:
        empty = is_parameter(v) or _is_given_text(v)
        symbols = tuple(Text(("",)) if empty else held(expr(e)) for e in symbols)
    return Tensor(dims, symbols) if dims else symbols[0]


def _assigned_in_whens(source: flat.FlatModel) -> Iterator[str]:
    """Names of variables that when-clauses give values to."""
    statements = chain.from_iterable(a.statements for a in source.algorithms)
    for node in inside((*source.equations, *statements)):
        if isinstance(node, flat.WhenEquation | flat.WhenStatement):
            for _, body in node.branches:
                yield from (v.name for item in inside(body) for v in set_by(item))


# Parameters ----------------------------------------------------------------------------


def _parameters(model: Model, source: flat.FlatModel) -> list[dae.Parameter]:
    scope = Scope(model, events=False)
    result: list[dae.Parameter] = []
    for v in ordered([v for v in source.variables if is_parameter(v)]):
        given = v.binding if v.binding is not None else v.attributes.start
        if given is None:
            value = zero_of(v.type.element(len(v.type.dims)), model.table)
        else:
            model.opened = {}
            value = lower_expression(scope, given)
            if v.attributes.fixed is not None:  # maybe found at the start
                value = _at_start(model, value)
        if v.type.base is _STRING:
            model.values[v.name] = value
            continue
        result.extend(_enter(model, v, spread(model, value, v)))
    model.opened = None
    return result


def _at_start(model: Model, value: Value) -> Value:
    """The value where time is that of the start."""
    table = model.table
    if isinstance(value, Text):
        return value
    put_in = Substitution(table, {table.time: table.symbol(dae.START_TIME)})
    return each(lambda e: put_in(e) if isinstance(e, Expr) else e, value)


def spread(model: Model, value: Value, v: flat.Variable) -> tuple[Expr, ...]:
    """The value of each scalar of a variable; a scalar value stands for all (`each`)."""
    items, size = elements(value), prod(fixed_dims(v.type))
    if not isinstance(value, Tensor):
        items = items * size
    if len(items) != size:
        raise error("L331", f"`{v.name}` has {size} entries, its value {len(items)}", v.span)
    return tuple(number(model.table, e) for e in items)


def _enter(model: Model, v: flat.Variable, values: tuple[Expr, ...]) -> Iterator[dae.Parameter]:
    dims = fixed_dims(v.type)
    names = scalar_names(v.name, dims)
    frozen = v.variability is Variability.CONSTANT or v.final or v.structural
    if frozen and all(e.is_const for e in values):
        model.values[v.name] = Tensor(dims, values) if dims else values[0]
    model.parameter_values.update(zip(names, values, strict=True))
    low, high = _attributes(model, v, len(names), v.attributes.min, v.attributes.max)
    for i, (name, value) in enumerate(zip(names, values, strict=True)):
        yield dae.Parameter(
            name,
            KINDS[v.type.base],
            value,
            settable=value.is_const and not frozen,
            structural=v.structural,
            constant=v.variability is Variability.CONSTANT,
            unit=v.attributes.unit,
            display_unit=v.attributes.display_unit,
            description=v.description,
            protected=v.protected,
            component=v.component,
            literals=v.type.literals,
            type_name=v.type.name,
            minimum=low[i],
            maximum=high[i],
            final=v.final,
            span=v.span,
        )


def ordered(variables: Sequence[flat.Variable]) -> list[flat.Variable]:
    """Every parameter after those that its value refers to; else as declared."""
    by_name = {v.name: v for v in variables}

    def needs(name: str) -> Iterator[str]:
        v = by_name[name]
        return (n for n in referenced(v.binding, v.attributes.start) if n in by_name)

    try:
        return [by_name[name] for name in in_order(by_name, needs)]
    except Circle as circle:
        raise _cycle(by_name, circle.names) from None


def _cycle(by_name: dict[str, flat.Variable], names: list[str]) -> Exception:
    message = f"the value of a parameter depends on itself: {ticked(names)}"
    related = [Related(f"`{n}` is declared here", by_name[n].span) for n in names[1:]]
    return error("L332", message, by_name[names[0]].span, related=related)


def referenced(*roots: flat.Expression | None) -> Iterator[str]:
    """Names of the variables that expressions refer to, in their order."""
    nodes = nodes_of(root for root in roots if root is not None)
    return (node.name for node in nodes if isinstance(node, flat.Reference))


# Unknowns ---------------------------------------------------------------------------------


def _describe(model: Model, v: flat.Variable) -> Iterator[dae.Variable]:
    a, names = v.attributes, scalar_names(v.name, fixed_dims(v.type))
    told = a.start, a.nominal, a.min, a.max, a.fixed
    start, nominal, low, high, fixed = _attributes(model, v, len(names), *told)
    for i, name in enumerate(names):
        yield dae.Variable(
            name,
            KINDS[v.type.base],
            start=start[i],
            fixed=_is_fixed(model, v, fixed[i]),
            start_written=a.start_written,
            fixed_written=a.fixed_written,
            state_select=a.state_select,
            nominal=nominal[i],
            minimum=low[i],
            maximum=high[i],
            unit=a.unit,
            display_unit=a.display_unit,
            description=v.description,
            protected=v.protected,
            causality=v.causality,
            component=v.component,
            literals=v.type.literals,
            type_name=v.type.name,
            at_start=v.at_start,
            span=v.span,
        )


def _is_fixed(model: Model, v: flat.Variable, value: Expr | None) -> bool:
    """Parameters that it hangs on become structural: it says which equations there are."""
    if value is None:
        return False
    value = model.number(value)
    if not value.is_const:
        raise error("L333", f"`fixed` of `{v.name}` must be known at compile time", v.span)
    return bool(value.data)


def _attributes(
    model: Model, v: flat.Variable, size: int, *told: flat.Expression | None
) -> list[tuple[Expr | None, ...]]:
    """Attributes, each for every scalar of a variable."""
    none: tuple[Expr | None, ...] = (None,) * size
    if not any(told):
        return [none] * len(told)
    scope = Scope(model, events=False)
    return [none if e is None else spread(model, lower_expression(scope, e), v) for e in told]
