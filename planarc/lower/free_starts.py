"""Start values that hang on parameters which the start finds.

In:   Classified, of a model without parameters that have `fixed = false` (`free_parameters`)
Out:  Classified, its start values known before the start
      Hanging: the start values that were held, as initial equations

What is held at such a value is a condition that is solved together with the parameters; what is
set at events has the value before the start. As a guess, a start value takes the guesses of these
parameters; so does a nominal value.

Example:

    parameter Real a(fixed=false, start=1);        Real a(start=1);
    Real x(start=2*a, fixed=true);            ->   Real x(start=2);
    initial equation                               initial equation
      a^2 = 9;                                       a^2 = 9;
                                                     x = 2*a;

Reference: Modelica Language Specification 3.6, section 8.6.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from msgspec import Struct, field
from msgspec.structs import replace

from planarc.core.source import Span
from planarc.ir import dae, flat
from planarc.ir.expr import Expr, Substitution, symbols
from planarc.lower.assignment import zero_of
from planarc.lower.classify import Classified, ordered, referenced, spread
from planarc.lower.scalar import lower_expression
from planarc.lower.scope import Model, Scope
from planarc.lower.values import fixed_dims, scalar_names


class Hanging(Struct):
    """Initial equations `x = start`, `pre(d) = start`, and those of discrete variables that are
    not held but where nothing else says what they are before the start."""

    held: list[dae.Equation] = field(default_factory=list)
    loose: list[dae.Equation] = field(default_factory=list)


def release_starts(
    model: Model, source: flat.FlatModel, classified: Classified
) -> tuple[Classified, Hanging]:
    """The variables with start values that are known before the start."""
    hanging = Hanging()
    guesses = _guesses(model, source)
    if not guesses:
        return classified, hanging
    release = _Release(model, guesses, dict(_places(source)), hanging)
    return replace(
        classified,
        variables=tuple(map(release.continuous, classified.variables)),
        discretes=tuple(map(release.discrete, classified.discretes)),
        inputs=tuple(map(release.guessed, classified.inputs)),
    ), hanging


def _guesses(model: Model, source: flat.FlatModel) -> Mapping[Expr, Expr]:
    """Of each scalar that the start finds what is known of it before."""
    found: dict[Expr, Expr] = {}
    scope = Scope(model, events=False)
    for v in ordered([v for v in source.variables if v.at_start]):
        given = v.binding if v.binding is not None else v.attributes.start
        value = zero_of(v.type, model.table) if given is None else lower_expression(scope, given)
        put_in = Substitution(model.table, found)
        own = spread(model, model.values[v.name], v)
        found |= zip(own, map(put_in, spread(model, value, v)), strict=True)
    return found


def _places(source: flat.FlatModel) -> Iterator[tuple[str, Span]]:
    """Where the start values of scalars are written that hang on such parameters."""
    free = {v.name for v in source.variables if v.at_start}
    for v in source.variables:
        start = v.attributes.start
        if start is not None and not free.isdisjoint(referenced(start)):
            yield from ((name, start.span) for name in scalar_names(v.name, fixed_dims(v.type)))


class _Release(Struct):
    """What becomes of the start values of variables."""

    model: Model
    guesses: Mapping[Expr, Expr]
    places: Mapping[str, Span]
    hanging: Hanging

    def continuous(self, v: dae.Variable) -> dae.Variable:
        if not (v.fixed and self._hangs(v)):
            return self.guessed(v)
        self.hanging.held.append(self._equation(v, self.model.table.symbol(v.name)))
        return replace(self.guessed(v), fixed=False, start_written=False)

    def discrete(self, v: dae.Variable) -> dae.Variable:
        if v.at_start or not self._hangs(v):
            return self.guessed(v)
        into = self.hanging.held if v.fixed else self.hanging.loose
        into.append(self._equation(v, self.model.table.pre(v.name)))
        return replace(self.guessed(v), fixed=False)

    def guessed(self, v: dae.Variable) -> dae.Variable:
        """The variable with what is known of its start and its size."""
        return replace(v, start=self._known(v.start), nominal=self._known(v.nominal))

    def _known(self, e: Expr | None) -> Expr | None:
        return None if e is None else Substitution(self.model.table, self.guesses)(e)

    def _hangs(self, v: dae.Variable) -> bool:
        return v.start is not None and any(s in self.guesses for s in symbols(v.start))

    def _equation(self, v: dae.Variable, left: Expr) -> dae.Equation:
        assert v.start is not None
        return dae.Equation(left, v.start, self.places[v.name], v.component)
