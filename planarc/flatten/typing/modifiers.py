"""The values of modifiers, typed in the scope that they are written in.

Reference: Modelica Language Specification 3.6, section 7.2.
"""

from __future__ import annotations

import re

from planarc.core.diagnostic import Once, PlanarcError
from planarc.core.mend import Each
from planarc.core.prose import counted
from planarc.core.source import Span
from planarc.flatten.terms.conform import dims_conform, type_text
from planarc.flatten.terms.select import pick
from planarc.flatten.tree.nodes import Binding, Env
from planarc.ir import flat

_NAME = r"\w+\s*=\s*$"


def type_binding(binding: Binding, dims: flat.Dims = ()) -> flat.Expression:
    """The expression of a modifier, for its member of an array of components; `dims` are the sizes
    of what it modifies in that member."""
    if binding.typed is None:
        if not binding.whole:
            binding.whole.append(Env(binding.scope).typed(binding.expression))
        (typed,) = binding.whole
        binding.typed = _member_value(typed, binding, dims) if binding.subscripts else typed
    return binding.typed


def _member_value(typed: flat.Expression, binding: Binding, dims: flat.Dims) -> flat.Expression:
    of_one = bool(dims) and dims_conform(dims, typed.type.dims)  # `r={1, 0}` of one member
    if of_one or len(typed.type.dims) < len(binding.subscripts):
        span = binding.span
        needed = "a value for each member" if of_one else "an array"
        raise PlanarcError(
            Once(
                "F224",
                f"a modifier of an array of components needs {needed}, but this is "
                f"{type_text(typed.type)}",
                span,
                hint="write `each` before it if all members get the same value, as in "
                f"`({_with_each(span)})`",
                mend=Each(),
                kind=f"{span.source.name}:{span.line}" if span else "",  # often they all lack it
            )
        )
    for size, members in zip(typed.type.dims, binding.sizes, strict=False):
        if size is not None and size != members:
            given = counted(size, "value")
            message = f"the modifier has {given} for {counted(members, 'member')}"
            if size < members:
                message = f"the modifier has {given}, but none for member {size + 1}"
            hint = "give as many values as there are members"
            kind = f"{binding.span.source.name}:{binding.span.start}"
            raise PlanarcError(Once("F224", message, binding.span, hint=hint, kind=kind))
    return pick(typed, binding.subscripts)


def _with_each(value: Span) -> str:
    """The modifier of a value with `each` before it; where that is long, another one."""
    text = value.source.text
    name = re.search(_NAME, text[text.rfind("\n", 0, value.start) + 1 : value.start])
    modifier = f"{name[0]}{value.text}" if name else ""
    return f"each {modifier}" if modifier and re.fullmatch(".{,40}", modifier) else "each m=1"
