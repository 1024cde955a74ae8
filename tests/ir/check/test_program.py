"""The checker of programs finds what is broken."""

from __future__ import annotations

from pathlib import Path

import pytest
from msgspec.structs import replace

import planarc
from planarc.ir.program import Let
from tests.ir.check.program import BrokenProgramError, check

FOUR_BAR = Path(__file__).parents[3] / "examples" / "four_bar.pmo"


def test_checker_sees_what_is_broken() -> None:
    program = planarc.load(FOUR_BAR).compiled().program
    check(program)
    missing = dict(program.slots)
    del missing[program.candidates[0].name]
    twice = (*program.levels[:-1], (*program.levels[-1], *program.levels[-1]))
    for broken in (
        replace(program, slots=missing),
        replace(program, levels=twice),
        replace(program, rest=(Let(program.table.symbol("$t999"), program.table.symbol("?")),)),
        replace(program, blocks=(*program.blocks[:1], replace(program.blocks[1], first=0))),
    ):
        with pytest.raises(BrokenProgramError):
            check(broken)
