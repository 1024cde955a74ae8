"""Dimensions of components: written sizes evaluated, `:` deduced from the binding.

Reference: Modelica Language Specification 3.6, sections 10.1 and 10.3.1.
"""

from __future__ import annotations

from collections.abc import Sequence

from planarc.core.diagnostic import error
from planarc.flatten.instances import bindings
from planarc.flatten.terms.conform import no_scalar, type_text
from planarc.flatten.tree.modify import type_mod
from planarc.flatten.tree.nodes import Element, Env, Leaf, Mod, Scope
from planarc.flatten.typing import references
from planarc.flatten.typing.modifiers import type_binding
from planarc.flatten.values import compute, evaluate
from planarc.ir import flat, syntax

Written = Sequence[tuple[syntax.Expression, Scope]]


def _size(expression: syntax.Expression, scope: Scope, name: str) -> int:
    if isinstance(expression, syntax.Integer):
        return expression.value
    enumerated = references.size_of_type(expression, scope)
    if enumerated is not None:
        return enumerated
    typed = Env(scope).typed(expression)
    what = f"the size of `{name}`"
    if typed.type.base is not flat.Base.INTEGER or typed.type.dims:
        message = f"{what} must be an Integer, but is {type_text(typed.type)}"
        raise no_scalar("F255", message, expression.span)
    value = evaluate.structural_value(typed, Env(scope), what)
    assert isinstance(value, int)
    if value < 0:
        raise error("F255", f"{what} is negative: {value}", expression.span)
    return value


def leaf_dims(leaf: Leaf, written: Written) -> tuple[int, ...]:
    """The sizes of a variable; it may leave some of them to its value."""
    if not _is_open(written):
        return tuple([_size(expression, scope, leaf.name) for expression, scope in written])
    binding = leaf.mod.binding or type_mod(leaf.layout).binding
    value: flat.Expression | None = None
    if bindings.record_binding(leaf.parent) is not None:
        whole = bindings.record_value(leaf.parent)
        value = None if whole is None else references.field_of(whole, leaf.element.name, whole.span)
    elif binding is not None:
        value = type_binding(binding)
    if value is None:
        start = leaf.mod.sub("start").binding
        value = None if start is None or start.each else type_binding(start)
    return _deduced(written, value, leaf.name, leaf.element)


def family_dims(written: Written, element: Element, mod: Mod, name: str) -> tuple[int, ...]:
    """The sizes of an array of components."""
    if not _is_open(written):
        return tuple([_size(expression, scope, name) for expression, scope in written])
    value = None if mod.binding is None else type_binding(mod.binding)
    return _deduced(written, value, name, element)


def _is_open(written: Written) -> bool:
    return bool(written) and any(isinstance(size, syntax.Colon) for size, _ in written)


def _names_itself(expression: syntax.Expression, name: str) -> bool:
    """`A[:, size(A, 1)]`: another size of the array being declared."""
    if not isinstance(expression, syntax.Call):
        return False
    return any(isinstance(a, syntax.Ref) and a.names == (name,) for a in expression.arguments)


def _deduced(
    written: Written, value: flat.Expression | None, name: str, element: Element
) -> tuple[int, ...]:
    span = element.definition.span
    if value is None:
        message = f"the size `:` of `{name}` needs a value that tells it"
        hint = "write the size, or bind the variable"
        raise error("F256", message, span, hint=hint)
    if len(value.type.dims) != len(written):
        raise error(
            "F256",
            f"`{name}` has {len(written)} dimensions, but its value is {type_text(value.type)}",
            value.span,
        )
    sizes = []
    dims = value.type.dims
    if None in dims and _is_open(written):
        dims = _computed(value, written[0][1], dims)
    for (expression, scope), size in zip(written, dims, strict=True):
        if _names_itself(expression, element.name) and size is not None:
            sizes.append(_own_size(expression, dims) or size)
        elif not isinstance(expression, syntax.Colon):
            sizes.append(_size(expression, scope, name))
        elif size is None:
            raise error("F256", f"the size of the value of `{name}` is not known", value.span)
        else:
            sizes.append(size)
    return tuple(sizes)


def _own_size(expression: syntax.Expression, dims: flat.Dims) -> int | None:
    """The size that `size(A, 1)` names of the value with these sizes, if it is that."""
    match expression:
        case syntax.Call(function=syntax.Ref() as function, arguments=(_, syntax.Integer() as k)):
            if function.names == ("size",) and 1 <= k.value <= len(dims):
                return dims[k.value - 1]
    return None


def _computed(value: flat.Expression, scope: Scope, dims: flat.Dims) -> flat.Dims:
    """The sizes that a value turns out to have, where it can be computed now."""
    found = evaluate.try_value(value, Env(scope), mark=True)
    if found is None:
        return dims
    sizes = compute.shape(found)
    return (*sizes, *dims[len(sizes) :])
