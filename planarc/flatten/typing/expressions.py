"""Typing of expressions: every name resolved, every node with its type.

In:   syntax.Expression, Env
Out:  flat.Expression

Example: `2*r[1]` in the component `body` becomes
    Binary(Real, "*", Literal(Integer, 2), Reference(Real, "body.r", (1,)))

Promises:  operands have types that the operator allows, or the expression is refused.
Reference: Modelica Language Specification 3.6, chapters 3 and 10.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from planarc.core.diagnostic import PlanarcError, error
from planarc.flatten.refusal import for_each
from planarc.flatten.terms.conform import common_type, expect_scalar, type_text, unify
from planarc.flatten.terms.select import array, integer
from planarc.flatten.tree.nodes import Env
from planarc.flatten.typing import comprehension, matrices, operators, references
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
    base, dimension = env.end
    size = base.type.dims[dimension]
    if size is not None:
        return integer(size, node.span)
    return flat.Builtin(flat.INTEGER, node.span, "size", (base, integer(dimension + 1, node.span)))


def _colon(node: syntax.Colon, env: Env) -> flat.Expression:
    raise error("F223", "`:` has a meaning only as a subscript or a dimension", node.span)


def _unary(node: syntax.Unary, env: Env) -> flat.Expression:
    return operators.unary(node.op, type_expression(node.operand, env), node.span)


def _binary(node: syntax.Binary, env: Env) -> flat.Expression:
    """Long sums lean to the left: their spine is walked, not recursed."""
    spine: list[syntax.Binary] = []
    left: syntax.Expression = node
    while isinstance(left, syntax.Binary):
        spine.append(left)
        left = left.left
    spine.reverse()
    value, *others = _each((left, *(b.right for b in spine)), env)
    for binary, right in zip(spine, others, strict=True):
        value = operators.binary(binary.op, value, right, binary.span)
    return value


def _each(parts: Iterable[syntax.Expression], env: Env) -> list[flat.Expression]:
    return for_each(parts, lambda part: type_expression(part, env))


def _if(node: syntax.If, env: Env) -> flat.Expression:
    conditions = []
    for condition, _ in node.branches:
        typed = type_expression(condition, env)
        conditions.append(expect_scalar(typed, (flat.Base.BOOLEAN,), "the condition of `if`"))
    branches = [value for _, value in node.branches]
    chosen = _chosen_branch(conditions)
    if chosen is not None:
        return type_expression([*branches, node.otherwise][chosen], env)
    *values, otherwise = _each((*branches, node.otherwise), env)
    type_ = otherwise.type
    for branch in values:
        common = unify(branch.type, type_)
        if common is None:
            chosen = _structural_branch(conditions, branch.type, type_, env)
            if chosen is not None:
                return [*values, otherwise][chosen]
            raise error(
                "F271",
                f"the branches of `if` have different types: {type_text(branch.type)} "
                f"and {type_text(type_)}",
                branch.span,
            )
        type_ = common
    return flat.If(type_, node.span, tuple(zip(conditions, values, strict=True)), otherwise)


def _structural_branch(
    conditions: list[flat.Expression], one: flat.Type, other: flat.Type, env: Env
) -> int | None:
    """Branches of different size: parameters must choose one of them now (3.6.5)."""
    if unify(one, other, dims=False) is None:
        return None
    for index, condition in enumerate(conditions):
        known = evaluate.try_value(condition, env, mark=True)
        if known is None:
            return None
        if known:
            return index
    return len(conditions)


def _chosen_branch(conditions: list[flat.Expression]) -> int | None:
    """The branch that literal conditions choose, so that the others need no types."""
    for index, condition in enumerate(conditions):
        known = evaluate.literal_value(condition)
        if known is None:
            return None
        if known:
            return index
    return len(conditions)


def _range(node: syntax.Range, env: Env) -> flat.Expression:
    parts = (node.start, node.stop) if node.step is None else (node.start, node.stop, node.step)
    start, stop, *steps = _each(parts, env)
    step = steps[0] if steps else None
    return operators.range_(start, step, stop, node.span, env)


def _call(node: syntax.Call, env: Env) -> flat.Expression:
    return env.session.makers.call(node, env)


def _partial(node: syntax.PartialApplication, env: Env) -> flat.Expression:
    raise error("F292", "a function can be given only to an input that is a function", node.span)


def _comprehension(node: syntax.Comprehension, env: Env) -> flat.Expression:
    return comprehension.type_comprehension(node, "array", env)


def _array(node: syntax.Array, env: Env) -> flat.Expression:
    if len(node.items) == 1 and isinstance(node.items[0], syntax.Comprehension):
        return comprehension.type_comprehension(node.items[0], "array", env)
    items = _each(node.items, env)
    if not items:
        raise error("F272", "`{}` needs at least one entry: write `zeros(0)`", node.span)
    return array(items, common_type(items[0].type, items[1:], _unlike), node.span)


def _unlike(type_: flat.Type, item: flat.Expression) -> PlanarcError:
    texts = f"{type_text(type_)} and {type_text(item.type)}"
    return error("F272", f"the entries of an array have different types: {texts}", item.span)


def _matrix(node: syntax.Matrix, env: Env) -> flat.Expression:
    rows = for_each(node.rows, lambda row: _each(row, env))
    return matrices.matrix(rows, node.span)


def _tuple(node: syntax.Tuple, env: Env) -> flat.Expression:
    if len(node.items) == 1 and node.items[0] is not None:
        return type_expression(node.items[0], env)
    raise error("F273", "a list in parentheses may stand only left of a function call", node.span)


def _index(node: syntax.Index, env: Env) -> flat.Expression:
    return references.with_subscripts(
        type_expression(node.base, env), node.subscripts, env, node.span
    )


def _member(node: syntax.Member, env: Env) -> flat.Expression:
    return references.field_of(type_expression(node.base, env), node.name, node.span)


_TYPERS: dict[type, Callable[[Any, Env], flat.Expression]] = {
    **dict.fromkeys(_LITERALS, _literal),
    syntax.End: _end,
    syntax.Colon: _colon,
    syntax.Ref: references.type_reference,
    syntax.Unary: _unary,
    syntax.Binary: _binary,
    syntax.If: _if,
    syntax.Range: _range,
    syntax.Call: _call,
    syntax.PartialApplication: _partial,
    syntax.Comprehension: _comprehension,
    syntax.Array: _array,
    syntax.Matrix: _matrix,
    syntax.Tuple: _tuple,
    syntax.Index: _index,
    syntax.Member: _member,
}
