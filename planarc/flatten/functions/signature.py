"""The types of a function's results, known before its body is looked at.

Sizes of results may depend on arguments: with `output Real w[size(v, 1)]` a call with a
vector of three entries has a result of three.

Reference: Modelica Language Specification 3.6, sections 12.2 and 12.4.
"""

from __future__ import annotations

from planarc.core.diagnostic import error
from planarc.core.source import Span
from planarc.flatten.terms.constant import NotConstant
from planarc.flatten.tree.nodes import Signature
from planarc.flatten.values import evaluator
from planarc.ir import flat


def result_type(
    signature: Signature, output: int, arguments: list[flat.Expression], span: Span
) -> flat.Type:
    """The type of a result; sizes that depend on the arguments are computed."""
    if output >= len(signature.outputs):
        raise error("F290", f"`{signature.name}` has no result", span)
    variable = signature.outputs[output]
    if None not in variable.type.dims:
        return variable.type
    frame = {v.name: a for v, a in zip(signature.inputs, arguments, strict=False)}
    dims = tuple(
        size if size is not None else _known_size(variable, k, frame)
        for k, size in enumerate(variable.type.dims)
    )
    return variable.type.with_dims(dims)


def _known_size(
    variable: flat.Variable, k: int, arguments: dict[str, flat.Expression]
) -> int | None:
    """The size of an output as far as the types and values of the arguments tell it."""
    if k >= len(variable.sizes) or variable.sizes[k] is None:
        return None
    size = variable.sizes[k]
    assert size is not None
    try:
        value = evaluator.Evaluator(None).value(_insert(size, arguments))
    except NotConstant:
        return None
    return value if isinstance(value, int) else None


def _insert(e: flat.Expression, arguments: dict[str, flat.Expression]) -> flat.Expression:
    """Inputs replaced by arguments, in an expression of a size."""
    match e:
        case flat.Reference(name=name) if name in arguments and not e.subscripts:
            return arguments[name]
        case flat.Unary():
            return flat.Unary(e.type, e.span, e.op, _insert(e.operand, arguments))
        case flat.Binary():
            left, right = _insert(e.left, arguments), _insert(e.right, arguments)
            return flat.Binary(e.type, e.span, e.op, left, right)
        case flat.Builtin():
            inner = tuple(_insert(a, arguments) for a in e.arguments)
            return flat.Builtin(e.type, e.span, e.function, inner)
        case flat.If():
            branches = tuple((_insert(c, arguments), _insert(v, arguments)) for c, v in e.branches)
            return flat.If(e.type, e.span, branches, _insert(e.otherwise, arguments))
    return e
