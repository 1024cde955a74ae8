"""Exit codes, and which one an error has."""

from __future__ import annotations

from enum import IntEnum

from planarc.core.diagnostic import PlanarcError, RunError, UsageError


class Exit(IntEnum):
    DONE = 0
    MODEL = 1  # the model is wrong
    USAGE = 2  # the request is wrong
    RUN = 3  # the run failed part-way; what was computed is saved
    BUG = 70  # a mistake of planarc's own (EX_SOFTWARE of sysexits.h)
    INTERRUPTED = 130  # 128 + SIGINT
    BROKEN_PIPE = 141  # 128 + SIGPIPE


def exit_code(error: PlanarcError) -> Exit:
    if isinstance(error, UsageError):
        return Exit.USAGE
    return Exit.RUN if isinstance(error, RunError) else Exit.MODEL
