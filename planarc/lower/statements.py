"""Statements run one after the other on expressions instead of numbers.

Example:  after  `a := 2*x; if p > 0 then a := a + 1; end if;`  the variable a has the
value `if 0 < p then 2*x + 1 else 2*x`.

An `if` whose condition is not known is run on both sides and joined; loops run as
often as they would, which must be known when the model is compiled. Serves
functions (`functions`) and the algorithm sections of models (`algorithms`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

from planarc.core.diagnostic import PlanarcError, Related, error
from planarc.core.source import Span
from planarc.ir import dae, flat
from planarc.ir.expr import Expr
from planarc.lower import functions, scalar
from planarc.lower.scope import Scope, unsupported
from planarc.lower.values import Struct, Tensor, Text, Value, elements, expr, fixed_dims, stack

MAX_TURNS = 100_000  # of one loop


class _Leave(Exception):
    """`break` or `return` inside a loop or body that runs now."""

    def __init__(self, whole_function: bool) -> None:
        self.whole_function = whole_function


@dataclass
class Runner:
    """The state while statements are run. `values` are the variables that have one."""

    scope: Scope
    label: str  # what is run, for messages
    span: Span  # where it was called
    events: bool = False  # relations make events (algorithm sections of models)
    values: dict[str, Value] = field(default_factory=dict)
    handlers: ClassVar[Mapping[type, Callable[[Any, Any], None]]] = {}
    unknown_branch: int = 0  # depth of if-branches whose condition is not known

    def run_body(self, statements: Sequence[flat.Statement]) -> None:
        """Run to the end or to a `return`."""
        try:
            self.run(statements)
        except _Leave as leave:
            if not leave.whole_function:
                raise self.refused("`break` outside of a loop", self.span) from None

    def run(self, statements: Sequence[flat.Statement]) -> None:
        for statement in statements:
            self.handlers[type(statement)](self, statement)

    def declare(self, variable: flat.Variable) -> None:
        if variable.binding is not None:
            self.values[variable.name] = self.value(variable.binding)
            return
        type_ = variable.type.with_dims(self._dims(variable))
        has_parts = type_.base is flat.Base.RECORD or bool(type_.dims)
        if has_parts and None not in type_.dims:
            # Entries and fields may be assigned one by one; until then they are zero.
            self.values[variable.name] = self._zero(type_)

    def _dims(self, variable: flat.Variable) -> tuple[int | None, ...]:
        """The dimensions, with those that depend on the inputs computed."""
        dims = list(variable.type.dims)
        for k, size in enumerate(variable.sizes):
            if dims[k] is None and size is not None:
                value = expr(self.value(size))
                dims[k] = int(value.data) if value.is_const else None
        return tuple(dims)

    def _zero(self, type_: flat.Type) -> Value:
        if dims := fixed_dims(type_):
            one = self._zero(type_.element(len(dims)))
            return Tensor(dims, (one,) * math.prod(dims))
        if type_.base is flat.Base.RECORD:
            return Struct(tuple((name, self._zero(field)) for name, field in type_.fields))
        table = self.scope.table
        return table.false if type_.base is flat.Base.BOOLEAN else table.zero

    def here(self) -> Scope:
        outer = self.scope
        return Scope(outer.model, self.values, self.events, outer.at_event, outer.depth)

    def value(self, e: flat.Expression) -> Value:
        return scalar.lower_expression(self.here(), e)

    def refused(self, what: str, span: Span) -> PlanarcError:
        return error(
            "L322",
            f"{what} in {self.label} cannot be turned into equations",
            span,
            hint="let the condition depend on values that are known at compile time",
            related=(Related("called here", self.span),),
        )

    # Statements

    def assign(self, s: flat.Assignment) -> None:
        self._store(s.target, self.value(s.value))

    def assign_tuple(self, s: flat.TupleAssignment) -> None:
        here = self.here()
        given = tuple(scalar.lower_expression(here, a) for a in s.value.arguments)
        results = functions.inline(here, s.value.function, given, s.span)
        for target, value in zip(s.targets, results, strict=False):
            if target is not None:
                self._store(target, value)

    def _store(self, target: flat.Reference, value: Value) -> None:
        """Assign to a variable, to an entry of it, or to a field (`o.a[1] := ...`)."""
        whole, *path = target.name.split(".")
        if not path or whole not in self.values:
            whole, path = target.name, []
        if path or target.subscripts:
            old = self.here().value(whole, target.span)
            value = self._replaced(old, path, target, value)
        self.values[whole] = value

    def _replaced(
        self, old: Value, path: Sequence[str], target: flat.Reference, value: Value
    ) -> Value:
        if not path:
            return assigned(self.here(), old, target.subscripts, value, target.span)
        if not isinstance(old, Struct):
            raise unsupported("an assignment to a field of an array of records", target.span)
        return Struct(
            tuple(
                (n, self._replaced(v, path[1:], target, value) if n == path[0] else v)
                for n, v in old.fields
            )
        )

    def branch(self, s: flat.IfStatement) -> None:
        self._branch(list(s.branches), s.otherwise, s.span)

    def _branch(
        self,
        branches: list[tuple[flat.Expression, tuple[flat.Statement, ...]]],
        otherwise: tuple[flat.Statement, ...],
        span: Span,
    ) -> None:
        if not branches:
            self.run(otherwise)
            return
        (test, body), *rest = branches
        condition = expr(self.value(test))
        if condition.is_const:
            if condition.data:
                self.run(body)
            else:
                self._branch(rest, otherwise, span)
            return
        before = dict(self.values)
        self.unknown_branch += 1
        self.run(body)
        then = self.values
        self.values = before
        self._branch(rest, otherwise, span)
        self.unknown_branch -= 1
        self._join(condition, then, span)

    def _join(self, condition: Expr, then: Mapping[str, Value], span: Span) -> None:
        here = self.here()
        for name, value in then.items():
            other = self.values.get(name)
            if other is not None and other is not value:
                self.values[name] = scalar.choose(here, condition, value, other, span)
            elif other is None:  # assigned on one side only; read on that side only
                self.values[name] = value

    def loop_for(self, s: flat.ForStatement) -> None:
        domain = elements(self.value(s.range))
        if len(domain) > MAX_TURNS:
            raise self.refused(f"a loop of {len(domain)} turns", s.span)
        hidden = self.values.get(s.iterator)
        try:
            for value in domain:
                self.values[s.iterator] = value
                self.run(s.body)
        except _Leave as leave:
            if leave.whole_function:
                raise
        self.values.pop(s.iterator, None)
        if hidden is not None:
            self.values[s.iterator] = hidden

    def loop_while(self, s: flat.WhileStatement) -> None:
        for _ in range(MAX_TURNS):
            condition = expr(self.value(s.condition))
            if not condition.is_const:
                raise self.refused("a `while` whose condition is unknown", s.span)
            if not condition.data:
                return
            try:
                self.run(s.body)
            except _Leave as leave:
                if leave.whole_function:
                    raise
                return
        raise self.refused(f"a loop of more than {MAX_TURNS} turns", s.span)

    def leave_loop(self, s: flat.Break) -> None:
        if self.unknown_branch:
            raise self.refused("a `break` under an unknown condition", s.span)
        raise _Leave(whole_function=False)

    def leave_function(self, s: flat.Return) -> None:
        if self.unknown_branch:
            raise self.refused("a `return` under an unknown condition", s.span)
        raise _Leave(whole_function=True)

    def check(self, s: flat.Assert) -> None:
        condition = expr(self.value(s.condition))
        if condition is self.scope.table.true or self.unknown_branch:
            return
        text = self.value(s.message)
        parts = text.parts if isinstance(text, Text) else ()
        self.scope.model.assertions.append(
            dae.Assertion(condition, dae.Message(parts), s.warning, s.component, s.span)
        )

    def refuse(self, s: flat.Statement) -> None:
        raise self.refused("this statement", s.span)


def assigned(
    scope: Scope,
    old: Value,
    subscripts: tuple[flat.Expression, ...],
    value: Value,
    span: Span,
) -> Value:
    """The array `old` after `old[subscripts] := value`."""
    if not subscripts:
        return value
    assert isinstance(old, Tensor)
    first, rest = subscripts[0], subscripts[1:]
    rows = list(old.rows())
    if isinstance(first, flat.Slice):
        positions = list(range(len(rows)))
        many = True
    else:
        at = scalar.lower_expression(scope, first)
        many = isinstance(at, Tensor)
        numbers = [expr(p) for p in elements(at)]
        if not all(n.is_const for n in numbers):
            raise unsupported("an assignment to an entry that is chosen while running", span)
        positions = [int(n.data) - 1 for n in numbers]
    values = value.rows() if many and isinstance(value, Tensor) else (value,) * len(positions)
    for position, entry in zip(positions, values, strict=True):
        if not 0 <= position < len(rows):
            raise error("L312", f"subscript {position + 1} is outside of 1 to {len(rows)}", span)
        rows[position] = assigned(scope, rows[position], rest, entry, span)
    return stack(rows, old.shape[1:])


Runner.handlers = {
    flat.Assignment: Runner.assign,
    flat.TupleAssignment: Runner.assign_tuple,
    flat.IfStatement: Runner.branch,
    flat.ForStatement: Runner.loop_for,
    flat.WhileStatement: Runner.loop_while,
    flat.Break: Runner.leave_loop,
    flat.Return: Runner.leave_function,
    flat.Assert: Runner.check,
    flat.WhenStatement: Runner.refuse,
    flat.Terminate: Runner.refuse,
    flat.Reinit: Runner.refuse,
}
