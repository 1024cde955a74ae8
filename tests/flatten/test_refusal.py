"""Refusals of several parts at once are of the kind that decides what is done about them."""

from __future__ import annotations

import pytest

from planarc.core.diagnostic import Diagnostic, PlanarcError, error
from planarc.core.source import NOWHERE
from planarc.flatten.refusal import (
    NotThere,
    TooLarge,
    UnknownValue,
    for_each,
    too_large,
    unknown_value,
)

PLAIN = error("F270", "plain")
ABSENT = NotThere(Diagnostic("F215", "absent"))
LARGE = too_large("large", None)
UNKNOWN = unknown_value("unknown", NOWHERE)


@pytest.mark.parametrize(
    ("problems", "kind"),
    [
        ([PLAIN, PLAIN], PlanarcError),
        ([PLAIN, UNKNOWN], UnknownValue),
        ([LARGE, PLAIN], TooLarge),
        ([LARGE, UNKNOWN], UnknownValue),
        ([ABSENT, ABSENT], NotThere),
        ([ABSENT, PLAIN], PlanarcError),
    ],
)
def test_one_error_tells_all_and_is_of_the_kind_that_decides(
    problems: list[PlanarcError], kind: type[PlanarcError]
) -> None:
    def fail(problem: PlanarcError) -> None:
        raise problem

    with pytest.raises(PlanarcError) as caught:
        for_each(problems, fail)
    assert type(caught.value) is kind
    assert caught.value.diagnostics == tuple(d for p in problems for d in p.diagnostics)


def test_what_succeeds_keeps_its_order() -> None:
    assert for_each((3, 1, 2), lambda n: -n) == [-3, -1, -2]
