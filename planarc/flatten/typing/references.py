"""References: from `a.b[1].c` to the node or the typed expression that it means.

In:   syntax.Ref, Env
Out:  View (nodes of the instance tree, as nested lists for slices), or a typed value

Example: with `Link link[2]`, `link[i].body.m` inside `for i in 1:2` becomes the
Reference `link[1].body.m`; `link.body.m` becomes `{link[1].body.m, link[2].body.m}`.

Promises:  constants of packages are replaced by their values; protected elements are
           not reached through a dot; a component that is not there is reported.
Reference: Modelica Language Specification 3.6, sections 5.3.2 and 10.5.

The file is long because parts, subscripts and values of a reference are steps of one walk.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from msgspec import Struct
from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic, Once, PlanarcError, Related, error
from planarc.core.prose import counted, listed, sized
from planarc.core.source import Span
from planarc.flatten.refusal import (
    NotThere,
    OutOfRange,
    TurnOnce,
    unknown_value,
)
from planarc.flatten.terms.conform import base_conforms, type_text, unlike_dims
from planarc.flatten.terms.select import array, integer, subscripted
from planarc.flatten.tree import lookup, redeclare
from planarc.flatten.tree.demand import class_of, layout_of, leaf_binding, node_of, static_instance
from planarc.flatten.tree.inherit import TIMELESS
from planarc.flatten.tree.nodes import (
    Absent,
    Class,
    Element,
    Env,
    Family,
    Instance,
    Leaf,
    Node,
    Scope,
)
from planarc.flatten.values import evaluate
from planarc.ir import flat, syntax
from planarc.ir.flatwalk import names_in
from planarc.ir.syntaxwalk import nodes_of

#: An index, many, or one that varies.
Chosen: TypeAlias = "int | list[int] | flat.Expression"

View: TypeAlias = "Node | Class | flat.Expression | Pick | list[View]"


class Pick(Struct, eq=False):
    """One of many, chosen by an index that varies: a value only."""

    views: list[View]
    index: flat.Expression


def type_reference(ref: syntax.Ref, env: Env) -> flat.Expression:
    """The value that a reference stands for."""
    first = ref.parts[0]
    if not ref.absolute and first.name in env.locals:
        return _local(ref, env)
    if first.name == "time" and len(ref.parts) == 1 and lookup.find(env.scope, "time") is None:
        if env.scope.part.definition.kind in TIMELESS:
            kind = env.scope.part.definition.kind.value
            raise error("F217", f"`time` is known in models and blocks, not in a {kind}", ref.span)
        return flat.Builtin(flat.REAL, ref.span, "time")
    if any(part.subscripts for part in ref.parts):
        env = env.picking()
    return value_of(resolve(ref, env), ref, env)


def _local(ref: syntax.Ref, env: Env) -> flat.Expression:
    first = ref.parts[0]
    value = env.locals[first.name]
    if isinstance(value, flat.Reference):
        value = replace(value, span=ref.span)  # where it is used, not where it is declared
    found = lookup.find(env.scope, first.name) if first.subscripts else None
    element = found[0] if found and not found[0].is_class else None
    value = with_subscripts(value, first.subscripts, env, ref.span, first.name, element)
    for part in ref.parts[1:]:
        field = field_of(value, part.name, ref.span)
        value = with_subscripts(field, part.subscripts, env, ref.span, part.name)
    return value


def field_of(value: flat.Expression, name: str, span: Span) -> flat.Expression:
    """A field of a record value; of an array of records, that of each."""
    for index, (field, type_) in enumerate(value.type.fields):
        if field == name:
            if isinstance(value, flat.Record):
                return value.items[index]
            if isinstance(value, flat.Array) and value.items:
                return array([field_of(i, name, span) for i in value.items], type_, span)
            whole = type_.with_dims((*value.type.dims, *type_.dims))
            return flat.Field(whole, span, value, name)
    raise error("F213", f"a value of type {type_text(value.type)} has no field `{name}`", span)


# Resolving ------------------------------------------------------------------------------------


def resolve(ref: syntax.Ref, env: Env) -> View:
    """The nodes that a reference means, its subscripts applied to arrays of components."""
    first = ref.parts[0]
    view: View
    if ref.absolute:
        element = lookup.member(env.session.root_scope.instance, first.name)
        own = False
    else:
        found = lookup.find(env.scope, first.name, ref.span)
        element, own = found if found is not None else (None, False)
    if element is None:
        counters, alone = env.iterators if env.end else (), len(ref.parts) == 1
        raise lookup.unknown(env.scope, first.name, ref.span, counters, alone)
    view = _open(element, own, first, ref, env)
    for part in ref.parts[1:]:
        view = step(view, part, ref, env)
    return view


def _open(element: Element, own: bool, part: syntax.RefPart, ref: syntax.Ref, env: Env) -> View:
    if element.is_class:
        return class_of(element, ref.span)
    instance = element.scope.instance
    if not own and instance.prefix is not None:
        definition = element.definition
        assert isinstance(definition, syntax.Component)
        if definition.variability is not syntax.Variability.CONSTANT:
            outer = instance.cls.name
            told = Once(
                "F217",
                f"`{part.name}` belongs to the enclosing class `{outer}` and is no constant",
                ref.span,
                hint=_handed_on(definition, env.scope.instance, outer),
                related=(Related("declared here", definition.span),),
                kind=f"{env.scope.instance.cls.name} in {outer}",
            )
            raise PlanarcError(told)
    return select(node_of(element), part.subscripts, env, ref)


def _handed_on(definition: syntax.Component, inner: Instance, outer: str) -> str:
    """How a class inside of another one gets what a component of that is."""
    if inner.layout.kind is syntax.ClassKind.FUNCTION:
        return f"give the function an input for it, and for all else of `{outer}` that it needs"
    name = inner.cls.name.rpartition(".")[2]
    if definition.prefixes.inner:
        declared = f"`outer {definition.type} {definition.name};`"
        return f"write {declared} in `{name}`, which stands for the one around it"
    return f"declare it in `{name}` too, and give it its value where `{outer}` has such a part"


#: Names of a vector's rows, in words of other languages.
_COORDINATES = "xyz"


def step(view: View, part: syntax.RefPart, ref: syntax.Ref, env: Env) -> View:
    """One more identifier of a reference."""
    if isinstance(view, list):
        return [step(v, part, ref, env) for v in view]
    if isinstance(view, Pick):
        return Pick([step(v, part, ref, env) for v in view.views], view.index)
    if isinstance(view, Family):
        if not view.items:
            return _step_empty(view, part, ref, env)
        return [step(v, part, ref, env) for v in nested(view)]
    if isinstance(view, Class):
        return _step_class(view, part, ref, env)
    if isinstance(view, Absent):
        raise absent_error(view, ref.span)
    if isinstance(view, Instance):
        return _entered(lookup.public_member(view, part.name, ref.span), part, ref, env)
    if isinstance(view, Leaf):
        message = f"`{view.name}` is a variable and has no element `{part.name}`"
        names = view.name.split(".")
        modifier = "(".join([*names, f"{part.name}=..."]) + ")" * len(names)
        hint = f"write `{modifier}` where `{names[0]}` is declared"
        known = part.name in ("start", "fixed", "min", "max", "nominal", "unit", "stateSelect")
        rows = _COORDINATES[: view.type.dims[0]] if view.type.dims else ""
        if part.name in tuple(rows):
            row = rows.index(part.name) + 1
            hint, known = f"write `{view.name}[{row}]`: rows of vectors have numbers", True
        raise error("F213", message, ref.span, hint=hint if known else None)
    field = field_of(view, part.name, ref.span)
    return with_subscripts(field, part.subscripts, env, ref.span, part.name)


def _step_empty(view: Family, part: syntax.RefPart, ref: syntax.Ref, env: Env) -> View:
    """A member of an array without components: an empty array of the type that it would have."""
    one = step(static_instance(view.cls), part, ref, env)
    if isinstance(one, Instance) and one.element is not None:
        return Family(one.name, view.dims, [], one.cls, one.element)
    if not isinstance(one, Leaf):
        return []
    return _without_entries(view.dims, one.type, ref.span)


def _without_entries(dims: tuple[int, ...], type_: flat.Type, span: Span) -> flat.Array:
    items = tuple(_without_entries(dims[1:], type_, span) for _ in range(dims[0]))
    return flat.Array(type_.with_dims((*dims, *type_.dims)), span, items)


def _step_class(cls: Class, part: syntax.RefPart, ref: syntax.Ref, env: Env) -> View:
    instance = static_instance(cls)
    builtin = instance.layout.builtin
    if builtin is not None and part.name in builtin.literals:
        return flat.Literal(builtin, ref.span, builtin.literals.index(part.name) + 1)
    return _entered(lookup.class_member(cls, part.name, ref.span), part, ref, env)


def _entered(element: Element, part: syntax.RefPart, ref: syntax.Ref, env: Env) -> View:
    if element.is_class:
        return class_of(element, ref.span)
    return select(node_of(element), part.subscripts, env, ref)


def absent_error(view: Absent, span: Span) -> NotThere:
    declared = Related("declared here", view.element.definition.span)
    message = f"`{view.name}` does not exist: its condition is false"
    hint = "only a connection may name it, which is then left out: switch it on, or do without it"
    return NotThere(Diagnostic("F215", message, span, hint=hint, related=(declared,)))


# Subscripts --------------------------------------------------------------------------------------


def select(node: Node, subscripts: syntax.Expressions, env: Env, ref: syntax.Ref) -> View:
    """Subscripts on a component."""
    if not subscripts:
        return node
    if isinstance(node, Leaf):
        value = leaf_value(node, ref.span, env)
        return with_subscripts(value, subscripts, env, ref.span, node.name, node.element)
    if isinstance(node, Absent):
        raise absent_error(node, ref.span)
    if isinstance(node, Instance):
        raise error("F218", f"`{node.name}` is no array", ref.span)
    if len(subscripts) > len(node.dims):
        message = f"`{node.name}` has {counted(len(node.dims), 'dimension')}, not {len(subscripts)}"
        raise error("F218", message, ref.span)
    chosen: list[Chosen] = [_chosen(node, k, s, env) for k, s in enumerate(subscripts)]
    chosen += [list(range(1, d + 1)) for d in node.dims[len(subscripts) :]]
    return _select(node, chosen, 0, 0)


def _chosen(node: Family, k: int, subscript: syntax.Expression, env: Env) -> Chosen:
    if isinstance(subscript, syntax.Colon):
        return list(range(1, node.dims[k] + 1))
    size = flat.Type(flat.Base.INTEGER, node.dims)
    whole = flat.Reference(size, subscript.span, node.name)
    typed = type_subscript(subscript, env.with_end(whole, k), node.element, k)
    if env.picks and not typed.type.dims and _varies(typed, env):
        if not node.dims[k]:
            message = f"`{node.name}` has no members that an index could choose"
            raise error("F219", message, subscript.span)
        return typed
    value = evaluate.structural_value(
        typed, env, f"the index of the array of components `{node.name}`"
    )
    indices = value if isinstance(value, list) else [value]
    for index in indices:
        if not isinstance(index, int) or not 1 <= index <= node.dims[k]:
            raise out_of_range(node.name, index, node.dims[k], subscript.span, env)
    chosen = [i for i in indices if isinstance(i, int)]
    return chosen if isinstance(value, list) else chosen[0]


def _varies(index: flat.Expression, env: Env) -> bool:
    """Whether an index is known only while the model runs. A loop over the array's members is
    written out instead."""
    turns = env.iterators & env.hidden
    return evaluate.try_value(index, env) is None and turns.isdisjoint(names_in((index,)))


def out_of_range(name: str, index: object, size: int, span: Span, env: Env) -> PlanarcError:
    hint = "the first index is 1" if index == 0 else None
    counted_by = [(n, env.locals[n]) for n in sorted(env.iterators)]
    at = [f"`{n}` = {v.value}" for n, v in counted_by if isinstance(v, flat.Literal)]
    if at:
        here = f"this is at {listed(at)}: let the loop run over"
        hint = (
            f"{hint}; {here} others"
            if hint
            else f"{here} fewer values, or write this in one of its own"
        )
    message = f"the index {index} of `{name}` is outside of 1 to {size}"
    if not size:
        message = f"the index {index} is outside of `{name}`, which has no members"
    if not at:
        return OutOfRange(Diagnostic("F219", message, span, hint=hint))
    loop = env.loop
    related = (Related("the loop is this one", loop),) if loop and loop.line != span.line else ()
    # All others follow from one mistake, that of the loop's range: at its beginning, or at its end.
    low = isinstance(index, int) and index < 1
    kind = f"{loop.source.name}:{loop.start} {low}" if loop else f"{span.line} {index} {at}"
    return OutOfRange(TurnOnce("F219", message, span, hint=hint, related=related, kind=kind))


def _select(node: Family, chosen: Sequence[Chosen], k: int, offset: int) -> View:
    if k == len(chosen):
        return node.items[offset]
    here = chosen[k]
    base = offset * node.dims[k]
    if isinstance(here, int):
        return _select(node, chosen, k + 1, base + here - 1)
    if isinstance(here, list):
        return [_select(node, chosen, k + 1, base + i - 1) for i in here]
    return Pick([_select(node, chosen, k + 1, base + i) for i in range(node.dims[k])], here)


def nested(node: Family) -> list[View]:
    whole = _select(node, [list(range(1, d + 1)) for d in node.dims], 0, 0)
    assert isinstance(whole, list)
    return whole


def with_subscripts(
    value: flat.Expression,
    subscripts: syntax.Expressions,
    env: Env,
    span: Span,
    name: str,
    element: Element | None = None,
) -> flat.Expression:
    """Subscripts on a value of that name, which an element may declare."""
    if not subscripts:
        return value
    dims = value.type.dims
    name = value.name if isinstance(value, flat.Reference) else name
    if len(subscripts) > len(dims):
        message = f"`{name}` has {counted(len(dims), 'dimension')}, not {len(subscripts)}"
        raise error("F218", message, span)
    typed: list[flat.Expression] = []
    for k, subscript in enumerate(subscripts):
        if isinstance(subscript, syntax.Colon):
            typed.append(flat.Slice(flat.INTEGER.with_dims((dims[k],)), subscript.span))
            continue
        index = type_subscript(subscript, env.with_end(value, k), element, k)
        _check_range(index, dims[k], name, env)
        typed.append(index)
    return subscripted(value, tuple(typed), span)


def type_subscript(
    subscript: syntax.Expression, env: Env, element: Element | None = None, k: int = 0
) -> flat.Expression:
    """An index of dimension `k`, counted from 0, of what an element declares."""
    index = env.typed(subscript)
    base = index.type.base
    if element is not None and base in _INDICES:
        _check_index(index.type, subscript, element, k, env)
    if len(index.type.dims) > 1 or base not in _INDICES:
        message = f"an index must be an Integer, but is {type_text(index.type)}"
        raise error("F218", message, subscript.span)
    folded = evaluate.fold_index(index, env)
    if base is flat.Base.BOOLEAN and isinstance(folded, flat.Literal):
        return integer(int(folded.value) + 1, index.span)
    if base is flat.Base.BOOLEAN and not index.type.dims:
        one, two = integer(1, index.span), integer(2, index.span)
        return flat.If(flat.INTEGER, index.span, ((folded, two),), one)
    if base is flat.Base.ENUMERATION and isinstance(folded, flat.Literal):
        return integer(int(folded.value), index.span)
    return folded


_INDICES = (flat.Base.INTEGER, flat.Base.BOOLEAN, flat.Base.ENUMERATION)


def _check_index(
    type_: flat.Type, subscript: syntax.Expression, element: Element, k: int, env: Env
) -> None:
    """An index is of the type that the dimension is declared with, else an Integer (10.5)."""
    is_integer = type_.base is flat.Base.INTEGER
    if is_integer and (_is_counted(subscript, env) or not _names_type(element, k)):
        return
    definition, scope, _ = redeclare.effective_component(element)
    layout = layout_of(lookup.find_class(scope, definition.type))
    dimension, where = redeclare.written_dims(element, layout)[k]
    declared = _dimension_type(dimension, where)
    if base_conforms(declared or flat.INTEGER, type_):
        return
    if type_.base is flat.Base.ENUMERATION and declared is None:
        return  # taken by its number, as flat models do that say sizes in numbers
    text, wanted = subscript.span.text, dimension.span.text
    name = type_.name.rpartition(".")[2] or type_.base.value
    what = {flat.Base.INTEGER: "an Integer", flat.Base.BOOLEAN: "a Boolean"}
    message = f"{what.get(type_.base, f'a value of `{name}`')} is no index of `{element.name}`"
    message += f", whose dimension is {f'`{wanted}`' if declared else f'not `{name}`'}"
    hint = None
    if type_.base is flat.Base.BOOLEAN:
        hint = f"write `if {text} then 2 else 1` in its place"
    elif is_integer and declared is not None and declared.literals:
        first, last = (f"{wanted}.{n}" for n in (declared.literals[0], declared.literals[-1]))
        hint = f"write a range of it, such as `{first}:{last}`"
        hint = hint if type_.dims else f"write `{wanted}({text})` in its place"
    related = (Related("declared here", definition.span),)
    raise error("F218", message, subscript.span, hint=hint, related=related)


def _is_counted(subscript: syntax.Expression, env: Env) -> bool:
    """An iterator, which may run over what it indexes, and `end` are right for any dimension."""
    if isinstance(subscript, syntax.Ref) and subscript.parts[0].name in env.locals:
        return True
    return any(isinstance(node, syntax.End) for node in nodes_of(subscript))


def _names_type(element: Element, k: int) -> bool:
    """Whether the declaration itself has a type for that dimension."""
    definition = element.definition
    if not isinstance(definition, syntax.Component):
        return False
    written = (*definition.dimensions, *definition.type_dimensions)
    return k < len(written) and _dimension_type(written[k], element.scope) is not None


def _check_range(index: flat.Expression, size: int | None, name: str, env: Env) -> None:
    if size is None:
        return
    values = index.items if isinstance(index, flat.Array) else (index,)
    for value in values:
        if isinstance(value, flat.Literal) and not 1 <= int(value.value) <= size:
            raise out_of_range(name, value.value, size, index.span, env)


# Values ------------------------------------------------------------------------------------------


def value_of(view: View, ref: syntax.Ref, env: Env) -> flat.Expression:
    """The typed expression of what a reference resolved to."""
    if isinstance(view, Leaf):
        return leaf_value(view, ref.span, env)
    if isinstance(view, list):
        return _list_value([value_of(v, ref, env) for v in view], ref)
    if isinstance(view, Pick):
        return _picked([value_of(v, ref, env) for v in view.views], view.index, ref)
    if isinstance(view, Instance):
        return instance_value(view, ref.span, env)
    if isinstance(view, Family):
        return _list_value([value_of(v, ref, env) for v in nested(view)], ref)
    if isinstance(view, Class):
        outputs = env.function.outputs if env.function and env.in_algorithm else ()
        own = env.function is not None and env.function.name == view.name
        hint = f"a function gives its output: write `{outputs[0].name} := ...`" if outputs else None
        message = f"`{ref}` is a class, not a value"
        raise error("F216", message, ref.span, hint=hint if own else None)
    if isinstance(view, Absent):
        raise absent_error(view, ref.span)
    return view


def _picked(
    items: list[flat.Expression], index: flat.Expression, ref: syntax.Ref
) -> flat.Expression:
    first = items[0].type
    if any(item.type.dims != first.dims for item in items):
        message = f"the members that the index of `{ref}` may choose have different sizes"
        raise unknown_value(message, index.span)
    return subscripted(array(items, first, ref.span), (index,), ref.span)


def _list_value(items: list[flat.Expression], ref: syntax.Ref) -> flat.Expression:
    """An array of the members' values, whose sizes must be equal (10.6.9)."""
    element = items[0].type if items else flat.REAL
    unlike = next((u for item in items if (u := unlike_dims(element, item.type))), None)
    if unlike is not None:
        message = f"the members of `{ref}` have {sized(unlike)}, and make no array"
        hint = "take one member at a time by its index, or give all the same size"
        raise PlanarcError(Once("F272", message, ref.span, hint=hint, kind=f"members of {ref}"))
    return array(items, element, ref.span)


def leaf_value(leaf: Leaf, span: Span, env: Env) -> flat.Expression:
    """A variable as an expression; a package constant as its value."""
    if leaf.parent.prefix is None:
        return evaluate.package_constant(leaf, span)
    if leaf.parent.drawn:
        binding = leaf_binding(leaf)
        if binding is not None:
            return binding
    if env.function is not None:
        return env.function.capture(leaf, span)
    return flat.Reference(leaf.type, span, leaf.name)


def instance_value(instance: Instance, span: Span, env: Env) -> flat.Expression:
    """A record component as a value of its fields."""
    if not instance.has_value:
        raise error("F216", f"`{instance.name}` is a component, not a value", span)
    if instance.layout.kind is syntax.ClassKind.OPERATOR_RECORD:
        env.session.operator_records[instance.cls.name] = instance.cls
    items = [(n, node_value(node_of(e), span, env)) for n, e in lookup.components(instance)]
    type_ = flat.Type(
        flat.Base.RECORD, (), instance.cls.name, (), tuple((n, e.type) for n, e in items)
    )
    return flat.Record(type_, span, tuple(e for _, e in items))


def node_value(node: Node, span: Span, env: Env) -> flat.Expression:
    ref = syntax.Ref(span, (syntax.RefPart(span, node.name),))
    return value_of(node, ref, env)


def size_of_type(expression: syntax.Expression, scope: Scope) -> int | None:
    """An enumeration or `Boolean` as a dimension has one entry a value (10.1)."""
    type_ = _dimension_type(expression, scope)
    if type_ is None:
        return None
    return 2 if type_.base is flat.Base.BOOLEAN else len(type_.literals) or None


def _dimension_type(expression: syntax.Expression, scope: Scope) -> flat.Type | None:
    """The built-in type that a dimension names."""
    if not isinstance(expression, syntax.Ref):
        return None
    found = lookup.find(scope, expression.parts[0].name)
    if found is None or not found[0].is_class:
        return None
    view = resolve(expression, Env(scope))
    return layout_of(view).builtin if isinstance(view, Class) else None
