"""Settings of the command line put into a compiled model and the options of its run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from msgspec.structs import replace

from planarc.cli.settings import Setting, sort_settings
from planarc.core.diagnostic import Diagnostic, Severity
from planarc.core.prose import be, both

if TYPE_CHECKING:
    from planarc.compiled import Compiled
    from planarc.core.options import RunOptions
    from planarc.request.request import Request


def apply_settings(
    settings: Sequence[Setting], request: Request, compiled: Compiled, options: RunOptions
) -> tuple[Compiled, RunOptions, tuple[Diagnostic, ...]]:
    """Apply all settings; a structural parameter makes another model, and a note says so."""
    program = compiled.program
    parameters = {p.name: p for p in program.parameter_slots}
    given, begun = sort_settings(settings, parameters)
    values = {n: v for n, v in given.items() if isinstance(v, float)}
    starts = {n: v for n, v in begun.items() if isinstance(v, float)}
    if len(values) < len(given) or len(starts) < len(begun):
        from planarc.api.values import parameter_values, start_values

        values |= parameter_values(program, {n: given[n] for n in given.keys() - values.keys()})
        starts |= start_values(program, {n: begun[n] for n in begun.keys() - starts.keys()})
    structural = {n: v for n, v in values.items() if n in parameters and parameters[n].structural}
    plain = {n: v for n, v in values.items() if n not in structural}
    options = replace(options, values=plain, starts=starts)
    if not structural:
        return compiled, options, ()
    from planarc.api.variant import compile_variant, texts_of

    texts = texts_of(request, program, structural, options.backend)
    again = compile_variant(request, texts, options.backend, program)
    note = Diagnostic(
        "C116",
        f"{both(structural)} {be(len(structural))} structural: the model was compiled again",
        severity=Severity.NOTE,
    )
    return again, options, (note,)
