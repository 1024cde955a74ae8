"""All functions of the past."""

from __future__ import annotations

from planarc.instance.past.kinks import kink_functions
from planarc.instance.past.pieces import piece_functions
from planarc.instance.past.record import record_functions
from planarc.instance.past.start import start_functions

#: What they ask of a model.
_MODEL = """
declare void @px_intervals(ptr, ptr, ptr)
@px_past = external constant [0 x i64]
"""


def past_functions(crowded: bool) -> tuple[str, ...]:
    return (_MODEL, *piece_functions(), *record_functions(crowded), *kink_functions(),
            *start_functions())  # fmt: skip
