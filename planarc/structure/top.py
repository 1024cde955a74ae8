"""The top level: accelerations, forces and all other algebraic unknowns.

In:   System, of as many equations as unknowns, and their matching
Out:  steps, each block with as many tears as residuals

The equations are put into block lower triangular form. An equation alone in its block
that can be solved becomes an assignment. A larger block is torn: the derivatives of
candidates first, then other derivatives (in a mechanism angular accelerations, from
which motion and inertia forces follow outwards), then, where that leaves a large block
fewer tears, the forces of equations with modes (a contact's), then the unknown that makes
most equations solvable (a cut force of each loop); the residuals are the joints' force
laws and the loops' closing conditions, linear in the tears.

Example: pendulum    der(w) torn, a := ..., f := m*(a - g), residual I*der(w) - ...

Needs:     a complete matching.
"""

from __future__ import annotations

from planarc.core.blocks import sort_blocks
from planarc.ir.expr import Expr, Op
from planarc.ir.sorted import Step
from planarc.structure.matching import Matching
from planarc.structure.steps import make_steps
from planarc.structure.system import Scalar, System, Systems
from planarc.structure.tearing import tear_system

#: Blocks of more tears than this take longer to solve than to evaluate: there fewer tears count.
#: Smaller ones keep to joints' forces: with these, blows on a hundred random four-bars are told to
#: 1e-11 rad/s, with contacts' forces to 3e-10.
LARGE = 24


def sort_top(
    systems: Systems,
    system: System,
    matching: Matching,
    favoured: frozenset[Expr],
) -> tuple[Step, ...]:
    solver = matching.equation
    needs = [
        [solver[v] for v in scalar.unknowns if solver[v] != e]
        for e, scalar in enumerate(system.equations)
    ]
    steps: list[Step] = []
    for block in sort_blocks(needs):
        part = _part(system, block, matching)
        rows = [s.row() for s in part.equations]
        rank = [0 if s in favoured else 1 if s.order else 3 for s in part.unknowns]
        torn = tear_system(rows, rank)
        if len(torn.tears) > LARGE and (modal := _modal(part)):
            earlier = tear_system(
                rows, [2 if v in modal and r == 3 else r for v, r in enumerate(rank)]
            )
            torn = min(torn, earlier, key=lambda t: len(t.tears))
        steps.extend(make_steps(systems, part, torn))
    return tuple(steps)


def _modal(part: System) -> set[int]:
    """The unknowns of equations that are another one in each mode: these are left as residuals,
    whatever is torn."""
    return {
        v
        for s in part.equations
        if not (s.factors or s.solved) and _chooses(s.form.residual)
        for v in s.unknowns
    }


def _chooses(e: Expr) -> bool:
    """Whether an equation's residual is an if-expression, but for its sign."""
    while e.op is Op.NEG:
        (e,) = e.args
    return e.op is Op.IF


def _part(system: System, block: list[int], matching: Matching) -> System:
    """The equations of a block, in the unknowns that they are matched with."""
    variables = sorted(matching.variable[e] for e in block)
    number = {v: i for i, v in enumerate(variables)}
    equations = []
    for e in block:
        s = system.equations[e]
        equations.append(
            Scalar(
                s.form,
                tuple(number[v] for v in s.unknowns if v in number),
                {number[v]: f for v, f in s.factors.items() if v in number},
                {number[v]: f for v, f in s.solved.items() if v in number},
            )
        )
    return System(
        system.height,
        tuple(system.unknowns[v] for v in variables),
        tuple(equations),
        tuple(system.live[e] for e in block),
        tuple(system.variables[v] for v in variables),
    )
