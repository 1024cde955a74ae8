"""The crowds of a model: its ports and bodies, and what they read.

    px_feel(block, t, out)    values that stand in no slot

and the table `px_touches`, as of `instance.crowd.layout`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import accumulate

from planarc.codegen.native.assembly import POINTER, REAL, SELDOM, Code, table
from planarc.codegen.native.carried import Carrier
from planarc.codegen.native.formulas import formula, real
from planarc.instance.actions import carry_values, endings
from planarc.instance.clauses import reader
from planarc.instance.crowd.layout import Count, Of, Part
from planarc.ir.expr import Expr
from planarc.ir.frame import Frame
from planarc.ir.once import once
from planarc.ir.program import Program
from planarc.solve.states.selector import open_blocks
from planarc.solve.stepping.ports import Sites, colour, columns_of
from planarc.solve.stepping.refusal import body

#: Impulses that are remembered, one member, and besides: what presses on circles that do not
#: overlap are three contacts each, on bars some more.
_ROOM, _MORE = 8, 32


class Crowds:
    """What is told of them; `selection` are the states where they never change."""

    def __init__(self, program: Program, selection: Sequence[int]) -> None:
        self._program, self._sites = program, Sites(program)
        self._others: dict[Expr, int] = {}
        self.members = [i for m in self._sites.crowds().values() for i in m]
        candidates = program.candidates
        chosen = range(len(candidates)) if open_blocks(program) else selection
        rates = self._sites.states_feel(c.derivative for c in candidates)
        felt = (*self._sites.felt, *(rates[i] for i in chosen))
        self._parts = self._numbers(colour(felt, self._sites.count), rates)
        self.others = list(self._others)

    def table(self) -> list[int]:
        sites, parts = self._sites, self._parts
        head = len(Count) + len(Part) + 1
        starts = accumulate(map(len, (parts[p] for p in Part)), initial=head)
        counts = {
            Count.SENSED: len(self.others),
            Count.TOUCHES: len(sites.touched.all),
            Count.PORTS: sites.count,
            Count.MEMBERS: len(self.members),
            Count.CROWDS: len(sites.crowds()),
            Count.COLOURS: max(parts[Part.COLOUR], default=-1) + 1,
            Count.ROOM: _ROOM * len(self.members) + len(sites.touched.all) + _MORE,
            Count.JAM: len(endings(self._program)) + 1,
        }
        return [*(counts[k] for k in Count), *starts, *(n for p in Part for n in parts[p])]

    def names(self) -> list[str]:
        """What the members are called."""
        return [body(self._sites.members[i].read["x"]) for i in self.members]

    def _numbers(self, colours: list[int], rates: list[int]) -> dict[Part, list[int]]:
        sites = self._sites
        touched, crowds = sites.touched.all, sites.crowds().values()
        squares = (len(touched), *(2 * len(m) ** 2 for m in crowds))
        read = [sites.members[i].read for i in self.members]
        before = {d.slot: d.pre for d in self._program.discretes}
        starts, felt = _rows(sites.felt)
        state_starts, state_felt = _rows(rates)
        return {
            Part.RATES: self._values(sites.rates),
            Part.ACCELERATIONS: self._values(sites.accelerations),
            Part.PUSHES: sites.pushes,
            Part.BEFORE: sites.before,
            Part.STILL: [int(group < 0) for group in sites.groups.tolist()],
            Part.COLOUR: colours,
            Part.FELT_STARTS: starts,
            Part.FELT: felt,
            Part.STATE_STARTS: state_starts,
            Part.STATE_FELT: state_felt,
            Part.OF_TOUCHES: self._values(t.read[n] for n in ("gap", "e", "mu") for t in touched),
            Part.LOWS: [s for t in touched for s in (t.slots["low"], before[t.slots["low"]])],
            Part.FIRST_MEMBERS: [*accumulate(map(len, crowds), initial=0)],
            Part.FIRST_KEYS: [*accumulate(squares)],
            Part.MEMBERS: self._values(r[w.name.lower()] for w in Of for r in read),
            Part.PORT: [sites.members[i].port for i in self.members],
        }

    def _values(self, expressions: Iterable[Expr]) -> list[int]:
        """Slots, or places among the others behind them."""
        program, found = self._program, []
        for e in expressions:
            slot = None if e.is_const else program.slots.get(repr(e))
            if slot is None:
                slot = program.size + self._others.setdefault(e, len(self._others))
            found.append(slot)
        return found


def _rows(rows: Sequence[int]) -> tuple[list[int], list[int]]:
    """Where each row begins, and its columns."""
    columns = [list(columns_of(bits)) for bits in rows]
    return [*accumulate(map(len, columns), initial=0)], [j for c in columns for j in c]


@once
def crowds_of(program: Program) -> Crowds:
    """Those of a run, which begins with the first candidates as states."""
    states = (code.first + i for code in program.blocks if code.height for i in range(code.free))
    return Crowds(program, tuple(states))


def table_functions(
    program: Program, crowds: Crowds, carrier: Carrier | None = None
) -> tuple[str, list[int]]:
    """The function, by a `carrier` carried out, and the table: as text, and as numbers."""
    numbers = crowds.table()
    c = Code("px_feel", "void", ((POINTER, "m"), (REAL, "t"), (POINTER, "out")))
    m, t, out = c.arguments
    if not carry_values(program, crowds.others, carrier, c, out):
        leaf = reader(program, m.load(POINTER, Frame.W), t)
        for i, e in enumerate(crowds.others):
            out.store(real(c, formula(c, e, leaf)), i)
    c.give()
    return c.text(SELDOM) + table("px_touches", numbers), numbers
