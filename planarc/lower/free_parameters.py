"""Parameters that get their values at the start become unknowns that do not change.

In:   flat.FlatModel
Out:  flat.FlatModel   without parameters that have `fixed = false`

What is computed from such a parameter is an unknown too, its binding an equation.

Example:

    parameter Real p(fixed=false);           Real p;
    parameter Real q = 2*p;                  Real q = 2*p;
    initial equation                   ->    initial equation
      der(x) = 0;                              der(x) = 0;
                                             equation
                                               der(p) = 0;

Promises:  only parameters of type Real; others are refused.
Reference: Modelica Language Specification 3.6, section 8.6.
"""

from __future__ import annotations

from dataclasses import replace

from planarc.ir import flat
from planarc.ir.flat import Base, Variability
from planarc.lower.classify import in_order, is_parameter, referenced
from planarc.lower.scope import unsupported
from planarc.lower.values import fixed_dims


def release_parameters(source: flat.FlatModel) -> flat.FlatModel:
    """Parameters with `fixed = false`, and what is computed from them, become unknowns."""
    free = {v.name for v in source.variables if _is_free(v)}
    if not free:
        return source
    for v in in_order([v for v in source.variables if is_parameter(v)]):
        if v.name not in free and any(n in free for n in referenced((v.binding,))):
            free.add(v.name)
    variables, constancy = [], []
    for v in source.variables:
        if v.name not in free:
            variables.append(v)
            continue
        if v.type.base is not Base.REAL or v.structural:
            kind = "a structural parameter" if v.structural else "a parameter that is no `Real`"
            raise unsupported(f"`fixed = false` for {kind}, `{v.name}`", v.span)
        variables.append(replace(v, variability=Variability.CONTINUOUS))
        if v.binding is None:
            constancy.append(_constant_in_time(v))
    equations = (*source.equations, *constancy)
    return replace(source, variables=tuple(variables), equations=equations)


def _is_free(v: flat.Variable) -> bool:
    return is_parameter(v) and v.binding is None and _is_false(v.attributes.fixed)


def _is_false(value: flat.Expression | None) -> bool:
    if isinstance(value, flat.Array):
        return bool(value.items) and all(_is_false(item) for item in value.items)
    return isinstance(value, flat.Literal) and value.value is False


def _constant_in_time(v: flat.Variable) -> flat.Equality:
    rate = flat.Builtin(v.type, v.span, "der", (flat.Reference(v.type, v.span, v.name),))
    zero: flat.Expression = flat.Literal(replace(v.type, dims=()), v.span, 0.0)
    for size in reversed(fixed_dims(v.type)):
        inner = () if isinstance(zero, flat.Literal) else zero.type.dims
        zero = flat.Array(replace(v.type, dims=(size, *inner)), v.span, (zero,) * size)
    return flat.Equality(v.span, v.component, rate, zero)
