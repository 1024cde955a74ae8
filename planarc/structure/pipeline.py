"""The stage `structure`: a scalar model is reduced to index 1 and sorted.

Dae -> eliminate_aliases -> uncover_constraints -> check_regular -> reduce_index -> expand_equations
    -> sort_level (each level below the top) -> sort_top -> SortedDae
"""

from __future__ import annotations

from collections.abc import Sequence

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.ir.dae import Dae
from planarc.ir.expr import Expr
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


def reduce_aliases(dae: Dae, signs: Signs) -> Reduced:
    elimination = eliminate_aliases(dae, signs)
    number = {name: i for i, name in enumerate(elimination.kept)}
    contents = Contents(number.__contains__)
    live = uncover_constraints(dae.table, contents, elimination.live)
    elimination = replace(elimination, live=tuple(live))
    rows = []
    for e in elimination.live:
        highest: dict[int, int] = {}
        for s in contents.ordered(e.residual):
            name, order = s.data
            highest[number[name]] = max(highest.get(number[name], 0), order)
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
