"""What functions that solve blocks give back, and which blocks have functions of their own."""

from __future__ import annotations

from typing import Final

#: The solution is there, steps are to follow, there is none, a number is none.
DONE, MORE, UNSOLVED, NOT_FINITE = 1, 0, -1, -2
#: Largest number of unknowns that are eliminated in registers.
SMALL: Final = 5
#: Unknowns of blocks that `pc_linear_top` solves: fewer have code of their own (`pair`).
TOP: Final = range(3, SMALL + 1)
