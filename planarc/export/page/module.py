"""A model as a WebAssembly module for a page.

In:   Compiled
Out:  Module   bytes; the slots of values that may be set

Elementary functions are those of JavaScript's `Math`: they differ from the platform's own in the
last digit at most, which runs without events carry on as they carry rounding.

Steps are explicit ones, or, where it is wished, implicit ones by exact derivatives, which make the
module larger.

Needs:     llvmlite
Raises:    PlanarcError C300 for what cannot be exported, and what a start may raise.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.export.delays import delay_messages
from planarc.export.image import take_image
from planarc.export.link.wasm import write_module
from planarc.export.module import write_whole
from planarc.export.objects import compile_wasm
from planarc.export.page.entries import functions
from planarc.export.page.held import taken
from planarc.export.wishes import tolerance_of
from planarc.instance.plan import is_eventful
from planarc.ir.derivatives import Scope

if TYPE_CHECKING:
    from planarc.compiled import Compiled


class Module(Data):
    """`starts` are the slots of candidates whose start values may be set; `late` is why a run may
    end at a delay."""

    code: bytes
    starts: frozenset[int]
    late: tuple[str, ...]


def make_module(compiled: Compiled, stiff: bool = False) -> Module:
    """The module of a model."""
    from planarc.codegen.slopes import derive_slopes

    program = taken(compiled.program, stiff)
    image = replace(take_image(compiled), stiff=stiff)
    entries = functions(is_eventful(program), image.step is not None)
    slopes = derive_slopes(program, Scope.ALL, ()) if stiff else None
    written = write_whole(program, image, entries, "", tolerance_of(program), slopes, stiff)
    objects = compile_wasm(written)
    late = tuple(delay_messages(program, image.lags))
    return Module(write_module(objects, entries.names), frozenset(s for s, _ in image.held), late)
