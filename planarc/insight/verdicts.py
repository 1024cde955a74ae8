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

from typing import TYPE_CHECKING

from planarc.insight.accounts import judge_accounts
from planarc.insight.late import judge_late
from planarc.insight.limited import judge_limited
from planarc.insight.losses import judge_losses
from planarc.insight.passing import judge_passing
from planarc.insight.pulling import judge_pulling
from planarc.insight.reactions import judge_reactions
from planarc.insight.runaway import judge_runaway
from planarc.insight.sparse import judge_sparse
from planarc.insight.still import judge_still
from planarc.insight.untouched import judge_untouched

if TYPE_CHECKING:
    from planarc.core.diagnostic import Diagnostic
    from planarc.ir.result import Result


def judge(result: Result, tolerance: float) -> list[Diagnostic]:
    lost, grown = judge_losses(result, tolerance), judge_runaway(result)
    found = [] if lost is None else [lost]
    found += judge_reactions(result)
    found += judge_accounts(result)
    found += [] if grown is None else [grown]
    found += judge_passing(result)
    found += judge_late(result)
    found += judge_limited(result)
    found += judge_pulling(result)
    found += judge_untouched(result)
    found += judge_sparse(result)
    if not found:
        found += judge_still(result)
    return found
