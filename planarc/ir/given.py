"""The one place in the user's text that an assertion of a library is about.

In:   FlatModel, an assertion on parameters alone
Out:  the place of that value; NOWHERE where there are several, or none
In:   an assertion in a function, and a place where that is called
Out:  the call, where the user wrote that and not the function

Example: of `Polygon contour1(vertices=corners)` the assertion asks `hollow`, which follows from
`vertices` inside of the library: the place is that of the value of `corners`.
"""

from __future__ import annotations

from functools import cached_property, partial

from msgspec import Struct
from msgspec.structs import replace

from planarc.core.source import NOWHERE, Span
from planarc.ir import dae, flat
from planarc.ir.flatwalk import names_in
from planarc.ir.places import is_own


class Given(Struct, dict=True):
    """Places of what the user gave to the components of a model."""

    source: flat.FlatModel

    def __call__(self, e: flat.Assert) -> Span:
        if is_own(self.source, e.span):
            return NOWHERE
        names, places = list(names_in((e.condition,))), dict[str, Span]()
        seen = set(names)
        for name in names:
            variable = self._variables.get(name)
            if variable is None or variable.variability > flat.Variability.PARAMETER:
                return NOWHERE
            binding = variable.binding
            if binding is None:
                continue
            if is_own(self.source, binding.span):
                places[name] = self._origin(binding).span
                continue
            inner = names_in((binding,)) - seen
            names += inner
            seen |= inner
        return next(iter(places.values())) if len(places) == 1 else NOWHERE

    def called(self, assertion: dae.Assertion, call: Span) -> dae.Assertion:
        own = partial(is_own, self.source)
        if assertion.given is not NOWHERE or own(assertion.span) or not own(call):
            return assertion
        return replace(assertion, given=call)

    def _origin(self, value: flat.Expression) -> flat.Expression:
        """The value of the parameter that a value names, where that is written in the text."""
        while isinstance(value, flat.Reference) and not value.subscripts:
            named = self._variables.get(value.name)
            if named is None or named.binding is None:
                break
            if not is_own(self.source, named.binding.span):
                break
            value = named.binding
        return value

    @cached_property
    def _variables(self) -> dict[str, flat.Variable]:
        return {v.name: v for v in self.source.variables}
