"""Algorithm sections of models: run on expressions, then one equation a result.

In:   flat.Algorithm    statements
Out:  dae.Equation      `v = what v holds after the last statement`, for each v assigned

A variable that is read before it is assigned starts from its start value, or from
`pre(v)` when it is discrete (specification 11.1.2), also where whens alone assign it:
`when not lit and time > 1 then lit := true; end when;` asks for the value before the
event. A when-statement acts at its event; outside of it the variables that it assigns
keep their values. Several whens that assign one variable act one after the other.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from msgspec import field
from msgspec.structs import replace

from planarc.core.diagnostic import error
from planarc.core.source import Span
from planarc.ir import dae, flat
from planarc.ir.expr import Expr
from planarc.ir.flatwalk import assigned_in
from planarc.lower import equations
from planarc.lower.equations import Lowered
from planarc.lower.scalar import assertion, message
from planarc.lower.scope import Model, Scope
from planarc.lower.statements import Runner
from planarc.lower.texts import held, number, number_held
from planarc.lower.values import Text, Value, expr
from planarc.runtime.tensor import each, elements


def lower_algorithm(
    model: Model, algorithm: flat.Algorithm, starts: Mapping[str, Value], into: Lowered
) -> None:
    """Append the equations of an algorithm section to `into`."""
    model.component = algorithm.component
    runner = _Section(Scope(model), "this algorithm", algorithm.span, events=True)
    runner.into = into
    plain = assigned_in(algorithm.statements, whens=False)
    for name in assigned_in(algorithm.statements):
        runner.values[name] = _before(model, name, starts, algorithm.span)
    runner.plain = frozenset(plain)
    last = {name: s for s in algorithm.statements for name in assigned_in([s])}
    for s in algorithm.statements:
        ended = [name for name, at in last.items() if at is s and name not in plain]
        runner.final = frozenset(ended if isinstance(s, flat.WhenStatement) else ())
        runner.run_body([s])
        for name in ended:  # from here on it is as the event leaves it
            runner.values.pop(name, None)
    for symbol, value in _results(runner, plain):
        equations.add_equation(into, symbol, value, algorithm)


def lower_initial_algorithm(
    model: Model, algorithm: flat.Algorithm, starts: Mapping[str, Value]
) -> Iterator[dae.Equation]:
    """The initial equations that an initial algorithm stands for."""
    scope = Scope(model, events=False, at_event=True)
    runner = Runner(scope, "this initial algorithm", algorithm.span)
    names = assigned_in(algorithm.statements, whens=False)
    for name in names:
        runner.values[name] = _before(model, name, starts, algorithm.span)
    count = len(model.assertions)
    runner.run_body(algorithm.statements)
    model.forget_bounds(count)  # the values at the start are not those that rows hold
    for symbol, value in _results(runner, names):
        yield dae.Equation(symbol, value, algorithm.span, algorithm.component)


def _results(runner: Runner, names: Sequence[str]) -> Iterator[tuple[Expr, Expr]]:
    """The scalars of variables with what they hold after the last statement."""
    for name in names:
        symbols = elements(runner.scope.model.values[name])
        for symbol, value in zip(symbols, elements(runner.values[name]), strict=True):
            table = runner.scope.table
            yield number(table, symbol), number_held(runner.scope, value, runner.span)


def _before(model: Model, name: str, starts: Mapping[str, Value], span: Span) -> Value:
    table = model.table

    def one(e: Value) -> Value:
        if isinstance(e, Text):
            return held(expr(one(number(table, e))))
        symbol = expr(e)
        return table.pre(symbol.name) if symbol.name in model.discretes else starts[symbol.name]

    return each(one, model.values[name])


class _Section(Runner):
    """A runner that also knows when-statements."""

    into: Lowered = field(default_factory=Lowered)
    plain: frozenset[str] = frozenset()  # what is assigned outside of whens, too
    final: frozenset[str] = frozenset()  # what no later statement assigns
    left: list[dict[str, Value]] = field(default_factory=list)  # by the when-branches
    asserted: list[dae.Assertion] = field(default_factory=list)  # by the present when-branch

    def when(self, s: flat.WhenStatement) -> None:
        if self.path is not None:
            raise error("L350", "a `when` cannot stand under an `if` that changes", s.span)
        clause = equations.when(self.here(), s, self._actions)
        self.into.whens.append(clause)
        left, self.left = self.left, []
        for (name, _), values in reversed(list(zip(clause.branches, left, strict=True))):
            changed = {n: v for n, v in values.items() if n in self.values and n not in self.final}
            self._join(equations.fires(self.scope.model, name), changed, self.values, s.span)

    def _actions(self, body: Sequence[flat.Statement]) -> Iterator[dae.Action]:
        scope = replace(self.scope, at_event=True)
        inner = _Section(scope, self.label, self.span, values=dict(self.values))
        plain = assigned_in(body, whens=False)
        for name in plain:  # what is not assigned on every way keeps its value
            if name not in inner.values:
                inner.values[name] = _before(self.scope.model, name, {}, self.span)
        for s in body:
            match s:
                case flat.Reinit():
                    yield from equations.reinit(inner.here(), s)
                case flat.Terminate():
                    yield dae.Terminate(message(inner.here(), s.message), s.span)
                case flat.Assert():
                    yield assertion(inner.here(), s)
                case _:
                    inner.run_body([s])
        yield from inner.asserted
        self.left.append({name: inner.values[name] for name in plain})
        for symbol, value in _results(inner, [name for name in plain if name not in self.plain]):
            if value is not self.scope.table.pre(symbol.name):
                yield equations.set_discrete(symbol, value, self.span)

    def check(self, s: flat.Assert) -> None:
        if self.scope.at_event:
            self.asserted.append(assertion(self.here(), s))
        else:
            super().check(s)


_Section.handlers = {
    **Runner.handlers,
    flat.WhenStatement: _Section.when,
    flat.Assert: _Section.check,
}
