"""Derivatives of a program: the implicit function theorem as a list of small sums.

In:   Program, Scope
Out:  `Slopes`: formulas of coefficients, and the order in which motions are passed on

Every value that the levels compute is a node, and moves when the states move: by d for
each. A formula ties its target's motion to those of what it reads; the residual of a
block ties the motions of its tears, though none of them has a formula; each state moves
as it is told. Passed on in the order of evaluation, with one small linear system a block,
these give all columns of the Jacobian at once, through torn blocks and for any choice of
states.

    x = L*cos(phi)           d(x) = -L*sin(phi)*d(phi)
    residual x*y - a         0 = y*d(x) + x*d(y)
    state phi                d(phi) = 1

Parameters and inputs are leaves as the states are, where all derivatives are asked for;
parameters that are computed from others move by their formulas. So is the time, where it is wished
that it moves by itself.

Coefficients are read at the present point: tears, and all that has a slot, are taken from
the workspace, where the last evaluation has left them. A linear block's residual is its
residual at zero and the product of its matrix with the tears; of one that is solved by
elimination, the residual itself.

Needs:     formulas that can be differentiated; `derive_slopes` gives None where the
           program calls functions that cannot.
Promises:  only nodes are kept that move, and that the derivatives asked for, or tears,
           depend on.
Reference: A. Griewank and A. Walther, Evaluating Derivatives, 2nd ed., SIAM 2008,
           sections 3.1 and 15.3 (extended Jacobian systems).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from functools import cache

from msgspec import Struct

from planarc.codegen.statements import Lister, Temporaries, is_trivial
from planarc.core.data import Data
from planarc.ir.calculus import Partials
from planarc.ir.closing import applied
from planarc.ir.derivatives import Group, Head, Scope
from planarc.ir.expr import Expr, Exprs, below, named, symbols, text
from planarc.ir.program import BlockCode, Let, Program, Solve, Statement


class Row(Data):
    """The target's motion is the sum of (source, slope): as nodes and formula."""

    target: int
    terms: tuple[tuple[int, Expr], ...]


class Run(Data):
    """Rows `first` to `stop`. In a block, tears are solved for so that its residuals do not
    move; those from `inner` on are only for these."""

    first: int
    inner: int
    stop: int
    tears: tuple[int, ...] = ()
    residuals: tuple[int, ...] = ()
    block: int = -1


class Slopes(Data):
    """`body` computes what the coefficients share, without solving or storing anything."""

    nodes: tuple[Expr, ...]
    slots: tuple[int, ...]  # of each node: -1 where it has none
    body: tuple[Let, ...]
    coefficients: tuple[Expr, ...]  # row by row
    rows: tuple[Row, ...]
    runs: tuple[Run, ...]
    #: Nodes of each candidate itself and of its derivative (-1: it does not move).
    candidates: tuple[tuple[int, int], ...]
    wanted: tuple[int, ...]  # slots whose derivatives are asked for

    def named(self, table: Exprs) -> tuple[list[Let], list[Expr], dict[Expr, int]]:
        """Statements, trivial coefficients, and the places of those that statements set: of equal
        formulas a printer may make a loop."""
        lets, taken, places = list(self.body), [], {}
        for i, e in enumerate(self.coefficients):
            if not is_trivial(e):
                lets.append(Let(table.symbol(f"$c{i}"), e))
                e = lets[-1].target
                places[e] = i
            taken.append(e)
        return lets, taken, places

    def tape(self) -> list[int]:
        """The numbers of `planarc.ir.derivatives`."""
        starts = [0]
        for row in self.rows:
            starts.append(starts[-1] + len(row.terms))
        owners = [-1] * len(self.nodes)
        for i, run in enumerate(self.runs):
            if run.residuals:
                own = [*run.tears, *(row.target for row in self.rows[run.first : run.stop])]
                for node in own:
                    owners[node] = i
        lists: list[Sequence[int]] = [
            starts,
            [row.target for row in self.rows],
            [source for row in self.rows for source, _ in row.terms],
            owners,
            self.slots,
        ]
        begins = [len(Head)]
        for part in lists:
            begins.append(begins[-1] + len(part))
        members = begins[-1] + len(Group) * len(self.runs)
        table: list[int] = []
        listed: list[int] = []
        for run in self.runs:
            sizes = len(run.tears), len(run.residuals)
            table += [run.first, run.inner, run.stop, *sizes, members + len(listed), run.block]
            listed += [*run.tears, *run.residuals]
        pairs = [node for pair in self.candidates for node in pair]
        begins.append(members + len(listed))
        head = [
            begins[-1] + len(pairs),
            len(self.nodes),
            len(self.rows),
            starts[-1],
            len(self.runs),
            max((len(run.residuals) for run in self.runs), default=0),
            len(self.candidates),
            *begins,
        ]
        return [*head, *(n for part in lists for n in part), *table, *listed, *pairs]


def derive_slopes(
    program: Program,
    scope: Scope = Scope.RATES,
    wanted: Collection[int] | None = None,
    timed: bool = False,
) -> Slopes | None:
    """`wanted` are the slots of the values asked for, where these are not all of the scope; with
    `timed` the time is a node."""
    return _Deriver(program, scope, wanted, timed).derive()


class _Piece(Struct):
    """Statements of one run, before it is known which of them count."""

    lets: list[Let]
    inner: int
    tears: tuple[Expr, ...] = ()
    residuals: tuple[Expr, ...] = ()
    block: int = -1


class _Deriver:
    def __init__(
        self, program: Program, scope: Scope, wanted: Collection[int] | None, timed: bool
    ) -> None:
        self._program, self._table, self._scope = program, program.table, scope
        self._asked, self._timed = wanted, timed
        self._pieces: list[_Piece] = []
        self._partials = Partials(program.table)
        self._numbers: dict[Expr, int] = {}  # nodes
        self._slot: Callable[[Expr], int] = cache(lambda e: program.slots.get(text(e), -1))

    def derive(self) -> Slopes | None:
        program = self._program
        everything = self._scope is Scope.ALL
        if everything and program.delays and program.parameter_slots:
            return None  # no formula tells how the past moves with parameters
        if everything:
            self._statements(program.parameters)
        for level in program.levels:
            self._statements(level)
        if everything:
            self._statements(program.rest)
        lets = {let.target: let for piece in self._pieces for let in piece.lets}
        self._drop(self._needed())
        rows, runs = self._rows()
        found = [slope for row in rows for _, slope in row.terms]
        body, coefficients = self._listed(lets, found)
        used = below((*coefficients, *(let.value for let in body)))
        if any(wrt for e in used for *_, wrt in applied(e)):
            return None
        slots = tuple(map(self._slot, self._numbers))
        places = {slot: node for node, slot in enumerate(slots)}
        return Slopes(
            tuple(self._numbers),
            slots,
            body,
            coefficients,
            rows,
            runs,
            tuple((places[c.slot], places.get(c.derivative, -1)) for c in program.candidates),
            tuple(self._wanted_slots()),
        )

    # The statements as runs

    def _statements(self, statements: Iterable[Statement]) -> None:
        for s in statements:
            if isinstance(s, Solve):
                code = self._program.blocks[s.block]
                if code.residuals:
                    self._pieces.append(self._block(s.block, code))
                else:  # its tears are states
                    self._plain().tears += code.tears
                    self._plain().lets.extend(code.body)
            else:
                self._plain().lets.append(s)

    def _plain(self) -> _Piece:
        """The piece that statements outside of blocks go to."""
        if not self._pieces or self._pieces[-1].residuals:
            self._pieces.append(_Piece([], 0))
        return self._pieces[-1]

    def _block(self, block: int, code: BlockCode) -> _Piece:
        inner = list(code.body[: code.inner])
        if code.direct is not None:
            names = (f"$rest[{block}][{i}]" for i, _ in enumerate(code.residuals))
            residuals = tuple(map(self._table.symbol, names))
            lets = [*inner, *map(Let, residuals, code.residuals)]
        elif code.linear and code.residuals:
            more, residuals = self._linear(code)
            lets = [*inner, *more]
        else:
            lets, residuals = list(code.body), code.residuals
        return _Piece(lets, len(inner), code.tears, residuals, block)

    def _linear(self, code: BlockCode) -> tuple[list[Let], tuple[Expr, ...]]:
        """The residuals at the tears, from those at zero and the matrix."""
        table, lets = self._table, list[Let]()
        sums = [[r] for r in code.residuals]
        if code.tangent is not None:
            pairs = zip(code.tangent.seeds, code.tears, strict=True)
            lets.extend(Let(seed, tear) for seed, tear in pairs)
            lets.extend(code.tangent.body)
            for i, entry in enumerate(code.tangent.entries):
                sums[i].append(entry)
        for i, j, value in code.jacobian:
            sums[i].append(table.mul(value, code.tears[j]))
        names = tuple(table.symbol(f"$whole({text(r)})") for r in code.residuals)
        lets.extend(Let(n, table.add(*terms)) for n, terms in zip(names, sums, strict=True))
        return lets, names

    # What counts

    def _needed(self) -> set[Expr]:
        """Targets that what is asked for depends on."""
        wanted = {r for piece in self._pieces for r in piece.residuals}
        slots = self._wanted_slots()
        targets = (let.target for piece in self._pieces for let in piece.lets)
        wanted.update(e for e in targets if self._slot(e) in slots)
        for piece in reversed(self._pieces):
            for let in reversed(piece.lets):
                if let.target in wanted:
                    wanted.update(symbols(let.value))
        return wanted

    def _wanted_slots(self) -> Collection[int]:
        rates = dict.fromkeys(c.derivative for c in self._program.candidates)
        if self._asked is not None:
            return rates | dict.fromkeys(self._asked)
        return range(self._program.size) if self._scope is Scope.ALL else rates

    def _drop(self, wanted: set[Expr]) -> None:
        for piece in self._pieces:
            inner = [let for let in piece.lets[: piece.inner] if let.target in wanted]
            others = [let for let in piece.lets[piece.inner :] if let.target in wanted]
            piece.lets, piece.inner = [*inner, *others], len(inner)

    # Rows

    def _rows(self) -> tuple[tuple[Row, ...], tuple[Run, ...]]:
        program, number = self._program, self._numbers
        if self._scope is Scope.ALL:
            settable = [p.name for p in program.parameter_slots if p.settable]
            for name in dict.fromkeys((*settable, *program.inputs)):
                number[named(self._table, name)] = len(number)
        if self._timed:
            number[self._table.time] = len(number)
        rows: list[Row] = []
        runs: list[Run] = []
        for piece in self._pieces:
            tears = tuple(number.setdefault(e, len(number)) for e in piece.tears)
            first = inner = len(rows)
            kept = set(piece.residuals)
            for i, let in enumerate(piece.lets):
                terms = self._terms(let)
                if terms or let.target in kept:
                    node = number.setdefault(let.target, len(number))
                    rows.append(Row(node, terms))
                    inner += i < piece.inner
            residuals = tuple(number[e] for e in piece.residuals)
            runs.append(Run(first, inner, len(rows), tears, residuals, piece.block))
        return tuple(rows), tuple(runs)

    def _terms(self, let: Let) -> tuple[tuple[int, Expr], ...]:
        knowns = sorted(s for s in below((let.value,)) if s in self._numbers)
        slopes = zip(knowns, self._partials.by(let.value, knowns), strict=True)
        return tuple(
            [(self._numbers[s], slope) for s, slope in slopes if slope is not self._table.zero]
        )

    # Coefficients

    def _listed(
        self, lets: dict[Expr, Let], slopes: Sequence[Expr]
    ) -> tuple[tuple[Let, ...], tuple[Expr, ...]]:
        """Shared parts, behind the temporaries that they need."""
        count = sum(1 for e in self._table.symbols() if e.name.startswith("$t"))
        lister = Lister(self._table, Temporaries(self._table, count), slopes)
        own: list[Let] = []
        written = tuple(lister.value(own, e) for e in slopes)
        unstored = {target: let for target, let in lets.items() if self._slot(target) < 0}
        reached = list(dict.fromkeys((*(let.value for let in own), *written)))
        needed = set(reached)
        for e in reached:  # grows on the way
            more = (unstored[e].value,) if e in unstored else e.args
            for a in more:
                if a not in needed:
                    needed.add(a)
                    reached.append(a)
        before = [let for target, let in unstored.items() if target in needed]
        return (*before, *own), written
