"""Array constructors and reductions with iterators, and the ranges of for-loops.

In:   `e for i in r, j in s`
Out:  an array (or `sum`, `product`, `min`, `max` of it), opened when the ranges are known

Example: `{i^2 for i in 1:3}` becomes `{1^2, 2^2, 3^2}`; inside a function whose
sizes are unknown it stays a Comprehension.

Reference: Modelica Language Specification 3.6, sections 10.3.4.1, 10.4.1 and 11.2.2.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress

from planarc.core.diagnostic import PlanarcError, error
from planarc.core.prose import counted, listed
from planarc.core.source import Span
from planarc.flatten.refusal import too_large, unknown_value
from planarc.flatten.terms.conform import common_type
from planarc.flatten.terms.constant import to_expression
from planarc.flatten.terms.select import array, integer
from planarc.flatten.tree import lookup
from planarc.flatten.tree.demand import layout_of
from planarc.flatten.tree.nodes import Class, Env, Family, Leaf, is_overloaded
from planarc.flatten.typing import references
from planarc.flatten.typing.arrays import size_along
from planarc.flatten.values import evaluate
from planarc.flatten.values.variability import variability_of
from planarc.ir import flat, syntax
from planarc.ir.syntaxwalk import references_in
from planarc.runtime import elementary

MAX_OPENED = 200_000


def type_comprehension(node: syntax.Comprehension, reduce: str, env: Env) -> flat.Expression:
    """The value of a comprehension, or of a reduction over one."""
    if reduce == "array":
        opened = _open_array(node, node.iterators[::-1], env)
    else:
        items = _open_items(node, node.iterators, env)
        opened = None if items is None else _reduced(node, items, reduce, env)
    return _kept(node, reduce, env) if opened is None else opened


def iteration_values(
    iterator: syntax.Iterator, env: Env, uses: object = ()
) -> list[flat.Expression] | None:
    """The values that an iterator takes, None when they are known only when run."""
    typed = iteration_range(iterator, env, uses)
    if env.function is not None and not isinstance(typed, flat.Array):
        value = evaluate.try_value(typed, env)
    elif isinstance(typed, flat.Array) and _changes(typed, env):
        return list(typed.items)
    elif env.in_algorithm and _changes(typed, env):
        return None
    else:
        value = evaluate.structural_value(
            typed, env, f"the range of the iterator `{iterator.name}`"
        )
    if value is None:
        return None
    assert isinstance(value, list)
    if len(value) > MAX_OPENED:
        raise too_large(f"a loop over {len(value):,} values is too long", iterator.span)
    element = typed.type.element()
    return [to_expression(v, element, iterator.span) for v in value]


def turns(loop: syntax.ForEquation | syntax.ForStatement, env: Env) -> Iterator[Env]:
    """The environment of every turn of a loop, whose ranges must be known now."""

    def inner(iterators: tuple[syntax.Iterator, ...], env: Env) -> Iterator[Env]:
        if not iterators:
            yield env
            return
        values = iteration_values(iterators[0], env, loop.body)
        if values is None:
            raise unknown_value("the range of this loop must be known when compiling", loop.span)
        for value in values:
            yield from inner(iterators[1:], env.with_iterator(iterators[0], value))

    return inner(loop.iterators, env)


def _changes(typed: flat.Expression, env: Env) -> bool:
    return variability_of(typed, env.session, env.hidden) > flat.Variability.PARAMETER


def iteration_range(iterator: syntax.Iterator, env: Env, uses: object = ()) -> flat.Expression:
    """The typed range of an iterator: an array, a type name, or deduced from its use."""
    if iterator.range is None:
        return _deduced_range(iterator, env, uses)
    if isinstance(iterator.range, syntax.Ref):
        typed = _range_of_type(iterator.range, env)
        if typed is not None:
            return typed
    typed = env.typed(iterator.range)
    if len(typed.type.dims) != 1:
        message = f"the iterator `{iterator.name}` needs a vector to run over"
        hint = "write a range such as `1:n`"
        raise error("F275", message, iterator.range.span, hint=hint)
    return typed


def _range_of_type(ref: syntax.Ref, env: Env) -> flat.Expression | None:
    """`for e in Kind`: all values of an enumeration or of Boolean."""
    if ref.parts[0].name in env.locals:
        return None
    found = lookup.find(env.scope, ref.parts[0].name, ref.span)
    if found is None or not found[0].is_class:
        return None
    view = references.resolve(ref, env)
    builtin = layout_of(view).builtin if isinstance(view, Class) else None
    if builtin is None:
        return None
    if builtin.base is flat.Base.BOOLEAN:
        items = [flat.Literal(flat.BOOLEAN, ref.span, v) for v in (False, True)]
        return array(list(items), flat.BOOLEAN, ref.span)
    numbers = range(1, len(builtin.literals) + 1)
    return array([flat.Literal(builtin, ref.span, n) for n in numbers], builtin, ref.span)


def _deduced_range(iterator: syntax.Iterator, env: Env, uses: object) -> flat.Expression:
    """`for i loop x[i] ...`: 1 to the size of the array that `i` indexes (11.2.2.1)."""
    found = [_range_of(use, iterator, env) for use in _find_uses(iterator.name, uses)]
    if not found:
        message = f"the iterator `{iterator.name}` has no range and is not used as a plain index"
        raise error("F275", message, iterator.span)
    sizes = sorted({r.type.dims[0] for r in found if r.type.dims[0] is not None})
    if len(sizes) > 1:
        named, counts = iterator.name, listed(map(str, sizes))
        message = f"the iterator `{named}` is the index of arrays of {counts} entries"
        raise error("F275", message, iterator.span, hint=f"write a range: `{named} in 1:n`")
    return found[0]


def _range_of(use: tuple[syntax.Ref, int], iterator: syntax.Iterator, env: Env) -> flat.Expression:
    """The values that index one dimension of an array, whose type may be an enumeration."""
    prefix, dimension = use
    last = syntax.RefPart(prefix.span, prefix.parts[-1].name)
    base = syntax.Ref(prefix.span, (*prefix.parts[:-1], last), prefix.absolute)
    view = references.resolve(base, env) if base.parts[0].name not in env.locals else None
    span = iterator.span
    if isinstance(view, Leaf):
        declared = view.element.definition
        sizes = declared.dimensions if isinstance(declared, syntax.Component) else ()
        written = sizes[dimension] if dimension < len(sizes) else None
        if isinstance(written, syntax.Ref):
            typed = _range_of_type(written, Env(view.element.scope))
            if typed is not None:
                return typed
    if isinstance(view, Family):
        _check_dimension(prefix, dimension, view.dims)
        size: int | None = view.dims[dimension]
        stop: flat.Expression = integer(view.dims[dimension], span)
    else:
        value = env.typed(base)
        _check_dimension(prefix, dimension, value.type.dims)
        size, stop = value.type.dims[dimension], size_along(value, dimension, span)
    return flat.Range(flat.INTEGER.with_dims((size,)), span, integer(1, span), None, stop)


def _check_dimension(indexed: syntax.Ref, dimension: int, dims: flat.Dims) -> None:
    """Refuse `v[i, i]` of a vector, and `x[i]` of a number."""
    if dimension >= len(dims):
        part = indexed.parts[-1]
        has = f"`{part.name}` has {counted(len(dims), 'dimension')}, not {len(part.subscripts)}"
        raise error("F218", has, indexed.span)


def _find_uses(name: str, uses: object) -> Iterator[tuple[syntax.Ref, int]]:
    for ref in references_in(uses):
        for count, part in enumerate(ref.parts, 1):
            for k, subscript in enumerate(part.subscripts):
                if isinstance(subscript, syntax.Ref) and subscript.names == (name,):
                    yield syntax.Ref(ref.span, ref.parts[:count], ref.absolute), k


def _open_array(
    node: syntax.Comprehension, iterators: tuple[syntax.Iterator, ...], env: Env
) -> flat.Expression | None:
    """`{e for i, j}` is `{{e for i} for j}`: the last iterator is the outermost (10.4.1.2)."""
    if not iterators:
        return env.typed(node.body)
    values = iteration_values(iterators[0], env, (node.body,))
    if values is None:
        return None
    items = []
    for value in values:
        item = _open_array(node, iterators[1:], env.with_local(iterators[0].name, value))
        if item is None:
            return None
        items.append(item)
        _bound(math.prod(d or 0 for d in item.type.dims) * len(values), node.span)
    type_ = _common_type(items) if items else _type_of_none(node, iterators, env)
    return array(items, type_, node.span)


def _common_type(items: list[flat.Expression]) -> flat.Type:
    return common_type(items[0].type, items[1:], _unlike)


def _type_of_none(
    node: syntax.Comprehension, iterators: tuple[syntax.Iterator, ...], env: Env
) -> flat.Type:
    """The type of the entries of an array that has none; sizes that hang on them are zero."""
    type_ = _type_of_body(node, iterators, env) or flat.REAL
    inner = (iteration_values(i, env, (node.body,)) for i in iterators[1:])
    sizes = (len(values or ()) for values in inner)
    return type_.with_dims((*sizes, *(n or 0 for n in type_.dims)))


def _unlike(_: flat.Type, item: flat.Expression) -> PlanarcError:
    return error("F272", "the entries of an array have different types", item.span)


def _open_items(
    node: syntax.Comprehension, iterators: tuple[syntax.Iterator, ...], env: Env
) -> list[flat.Expression] | None:
    if not iterators:
        return [env.typed(node.body)]
    values = iteration_values(iterators[0], env, (node.body,))
    if values is None:
        return None
    items: list[flat.Expression] = []
    for value in values:
        inner = _open_items(node, iterators[1:], env.with_local(iterators[0].name, value))
        if inner is None:
            return None
        items += inner
        _bound(len(inner) * len(values), node.span)
    return items


def _bound(count: int, span: Span) -> None:
    if count > MAX_OPENED:
        raise too_large(f"a loop over {count:,} values is too long", span)


def _reduced(
    node: syntax.Comprehension, items: list[flat.Expression], reduce: str, env: Env
) -> flat.Expression:
    if not items:
        return _of_nothing(node, reduce, env)
    type_, span = _common_type(items), node.span
    if reduce in ("sum", "product") and is_overloaded(items[0], env):
        return env.session.makers.operate(reduce, (array(items, type_, span),), span, env)
    if type_.dims and reduce == "sum":
        total = items[0]
        for item in items[1:]:
            total = flat.Binary(type_, span, "+", total, item)
        return total
    return flat.Builtin(type_, span, reduce, (array(items, type_, span),))


def _of_nothing(node: syntax.Comprehension, reduce: str, env: Env) -> flat.Expression:
    """A sum of no Integers is the Integer 0, which stands for a Real, too. The greatest number is
    one that only a Real has."""
    number = elementary.OF_NOTHING[reduce]
    type_ = _type_of_body(node, node.iterators, env)
    if type_ is not None and is_overloaded(nothing := array([], type_, node.span), env):
        return env.session.makers.operate(reduce, (nothing,), node.span, env)
    if reduce in ("sum", "product") and (type_ is None or type_.base is not flat.Base.REAL):
        return integer(int(number), node.span)
    return flat.Literal(flat.REAL, node.span, number)


def _type_of_body(
    node: syntax.Comprehension, iterators: tuple[syntax.Iterator, ...], env: Env
) -> flat.Type | None:
    """The type of an entry; None where that hangs on the iterators' values."""
    with suppress(PlanarcError):
        for iterator in iterators:
            type_ = iteration_range(iterator, env, (node.body,)).type.element()
            env = env.with_local(iterator.name, flat.Reference(type_, iterator.span, iterator.name))
        return env.typed(node.body).type
    return None


def _kept(node: syntax.Comprehension, reduce: str, env: Env) -> flat.Expression:
    """Sizes are unknown: the iterators stay."""
    if env.function is None and not env.in_algorithm:
        raise unknown_value("the range of this loop must be known when compiling", node.span)
    ranges = []
    for iterator in node.iterators[::-1] if reduce == "array" else node.iterators:
        typed = iteration_range(iterator, env, (node.body,))
        local = flat.Reference(typed.type.element(), iterator.span, iterator.name)
        env = env.with_local(iterator.name, local)
        ranges.append((iterator.name, typed))
    body = env.typed(node.body)
    type_ = body.type
    if reduce == "array":
        sizes = tuple(r.type.dims[0] for _, r in ranges)
        type_ = type_.with_dims((*sizes, *type_.dims))
    return flat.Comprehension(type_, node.span, body, tuple(ranges), reduce)
