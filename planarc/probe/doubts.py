"""Assertions that parameters alone break, told without a run.

In:   FlatModel, Dae
Out:  a message (R430) for each, at the user's text; an error only where it is about a part of the
      user's model

Parameters have the values of their declarations here; what follows from the start, or from a
parameter without value, is left to the run.

Example: `BodyBox lever(density=7.8, ...)` is of no solid, however it moves; no contact works with
the corner of a `Polygon` that is hollow.
"""

from __future__ import annotations

from collections.abc import Iterator

from planarc.core.diagnostic import Diagnostic
from planarc.core.source import NOWHERE, Span
from planarc.evaluate.declared import DeclaredValues
from planarc.ir.dae import Dae
from planarc.ir.flat import FlatModel, Part
from planarc.ir.places import own_part
from planarc.runtime.texts import formatted
from planarc.solve.messages.assertion import assertion_diagnostic


def find_doubts(flat: FlatModel, dae: Dae) -> Iterator[Diagnostic]:
    """What a model's components say of their parameters."""
    open_ones = {v.name for v in flat.variables if v.binding is None}
    values, told = DeclaredValues(dae, open_ones), set[Span]()
    said: set[tuple[Part | None, str]] = set()  # once of two contacts in one part
    for assertion in dae.assertions:
        if not assertion.warning and own_part(dae, assertion.component) is None:
            continue  # a library's class by itself has not its values yet
        try:
            if values(assertion.condition):
                continue
            texts = [
                part if isinstance(part, str) else formatted(values(part[0]), part[1])
                for part in assertion.message.parts
            ]
        except (KeyError, ArithmeticError, ValueError):
            continue
        text = (own_part(dae, assertion.component), "".join(texts))
        if text not in said and (assertion.given is NOWHERE or assertion.given not in told):
            told.add(assertion.given)
            said.add(text)
            yield assertion_diagnostic(dae, None, assertion, text[1])
