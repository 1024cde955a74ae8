"""Steps that the right-hand side runs, that only results need, that never change.

In:   the levels of the sorted model; what the derivatives and the zero functions need
Out:  `Reach`: constant steps, the steps of `levels`, those of `rest`

Example: with the states phi, der(phi) and nothing that asks for `power`

    L2 = L*L             constant
    f  = m*g*sin(phi)    level
    der(der(phi)) = f/L2 level
    power = f*der(phi)   rest

A small linear block is solved from its matrix alone (`blocks`), so its inner unknowns
may be late: those that only results need are computed with the rest.

Needs:     steps stand in the order of evaluation.
Promises:  order is kept; every step is in exactly one of the three parts; a late
           assignment is in `rest` and no longer computed by its block.
"""

from __future__ import annotations

from collections.abc import Iterable

from planarc.core.data import Data
from planarc.ir.expr import Expr, Op, below
from planarc.ir.sorted import Assignment, Block, Level, Step, computed

# Where it counts: an enumeration looks up its members by a function.
_CONST, _SYMBOL = Op.CONST, Op.SYMBOL
#: Number of tears below which a linear block of the top level is solved from its matrix as it
#: is: that is hardly sparse.
FEWEST = 8


class Reach(Data):
    constant: tuple[Assignment, ...]
    levels: tuple[tuple[Step, ...], ...]
    rest: tuple[Step, ...]
    late: frozenset[Expr] = frozenset()


def split_steps(
    levels: Iterable[Level], parameters: Iterable[str], derivatives: Iterable[Expr]
) -> Reach:
    """The steps told apart by what needs them. `derivatives` are the symbols that the right-hand
    side must give."""
    names = set(parameters)
    constant: list[Assignment] = []
    moving: list[list[Step]] = []
    for level in levels:
        moving.append([])
        for step in level.steps:
            if isinstance(step, Assignment) and is_constant(step.value, names):
                constant.append(step)
                if step.target.order == 0:
                    names.add(step.target.name)
            else:
                moving[-1].append(step)
    late: set[Expr] = set()
    kept = _needed(moving, set(derivatives), late)
    rest: list[Step] = []
    for step in (s for steps in moving for s in steps):
        if id(step) not in kept:
            rest.append(step)
        elif isinstance(step, Block):
            rest.extend(a for a in step.inner if a.target in late)
    return Reach(
        tuple(constant),
        tuple(tuple(s for s in steps if id(s) in kept) for steps in moving),
        tuple(rest),
        frozenset(late),
    )


def is_constant(value: Expr, parameters: set[str]) -> bool:
    """Whether parameters alone make the value."""
    return all(
        e.args or e.op is _CONST or (e.op is _SYMBOL and not e.data[1] and e.data[0] in parameters)
        for e in below((value,))
    )


def needed_steps(steps: Iterable[Step], wanted: Iterable[Expr]) -> tuple[Step, ...]:
    """The steps that the wanted symbols need, in their order."""
    steps = tuple(steps)
    kept = _needed([list(steps)], set(wanted), None)
    return tuple(s for s in steps if id(s) in kept)


def values(step: Step) -> tuple[Expr, ...]:
    """The formulas of a step."""
    return (*(a.value for a in step.inner), *(r.value for r in step.residuals))


def _needed(levels: list[list[Step]], wanted: set[Expr], late: set[Expr] | None) -> set[int]:
    """The steps, by identity, that the wanted symbols need; with `late`, also all that
    find states, and the inner unknowns that may come late are added there."""
    kept: set[int] = set()
    for steps in reversed(levels):
        for step in reversed(steps):
            finds_states = late is not None and step.free > 0
            if finds_states or not wanted.isdisjoint(computed(step)):
                kept.add(id(step))
                if late is not None and isinstance(step, Block) and is_small_linear(step):
                    late.update(_unwanted(step, wanted))
                wanted.update(below(values(step)))
    return kept


def is_small_linear(block: Block) -> bool:
    """Whether a block of the top level is solved from its matrix alone."""
    return block.linear and not block.free and 0 < len(block.tears) < FEWEST


def _unwanted(block: Block, wanted: set[Expr]) -> list[Expr]:
    """The inner unknowns that nothing behind the block needs, directly or not."""
    needed = set(wanted)
    found = []
    for a in reversed(block.inner):
        if a.target in needed:
            needed.update(below((a.value,)))
        else:
            found.append(a.target)
    return found
