"""Evaluation while compiling: values of constants, parameters and function calls.

In:   flat.Expression
Out:  Value (float, int, bool, str; list for arrays, dict for records)

Array sizes, conditions of components, structural if-equations and ranges of loops
shape the model; the parameters that they depend on are marked structural, which
means that another value of them needs another compilation.

Example: with `parameter Integer n = 2*m; parameter Integer m = 3;` the size of
`Real x[n]` is 6, and both `n` and `m` are structural.

Reference: Modelica Language Specification 3.6, sections 3.8 and 4.5.
"""

from __future__ import annotations

from planarc.core.diagnostic import Once, PlanarcError, Related
from planarc.core.source import Span
from planarc.flatten.refusal import unknown_value, variable_for_value
from planarc.flatten.terms.conform import expect_scalar
from planarc.flatten.terms.constant import NotConstant, Value, to_expression
from planarc.flatten.tree.nodes import Env, Leaf, Scope
from planarc.flatten.values import evaluator
from planarc.flatten.values.variability import variability_of
from planarc.ir import flat, syntax


def _value(expression: flat.Expression, env: Env, mark: bool = False) -> Value:
    return evaluator.Evaluator(env.session, mark, hidden=env.hidden).value(expression)


def structural_value(expression: flat.Expression, env: Env, what: str) -> Value:
    """The value of an expression that shapes the model; refused when it has none."""
    if isinstance(expression, flat.Literal):
        return expression.value
    try:
        return _value(expression, env, mark=True)
    except NotConstant as problem:
        message = f"{what} must be known when the model is compiled: {problem.reason}"
        if problem.variable and problem.span is not None:
            raise variable_for_value(message, problem.variable, problem.span) from None
        raise unknown_value(message, problem.span or expression.span) from None


def try_value(expression: flat.Expression, env: Env, mark: bool = False) -> Value | None:
    """The value, or None when it is not known yet."""
    if isinstance(expression, flat.Literal):
        return expression.value
    try:
        value = _value(expression, env)
        if mark:  # only what really had a value is structural
            _value(expression, env, mark=True)
        return value
    except NotConstant:
        return None


def literal_value(expression: flat.Expression) -> Value | None:
    """The value of an expression of literals only."""
    if isinstance(expression, flat.Literal):
        return expression.value
    if isinstance(expression, flat.Builtin) and expression.function == "noEvent":
        return literal_value(expression.arguments[0])
    if isinstance(expression, flat.Unary) and expression.op == "not":
        inner = literal_value(expression.operand)
        return None if inner is None else not inner
    if isinstance(expression, flat.Binary):
        left, right = literal_value(expression.left), literal_value(expression.right)
        if left is None or right is None:
            return None
        try:
            return evaluator.Evaluator(None).value(expression)
        except NotConstant:
            return None
    return None


def condition_of(expression: syntax.Expression, env: Env, what: str) -> flat.Expression:
    """A typed Boolean scalar."""
    return expect_scalar(env.typed(expression), (flat.Base.BOOLEAN,), what)


def evaluate_condition(condition: syntax.Expression, scope: Scope, what: str) -> bool:
    """A structural Boolean."""
    env = Env(scope)
    return bool(structural_value(condition_of(condition, env, what), env, what))


def fold_index(index: flat.Expression, env: Env) -> flat.Expression:
    """A subscript as a literal when its value can be known now."""
    if isinstance(index, flat.Literal):
        return index
    if env.function is not None and not index.type.dims:
        return index
    if variability_of(index, env.session, env.hidden) > flat.Variability.PARAMETER:
        return index
    value = try_value(index, env, mark=True)
    return index if value is None else to_expression(value, index.type, index.span)


def range_size(
    start: flat.Expression, step: flat.Expression | None, stop: flat.Expression, env: Env
) -> int | None:
    """The number of values in a range, None when it is known only when run."""
    try:
        values = [None if e is None else _value(e, env, mark=True) for e in (start, step, stop)]
        first, increment, last = (None if v is None else float(v) for v in values)  # type: ignore[arg-type]
    except (NotConstant, TypeError, ValueError):
        return None
    assert first is not None and last is not None
    return evaluator.range_count(first, 1.0 if increment is None else increment, last, start.span)


def package_constant(leaf: Leaf, span: Span) -> flat.Expression:
    """The value of a constant that belongs to a class, not to a component."""
    if leaf.variability is not flat.Variability.CONSTANT:
        in_package = leaf.parent.layout.kind is syntax.ClassKind.PACKAGE
        hint = "declare it `constant`"
        hint = (
            f"{hint}: a package holds constants only"
            if in_package
            else (f"name it as that of a component of `{leaf.parent.name}`, or {hint}")
        )
        told = Once(
            "F217",
            f"`{leaf.name}` is no constant: outside of an instance of its class it has no value",
            span,
            hint=hint,
            related=(Related("declared here", leaf.span),),
            kind=leaf.name,
        )
        raise PlanarcError(told)
    try:
        value = evaluator.Evaluator(leaf.parent.session).leaf_value(leaf)
    except NotConstant as problem:
        message = f"the constant `{leaf.name}` has no value: {problem.reason}"
        raise unknown_value(message, problem.span or leaf.span) from None
    return to_expression(value, leaf.type, span)
