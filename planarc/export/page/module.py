"""A model as a WebAssembly module for a page.

In:   Compiled
Out:  Module   bytes; the slots of values that may be set

Elementary functions are those of JavaScript's `Math`: they differ from the platform's own in the
last digit at most, which runs without events carry on as they carry rounding.

Needs:     llvmlite
Raises:    PlanarcError C300 for what cannot be exported, and what a start may raise.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from planarc.core.data import Data
from planarc.export.image import take_image
from planarc.export.link.wasm import write_module
from planarc.export.module import compile_library
from planarc.export.page.entries import functions
from planarc.export.refusal import refuse
from planarc.export.wishes import tolerance_of

if TYPE_CHECKING:
    from planarc.compiled import Compiled

_TRIPLE = "wasm32-unknown-unknown"


class Module(Data):
    """`starts` are the slots of candidates whose start values may be set."""

    code: bytes
    starts: frozenset[int]


def make_module(compiled: Compiled) -> Module:
    """The module of a model."""
    program = compiled.program
    refuse(program)
    image, entries = take_image(compiled), functions()
    objects = compile_library(program, image, entries, "", tolerance_of(program), _TRIPLE)
    return Module(write_module(objects, entries.names), frozenset(s for s, _ in image.held))
