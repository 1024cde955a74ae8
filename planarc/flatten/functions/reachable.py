"""The functions that a flat model calls, directly or through others.

Functions that were only run while compiling are left out. The interfaces of inputs that
are functions themselves come along, as partial functions.
"""

from __future__ import annotations

from msgspec.structs import replace

from planarc.flatten.tree.nodes import Session
from planarc.ir import flat
from planarc.ir.flatwalk import expressions_of_model, functions_called


def with_functions(model: flat.FlatModel, session: Session) -> flat.FlatModel:
    """The model with the functions that it calls, in the order in which they were made."""
    wanted = functions_called(expressions_of_model(model), session.functions)
    called = [f for name, f in session.functions.items() if name in wanted]
    return replace(model, functions=(*_interfaces(called, session), *called))


def _interfaces(functions: list[flat.Function], session: Session) -> list[flat.Function]:
    """The partial functions that are the types of inputs."""
    names = {v.type.name: None for f in functions for v in f.inputs if _is_function(v)}
    return [
        flat.Function(name, formal.inputs, formal.outputs, partial=True)
        for name, formal in session.formals.items()
        if name in names
    ]


def _is_function(variable: flat.Variable) -> bool:
    return variable.type.base is flat.Base.FUNCTION
