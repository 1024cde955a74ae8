"""The statement lists of a program, and the slots of all that they compute.

In:   SortedDae
Out:  `Sections`

What parameters alone make is computed once, in `parameters`: whole steps of the
model (a rod's half length), and parts of formulas (`$p1 := m*g`). Start values are
computed there too, each in a slot of its own that a user may overwrite before the
start. What only results need is in `rest`. Zero functions of relations repeat the
few steps of `rest` that they need; blocks that they need are solved with the levels.

Needs:     see `pipeline`.
Promises:  every symbol that a statement reads has a slot, or is a temporary that the
           same list set before.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeAlias

from planarc.codegen.aliases import Aliases
from planarc.codegen.blocks import BlockWriter, Modes
from planarc.codegen.derive import Derived, Deriver
from planarc.codegen.factoring import shorten_levels
from planarc.codegen.layout import Layout
from planarc.codegen.reach import Reach, is_constant, needed_steps, split_steps, values
from planarc.codegen.statements import Lister, Temporaries, name_parts
from planarc.core.data import Data
from planarc.ir.dae import INITIAL, TERMINAL, Equation
from planarc.ir.expr import Expr, Op, symbols
from planarc.ir.program import BlockCode, Let, Statement
from planarc.ir.sorted import Assignment, Block, SortedDae, Step, computed

#: A symbol, its value, and the number of the equation that says so.
_Given: TypeAlias = "tuple[Expr, Expr, int | None]"


class Sections(Data):
    layout: Layout
    aliases: Aliases
    homes: dict[str, Expr]  # of each alias: the symbol that holds it, or its negative, or time
    constant_slots: frozenset[int]
    blocks: tuple[BlockCode, ...]
    parameters: tuple[Statement, ...]
    levels: tuple[tuple[Statement, ...], ...]
    rest: tuple[Statement, ...]
    initial: tuple[Statement, ...]
    initial_residuals: tuple[Expr, ...]
    roots: tuple[Statement, ...]
    zeros: tuple[Expr, ...]
    discrete: tuple[Statement, ...]
    origins: tuple[Equation, ...]  # of formulas that stay the same: numbered behind the sorted ones


def write_sections(sorted: SortedDae) -> Sections:
    return _Writer(sorted).write()


class _Writer:
    def __init__(self, sorted: SortedDae) -> None:
        self._sorted = sorted
        self._dae = sorted.dae
        self._table = sorted.dae.table
        self._aliases = Aliases(sorted.dae, sorted.aliases)
        self._temporaries = Temporaries(self._table)
        self._layout = Layout()
        self._origins: list[Equation] = []
        self._parts: dict[Expr, Expr] = {}  # formulas of parameters alone -> their symbols
        self._short = shorten_levels(self._table, sorted.levels)

    def write(self) -> Sections:
        sorted, layout = self._sorted, self._layout
        zeros = [self._aliases(r.zero) for r in self._dae.relations]
        initial = [self._aliases(r.value) for r in sorted.initial_residuals]
        discrete = [(a.target, self._aliases(a.value), a.equation) for a in sorted.discrete]
        reach = self._reach(zeros)
        names = {p.name for p in self._dae.parameters}
        names.update(a.target.name for a in reach.constant if a.target.order == 0)
        homes, fixed_lets, moving_lets = self._home_aliases(names)
        levels, rest = self._derive(reach)
        steps = [s for steps in (*levels, rest) for s in steps]
        self._blocks = BlockWriter(self._table, layout, self._temporaries, Modes(self._dae, steps))
        moving = [f for s in steps for f in _formulas(s)]
        moving += [*zeros, *initial, *(v for _, v, _ in discrete), *(v for _, v in moving_lets)]
        self._parts = name_parts(self._table, moving, names)

        parameters = self._parameters(reach, fixed_lets)
        constant_slots = frozenset(layout.slots.values()) - {0}
        layout.add(*(c.symbol for c in sorted.candidates))
        for step in (*(s for steps in reach.levels for s in steps), *reach.rest):
            layout.add(*computed(step))
        layout.add(*(symbol for symbol, _ in moving_lets))
        self._add_discretes()

        level_lists = self._levels(levels)
        rest_list = self._section(rest, moving_lets)
        initial_list, initial_residuals = self._values([], initial)
        root_steps = needed_steps(reach.rest, symbols(*zeros))
        root_list, zero_symbols = self._values(root_steps, zeros)
        lister = self._lister([v for _, v, _ in discrete])
        discrete_list: list[Let] = []
        for target, value, equation in discrete:
            lister.let(discrete_list, target, value, equation)
        return Sections(
            layout=layout,
            aliases=self._aliases,
            homes=homes,
            constant_slots=constant_slots,
            blocks=tuple(self._blocks.blocks),
            parameters=parameters,
            levels=level_lists,
            rest=rest_list,
            initial=initial_list,
            initial_residuals=initial_residuals,
            roots=root_list,
            zeros=zero_symbols,
            discrete=tuple(discrete_list),
            origins=tuple(self._origins),
        )

    # What is computed where

    def _reach(self, zeros: Sequence[Expr]) -> Reach:
        """The split of the steps; blocks that zero functions need go with the levels."""
        candidates = [c.symbol for c in self._sorted.candidates]
        wanted = [*candidates, *map(self._table.der, candidates)]
        names = [p.name for p in self._dae.parameters]
        reach = split_steps(self._short, names, wanted)
        needed = needed_steps(reach.rest, symbols(*zeros))
        blocks = [s for s in needed if isinstance(s, Block)]
        if not blocks:
            return reach
        wanted += [symbol for block in blocks for symbol in block.tears]
        return split_steps(self._short, names, wanted)

    def _derive(
        self, reach: Reach
    ) -> tuple[list[list[Derived | Assignment]], list[Derived | Assignment]]:
        deriver = Deriver(self._sorted, reach)
        heights = [level.height for level in self._sorted.levels]
        levels = [deriver.derive(s, h) for s, h in zip(reach.levels, heights, strict=True)]
        return levels, deriver.derive(reach.rest, 0)

    def _home_aliases(
        self, names: set[str]
    ) -> tuple[dict[str, Expr], list[_Given], list[tuple[Expr, Expr]]]:
        """The place at which each alias is read; formulas get one home each, fixed or moving."""
        homes: dict[str, Expr] = {}
        by_formula: dict[Expr, Expr] = {}
        fixed: list[_Given] = []
        moving: list[tuple[Expr, Expr]] = []
        for alias in self._sorted.aliases:
            symbol = self._table.symbol(alias.name)
            e = self._aliases.target(symbol)
            bare = e.args[0] if e.op is Op.NEG else e
            if bare.op in (Op.SYMBOL, Op.TIME):
                homes[alias.name] = e
                continue
            if e not in by_formula:
                by_formula[e] = symbol
                if is_constant(e, names):
                    fixed.append((symbol, e, self._origin(alias.equation)))
                else:
                    moving.append((symbol, e))
            homes[alias.name] = by_formula[e]
        return homes, fixed, moving

    def _origin(self, equation: int | None) -> int | None:
        """The number of the equation that has made a variable constant."""
        if equation is None:
            return None
        self._origins.append(self._dae.equations[equation])
        return len(self._sorted.equations) + len(self._origins) - 1

    # Lists

    def _parameters(self, reach: Reach, aliases: Sequence[_Given]) -> tuple[Statement, ...]:
        """Dependent parameters, constant unknowns, parts of formulas, start values."""
        table, layout = self._table, self._layout
        lets: list[_Given] = []
        for p in self._dae.parameters:
            layout.add(p.name)
            if not p.settable:
                lets.append((table.symbol(p.name), p.value, None))
        lets.extend((a.target, a.value, a.equation) for a in reach.constant)
        lets.extend(aliases)
        lets.extend((symbol, value, None) for value, symbol in self._parts.items())
        starts = _start_values(self._sorted, self._aliases)
        lets.extend((symbol, value, None) for symbol, value in starts)
        layout.add(*(target for target, _, _ in lets))
        lister = Lister(table, self._temporaries, [v for _, v, _ in lets])
        out: list[Let] = []
        for target, value, equation in lets:
            lister.let(out, target, value, equation)
        return tuple(out)

    def _add_discretes(self) -> None:
        dae, layout = self._dae, self._layout
        layout.add(*(v.name for v in dae.inputs))
        for d in dae.discretes:
            layout.add(d.name, f"pre({d.name})")
        layout.add(INITIAL, TERMINAL)
        layout.add(*(f"$sample[{i}]" for i in range(len(dae.samplers))))
        layout.add(*(f"event[{i}]" for i in range(len(dae.relations))))

    def _lister(self, formulas: Iterable[Expr]) -> Lister:
        return Lister(self._table, self._temporaries, formulas, self._parts)

    def _levels(
        self, levels: list[list[Derived | Assignment]]
    ) -> tuple[tuple[Statement, ...], ...]:
        """The section that all levels make: a value of the first is known in the last."""
        lister = self._lister(f for steps in levels for s in steps for f in _formulas(s))
        found = []
        for steps in levels:
            out: list[Statement] = []
            for step in steps:
                self._step(out, lister, step)
            found.append(tuple(out))
        return tuple(found)

    def _section(
        self, steps: list[Derived | Assignment], lets: Sequence[tuple[Expr, Expr]]
    ) -> tuple[Statement, ...]:
        formulas = [f for s in steps for f in _formulas(s)] + [value for _, value in lets]
        lister = self._lister(formulas)
        out: list[Statement] = []
        for step in steps:
            self._step(out, lister, step)
        written: list[Let] = []
        for symbol, value in lets:
            lister.let(written, symbol, value)
        return (*out, *written)

    def _values(
        self, steps: Iterable[Step], formulas: Sequence[Expr]
    ) -> tuple[tuple[Statement, ...], tuple[Expr, ...]]:
        """A section that gives values: each as a symbol that the section or a slot holds."""
        assignments = [s for s in steps if isinstance(s, Assignment)]
        lister = self._lister([*(f for s in assignments for f in values(s)), *formulas])
        out = lister.assigned(assignments)
        names = []
        for formula in formulas:
            names.append(self._temporaries.new())
            out.append(Let(names[-1], lister.value(out, formula)))
        return tuple(out), tuple(names)

    def _step(self, out: list[Statement], lister: Lister, step: Derived | Assignment) -> None:
        if isinstance(step, Assignment):
            out.extend(lister.assigned((step,)))
        else:
            self._blocks.write(out, lister, step)


def _formulas(step: Derived | Assignment) -> Sequence[Expr]:
    return (step.value,) if isinstance(step, Assignment) else step.formulas


def _start_values(sorted: SortedDae, aliases: Aliases) -> list[tuple[Expr, Expr]]:
    """`start(rev.phi)`, `nominal(rev.phi)` with their formulas of parameters: of candidates, held
    variables, unknowns of blocks at the top, and discrete values."""
    table = sorted.dae.table
    zero = table.zero
    found: dict[str, Expr] = {}
    for c in sorted.candidates:
        found[f"start({c.symbol})"] = c.start or zero
    for f in sorted.fixed:
        found.setdefault(f"start({f.symbol})", f.start)
    for symbol, start in sorted.guesses:
        found.setdefault(f"start({symbol})", start)
    for step in sorted.levels[-1].steps if sorted.levels else ():
        for tear in step.tears:
            found.setdefault(f"start({tear})", zero)
    for d in (*sorted.dae.discretes, *sorted.dae.inputs):
        found[f"start({d.name})"] = d.start or zero
    for c in sorted.candidates:
        if c.nominal is not None:
            found[f"nominal({c.symbol})"] = c.nominal
    return [(table.symbol(name), aliases(e)) for name, e in found.items()]
