"""Steps of a torn system: assignments and blocks in order of evaluation.

In:   System, Torn
Out:  steps   assignments from known values, blocks, assignments from what blocks gave

Residuals that depend on a common tear, directly or through assignments, belong to one
block; a tear that no residual depends on is a block of its own. Of the assignments a
block holds those that its residuals need and that depend on its tears.

Example: tears a, b, c; u := a + b; residual u; w := c

    Block(tears=(a, b), inner=(u,), residuals=(u,)), Block(tears=(c,)), w := c

Promises:  blocks of one level do not depend on each other.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from planarc.core.data import Data
from planarc.ir.sorted import Assignment, Block, Residual, Step
from planarc.structure.linear import Degrees
from planarc.structure.system import System, Systems
from planarc.structure.tearing import Torn


class Plan(Data):
    """A step as numbers: positions in `Torn.assignments`, unknowns, equations."""

    before: tuple[int, ...]
    blocks: tuple[tuple[tuple[int, ...], tuple[int, ...], tuple[int, ...]], ...]
    after: tuple[int, ...]


def plan_steps(rows: Sequence[Sequence[int]], torn: Torn) -> Plan:
    """The order of solving. `rows` are the unknowns of each equation; blocks are (tears, inner,
    residuals)."""
    mask = {v: 1 << i for i, v in enumerate(sorted(torn.tears))}  # tears that v depends on
    for v, e in torn.assignments:
        mask[v] = _union(mask[u] for u in rows[e] if u != v)
    residual_masks = [(e, _union(mask[u] for u in rows[e])) for e in torn.residuals]
    groups = _group([m for _, m in residual_masks], len(torn.tears))
    maker = {v: i for i, (v, _) in enumerate(torn.assignments)}
    inside: set[int] = set()
    blocks = []
    tears = sorted(torn.tears)
    for group in groups:
        own = tuple(tears[i] for i in _bits(group))
        residuals = tuple(e for e, m in residual_masks if m & group)
        inner = _needed(rows, torn, residuals, maker, mask)
        inside.update(inner)
        blocks.append((own, inner, residuals))
    loose = [e for e, m in residual_masks if not m]
    if loose:  # depends on nothing: a check that no unknown can meet
        blocks.append(((), (), tuple(loose)))
    before = [i for i, (v, _) in enumerate(torn.assignments) if not mask[v]]
    after = [i for i, (v, _) in enumerate(torn.assignments) if mask[v] and i not in inside]
    return Plan(tuple(before), tuple(blocks), tuple(after))


def _union(masks: Iterable[int]) -> int:
    union = 0
    for m in masks:
        union |= m
    return union


def _bits(mask: int) -> list[int]:
    """The places of the ones, ascending."""
    found = []
    while mask:
        low = mask & -mask
        found.append(low.bit_length() - 1)
        mask ^= low
    return found


def _group(masks: list[int], count: int) -> list[int]:
    """Disjoint unions of the masks that overlap, and single bits; by their lowest bit."""
    groups: list[int] = []
    for m in filter(None, masks):
        groups = [*(g for g in groups if not g & m), m | _union(g for g in groups if g & m)]
    single = (1 << count) - 1 & ~_union(groups)
    return sorted((*groups, *(1 << i for i in _bits(single))), key=lambda g: g & -g)


def _needed(
    rows: Sequence[Sequence[int]],
    torn: Torn,
    residuals: Sequence[int],
    maker: dict[int, int],
    mask: dict[int, int],
) -> tuple[int, ...]:
    """Positions of the assignments that the residuals need and that depend on tears."""
    needed: set[int] = set()
    stack = [v for e in residuals for v in rows[e]]
    while stack:
        v = stack.pop()
        if v in maker and mask[v] and maker[v] not in needed:
            needed.add(maker[v])
            stack.extend(rows[torn.assignments[maker[v]][1]])
    return tuple(sorted(needed))


def make_steps(systems: Systems, system: System, torn: Torn) -> tuple[Step, ...]:
    plan = plan_steps([s.unknowns for s in system.equations], torn)
    assignments = [
        Assignment(
            system.unknowns[v],
            systems.solve(system.equations[e], v, system.unknowns[v]),
            system.equations[e].form.index,
        )
        for v, e in torn.assignments
    ]
    steps: list[Step] = [assignments[i] for i in plan.before]
    for tears, inner, residuals in plan.blocks:
        chosen = tuple(assignments[i] for i in inner)
        forms = [system.equations[e].form for e in residuals]
        zero = tuple(Residual(f.residual, f.index) for f in forms)
        unknowns = tuple(system.unknowns[v] for v in tears)
        degrees = Degrees(dict.fromkeys(unknowns, 1))
        for a in chosen:
            degrees.define(a.target, a.value)
        linear = bool(zero) and all(degrees(r.value) < 2 for r in zero)
        steps.append(Block(unknowns, chosen, zero, linear))
    steps.extend(assignments[i] for i in plan.after)
    return tuple(steps)
