"""Clocked parts as discrete equations that hold at the ticks of their clocks.

In:   Parting, the Model that is being lowered
Out:  dae.Clock        a Boolean that is true in the pass of an event in which the clock ticks
      dae.Equation     the scalar equations of parts, each with its clock

A base clock counts its ticks; a part ticks at each of them that its rate says. Between ticks, its
variables keep their values. Values pass from one part to another as they are: each part reads what
the other one has, after it where both tick at once, so that no operator between clocks changes a
value. `sample` reads left limits.

Example: `y = sample(x, Clock(0.1))` is, with `$clock[1]` for `$sample[0]` that just became true,

    at $clock[1]:  y = left limit of x

Reference: Modelica Language Specification 3.6, sections 16.4 to 16.8.
"""

from __future__ import annotations

from collections.abc import Iterator

from msgspec import Struct, field

from planarc.core.diagnostic import error
from planarc.core.source import Span
from planarc.ir import dae, flat
from planarc.ir.expr import Expr
from planarc.lower import rounding
from planarc.lower.algorithms import run_at_event
from planarc.lower.clocks.parts import Part, Parting, equations_of
from planarc.lower.clocks.rates import Base, Rate, find_rates, is_event, ratio
from planarc.lower.equations import Lowered, fires, named_truth, scalar_pairs
from planarc.lower.scalar import assertion, lower_expression, message
from planarc.lower.scope import Model, Scope
from planarc.lower.values import expr

METHODS = ("ExplicitEuler", "ImplicitEuler", "ImplicitTrapezoid")


class _Pulse(Struct):
    """A base clock: when it ticks, how often it did so, and the time between its ticks; None where
    a condition ticks, of which the time before the first tick is given."""

    fires: Expr
    count: Expr
    interval: Expr | None
    at_first: Expr


class _Ticking(Struct):
    """What operators of clocks ask of the part that is being lowered (`scope.Ticking`)."""

    model: Model
    part: Part
    number: int
    rate: Rate
    pulse: _Pulse
    symbol: Expr  # true in the pass in which it ticks
    equations: list[dae.Equation] = field(default_factory=list)
    rates: dict[Expr, Expr] = field(default_factory=dict)
    last: Expr | None = None  # the time of the last tick

    def first(self) -> Expr:
        t = self.model.table
        return t.equal(self.pulse.count, t.const(self.rate.first))

    def interval(self) -> Expr:
        t, pulse = self.model.table, self.pulse
        if pulse.interval is not None:
            return t.mul(t.const(self.rate.every), pulse.interval)
        if self.last is None:
            self.last = t.symbol(f"$last[{self.number + 1}]")
            kept = t.if_(self.symbol, t.time, t.pre(self.last.name))
            _define(self.model, self.last, dae.Kind.REAL, kept, self.part.span)
        return t.if_(self.first(), pulse.at_first, t.sub(t.time, t.pre(self.last.name)))

    def derivative(self, e: Expr, span: Span) -> Expr:
        """The derivative of a variable of the part, which its clock's method integrates."""
        if not e.is_symbol or e.name not in self.model.discretes:
            hint = f"give it a variable of its own: `x = {span.text[4:-1]}`, and write `der(x)`"
            raise error("L375", f"`{span.text}` is no derivative of a variable", span, hint=hint)
        known = self.rates.get(e)
        if known is None:
            known = self.rates[e] = self.model.table.symbol(f"$rate[{e.name}]")
            self.model.discretes.add(known.name)
            self.equations.append(self._integrated(e, known, span))
        return known

    def _integrated(self, x: Expr, rate: Expr, span: Span) -> dae.Equation:
        t = self.model.table
        before, old = t.pre(rate.name), t.pre(x.name)
        match self.part.method:
            case "ExplicitEuler":
                slope = before
            case "ImplicitEuler":
                slope = rate
            case "ImplicitTrapezoid":
                slope = t.div(t.add(before, rate), t.const(2))
            case method:
                hint = f"choose one of {', '.join(f'`{m}`' for m in METHODS)}"
                problem = f"planarc does not know the solver method `{method}`"
                raise error("L376", problem, self.part.span, hint=hint)
        moved = t.add(old, t.mul(self.interval(), slope))
        value = t.if_(self.first(), old, moved)
        return dae.Equation(x, value, span, clock=self.number, integrates=True)


def lower_clocks(
    model: Model, parting: Parting, into: Lowered
) -> tuple[tuple[dae.Clock, ...], tuple[dae.Variable, ...]]:
    """Append the equations of clocked parts to `into`. The clocks, and discrete variables that
    these equations need. Raises PlanarcError (L37x)."""
    bases, rates, warnings = find_rates(parting)
    model.warnings += warnings
    busy = [
        (p, r) for p, r in zip(parting.parts, rates, strict=True) if p.equations or p.algorithms
    ]
    numbers = sorted({rate.base for _, rate in busy})
    pulses = {i: _pulse(model, bases[i], i) for i in numbers}
    clocks: list[dae.Clock] = []
    added: list[dae.Variable] = []
    for i, (part, rate) in enumerate(busy):
        pulse = pulses[rate.base]
        ticking = _Ticking(model, part, i, rate, pulse, _tick(model, part, i, rate, pulse))
        model.ticking = ticking
        into.equations.extend(_equations(ticking, into))
        into.equations.extend(ticking.equations)
        own = [dae.Variable(r.name, protected=True, span=part.span) for r in ticking.rates.values()]
        added += own
        names = part.variables.union(v.name for v in own)
        clocks.append(dae.Clock(ticking.symbol.name, names, part.span))
    model.ticking = None
    return tuple(clocks), tuple(added)


def _define(model: Model, symbol: Expr, kind: dae.Kind, value: Expr, span: Span) -> None:
    """A discrete variable of planarc's own, with its equation."""
    start = model.table.const(-1) if kind is dae.Kind.INTEGER else None
    variable = dae.Variable(symbol.name, kind, start, fixed=True, protected=True, span=span)
    model.discretes.add(symbol.name)
    model.auxiliaries.append((variable, dae.Equation(symbol, value, span, assigned=True)))


# Clocks ------------------------------------------------------------------------------------------


def _pulse(model: Model, base: Base, number: int) -> _Pulse:
    t, clock = model.table, base.clock
    interval: Expr | None = None
    at_first = t.zero
    if is_event(clock):
        truth = expr(lower_expression(Scope(model), clock.arguments[0]))
        at_first = expr(lower_expression(Scope(model), clock.arguments[1]))
    else:
        model.parameters.add(dae.START_TIME)
        interval = _interval(model, base)
        start = t.symbol(dae.START_TIME)
        truth = t.symbol(f"$sample[{len(model.samplers)}]")
        model.samplers.append(dae.Sampler(start, interval, clock.span))
    named = named_truth(model, truth, dae.Equation(truth, truth, clock.span))
    if is_event(clock):
        named = _afterwards(model, named, number, clock.span)
    fired = fires(model, named.name)
    count = t.symbol(f"$tick[{number + 1}]")
    before = t.pre(count.name)
    value = t.if_(fired, t.add(before, t.one), before)
    _define(model, count, dae.Kind.INTEGER, value, clock.span)
    return _Pulse(fired, count, interval, at_first)


def _afterwards(model: Model, condition: Expr, number: int, span: Span) -> Expr:
    """A condition as it was in the pass before: a clock ticks after what made its condition true,
    which may hang on what it changes in its turn. Where it is true at the start, that is a tick, as
    the published results of the Modelica Standard Library have it."""
    symbol = model.table.symbol(f"$ready[{number + 1}]")
    _define(model, symbol, dae.Kind.BOOLEAN, model.table.pre(condition.name), span)
    return symbol


def _interval(model: Model, base: Base) -> Expr:
    known, t = ratio(base.clock), model.table
    if known is not None:
        return t.const(float(known * base.grain))
    whole = expr(lower_expression(Scope(model, events=False), base.clock.arguments[0]))
    return t.mul(t.const(float(base.grain)), whole)


def _tick(model: Model, part: Part, i: int, rate: Rate, pulse: _Pulse) -> Expr:
    """The Boolean that is true in the pass in which a part ticks."""
    t = model.table
    truth = pulse.fires
    if rate.first:
        truth = t.and_(truth, t.less_equal(t.const(rate.first), pulse.count))
    if rate.every > 1:
        since = t.sub(pulse.count, t.const(rate.first))
        plain = Scope(model, events=False, at_event=True)
        rest = rounding.mod(plain, since, t.const(rate.every), part.span)
        truth = t.and_(truth, t.equal(rest, t.zero))
    symbol = t.symbol(f"$clock[{i + 1}]")
    _define(model, symbol, dae.Kind.BOOLEAN, truth, part.span)
    return symbol


# Equations -------------------------------------------------------------------------------------


def _equations(ticking: _Ticking, into: Lowered) -> Iterator[dae.Equation]:
    """The scalar equations of a part; what it asserts, and where it ends the run, at its ticks."""
    model, number_ = ticking.model, ticking.number
    scope = Scope(model, events=False, at_event=True)
    count = len(model.assertions)
    actions: list[dae.Action] = []
    for e in equations_of(ticking.part):
        model.component = e.component
        match e:
            case flat.Equality() | flat.IfEquation():
                for left, right in scalar_pairs(scope, e):
                    yield dae.Equation(left, right, e.span, e.component, clock=number_)
            case flat.Assert():
                actions.append(assertion(scope, e))
            case flat.Terminate():
                actions.append(dae.Terminate(message(scope, e.message), e.span))
    for algorithm in ticking.part.algorithms:
        for symbol, value in run_at_event(model, algorithm):
            origin = algorithm.span, algorithm.component
            yield dae.Equation(symbol, value, *origin, assigned=True, clock=number_)
    actions += model.take_assertions(count)
    if actions:
        branch = ticking.symbol.name, tuple(actions)
        into.whens.append(dae.When((branch,), ticking.part.span))
