"""A mistake of planarc's own, as a user is told of it."""

from __future__ import annotations

from pathlib import Path

from planarc.core.diagnostic import Diagnostic


def mistake(error: Exception) -> Diagnostic:
    """Where planarc broke, in one line that a user can pass on."""
    place = ""
    trace = error.__traceback__
    while trace is not None:
        file = Path(trace.tb_frame.f_code.co_filename)
        place = f"{file.parent.name}/{file.name}:{trace.tb_lineno}"
        trace = trace.tb_next
    return Diagnostic(
        "X001",
        f"sorry, planarc made a mistake: {type(error).__name__} in {place}",
        hint="report this line together with the model; PLANARC_DEBUG=1 shows the traceback",
    )
