"""Where contacts push, and what forces there do to everything else.

In:   Program, Kernel
Out:  Sites      touches (`impact`) have two ports each, along normal and slip, bodies of crowds
                 three: x, y, and the angle. Of each: its velocity, and its push in the workspace
      Ports      the same in a run
      Response   how the accelerations of ports and states answer to forces at ports

The equations are linear in the pushes, so that differences of evaluations are exact: the same
matrices J*M^-1*J' and M^-1*J' that impacts at events take, for open chains and closed loops.
Ports that nothing feels together are pushed together: a hundred free bodies take three
evaluations, not three hundred.

Example: two free bodies on a frictionless plane: ports x1 y1 phi1 x2 y2 phi2 have the colours
0 1 2 0 1 2, and V is diag(1/m1, 1/m1, 1/I1, 1/m2, 1/m2, 1/I2).

Reference: A. R. Curtis, M. J. D. Powell, J. K. Reid, IMA J. Appl. Math. 13(1), 1974, 117-119.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, cast

import numpy as np

from planarc.core.arrays import taken
from planarc.core.data import Data
from planarc.core.source import Span
from planarc.ir.dae import Impact
from planarc.ir.expr import Expr, symbols
from planarc.ir.impact import CROWD_KEPT, CROWD_NAMES
from planarc.ir.kernel import Kernel
from planarc.ir.program import Let, Program, Statement
from planarc.solve.contact.touches import Points, Touches
from planarc.solve.messages.text import Reader

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from planarc.core.arrays import Array, Vector


class Member(Data):
    """One `crowd(...)`: the expressions that it reads, the first of its three ports."""

    crowd: str
    span: Span
    read: dict[str, Expr]
    port: int


class Response(Data):
    """dv/dt = velocity @ f at the ports and dy/dt = states @ f, for forces f at the ports."""

    velocity: csr_array
    states: csr_array


class Column:
    """The values of expressions, as an array: slots at once, the others one by one."""

    def __init__(self, program: Program, expressions: Sequence[Expr], read: Reader) -> None:
        places = [program.slots.get(repr(e)) for e in expressions]
        self._at = np.array([i for i, p in enumerate(places) if p is not None], dtype=np.int64)
        self._slots = np.array([p for p in places if p is not None], dtype=np.int64)
        self._base = np.zeros(len(places))
        self._others: list[tuple[int, Expr]] = []
        self._read = read
        for i, e in enumerate(expressions):
            if e.is_const:
                self._base[i] = float(read(e))
            elif places[i] is None:
                self._others.append((i, e))

    def __call__(self, w: Sequence[float]) -> Vector:
        found = self._base.copy()
        found[self._at] = taken(w, self._slots)
        for i, e in self._others:
            found[i] = float(self._read(e))
        return found


class Sites:
    """All ports of a model: those of touches first, two each, then those of bodies, three each."""

    def __init__(self, program: Program) -> None:
        self.program, self.touched = program, Points(program)
        touches, own = self.touched.all, 2 * len(self.touched.all)
        pushes = [t.slots[f"push_{way}"] for t in touches for way in "nt"]
        found: dict[tuple[int, ...], int] = {}  # the pushes of a body -> its first port
        rates = [t.read[name] for t in touches for name in ("v", "slip")]
        accelerations = [t.read[name] for t in touches for name in ("a", "a_slip")]
        members: list[Member] = []
        for action in _crowds(program):
            read = dict(zip(CROWD_NAMES, action.arguments, strict=True))
            slots = tuple(program.slots[repr(read[name])] for name in CROWD_KEPT)
            if slots not in found:
                found[slots] = own + 3 * len(found)
                pushes += slots
                rates += [read[name] for name in ("v_x", "v_y", "w")]
                accelerations += [read[name] for name in ("a_x", "a_y", "z")]
            members.append(Member(action.component, action.span, read, found[slots]))
        self.members, self.count = tuple(members), len(pushes)
        self.pushes, self.rates, self.accelerations = pushes, rates, accelerations
        before = {d.slot: d.pre for d in program.discretes}
        self.before = [before[slot] for slot in pushes]
        self._felt = _felt(program, pushes)
        #: By port, the pushes that its acceleration depends on, as bits.
        self.felt = [self._feels(e) for e in accelerations]
        self.groups = self._find_groups()

    def crowds(self) -> dict[str, list[int]]:
        """The members of each crowd."""
        found: dict[str, list[int]] = {}
        for i, member in enumerate(self.members):
            found.setdefault(member.crowd, []).append(i)
        return found

    def states_feel(self, slots: Iterable[int]) -> list[int]:
        """The pushes that values depend on, by their slots, as bits."""
        by_slot = {self.program.slots.get(repr(e)): bits for e, bits in self._felt.items()}
        return [by_slot.get(slot, 0) for slot in slots]

    def _feels(self, e: Expr) -> int:
        bits = 0
        for symbol in symbols(e):
            bits |= self._felt.get(symbol, 0)
        return bits

    def _find_groups(self) -> Array:
        """Ports that move each other have one number; what moves nothing has -1."""
        group = list(range(self.count))

        def root(i: int) -> int:
            while group[i] != i:
                group[i] = i = group[group[i]]
            return i

        for row, bits in enumerate(self.felt):
            for port in columns_of(bits):
                group[root(port)] = root(row)
        still = [bits == 0 for bits in self.felt]
        return np.array([-1 if still[i] else root(i) for i in range(self.count)], dtype=np.int64)


class Ports(Sites):
    """The ports of a run."""

    def __init__(self, program: Program, kernel: Kernel) -> None:
        super().__init__(program)
        self.kernel = kernel
        self.touches = Touches(program, kernel)
        self.read = Reader(program, kernel, 0.0)
        self._pushes = np.array(self.pushes, dtype=np.int64)
        self._before = np.array(self.before, dtype=np.int64)
        self.velocity = Column(program, self.rates, self.read)
        self._acceleration = Column(program, self.accelerations, self.read)
        self._selection: tuple[int, ...] = ()

    def push(self, forces: Vector) -> None:
        """Set the force at each port, for the rows to show."""
        w = self.kernel.w
        for slots in (self._pushes, self._before):
            if isinstance(w, np.ndarray):
                w[slots] = forces
            else:
                for slot, force in zip(slots.tolist(), forces.tolist(), strict=True):
                    w[slot] = force

    def respond(self, t: float, y: Vector, active: Array) -> Response | None:
        """What forces at the active ports do; no port is pushed before or after it. The workspace
        is filled at `t` and `y`; None where the equations have no solution."""
        self._choose(tuple(self.kernel.selection))
        w = self.kernel.w
        free, rates = self._acceleration(w), taken(w, self._rates)
        velocity, states = np.zeros(len(self._v.rows)), np.zeros(len(self._b.rows))
        for colour in sorted(set(self._colours[active].tolist())):
            self.push(np.where(active & (self._colours == colour), 1.0, 0.0))
            if self.kernel.outputs(t, cast("Sequence[float]", y)) != 0:
                return None
            for entries, pattern, now, before in (
                (velocity, self._v, self._acceleration(w), free),
                (states, self._b, taken(w, self._rates), rates),
            ):
                mine = pattern.by_colour[colour]
                entries[mine] = (now - before)[pattern.rows[mine]]
        self.push(np.zeros(self.count))
        return Response(self._v.matrix(velocity, self.count), self._b.matrix(states, self.count))

    def _choose(self, selection: tuple[int, ...]) -> None:
        """Find the pattern and the colours for a choice of states."""
        if selection == self._selection:
            return
        self._selection = selection
        chosen = [self.program.candidates[i] for i in selection]
        self._rates = np.array([c.derivative for c in chosen], dtype=np.int64)
        states = self.states_feel(self._rates.tolist())
        self._colours = np.array(colour((*self.felt, *states), self.count), dtype=np.int64)
        self._v = _Pattern(self.felt, self._colours)
        self._b = _Pattern(states, self._colours)


def _crowds(program: Program) -> Iterable[Impact]:
    for when in program.whens:
        for _, _, actions in when.branches:
            yield from (a for a in actions if isinstance(a, Impact) and a.crowd)


def _felt(program: Program, pushes: Sequence[int]) -> dict[Expr, int]:
    """By symbol, the pushes that its value depends on, as bits."""
    names = {slot: name for name, slot in program.slots.items()}
    felt = {program.table.symbol(names[slot]): 1 << i for i, slot in enumerate(pushes)}
    for statements in (*program.levels, program.rest):
        for statement in statements:
            targets, read = _flow(program, statement)
            bits = 0
            for symbol in symbols(*read):
                bits |= felt.get(symbol, 0)
            if bits:
                felt.update(dict.fromkeys(targets, bits))
    return felt


def _flow(program: Program, statement: Statement) -> tuple[list[Expr], list[Expr]]:
    """What a statement sets, and the expressions that it reads."""
    if isinstance(statement, Let):
        return [statement.target], [statement.value]
    code = program.blocks[statement.block]
    lets = [*code.body, *code.jacobian_body]
    targets = [*code.tears, *(let.target for let in lets)]
    return targets, [let.value for let in lets] + [*code.residuals]


def columns_of(bits: int) -> Iterable[int]:
    """The places of the bits that are set, as they rise."""
    while bits:
        low = bits & -bits
        yield low.bit_length() - 1
        bits ^= low


class _Pattern:
    """The entries of a sparse matrix, row by row, from the columns of each row as bits."""

    def __init__(self, rows: Sequence[int], colours: Array) -> None:
        columns = [list(columns_of(bits)) for bits in rows]
        counts = [len(c) for c in columns]
        self._columns = np.array([j for c in columns for j in c], dtype=np.int32)
        self._starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
        self.rows = np.repeat(np.arange(len(rows)), counts)
        own = colours[self._columns]
        self.by_colour = [np.flatnonzero(own == c) for c in range(int(colours.max(initial=-1)) + 1)]

    def matrix(self, entries: Vector, columns: int) -> csr_array:
        from scipy.sparse import csr_array

        shape = len(self._starts) - 1, columns
        return csr_array((entries, self._columns, self._starts), shape=shape)


def colour(rows: Sequence[int], count: int) -> list[int]:
    """A colour for each column: those of one colour have no row in common."""
    near = [0] * count
    for bits in set(rows):
        for j in columns_of(bits):
            near[j] |= bits
    colours: list[int] = []
    for j in range(count):
        taken = {colours[i] for i in columns_of(near[j] & ((1 << j) - 1))}
        colours.append(next(c for c in range(len(taken) + 1) if c not in taken))
    return colours
