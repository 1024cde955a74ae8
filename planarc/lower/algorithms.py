"""Algorithm sections of models: run on expressions, then one equation a result.

In:   flat.Algorithm    statements
Out:  dae.Equation      `v = what v holds after the last statement`, for each v assigned

A variable that is read before it is assigned starts from its start value, or from
`pre(v)` when it is discrete (specification 11.1.2), also where whens alone assign it:
`when not lit and time > 1 then lit := true; end when;` asks for the value before the
event. A when-statement acts at its event; outside of it the variables that it assigns
keep their values. Several whens that assign one variable act one after the other.

How often a `while` turns may hang on parameters, which become structural where it would else stay
a loop.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from types import MappingProxyType

from msgspec import field
from msgspec.structs import replace

from planarc.core.diagnostic import PlanarcError, error
from planarc.core.source import Span
from planarc.ir import dae, flat
from planarc.ir.expr import Expr
from planarc.ir.flatwalk import assigned_in, inside, names_in, with_sources
from planarc.lower import equations
from planarc.lower.equations import Lowered
from planarc.lower.scalar import assertion, message
from planarc.lower.scope import Model, Scope, UnknownCourse, unsupported
from planarc.lower.statements import LEFT, Roll, Runner
from planarc.lower.texts import held, number, number_held
from planarc.lower.values import Text, Value, expr
from planarc.runtime.tensor import each, elements

_LOOPS = (flat.WhileStatement, flat.ForStatement)


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
        _run(runner, [s])
        for name in ended:  # from here on it is as the event leaves it
            runner.values.pop(name, None)
    for symbol, value in _results(runner, plain):
        equations.add_equation(into, symbol, value, algorithm)


def lower_initial_algorithm(
    model: Model, algorithm: flat.Algorithm, starts: Mapping[str, Value]
) -> Iterator[dae.Equation]:
    """The initial equations that an initial algorithm stands for."""
    count = len(model.assertions)
    found = run_at_event(model, algorithm, starts, "this initial algorithm")
    model.forget_bounds(count)  # the values at the start are not those that rows hold
    for symbol, value in found:
        yield dae.Equation(symbol, value, algorithm.span, algorithm.component)


def run_at_event(
    model: Model,
    algorithm: flat.Algorithm,
    starts: Mapping[str, Value] = MappingProxyType({}),
    label: str = "this algorithm",
) -> list[tuple[Expr, Expr]]:
    """The variables that an algorithm sets at one instant, with their values. Those that it reads
    before are as they were before the event."""
    model.component = algorithm.component
    runner = Runner(Scope(model, events=False, at_event=True), label, algorithm.span)
    names = assigned_in(algorithm.statements, whens=False)
    for name in names:
        runner.values[name] = _before(model, name, starts, algorithm.span)
    _run(runner, algorithm.statements)
    return list(_results(runner, names))


def _run(runner: Runner, statements: Sequence[flat.Statement]) -> None:
    """Run statements, with the present values of parameters where their course hangs on those."""
    kinds = {type(s) for s in inside(statements)}
    if kinds.isdisjoint(_LOOPS) or flat.WhenStatement in kinds:
        runner.run_body(statements)
        return
    try:
        _attempt(runner, statements)
    except UnknownCourse as problem:
        frozen = set(runner.scope.model.frozen)
        known = _known(runner, _deciding(statements))
        try:
            if not known:
                raise
            _attempt(runner, statements, known)
        except UnknownCourse:
            runner.scope.model.frozen = frozen
            _attempt_loops(runner, statements, problem)


def _attempt_loops(
    runner: Runner, statements: Sequence[flat.Statement], refusal: UnknownCourse
) -> None:
    """Run statements with loops that stay loops."""
    from planarc.lower.turns import run_loop

    try:
        _attempt(runner, statements, roll=run_loop)
    except PlanarcError as problem:
        raise refusal.nor(problem) from None


def _attempt(
    runner: Runner,
    statements: Sequence[flat.Statement],
    known: Mapping[str, Value] = MappingProxyType({}),
    roll: Roll | None = None,
) -> None:
    """Run statements with what is known beforehand; where they fail nothing has happened."""
    trial = replace(runner, values={**runner.values, **known}, ways=[1], turns=[0], roll=roll)
    with runner.scope.model.undone_on_error(relations=True):
        trial.run_body(statements)
        if roll is not None and not runner.scope.at_event:
            _refuse_moving(trial, statements)
    values = trial.values.items()
    runner.values = {n: v for n, v in values if n in runner.values or n not in known}
    runner.unset = trial.unset


def _refuse_moving(runner: Runner, statements: Sequence[flat.Statement]) -> None:
    """Refuse discrete variables that follow what moves: no event tells when they jump."""
    model = runner.scope.model
    for s in statements:
        for name in assigned_in([s]):
            found = elements(runner.values[name])
            if name in model.discretes and not all(model.is_steady(expr(e)) for e in found):
                what = f"the discrete variable `{name}` that a loop sets by what moves"
                raise unsupported(what, s.span)


def _deciding(statements: Sequence[flat.Statement]) -> list[str]:
    """The variables on which the turns of a `while` hang; none where there is no such loop."""
    found = list(inside(statements))
    loops = [s for s in found if isinstance(s, flat.WhileStatement)]
    choices = [s for s in found if isinstance(s, flat.IfStatement)] if loops else []
    names, before = names_in(s.condition for s in loops), -1
    while len(names) > before:
        before = len(names)
        names = with_sources(names, statements)
        for s in choices:
            if _decides(s, names):
                names |= names_in(test for test, _ in s.branches)
    return sorted(names)


def _decides(s: flat.IfStatement, names: Set[str]) -> bool:
    """True when some of the variables, or whether a loop ends, hang on a choice."""
    ends = any(isinstance(each, flat.Break) for each in inside([s]))
    return ends or not names.isdisjoint(assigned_in([s]))


def _known(runner: Runner, names: Sequence[str]) -> dict[str, Value]:
    """The numbers of variables that parameters alone give, which become structural."""
    model = runner.scope.model
    given = {**model.values, **runner.values}
    numbers = {n: given[n] for n in names if _is_of_numbers(given.get(n))}
    return {n: known for n, v in numbers.items() if (known := each(model.decided, v)) != v}


def _is_of_numbers(value: Value | None) -> bool:
    return all(isinstance(e, Expr) for e in elements(value))


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
                    _run(inner, [s])
        yield from inner.asserted
        self.left.append({name: inner.values[name] for name in plain})
        for symbol, value in _results(inner, [name for name in plain if name not in self.plain]):
            if value is not self.scope.table.pre(symbol.name):
                yield equations.set_discrete(symbol, value, self.span)

    def check(self, s: flat.Assert) -> None:
        if self.scope.at_event and LEFT not in self.values:
            self.asserted.append(assertion(self.here(), s))
        else:
            super().check(s)


_Section.handlers = {
    **Runner.handlers,
    flat.WhenStatement: _Section.when,
    flat.Assert: _Section.check,
}
