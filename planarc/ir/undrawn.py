"""A flat model as its equations see it: without its drawing.

In:   FlatModel
Out:  FlatModel   no visuals, no parameters that no equation needs, fewer functions

Example: of a hinge `phi`, `w`, `tau` stay; `cylinderColor`, `animation` and `heightShift` go.
"""

from __future__ import annotations

from msgspec.structs import replace

from planarc.ir import flat
from planarc.ir.flatwalk import (
    expressions_of_model,
    expressions_of_variable,
    functions_called,
    nodes_of,
)

_FIXED = (flat.Variability.CONSTANT, flat.Variability.PARAMETER)


def without_drawing(model: flat.FlatModel) -> flat.FlatModel:
    """The model with the parameters on which its equations depend, and no others."""
    fixed = {v.name: v for v in model.variables if v.variability in _FIXED}
    moving = tuple(v for v in model.variables if v.name not in fixed)
    todo = list(expressions_of_model(replace(model, variables=moving, visuals=(), declared=())))
    needed: set[str] = set()
    while todo:
        names = {n.name for n in nodes_of(todo) if isinstance(n, flat.Reference)} - needed
        needed |= names
        todo = [e for name in names if name in fixed for e in expressions_of_variable(fixed[name])]
    kept = tuple(v for v in model.variables if v.name not in fixed or v.name in needed)
    plain = replace(model, variables=kept, visuals=(), declared=())
    functions = {f.name: f for f in model.functions}
    called = functions_called(expressions_of_model(plain), functions)
    formal = {v.type.name for name in called for v in functions[name].inputs}
    used = tuple(f for f in model.functions if f.name in called | formal)
    return replace(plain, functions=used)
