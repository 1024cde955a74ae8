"""Parameters that get their values at the start become unknowns that do not change.

In:   flat.FlatModel
Out:  flat.FlatModel   without parameters that have `fixed = false`

One that an initial equation gives as an expression of other parameters is bound to
it, and stays a parameter; `time` in it is the time of the start. Others become unknowns,
and so does what is computed from them, its binding an equation; of start values that hang on
them cares `free_starts`. A Boolean, Integer or enumeration is set at the start.

Example:

    parameter Real p(fixed=false);           Real p;
    parameter Real q = 2*p;                  Real q = 2*p;
    initial equation                   ->    initial equation
      der(x) = 0;                              der(x) = 0;
                                             equation
                                               der(p) = 0;

    parameter Boolean b(fixed=false);        discrete Boolean b;
    initial equation                   ->    equation
      b = x > 0;                               when initial() then b = x > 0; end when;

Needs:     no structural parameter among them: such are refused.
Reference: Modelica Language Specification 3.6, section 8.6.
"""

from __future__ import annotations

from msgspec.structs import replace

from planarc.ir import flat
from planarc.ir.flat import Base, Variability
from planarc.ir.flatwalk import is_false, names_in, nodes_of
from planarc.lower.classify import is_parameter, ordered, referenced
from planarc.lower.scope import unsupported
from planarc.lower.values import fixed_dims


def release_parameters(source: flat.FlatModel) -> flat.FlatModel:
    """Parameters with `fixed = false`, and what is computed from them, become unknowns."""
    if not any(_is_free(v) for v in source.variables):
        return source
    source = _bound(source)
    free = {v.name for v in source.variables if _is_free(v)}
    if not free:
        return source
    for v in ordered([v for v in source.variables if is_parameter(v)]):
        if v.name not in free and any(n in free for n in referenced(_value(v))):
            free.add(v.name)
    variables, constancy = [], []
    for v in source.variables:
        if v.name not in free:
            variables.append(v)
            continue
        if not _is_free(v):
            v = replace(v, binding=_value(v))
        if v.structural:
            raise unsupported(f"`fixed = false` for a structural parameter, `{v.name}`", v.span)
        continuous = v.type.base is Base.REAL
        variability = Variability.CONTINUOUS if continuous else Variability.DISCRETE
        variables.append(replace(v, variability=variability, at_start=True))
        if v.binding is None and continuous:
            constancy.append(_constant_in_time(v))
    discrete = {v.name for v in variables if v.name in free and v.type.base is not Base.REAL}
    initial, at_start = [], []
    for e in source.initial_equations:
        turned = _set_at_start(e, discrete)
        initial.append(e) if turned is None else at_start.append(turned)
    return replace(
        source,
        variables=tuple(variables),
        equations=(*source.equations, *constancy, *at_start),
        initial_equations=tuple(initial),
    )


def _set_at_start(equation: flat.Equation, discrete: set[str]) -> flat.WhenEquation | None:
    """`initial equation b = value`, b discrete, as `when initial() then b = value`."""
    if not isinstance(equation, flat.Equality):
        return None
    left, right = equation.left, equation.right
    if isinstance(right, flat.Reference) and right.name in discrete:
        left, right = right, left
    if not isinstance(left, flat.Reference) or left.name not in discrete:
        return None
    span, component = equation.span, equation.component
    condition = flat.Builtin(flat.BOOLEAN, span, "initial")
    body = flat.Equality(span, component, left, right)
    return flat.WhenEquation(span, component, ((condition, (body,)),))


def _bound(source: flat.FlatModel) -> flat.FlatModel:
    """Free parameters bound to what initial equations `p = expression of parameters` give."""
    free = {v.name for v in source.variables if _is_free(v)}
    known = {v.name for v in source.variables if is_parameter(v)} - free
    values: flat.Named = {}
    used: set[int] = set()
    while True:
        before = len(values)
        for i, equation in enumerate(source.initial_equations):
            given = {} if i in used else _given(equation, free - values.keys(), known)
            if given:
                values |= given
                known |= given.keys()
                used.add(i)
        if len(values) == before:
            break
    variables = [
        replace(v, binding=values[v.name]) if v.name in values else v for v in source.variables
    ]
    rest = [e for i, e in enumerate(source.initial_equations) if i not in used]
    return replace(source, variables=tuple(variables), initial_equations=tuple(rest))


def _given(equation: flat.Equation, free: set[str], known: set[str]) -> flat.Named:
    """Free parameters and the expressions of known ones that an equation says they are."""
    if not isinstance(equation, flat.Equality):
        return {}
    left, right = equation.left, equation.right
    if isinstance(left, flat.Targets):
        wanted = [(k, e) for k, e in enumerate(left.items) if e is not None]
        whole = all(isinstance(e, flat.Reference) and _is_whole(e, free) for _, e in wanted)
        if not whole or not isinstance(right, flat.Call) or not _is_known(right, known):
            return {}
        return {
            e.name: replace(right, type=e.type, output=k)
            for k, e in wanted
            if isinstance(e, flat.Reference)
        }
    for one, other in ((left, right), (right, left)):
        if isinstance(one, flat.Reference) and _is_whole(one, free) and _is_known(other, known):
            return {one.name: other}
    return {}


def _is_whole(e: flat.Reference, free: set[str]) -> bool:
    return not e.subscripts and e.name in free


def _is_known(e: flat.Expression, known: set[str]) -> bool:
    """True for an expression of known parameters, and perhaps of the start time."""
    loops = (n for n in nodes_of((e,)) if isinstance(n, flat.Comprehension))
    iterators = {name for loop in loops for name, _ in loop.iterators}
    return names_in((e,)) - iterators <= known


def _is_free(v: flat.Variable) -> bool:
    return is_parameter(v) and v.binding is None and is_false(v.attributes.fixed)


def _value(v: flat.Variable) -> flat.Expression | None:
    """What a parameter is where the start does not find it."""
    start = v.attributes.start
    if v.binding is not None or start is None or _is_free(v):
        return v.binding
    return start if start.type.dims else _filled(v, start)


def _constant_in_time(v: flat.Variable) -> flat.Equality:
    rate = flat.Builtin(v.type, v.span, "der", (flat.Reference(v.type, v.span, v.name),))
    zero = flat.Literal(replace(v.type, dims=()), v.span, 0.0)
    return flat.Equality(v.span, v.component, rate, _filled(v, zero))


def _filled(v: flat.Variable, value: flat.Expression) -> flat.Expression:
    """An array of the dimensions of a variable, of one value everywhere."""
    for size in reversed(fixed_dims(v.type)):
        dims = (size, *value.type.dims)
        value = flat.Array(replace(v.type, dims=dims), v.span, (value,) * size)
    return value
