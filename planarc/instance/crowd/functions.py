"""All functions of crowds: those of an exported model, and those of a run in Python."""

from __future__ import annotations

from planarc.instance.crowd.impulses import impulse_functions
from planarc.instance.crowd.meetings import meeting_functions
from planarc.instance.crowd.places import place_functions
from planarc.instance.crowd.response import response_functions
from planarc.instance.crowd.steps import moment_functions, step_functions

#: What these call of a model's own.
_MODEL = """
declare ptr @px_member(i64)
"""


def crowd_functions(delayed: bool) -> tuple[str, ...]:
    """`delayed`: the model has a past."""
    return (_MODEL, *place_functions(), *meeting_functions(), *response_functions(),
            *impulse_functions(), *step_functions(delayed))  # fmt: skip


def moved_functions() -> tuple[str, ...]:
    """Those of one step, which leave what is doubtful to Python."""
    return (*place_functions(), *meeting_functions(), *response_functions(),
            *impulse_functions(doubts=True), *moment_functions(doubts=True))  # fmt: skip
