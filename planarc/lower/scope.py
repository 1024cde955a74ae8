"""The meaning of names while expressions are lowered, and the store of relations."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cached_property
from typing import Any, Protocol, TypeAlias

from msgspec import Struct, field
from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, PlanarcError, Related, error
from planarc.core.source import NOWHERE, Span
from planarc.ir import dae, flat
from planarc.ir.calculus import Differentiator, time_derivative
from planarc.ir.expr import Expr, Exprs, Op, Substitution, postorder, symbols
from planarc.lower.unset import exclude
from planarc.lower.values import Value

#: Beginning of the names of variables that delays need.
DELAY = "$delay["
#: Beginning of those of values whose derivatives are given.
GIVEN = "$given["
#: Unknowns of linear equations that a function solves, see `solutions`.
SOLUTION = "$solution["

#: Results of a call, from the scope, the function's name, its arguments and the call's place.
Inline: TypeAlias = "Callable[[Scope, str, Sequence[Value], Span], tuple[Value, ...]]"


def _no_functions(
    scope: Scope, name: str, arguments: Sequence[Value], span: Span
) -> tuple[Value, ...]:
    raise AssertionError(f"the flat model does not hold the function `{name}`")


class Ticking(Protocol):
    """What operators of clocks ask of the clocked part that is being lowered, see `clocks`."""

    def first(self) -> Expr:
        """Whether this is the first tick."""

    def interval(self) -> Expr:
        """The time since the tick before, s."""

    def derivative(self, e: Expr, span: Span) -> Expr:
        """That of a variable of the part."""


class UnknownCourse(PlanarcError):
    """The statements that a function runs hang on values that are not known yet (L322)."""

    def nor(self, problem: PlanarcError) -> UnknownCourse:
        """With what keeps its loops from staying loops."""
        told, why = self.diagnostics[0], problem.diagnostics[0]
        if why.message == told.message:
            return self
        related = (*told.related, Related(f"nor can it stay a loop: {why.message}", why.span))
        return UnknownCourse(replace(told, related=related))


class Endless(UnknownCourse):
    """Nothing tells when a loop ends."""


class OutsideArray(PlanarcError):
    """A subscript that is known lies outside of its array (L312)."""


class Model(Struct, dict=True):
    """Tables that all expressions of one model share while it is lowered.

    `values` gives every variable and parameter by its flat name; `steady` holds the
    scalar names that do not change between events (parameters and discrete variables).
    """

    table: Exprs
    functions: Mapping[str, flat.Function]
    #: `functions.inline`, which the pipeline hands in: expressions hold calls, and what a
    #: function does is told by expressions
    inline: Inline = _no_functions
    #: the place of the user's value that an assertion is about
    given: Callable[[flat.Assert], Span] = lambda _: NOWHERE
    #: an assertion with the place of the user's call that it stands for, and a call of its function
    called: Callable[[dae.Assertion, Span], dae.Assertion] = lambda a, _: a
    values: dict[str, Value] = field(default_factory=dict)
    parameters: set[str] = field(default_factory=set)
    discretes: set[str] = field(default_factory=set)
    #: the parameters entered so far, as expressions
    parameter_values: dict[str, Expr] = field(default_factory=dict)
    #: parameters whose present values shaped the equations
    frozen: set[str] = field(default_factory=set)
    relations: list[dae.Relation] = field(default_factory=list)
    component: str = ""  # of what is being lowered
    #: calls whose entries are taken one by one, as in `transpose({f(x)})`, while the value of one
    #: parameter is lowered; None elsewhere
    opened: dict[int, Value] | None = None
    samplers: list[dae.Sampler] = field(default_factory=list)
    assertions: list[dae.Assertion] = field(default_factory=list)
    warnings: list[Diagnostic] = field(default_factory=list)
    #: conditions of subscripts that an assertion checks already
    bounds: set[Expr] = field(default_factory=set)
    auxiliaries: list[tuple[dae.Variable, dae.Equation]] = field(default_factory=list)
    delays: list[dae.Delay] = field(default_factory=list)
    #: continuous variables that delays and given derivatives need, with their equations
    added: list[tuple[dae.Variable, dae.Equation]] = field(default_factory=list)
    delay_values: dict[tuple[Expr, Expr], Expr] = field(default_factory=dict)
    #: unknowns of linear equations, by the entries of these, see `solutions`
    solutions: dict[tuple[object, ...], tuple[Expr, ...]] = field(default_factory=dict)
    #: calls of which no course is known, by names and arguments, or by what is known of these
    refused: dict[tuple[object, ...], UnknownCourse] = field(default_factory=dict)
    #: number of calls of functions that give another value in each, which tells them apart
    impure_calls: int = 0
    #: number of symbols that stand for what turns of loops change, see `turns`
    symbols_of_turns: int = 0
    #: how many loops are being run once for all their turns: nothing in one is the model's own
    turning: int = 0
    #: whether a variable is differentiated
    is_moving: Callable[[str], bool] = lambda _: False
    #: discrete variables that follow continuous ones, see `lefts`
    lefts: dict[Expr, Expr] = field(default_factory=dict)
    #: the phase of every rounded expression, see `rounding`
    phases: dict[Expr, Expr] = field(default_factory=dict)
    ticking: Ticking | None = None
    blended: bool = False  # `homotopy` gives actual and simplified values in parts
    simplified: bool = False  # True when a simplified form was left out
    _relation_of: dict[tuple[Expr, bool], int] = field(default_factory=dict)

    @cached_property
    def time_derivative(self) -> Differentiator:
        parameters, discretes = self.parameters, self.discretes  # and not the model: no cycle
        return time_derivative(self.table, lambda name: name in parameters or name in discretes)

    def take_assertions(self, count: int) -> tuple[dae.Assertion, ...]:
        """Take those back that came after the first `count`: they hold elsewhere, or never."""
        taken = tuple(self.assertions[count:])
        del self.assertions[count:]
        self.bounds.difference_update(a.condition for a in taken)
        return taken

    @contextmanager
    def undone_on_error(self, relations: bool = False) -> Iterator[None]:
        """A block whose assertions, and on demand relations, are dropped when it fails: another way
        may be tried."""
        count, related = len(self.assertions), len(self.relations)
        try:
            yield
        except PlanarcError:
            self.take_assertions(count)
            if relations:
                self._forget_relations(related)
            raise

    def _forget_relations(self, count: int) -> None:
        """Drop those after the first `count`, whose places others take."""
        del self.relations[count:]
        self._relation_of = {k: i for k, i in self._relation_of.items() if i < count}
        self.refused.clear()  # calls whose arguments hold them

    @contextmanager
    def in_turn(self, span: Span) -> Iterator[None]:
        """A block that is run once for all turns of a loop. What it would add to the model holds
        for one turn only, and is refused; so is what is another value in each."""
        own: tuple[list[Any], ...] = (self.added, self.auxiliaries, self.delays, self.samplers)
        counts, calls = [len(listed) for listed in own], self.impure_calls
        self.turning += 1
        try:
            yield
        finally:
            self.turning -= 1
            grown = [len(listed) for listed in own] != counts
            for listed, count in zip(own, counts, strict=True):
                del listed[count:]
        if grown:
            raise unsupported("a loop with turns that need equations of their own", span)
        if self.impure_calls > calls:
            raise unsupported("a loop that calls a function that is not pure", span)

    @contextmanager
    def between_ticks(self) -> Iterator[None]:
        """A block about what is continuous, in a part that ticks."""
        ticking, self.ticking = self.ticking, None
        try:
            yield
        finally:
            self.ticking = ticking

    def forget_bounds(self, count: int) -> None:
        """Drop those of subscripts among the assertions after the first `count`."""
        bounds = set(self.bounds)
        self.assertions += (a for a in self.take_assertions(count) if a.condition not in bounds)

    def number(self, e: Expr) -> Expr:
        """An expression of parameters with their present values put in, which are then frozen.

        What is no expression of parameters comes back with its variables.
        """
        known: dict[Expr, Expr] = {}
        for symbol in symbols(e):
            value = self.parameter_values.get(symbol.name)
            if value is not None:
                self.frozen.add(symbol.name)
                known[symbol] = self.number(value)
        return Substitution(self.table, known)(e)

    def decided(self, e: Expr) -> Expr:
        """The number of an expression of parameters alone, now frozen; others as given."""
        frozen = set(self.frozen)
        found = self.number(e)
        if found.is_const:
            return found
        self.frozen = frozen
        return e

    def is_steady(self, e: Expr) -> bool:
        """True when the value cannot change between events."""
        return all(
            n.op is not Op.TIME and not (n.op is Op.SYMBOL and not self._is_steady_symbol(n))
            for n in postorder((e,))
        )

    def _is_steady_symbol(self, e: Expr) -> bool:
        if e.name in self.parameters or e.name in self.discretes:
            return True
        return e.name.startswith("$") and not e.name.startswith((DELAY, GIVEN, SOLUTION))

    def relation(self, zero: Expr, strict: bool, text: str, span: Span) -> Expr:
        """The stored truth of `zero < 0` (strict) or `zero <= 0`; equal ones share it."""
        key = (zero, strict)
        if key not in self._relation_of:
            self._relation_of[key] = len(self.relations)
            time_only = all(
                e.op is not Op.SYMBOL or e.name in self.parameters for e in postorder((zero,))
            ) and not any(e.op in (Op.PRE, Op.EVENT) for e in postorder((zero,)))
            self.relations.append(dae.Relation(zero, strict, time_only, text, span, self.component))
        return self.table.event(self._relation_of[key])


class Scope(Data):
    """The place of an expression.

    `locals` are a function's variables (None outside of functions). `events`: relations
    make events; false inside functions, `noEvent`, asserts and initial equations.
    `at_event`: inside a when-clause, where relations are plain and `pre` of a continuous
    variable is its value.
    """

    model: Model
    locals: Mapping[str, Value] | None = None
    events: bool = True
    at_event: bool = False
    depth: int = 0  # of function calls
    path: Expr | None = None  # what must hold for it to be evaluated; None: nothing
    unset: Mapping[str, Expr] = {}  # where some of `locals` have no value
    function: flat.Function | None = None  # whose variables `locals` are

    @property
    def table(self) -> Exprs:
        return self.model.table

    def without_events(self) -> Scope:
        return replace(self, events=False)

    def where(self, condition: Expr) -> Scope:
        """The same scope, evaluated only where a condition holds as well."""
        if condition is self.table.true:
            return self
        path = condition if self.path is None else self.table.and_(self.path, condition)
        return replace(self, path=path)

    def keep_within(
        self, position: Expr, fit: Collection[int], span: Span, what: str = "the subscript"
    ) -> None:
        """End the run where a subscript that is chosen while running is none that fits."""
        t, low, high = self.table, min(fit), max(fit)
        holds = t.and_(t.less_equal(t.const(low), position), t.less_equal(position, t.const(high)))
        for number in () if len(fit) == high - low + 1 else sorted({*range(low, high)} - {*fit}):
            holds = t.and_(holds, t.not_(t.equal(position, t.const(number))))
        if self.path is not None:
            holds = t.or_(t.not_(self.path), holds)
        if holds not in self.model.bounds:
            self.model.bounds.add(holds)
            parts = (f"{what} ", (position, ""), f" is outside of {low} to {high}")
            self.model.assertions.append(dae.Assertion(holds, dae.Message(parts), span=span))

    def keep_set(self, name: str, message: str, span: Span) -> None:
        """End the run where a variable without a value is asked for."""
        t, condition = self.table, self.unset[name]
        if self.path is not None:
            if exclude(t, self.path, condition):
                return
            condition = t.and_(self.path, condition)
        holds = t.not_(condition)
        if holds not in self.model.bounds:
            self.model.bounds.add(holds)
            self.model.assertions.append(dae.Assertion(holds, dae.Message((message,)), span=span))

    def value(self, name: str, span: Span) -> Value:
        if self.locals is not None and name in self.locals:
            if name in self.unset:
                self.keep_set(name, f"`{name}` is used before it has a value", span)
            return self.locals[name]
        if name in self.model.values and not self._is_own(name):
            return self.model.values[name]
        if self.locals is not None:
            message = f"`{name}` is used before it has a value"
            hint = "give it one above, or where it is declared"
            raise UnknownCourse(Diagnostic("L301", message, span, hint=hint))
        raise AssertionError(f"the flat model does not declare `{name}`")

    def _is_own(self, name: str) -> bool:
        """Whether a function declares it: the model's variable of this name is another one."""
        f = self.function
        return f is not None and name in (v.name for v in (*f.inputs, *f.outputs, *f.locals))


def outside_of_when(span: Span, when: str = "when condition then", where: str = "") -> PlanarcError:
    """An action at events that stands in no when-clause."""
    message = "`terminate` and `reinit` stand in when-clauses only"
    return error("L340", message, span, hint=f"write `{when} ... end when;`{where}")


def outside_array(number: int, count: int, span: Span) -> OutsideArray:
    """A subscript, counted from 1, that no entry has."""
    message = f"subscript {number} is outside of 1 to {count}"
    return OutsideArray(Diagnostic("L312", message, span))


def unsupported(what: str, span: Span, hint: str | None = None) -> PlanarcError:
    """A construct that planarc reads but cannot turn into equations."""
    return error("L302", f"{what} is not supported", span, hint=hint)
