"""Which variables tick with a clock, as far as checks before `lower.clocks` need to know.

In:   the equations, algorithms and variables of a model
Out:  the names of variables that stand together with an operator of clocks

Example: in `k = f(y); y = sample(x, Clock(0.1));` both `y` and `k` tick, and `x` does not.

Reference: Modelica Language Specification 3.6, section 16.7.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator

from planarc.core.disjoint import DisjointSets
from planarc.ir import flat
from planarc.ir.flatwalk import (
    CONVERSIONS,
    OUTWARDS,
    children,
    expressions_in,
    is_clocked_sample,
)

#: What stands in these ticks by itself: its clock is another one, or that of a `hold`.
_APART = CONVERSIONS | OUTWARDS
#: What stands beside these ticks.
_MARKS = CONVERSIONS | {"previous", "interval", "firstTick", "Clock"}


def find_ticking(
    equations: Iterable[flat.Equation],
    algorithms: Iterable[flat.Algorithm],
    variables: Collection[flat.Variable],
) -> set[str]:
    """The names of variables that tick with a clock."""
    moving = {v.name for v in variables if v.variability > flat.Variability.PARAMETER}
    sets: DisjointSets[str] = DisjointSets()
    ticking: list[str] = []
    for i, group in enumerate(_groups(equations, algorithms, variables)):
        todo: list[tuple[flat.Expression, str]] = [(e, f"${i}") for e in group]
        while todo:
            e, node = todo.pop()
            sets.add(node)
            kept = children(e)
            match e:
                case flat.Reference(name=name) if name in moving:
                    sets.join(node, name)
                case flat.Builtin() if is_clocked_sample(e):
                    ticking.append(node)
                    kept = e.arguments[1:]
                case flat.Builtin(function=function) if function in _MARKS | _APART:
                    ticking += [node] if function in _MARKS else []
                    if function in _APART:
                        node = f"{node}.{len(ticking)}"
                        ticking.append(node)
            todo += ((part, node) for part in kept)
    roots = {sets.find(node) for node in ticking if node in sets}
    return {name for name in moving if name in sets and sets.find(name) in roots}


def _groups(
    equations: Iterable[flat.Equation],
    algorithms: Iterable[flat.Algorithm],
    variables: Iterable[flat.Variable],
) -> Iterator[list[flat.Expression]]:
    """The expressions of each equation, binding and algorithm."""
    for v in variables:
        if v.binding is not None:
            yield [flat.Reference(v.type, v.span, v.name), v.binding]
    for equation in equations:
        yield list(expressions_in((equation,)))
    for algorithm in algorithms:
        yield list(expressions_in(algorithm.statements))
