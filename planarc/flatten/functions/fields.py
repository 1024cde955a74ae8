"""The first values of the fields of records in functions.

In:   an output or a local variable of a function that is a record, or an array of records
Out:  assignments, which stand before the first statement

A field has a value where its declaration in the record, or a modifier of the variable, gives it
one. A field whose size hangs on another field is filled with zeros, so that its entries may be
assigned one by one.

Example:  output N q(n=m);  where  record N  parameter Integer n=2; Real x[n]; end N;

    q.n := m;  q.x := fill(0, q.n);

Reference: Modelica Language Specification 3.6, section 12.4.4.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence

from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError
from planarc.core.source import Span
from planarc.flatten.functions.order import names_in_order
from planarc.flatten.terms.conform import expect
from planarc.flatten.terms.select import integer
from planarc.flatten.tree import lookup, redeclare
from planarc.flatten.tree.demand import layout_of, static_instance
from planarc.flatten.tree.modify import merge
from planarc.flatten.tree.nodes import (
    Binding,
    Class,
    Env,
    Instance,
    Mod,
    Scope,
    Signature,
)
from planarc.flatten.typing import references
from planarc.ir import flat, syntax
from planarc.ir.flatwalk import names_in

_EMPTY: dict[flat.Base, float | int | bool | str] = {
    flat.Base.REAL: 0.0,
    flat.Base.INTEGER: 0,
    flat.Base.BOOLEAN: False,
    flat.Base.STRING: "",
}

#: What the names in a text mean, by the instance that the text belongs to.
_Meanings = tuple[tuple[Instance, flat.Named], ...]


class _Place(Data):
    """A variable, an entry of it, or a field."""

    name: str  # as of the target of an assignment, `q.x`
    subscripts: flat.Expressions  # of it, for the dimensions of all arrays on the way
    dims: flat.Dims  # which these have
    value: flat.Expression  # what stands there, as it is read

    @property
    def type(self) -> flat.Type:
        return self.value.type

    @property
    def span(self) -> Span:
        return self.value.span

    def entry(self, at: flat.Expression, count: int | None) -> _Place:
        found = flat.Index(self.type.element(), self.span, self.value, (at,))
        return _Place(self.name, (*self.subscripts, at), (*self.dims, count), found)

    def field(self, name: str) -> _Place:
        found = references.field_of(self.value, name, self.span)
        return _Place(f"{self.name}.{name}", self.subscripts, self.dims, found)


def first_values(
    instance: Instance, variable: flat.Variable, names: flat.Named, signature: Signature
) -> tuple[flat.Statement, ...]:
    """The assignments to fields of a variable of the function; `names` are those in its text."""
    if variable.type.base is not flat.Base.RECORD or variable.binding is not None:
        return ()
    definition, scope, mod = redeclare.effective_component(lookup.declared(instance, variable.name))
    cls = lookup.find_class(scope, definition.type)
    mod = merge(mod, cls.mod, variable.name) if cls.mod else mod
    itself = flat.Reference(variable.type, variable.span, variable.name)
    sizes = [
        integer(n, variable.span)
        if n is not None
        else variable.sizes[k]
        if variable.sizes
        else None
        for k, n in enumerate(variable.type.dims)
    ]
    maker = _Maker(signature, ((instance, names),))
    return tuple(maker.each(_Place(variable.name, (), (), itself), sizes, cls, mod))


def without_overwritten(
    first: Sequence[flat.Statement], body: Sequence[flat.Statement], variables: Collection[str]
) -> tuple[flat.Statement, ...]:
    """The statements of a function, without first values of fields that none reads before the
    field is given another one: those of `Complex` are mostly such. `variables` are no fields."""
    kept: list[flat.Statement] = []
    for k, statement in enumerate(first):
        target = statement.target if isinstance(statement, flat.Assignment) else None
        name = target.name if isinstance(target, flat.Reference) else ""
        whole = next((v for v in variables if name.startswith(f"{v}.")), None)
        if whole is None or not _is_overwritten(name, whole, (*first[k + 1 :], *body)):
            kept.append(statement)
    return (*kept, *body)


def _is_overwritten(field: str, whole: str, behind: Iterable[flat.Statement]) -> bool:
    for statement in behind:
        if not isinstance(statement, flat.Assignment):
            return False
        target = statement.target
        if whole in names_in((statement.value,)) or not isinstance(target, flat.Reference):
            return False
        if target.name in (whole, field):
            return not target.subscripts
    return False


class _Maker(Data):
    signature: Signature
    meanings: _Meanings

    def each(
        self, place: _Place, sizes: Sequence[flat.Expression | None], cls: Class, mod: Mod
    ) -> Iterator[flat.Statement]:
        """The assignments to the fields of each entry, in a loop for each dimension."""
        if not sizes:
            yield from self._fields(place, cls, mod)
        elif (size := sizes[0]) is not None:
            count = place.type.dims[0]
            name = self._new_name(len(place.subscripts))
            at = flat.Reference(flat.INTEGER, place.span, name)
            body = tuple(self.each(place.entry(at, count), sizes[1:], cls, mod))
            if body:
                vector, one = flat.INTEGER.with_dims((count,)), integer(1, place.span)
                range_ = flat.Range(vector, place.span, one, None, size)
                yield flat.ForStatement(place.span, "", name, range_, body)

    def _new_name(self, depth: int) -> str:
        """The name of an iterator, which is none of the function's."""
        name = f"entry{depth + 1}"
        while any(name in names for _, names in self.meanings):
            name += "_"
        return name

    def _fields(self, place: _Place, cls: Class, mod: Mod) -> Iterator[flat.Statement]:
        record = static_instance(cls)
        fields = {n: place.field(n) for n, _ in place.type.fields}
        names = {n: field.value for n, field in fields.items()}
        inner = _Maker(self.signature, ((record, names), *self.meanings))
        for name in _in_order(record, mod):
            if name in fields:
                yield from inner._field(fields[name], name, record, mod.sub(name))

    def _field(
        self, field: _Place, name: str, record: Instance, outer: Mod
    ) -> Iterator[flat.Statement]:
        element = lookup.declared(record, name)
        definition, scope, own = redeclare.effective_component(element)
        cls = lookup.find_class(scope, definition.type)
        mod = merge(outer, merge(own, cls.mod, name), name)
        target = flat.Reference(field.type, field.span, field.name, field.subscripts)
        if mod.binding is not None:
            yield flat.Assignment(mod.binding.span, "", target, self._value(mod.binding, field))
            return
        sizes = self._sizes(redeclare.written_dims(element, layout_of(cls)), field)
        if field.type.base is flat.Base.RECORD:
            yield from self.each(field, sizes, cls, mod)
        elif None in field.type.dims and None not in sizes and field.type.base in _EMPTY:
            zero = flat.Literal(field.type.element(len(sizes)), field.span, _EMPTY[field.type.base])
            known = tuple(size for size in sizes if size is not None)
            value = flat.Builtin(field.type, field.span, "fill", (zero, *known))
            yield flat.Assignment(field.span, "", target, value)

    def _sizes(
        self, written: Sequence[tuple[syntax.Expression, Scope]], field: _Place
    ) -> list[flat.Expression | None]:
        """The sizes of a field; None for one that is open."""
        return [
            integer(known, field.span)
            if known is not None
            else None
            if isinstance(expression, syntax.Colon)
            else self._typed(expression, scope)
            for known, (expression, scope) in zip(field.type.dims, written, strict=True)
        ]

    def _value(self, binding: Binding, field: _Place) -> flat.Expression:
        """What a field is given: a modifier of an array of records has a value for each entry,
        where it is not written with `each`."""
        value = self._typed(binding.expression, binding.scope)
        more = len(value.type.dims) - len(field.type.dims)
        what = f"the value of `{field.name}`"
        if not 0 < more <= len(field.subscripts):
            expect(field.type, value, what)
            return value
        expect(field.type.with_dims((*field.dims[-more:], *field.type.dims)), value, what)
        return flat.Index(value.type.element(more), value.span, value, field.subscripts[-more:])

    def _typed(self, expression: syntax.Expression, scope: Scope) -> flat.Expression:
        names = next((n for owner, n in self.meanings if owner is scope.instance), {})
        return Env(scope, names, self.signature).typed(expression)


def _in_order(record: Instance, mod: Mod) -> list[str]:
    """The fields that modifiers from outside give, which may break a circle, then the others."""
    given = [name for name, sub in mod.subs.items() if sub.binding is not None]
    try:
        order = names_in_order(record)
    except PlanarcError:
        order = list(record.layout.members)
    return [*given, *(name for name in order if name not in given)]
