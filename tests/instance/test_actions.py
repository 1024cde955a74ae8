"""What clauses of a model do at events, as far as an export writes it."""

from __future__ import annotations

from planarc.compiler import compile_model
from planarc.instance.actions import endings
from planarc.instance.clauses import ordered_discretes
from planarc.ir.dae import SetDiscrete
from planarc.request.request import Request
from tests.export.fmus import EXAMPLES


def test_variables_that_only_keep_their_left_limits_come_first_and_end_no_run() -> None:
    program = compile_model(Request(EXAMPLES / "ratchet_and_pawl.pmo")).program
    discretes, count = ordered_discretes(program)
    assert sorted(discretes, key=program.discretes.index) == list(program.discretes)
    kept = {d.name for d in discretes[:count]}
    assert len(kept) == 14 and all(".rigid." in name for name in kept)
    set_anew = {a.name for a in endings(program) if isinstance(a, SetDiscrete)}
    assert set_anew == {"pushes.count", "pushes.begin"}
