"""What a check made of a model, handed on to its live page: nothing is flattened twice.

In:   Seen    in the thread that checks
Out:  Model   in the thread of pages

A table of expressions belongs to one thread. So the program goes over as bytes, and gets a table
of its own; the check goes on with its own, and code is made beside it.
"""

from __future__ import annotations

from msgspec.structs import replace

from planarc import stages
from planarc.api.model import Model
from planarc.compiled import Compiled, find_lead
from planarc.core.clock import Clock
from planarc.core.data import Data, without_collection
from planarc.core.diagnostic import Diagnostic
from planarc.core.options import Backend
from planarc.ir.store import dumps, loads
from planarc.probe.check import Seen
from planarc.request.request import Request


class Draft(Data):
    """A model without code. `lead` leads to its start, where it has a simplified form."""

    program: bytes
    warnings: tuple[Diagnostic, ...]
    lead: Compiled | None = None


def draft_of(seen: Seen, backend: Backend, clock: Clock) -> Draft:
    """What is to be handed on. Raises what the clock's watch raises."""
    with without_collection():
        program = stages.to_program(seen.model, clock)
        program = replace(program, mechanism=seen.checked.mechanism, figures=seen.flat.figures)
        lead = find_lead(seen.flat, seen.dae, backend, clock)
    return Draft(dumps(program, program.table), seen.checked.warnings, lead)


def model_of(draft: Draft, request: Request, backend: Backend, clock: Clock) -> Model:
    """The model that the request is for, with code."""
    with without_collection():
        program = loads(draft.program)
        compiled = Compiled.of(program, backend, clock, draft.warnings, draft.lead)
    return Model(request, backend, compiled)
