"""Built-in functions that build or reshape arrays, opened where sizes are known.

In:   typed arguments
Out:  the array by the rules of `runtime.tensor`; a call where sizes are known only when run

Example: `identity(2)` becomes `{{1, 0}, {0, 1}}`; `cross(a, b)` its three sums.

Reference: Modelica Language Specification 3.6, section 10.3.
"""

from __future__ import annotations

from collections.abc import Callable
from math import prod
from typing import Any

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError, error
from planarc.core.source import Span
from planarc.flatten.refusal import too_large
from planarc.flatten.terms.conform import (
    NUMERIC,
    common_type,
    dims_conform,
    scalar_count,
    type_text,
    unify,
)
from planarc.flatten.terms.select import array, integer, opened, real
from planarc.flatten.tree.nodes import Env
from planarc.flatten.typing import operators
from planarc.flatten.values import evaluate
from planarc.ir import flat
from planarc.runtime import tensor
from planarc.runtime.tensor import Tensor

Arguments = list[flat.Expression]
MAX_OPENED = 100_000
MANY = 1000  # arguments: as many as there are
MAX_MATRIX = 1_000_000  # entries of a matrix that is written out


def wrong_argument(name: str, value: flat.Expression) -> PlanarcError:
    hint = None
    if name == "cross" and value.type.dims == (2,):
        hint = "in the plane the product is a number: `PlanarMultiBody.Frames.cross(a, b)`"
    if value.type.name == "Complex" and not value.type.dims:
        hint = _of_complex(name, value.span.text)
    message = f"`{name}` cannot be applied to {type_text(value.type)}"
    return error("F291", message, value.span, hint=hint)


def by_fields(
    value: flat.Expression, make: Callable[[flat.Expression], flat.Expression]
) -> flat.Expression | None:
    """What is made of each field of a record, or of an array of such; None of what is neither."""
    if value.type.base is not flat.Base.RECORD or not isinstance(value, flat.Record | flat.Array):
        return None
    items = tuple(
        made if (made := by_fields(i, make)) is not None else make(i) for i in value.items
    )
    return replace(value, items=items)


def _of_complex(name: str, written: str) -> str | None:
    """What takes a complex number in the place of a built-in."""
    if name == "der":
        return f"take the derivatives of its parts, `der({written}.re)` and `der({written}.im)`"
    known = name in ("abs", "exp", "log", "sqrt")
    return f"write `Modelica.ComplexMath.{name}({written})`" if known else None


def size(arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    """`size(A)` and `size(A, i)`: literal when the type tells it."""
    value, *which = arguments
    dims = value.type.dims
    if not which:
        if None in dims:
            return flat.Builtin(flat.INTEGER.with_dims((len(dims),)), span, "size", (value,))
        return array([integer(d or 0, span) for d in dims], flat.INTEGER, span)
    dimension = which[0]
    if dimension.type.base is not flat.Base.INTEGER or dimension.type.dims:
        raise wrong_argument("size", dimension)
    known = evaluate.try_value(dimension, env, mark=True)
    if known is None:
        return flat.Builtin(flat.INTEGER, span, "size", (value, dimension))
    if not isinstance(known, int) or not 1 <= known <= len(dims):
        what = f"a value of type {type_text(value.type)}"
        raise error("F218", f"{what} has no dimension {known}", span)
    return size_along(value, known - 1, span)


def size_along(value: flat.Expression, k: int, span: Span) -> flat.Expression:
    """The size of a dimension, counted from 0: literal when the type tells it."""
    known = value.type.dims[k]
    if known is not None:
        return integer(known, span)
    return flat.Builtin(flat.INTEGER, span, "size", (value, integer(k + 1, span)))


def _sizes(name: str, arguments: Arguments, env: Env) -> flat.Dims:
    """Sizes given as arguments, None where they are known only when run."""
    sizes: list[int | None] = []
    for argument in arguments:
        if argument.type.base is not flat.Base.INTEGER or argument.type.dims:
            raise wrong_argument(name, argument)
        if env.function is not None or env.in_algorithm:
            value = evaluate.try_value(argument, env, mark=True)
        else:
            value = evaluate.structural_value(argument, env, f"a size given to `{name}`")
        if value is not None and int(value) < 0:  # type: ignore[arg-type]
            raise error("F255", f"a size given to `{name}` is negative: {value}", argument.span)
        sizes.append(None if value is None else int(value))  # type: ignore[arg-type]
    known = prod(s for s in sizes if s)  # also beside a size of zero
    if known > 10_000_000:
        raise too_large(f"`{name}` makes an array of {known:,} entries", arguments[0].span)
    return tuple(sizes)


# By sizes ---------------------------------------------------------------------------------


def _filled(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    given = {"zeros": integer(0, span), "ones": integer(1, span)}.get(name)
    value, sizes = (arguments[0], arguments[1:]) if given is None else (given, arguments)
    dims = _sizes(name, sizes, env)
    if None in dims or prod(d or 0 for d in dims) > MAX_OPENED:
        type_ = value.type.with_dims((*dims, *value.type.dims))
        return flat.Builtin(type_, span, "fill", (value, *sizes))
    result = value
    for d in reversed(dims):
        result = array([result] * (d or 0), result.type, span)
    return result


def _identity(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    (n,) = _sizes(name, arguments, env)
    given: Arguments = arguments if n is None else [integer(n, span)]
    return _applied(name, given, flat.INTEGER.with_dims((n, n)), span)


def _linspace(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    *ends, count = arguments
    (n,) = _sizes(name, [count], env)
    if n is not None and n < 2:
        raise error("F291", "`linspace` needs at least two points", span)
    given = arguments if n is None else [*ends, integer(n, span)]
    return _applied(name, given, flat.REAL.with_dims((n,)), span)


def _cat(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    along, *parts = arguments
    dimension = evaluate.structural_value(along, env, "the dimension given to `cat`")
    rank = len(parts[0].type.dims)
    if not isinstance(dimension, int) or not 1 <= dimension <= rank:
        what = f"arrays of {rank} dimensions along {dimension}"
        raise error("F291", f"`cat` cannot join {what}", span)
    return join(dimension, parts, span)


def join(dimension: int, parts: Arguments, span: Span) -> flat.Expression:
    """Arrays joined along a dimension, counted from 1."""
    type_ = parts[0].type.with_dims(())
    for part in parts:
        common = unify(type_, part.type, dims=False)
        if common is None or len(part.type.dims) != len(parts[0].type.dims):
            raise wrong_argument("cat", part)
        type_ = common.with_dims(())
    k = dimension - 1
    others = [(*p.type.dims[:k], *p.type.dims[dimension:]) for p in parts]
    if not all(dims_conform(others[0], o) for o in others):
        raise error("F291", "the arrays given to `cat` do not fit together", span)
    sizes = [p.type.dims[k] for p in parts]
    total = None if None in sizes else sum(s or 0 for s in sizes)
    type_ = type_.with_dims((*others[0][:k], total, *others[0][k:]))
    return _applied("cat", [integer(dimension, span), *parts], type_, span)


# By the dimensions of arrays --------------------------------------------------------------


class _Reshape(Data):
    """The arrays that a function takes, and the dimensions of its result by theirs."""

    takes: Callable[[flat.Dims], bool]
    gives: Callable[..., flat.Dims]
    numeric: bool = False


_RESHAPES = {
    "transpose": _Reshape(lambda d: len(d) > 1, lambda d: (d[1], d[0], *d[2:])),
    "symmetric": _Reshape(lambda d: len(d) == 2 and d[0] == d[1], lambda d: d),
    "scalar": _Reshape(lambda d: all(n in (1, None) for n in d), lambda d: ()),
    "vector": _Reshape(
        lambda d: sum(n not in (1, None) for n in d) < 2,
        lambda d: (None if None in d else prod(n or 0 for n in d),),
    ),
    "matrix": _Reshape(lambda d: all(n == 1 for n in d[2:]), lambda d: (*d, 1, 1)[:2]),
    "diagonal": _Reshape(lambda d: len(d) == 1, lambda d: d * 2, True),
    "skew": _Reshape(lambda d: d == (3,), lambda d: (3, 3), True),
    "cross": _Reshape(lambda d: d in ((3,), (None,)), lambda a, b: (3,), True),
    "outerProduct": _Reshape(lambda d: len(d) == 1, lambda a, b: (*a, *b), True),
}


def _reshaped(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    rule, type_ = _RESHAPES[name], arguments[0].type
    for argument in arguments:
        common = unify(type_, argument.type, dims=False)
        numeric = argument.type.base in NUMERIC or not rule.numeric
        if common is None or not numeric or not rule.takes(argument.type.dims):
            raise wrong_argument(name, argument)
        type_ = common
    dims = rule.gives(*(a.type.dims for a in arguments))
    if name in ("vector", "matrix") and len(arguments[0].type.dims) == len(dims):
        return arguments[0]
    return _applied(name, arguments, type_.with_dims(dims), span)


class _Typed(Data):
    """Arithmetic on typed expressions for the rules of `runtime.tensor`."""

    span: Span
    zero: flat.Expression
    one: flat.Expression

    def const(self, value: float) -> flat.Expression:
        return real(value, self.span)

    def sub(self, a: flat.Expression, b: flat.Expression) -> flat.Expression:
        return operators.binary("-", a, b, self.span)

    def add(self, a: flat.Expression, b: flat.Expression) -> flat.Expression:
        return operators.binary("+", a, b, self.span)

    def mul(self, a: flat.Expression, b: flat.Expression) -> flat.Expression:
        return operators.binary("*", a, b, self.span)

    def neg(self, a: flat.Expression) -> flat.Expression:
        return operators.unary("-", a, self.span)


def _applied(name: str, arguments: Arguments, type_: flat.Type, span: Span) -> flat.Expression:
    """The result entry by entry, or the call, where sizes are known only when run."""
    if any(None in t.dims for t in (type_, *(a.type for a in arguments))):
        return flat.Builtin(type_, span, name, tuple(arguments))
    entries = scalar_count(type_)
    given = sum(scalar_count(a.type) for a in arguments)
    if entries > (MAX_MATRIX if entries > given else tensor.MAX_ENTRIES):
        raise too_large(f"`{name}` makes an array of {entries:,} entries", span)
    number = integer if type_.base is flat.Base.INTEGER and name != "skew" else real
    t = _Typed(span, number(0, span), number(1, span))
    value = tensor.apply(t, name, _count, [_entries(a) for a in arguments])
    return _written(value, type_.with_dims(()), span)


def _count(argument: Any) -> int:
    return int(argument.value)


def _entries(value: flat.Expression) -> Any:
    """A value for the rules of `runtime.tensor`."""
    sizes = tuple(d or 0 for d in value.type.dims)
    items = [value]
    for _ in sizes:
        items = [entry for row in items for entry in opened(row)]
    return Tensor(sizes, tuple(items)) if sizes else value


def _written(value: Any, element: flat.Type, span: Span) -> flat.Expression:
    """What such a rule gives, as array constructors."""
    if not isinstance(value, Tensor):
        expression: flat.Expression = value
        return expression
    rows = [_written(row, element, span) for row in value.rows()]
    return array(rows, element.with_dims(value.shape[1:]), span)


def _ndims(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    return integer(len(arguments[0].type.dims), span)


def constructed(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    """`array(a, b)`, which is `{a, b}`: one dimension more than the entries have."""
    return array(arguments, common_type(arguments[0].type, arguments[1:], _unlike), span)


def _unlike(type_: flat.Type, item: flat.Expression) -> PlanarcError:
    texts = f"{type_text(type_)} and {type_text(item.type)}"
    return error("F272", f"the entries of an array have different types: {texts}", item.span)


#: the fewest and the most arguments, and what is built of them
BUILDERS: dict[str, tuple[int, int, Callable[[str, Arguments, Span, Env], flat.Expression]]] = {
    "ndims": (1, 1, _ndims),
    "zeros": (1, MANY, _filled),
    "ones": (1, MANY, _filled),
    "fill": (2, MANY, _filled),
    "identity": (1, 1, _identity),
    "linspace": (3, 3, _linspace),
    "cat": (2, MANY, _cat),
    "array": (1, MANY, constructed),
    **dict.fromkeys(_RESHAPES, (1, 1, _reshaped)),
    **dict.fromkeys(("cross", "outerProduct"), (2, 2, _reshaped)),
}
