"""The values of modifiers, typed in the scope that they are written in.

Reference: Modelica Language Specification 3.6, section 7.2.
"""

from __future__ import annotations

from planarc.core.diagnostic import Once, PlanarcError, error
from planarc.core.mend import Each
from planarc.flatten.terms.conform import type_text
from planarc.flatten.terms.select import pick
from planarc.flatten.tree.nodes import Binding, Env
from planarc.ir import flat


def type_binding(binding: Binding) -> flat.Expression:
    """The expression of a modifier, for its member of an array of components."""
    if binding.typed is None:
        typed = Env(binding.scope).typed(binding.expression)
        binding.typed = _member_value(typed, binding) if binding.subscripts else typed
    return binding.typed


def _member_value(typed: flat.Expression, binding: Binding) -> flat.Expression:
    if len(typed.type.dims) < len(binding.subscripts):
        span = binding.span
        raise PlanarcError(
            Once(
                "F224",
                "a modifier of an array of components needs an array, but this is "
                f"{type_text(typed.type)}",
                span,
                hint="write `each` before it if all members get the same value, as in `(each m=1)`",
                mend=Each(),
                kind=f"{span.source.name}:{span.line}" if span else "",  # often they all lack it
            )
        )
    for size, index in zip(typed.type.dims, binding.subscripts, strict=False):
        if size is not None and index > size:
            message = f"the modifier has {size} values, but the array of components has more"
            raise error("F224", message, binding.span)
    return pick(typed, binding.subscripts)
