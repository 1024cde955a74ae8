"""Loops whose end is known only while the model runs, as one operation on numbers.

Example: `while abs(d) > 1e-9 loop s := s + d; d := d*x; end while;`

    carried  s, d        what turns change        following  s + d, d*x
    given    x           what they only read      condition  1e-9 < abs(d)

A loop takes the first values of what is carried, then what is given. All of what follows is
computed from the values before the turn. It gives the values behind the last turn, and whether it
ended: 1, or 0 where it went on beyond `MOST_TURNS`, or `LOST` where its condition is not a number.
Where it did not end, its values are no numbers.
`closing` makes loops of expressions, and expressions of loops.
"""

from __future__ import annotations

from typing import Any, TypeAlias

from planarc.core.data import Data

MOST_TURNS = 100_000
LOST = -1.0

#: Operation, arguments, data. A constant is written as text: truths, zeros and what is not a
#: number are told apart so.
Node: TypeAlias = "tuple[int, tuple[int, ...], Any]"


class Loop(Data):
    """A loop, by the numbers of its nodes: carried values come first, then given ones, then
    operations in the order in which they are computed. So equal loops are equal, whatever table of
    expressions they came from."""

    name: str  # of the function in which it stands
    carried: int
    given: int
    nodes: tuple[Node, ...]
    condition: int
    following: tuple[int, ...]
    aside: int = 0  # how many of the last carried values serve derivatives: no turn reads them

    def __hash__(self) -> int:
        return hash((self.name, len(self.nodes), self.condition, self.following))

    @property
    def ended(self) -> int:
        """The output that says whether the loop ended."""
        return self.carried
