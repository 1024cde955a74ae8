"""The numbers of a native kernel: who is a state, and what each block is solved for."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import pytest

import planarc
from planarc.ir.frame import Record

pytest.importorskip("llvmlite")

FOUR_BAR = Path(__file__).parents[4] / "examples" / "four_bar.pmo"


def test_what_is_no_state_is_solved_for() -> None:
    from planarc.solve.kernels.native.layout import find_layout, numbers_of

    program = planarc.load(FOUR_BAR).compiled().program
    placed = find_layout(program).place
    n = program.state_count
    positions = next(b for b in program.blocks if b.height > 1 and b.residuals)
    speeds = next(b for b in program.blocks if b.height == 1 and b.residuals)
    for chosen in combinations(range(len(positions.tears)), positions.free):
        blocks = (positions, speeds)
        selection = tuple(sorted(b.first + i for b in blocks for i in chosen))
        numbers = numbers_of(program, placed, selection)
        states = [program.candidates[i] for i in selection]
        assert numbers[:n].tolist() == [c.slot for c in states]
        assert numbers[n : 2 * n].tolist() == [c.derivative for c in states]
        for block in blocks:
            at = placed.records[program.blocks.index(block)][Record.SOLVED]
            solved = numbers[at - (placed.numbers - len(numbers)) :][: len(block.residuals)]
            assert solved.tolist() == [i for i in range(len(block.tears)) if i not in chosen]
