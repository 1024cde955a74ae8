"""The stage `structure`: a scalar model is reduced to index 1 and sorted.

Dae -> eliminate_aliases -> uncover_constraints -> check_regular -> reduce_index -> expand_equations
    -> sort_level (each level below the top) -> sort_top -> SortedDae
"""

from __future__ import annotations

from collections.abc import Sequence

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.ir.dae import Dae, expressions_in
from planarc.ir.expr import Expr, symbols
from planarc.ir.flat import StateSelect
from planarc.ir.sorted import Candidate, Level, SortedDae, SourceEquation, Step
from planarc.structure.algebra import Algebra
from planarc.structure.alias import Elimination, eliminate_aliases, orders_needed
from planarc.structure.attributes import hold_states, merge_attributes
from planarc.structure.discrete import sort_discrete
from planarc.structure.expand import derivatives_of_inputs, expand_equations
from planarc.structure.hidden import uncover_constraints
from planarc.structure.initial import guess_tears, held_variables, initial_residuals
from planarc.structure.linear import Contents
from planarc.structure.numbers import ParameterNumbers
from planarc.structure.pantelides import Offsets, reduce_index
from planarc.structure.regular import check_regular
from planarc.structure.rewrite import expressions_of_rest, find_resets, rewrite_rest
from planarc.structure.signs import Signs
from planarc.structure.states import (
    check_always,
    derivatives_of_tears,
    describe_candidates,
    sort_level,
)
from planarc.structure.system import Systems
from planarc.structure.top import sort_top
from planarc.structure.unread import without_unread

#: What is to be a candidate for states, though equations must be differentiated for it.
CANDIDATES = (StateSelect.ALWAYS, StateSelect.PREFER)


class Reduced(Data):
    """A model after alias elimination, by numbers."""

    elimination: Elimination
    contents: Contents
    rows: list[list[tuple[int, int]]]  # unknowns of each equation, with their highest orders

    @property
    def unknowns(self) -> list[list[int]]:
        return [[v for v, _ in row] for row in self.rows]

    def offsets(self, dae: Dae, held: Sequence[Expr] = ()) -> Offsets:
        """The differentiations that index reduction asks for; `held` are symbols of states."""
        others = (self.elimination.rewrite(e) for e in expressions_of_rest(dae))
        least = orders_needed(self.elimination, self.contents, (*others, *held))
        return reduce_index(self.rows, [least[name] for name in self.elimination.kept])

    def solved_otherwise(self, offsets: Offsets) -> bool:
        """Whether an equation whose derivatives are given is solved for another unknown than the
        one that it gives its value: its derivatives do not hold it."""
        variable = offsets.matching.variable
        return any(
            entry.rates and self.elimination.kept[variable[e]] not in _names(entry.left)
            for e, entry in enumerate(self.elimination.live)
        )

    def without_rates(self) -> Reduced:
        """The same, where values are differentiated as they are."""
        live = tuple(replace(entry, rates=()) for entry in self.elimination.live)
        return _reduced(replace(self.elimination, live=live), self.contents)


def _names(e: Expr) -> set[str]:
    return {s.name for s in symbols(e)}


def reduce_aliases(dae: Dae, signs: Signs) -> Reduced:
    elimination = eliminate_aliases(dae, signs)
    number = {name: i for i, name in enumerate(elimination.kept)}
    contents = Contents(number.__contains__)
    live = uncover_constraints(dae.table, contents, elimination.live)
    return _reduced(replace(elimination, live=tuple(live)), contents)


def _reduced(elimination: Elimination, contents: Contents) -> Reduced:
    number = {name: i for i, name in enumerate(elimination.kept)}
    rows = []
    for e in elimination.live:
        highest: dict[int, int] = {}
        for s in contents.ordered(e.residual):
            name, order = s.data
            highest[number[name]] = max(highest.get(number[name], 0), order)
        # A derivative that is given holds its unknowns as they are, though it is one.
        for times, rate in enumerate(e.rates, start=1):
            for s in contents.ordered(rate):
                name, order = s.data
                v = number[name]
                highest[v] = max(highest.get(v, order - times), order - times)
        rows.append(list(highest.items()))
    return Reduced(elimination, contents, rows)


def structure(dae: Dae) -> SortedDae:
    """The model reduced to index 1 and sorted. Raises PlanarcError (codes S3xx) when the model has
    no solution by its structure."""
    table = dae.table
    signs = Signs(dae.parameters)
    reduced = reduce_aliases(dae, signs)
    elimination, contents = reduced.elimination, reduced.contents
    check_regular(dae, elimination, reduced.unknowns)
    rest = rewrite_rest(dae, elimination.rewrite)
    resets = find_resets(dae, elimination.rewrite)
    attributes = merge_attributes(dae, elimination, ParameterNumbers(dae))
    attributes = hold_states(dae, attributes, resets.symbols)

    held = [table.der(s) for s, a in attributes.items() if a.select in CANDIDATES]
    offsets = reduced.offsets(dae, held)
    if reduced.solved_otherwise(offsets):
        reduced = reduced.without_rates()
        elimination, offsets = reduced.elimination, reduced.offsets(dae, held)
    expansion = expand_equations(dae, elimination.live, offsets)
    rates = derivatives_of_inputs(dae, expansion, expressions_of_rest(rest))
    systems = Systems(
        table,
        contents,
        signs,
        expansion,
        offsets,
        elimination.kept,
        offsets.active(reduced.rows),
        Algebra(table, contents, signs),
    )

    levels: list[Level] = []
    candidates: list[Candidate] = []
    favoured: frozenset[Expr] = frozenset()
    steps: tuple[Step, ...] = ()
    for height in systems.heights:
        system = systems.at(height)
        if height:
            steps = sort_level(systems, system, attributes, favoured)
            check_always(steps, attributes, expansion.equations, resets, dae)
            candidates.extend(describe_candidates(dae, steps, attributes))
            favoured = derivatives_of_tears(table, steps)
        else:
            steps = sort_top(systems, system, offsets.matching, favoured)
        levels.append(Level(height, steps))
    if any(entry.rates for entry in elimination.live):
        wanted = _read_elsewhere(rest, elimination, candidates)
        levels = list(without_unread(levels, expansion.equations, wanted))

    first_initial = len(expansion.equations)
    first_discrete = first_initial + len(dae.initial_equations)
    return SortedDae(
        dae=replace(rest, inputs=(*rest.inputs, *rates)) if rates else rest,
        equations=(
            *expansion.equations,
            *(SourceEquation(e) for e in dae.initial_equations),
            *(SourceEquation(e) for e in dae.discrete_equations),
        ),
        aliases=elimination.aliases,
        levels=tuple(levels),
        candidates=tuple(candidates),
        fixed=held_variables(table, attributes, candidates, levels),
        guesses=guess_tears(steps, attributes),
        initial_residuals=initial_residuals(dae, elimination.rewrite, first_initial),
        discrete=sort_discrete(dae, elimination.rewrite, signs, first_discrete),
        equations_before=len(dae.equations),
        equations_after=len(elimination.live),
    )


def _read_elsewhere(
    rest: Dae, elimination: Elimination, candidates: Sequence[Candidate]
) -> frozenset[Expr]:
    """What is read beside the steps of the levels."""
    states = [c.symbol for c in candidates]
    others = (*expressions_of_rest(rest), *(a.target for a in elimination.aliases))
    told = (*(d.value for d in rest.declared), *(a for v in rest.visuals for _, a in v.attributes))
    shown = (elimination.rewrite(e) for value in told for e in expressions_in(value))
    return frozenset((*states, *map(rest.table.der, states), *symbols(*others, *shown)))
