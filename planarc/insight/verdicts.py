"""All that the rows of a run are judged by.

In:   Result, the tolerance
Out:  warnings and notes, in the order in which they are told

    losses      energy that the steps of the run lost
    reactions   parts of the user's own against the third law
    accounts    parts of the user's own that miscount their energy
    runaway     speeds that grow beyond all bounds
    passing     springs whose ends pass through each other
    late        sources that begin after its end
    limited     controllers that are at their limit
    pulling     contacts that pull, and tell it to the model alone
    untouched   contacts that do not come near
    sparse      rows that do not show a motion
    still       nothing moves, where nothing else is told
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from typing import Final, TypeAlias

from planarc.core.diagnostic import Diagnostic
from planarc.insight.accounts import judge_accounts, own_accounts
from planarc.insight.late import judge_late, timed_sources
from planarc.insight.limited import judge_limited, limited_blocks
from planarc.insight.losses import judge_losses
from planarc.insight.passing import declared_lines, judge_passing
from planarc.insight.pulling import judge_pulling, telling_joints
from planarc.insight.reactions import judge_reactions, torque_balances
from planarc.insight.runaway import judge_runaway
from planarc.insight.sparse import judge_sparse
from planarc.insight.still import judge_still
from planarc.insight.untouched import gaps_of_contacts, judge_untouched
from planarc.ir.once import once
from planarc.ir.program import Program
from planarc.ir.result import Result

Verdict: TypeAlias = Callable[[Result], Iterator[Diagnostic]]
#: The parts of a program that a verdict is about: most models have none of them.
Concerned: TypeAlias = Callable[[Program], Collection[object]]

#: Verdicts on parts, those before and those behind that on speeds.
_BEFORE: Final[tuple[tuple[Concerned, Verdict], ...]] = (
    (torque_balances, judge_reactions),
    (own_accounts, judge_accounts),
)
_BEHIND: Final[tuple[tuple[Concerned, Verdict], ...]] = (
    (declared_lines, judge_passing),
    (timed_sources, judge_late),
    (limited_blocks, judge_limited),
    (telling_joints, judge_pulling),
    (gaps_of_contacts, judge_untouched),
)


def judge(result: Result, tolerance: float) -> list[Diagnostic]:
    before, behind = _on_parts(result.program)
    lost, grown = judge_losses(result, tolerance), judge_runaway(result)
    found = [] if lost is None else [lost]
    for verdict in before:
        found += verdict(result)
    found += [] if grown is None else [grown]
    for verdict in behind:
        found += verdict(result)
    found += judge_sparse(result)
    if not found:
        found += judge_still(result)
    return found


@once
def _on_parts(program: Program) -> tuple[tuple[Verdict, ...], tuple[Verdict, ...]]:
    """The verdicts on parts that a program has."""
    before, behind = (
        tuple(verdict for parts, verdict in verdicts if parts(program))
        for verdicts in (_BEFORE, _BEHIND)
    )
    return before, behind
