"""Typing of expressions: every name resolved, every node with its type.

In:   syntax.Expression, Env
Out:  flat.Expression

Example: `2*r[1]` in the component `body` becomes
    Binary(Real, "*", Literal(Integer, 2), Reference(Real, "body.r", (1,)))

Promises:  operands have types that the operator allows, or the expression is refused.
Reference: Modelica Language Specification 3.6, chapters 3 and 10.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from planarc.core.diagnostic import error
from planarc.core.source import Span
from planarc.flatten.refusal import OutOfRange, for_each
from planarc.flatten.terms.conform import type_text, unify
from planarc.flatten.terms.constant import Value
from planarc.flatten.tree.nodes import Env, is_overloaded
from planarc.flatten.typing import arrays, clocks, comprehension, operators, references
from planarc.flatten.values import evaluate
from planarc.ir import flat, syntax


def type_expression(expression: syntax.Expression, env: Env) -> flat.Expression:
    """The typed form of an expression in its environment."""
    return _TYPERS[type(expression)](expression, env)


def _literal(node: Literal, env: Env) -> flat.Expression:
    return flat.Literal(_LITERALS[type(node)], node.span, node.value)


Literal = syntax.Integer | syntax.Real | syntax.String | syntax.Boolean
_LITERALS: dict[type, flat.Type] = {
    syntax.Integer: flat.INTEGER,
    syntax.Real: flat.REAL,
    syntax.String: flat.STRING,
    syntax.Boolean: flat.BOOLEAN,
}


def _end(node: syntax.End, env: Env) -> flat.Expression:
    if env.end is None:
        raise error("F223", "`end` stands for a size only inside a subscript", node.span)
    return arrays.size_along(*env.end, node.span)


def _binary(node: syntax.Binary, env: Env) -> flat.Expression:
    """Long sums lean to the left: their spine is walked, not recursed."""
    spine: list[syntax.Binary] = []
    left: syntax.Expression = node
    while isinstance(left, syntax.Binary):
        spine.append(left)
        left = left.left
    spine.reverse()
    value, *others = for_each((left, *(b.right for b in spine)), env.typed)
    for binary, right in zip(spine, others, strict=True):
        value = _operated(binary.op, (value, right), binary.span, env)
    return value


def _operated(
    op: str, operands: tuple[flat.Expression, ...], span: Span, env: Env
) -> flat.Expression:
    """An operator's value; operator records have functions of their own."""
    if any(is_overloaded(o, env) for o in operands):
        return env.session.makers.operate(op, operands, span, env)
    if len(operands) == 1:
        return operators.unary(op, operands[0], span)
    left, right = operands
    return operators.binary(op, left, right, span)


def _if(node: syntax.If, env: Env) -> flat.Expression:
    what = "the condition of `if`"
    conditions = [evaluate.condition_of(condition, env, what) for condition, _ in node.branches]
    parts = [*(value for _, value in node.branches), node.otherwise]
    chosen = _chosen(conditions, evaluate.literal_value)
    if chosen is not None:
        return env.typed(parts[chosen])  # the others need no types
    try:
        *values, otherwise = for_each(parts, env.typed)
    except OutOfRange:  # parameters may choose another branch: `if i < n then x[i + 1] else 0`
        chosen = _chosen(conditions, lambda c: evaluate.try_value(c, env, mark=True))
        if chosen is None:
            raise
        return env.typed(parts[chosen])
    type_ = otherwise.type
    for branch in values:
        common = unify(branch.type, type_)
        if common is None:
            if unify(branch.type, type_, dims=False) is not None:  # sizes that parameters choose
                chosen = _chosen(conditions, lambda c: evaluate.try_value(c, env, mark=True))
            if chosen is not None:
                return [*values, otherwise][chosen]
            types = f"{type_text(branch.type)} and {type_text(type_)}"
            raise error("F271", f"the branches of `if` have different types: {types}", branch.span)
        type_ = common
    if clocks.is_clock(type_):
        return [*values, otherwise][clocks.branch_of(conditions, what, env)]
    return flat.If(type_, node.span, tuple(zip(conditions, values, strict=True)), otherwise)


def _chosen(
    conditions: list[flat.Expression], value_of: Callable[[flat.Expression], Value | None]
) -> int | None:
    """The branch that the values of conditions choose, as far as they are known (3.6.5)."""
    for index, condition in enumerate(conditions):
        known = value_of(condition)
        if known is None:
            return None
        if known:
            return index
    return len(conditions)


def _range(node: syntax.Range, env: Env) -> flat.Expression:
    parts = (node.start, node.stop) if node.step is None else (node.start, node.stop, node.step)
    start, stop, *steps = for_each(parts, env.typed)
    step = steps[0] if steps else None
    return operators.range_(start, step, stop, node.span, env)


def _array(node: syntax.Array, env: Env) -> flat.Expression:
    if len(node.items) == 1 and isinstance(node.items[0], syntax.Comprehension):
        return comprehension.type_comprehension(node.items[0], "array", env)
    items = for_each(node.items, env.typed)
    if not items:
        raise error("F272", "`{}` needs at least one entry: write `zeros(0)`", node.span)
    return arrays.constructed("array", items, node.span, env)


def _matrix(node: syntax.Matrix, env: Env) -> flat.Expression:
    from planarc.flatten.typing.matrices import matrix

    rows = for_each(node.rows, lambda row: for_each(row, env.typed))
    return matrix(rows, node.span)


def _tuple(node: syntax.Tuple, env: Env) -> flat.Expression:
    if len(node.items) == 1 and node.items[0] is not None:
        return type_expression(node.items[0], env)
    message = "a list in parentheses may stand only left of a function call"
    vector = f"{{{node.span.text[1:-1].strip()}}}"
    raise error("F273", message, node.span, hint=f"write `{vector}` for a vector")


def _refused(code: str, message: str) -> Callable[[syntax.Expression, Env], flat.Expression]:
    def refuse(node: syntax.Expression, env: Env) -> flat.Expression:
        raise error(code, message, node.span)

    return refuse


_TYPERS: dict[type, Callable[[Any, Env], flat.Expression]] = {
    **dict.fromkeys(_LITERALS, _literal),
    syntax.End: _end,
    syntax.Colon: _refused("F223", "`:` has a meaning only as a subscript or a dimension"),
    syntax.Ref: references.type_reference,
    syntax.Unary: lambda node, env: _operated(node.op, (env.typed(node.operand),), node.span, env),
    syntax.Binary: _binary,
    syntax.If: _if,
    syntax.Range: _range,
    syntax.Call: lambda node, env: env.session.makers.call(node, env),
    syntax.PartialApplication: _refused(
        "F292", "a function can be given only to an input that is a function"
    ),
    syntax.Comprehension: lambda node, env: comprehension.type_comprehension(node, "array", env),
    syntax.Array: _array,
    syntax.Matrix: _matrix,
    syntax.Tuple: _tuple,
    syntax.Index: lambda node, env: references.with_subscripts(
        env.typed(node.base), node.subscripts, env, node.span, node.base.span.text
    ),
    syntax.Member: lambda node, env: references.field_of(
        env.typed(node.base), node.name, node.span
    ),
}
