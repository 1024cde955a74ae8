"""The levels below the top: what is a candidate for a state, and what follows from it.

In:   System      of a level, from the lowest one up
      Attributes  what the user said of each symbol
Out:  steps; their tears are the candidates for states

Each level is one tearing problem. Unknowns are torn in this order: StateSelect.always;
derivatives of candidates of the level below, so that velocities are chosen as positions
were; then by StateSelect (prefer, default, avoid, never); then those whose start was
written; then those that make most equations solvable; then the first. Those that the
others give all the same are no candidates (`thinning`). In a mechanism these are the
joints' coordinates, from the ground outwards; each loop leaves residuals, and the states
are the tears less the residuals, chosen while running.

Example: a crank-slider with the hinges A, B, C and the slide s

    tear A.phi, B.phi;  frames := ...;  C.phi := ...;  s := ...;  one residual: y = 0

Promises:  `StateSelect.always` is kept, or refused with what the symbol follows from.
Reference: S. E. Mattsson, G. Soederlind, SIAM J. Sci. Comput. 14(3), 1993, 677-692
           (dummy derivatives; here the choice is left to the run).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from planarc.core.diagnostic import Diagnostic, PlanarcError, Related
from planarc.core.prose import be, ticked
from planarc.ir.dae import Dae
from planarc.ir.expr import Expr, Exprs
from planarc.ir.flat import StateSelect
from planarc.ir.sorted import Assignment, Block, Candidate, SourceEquation, Step
from planarc.structure.attributes import Attributes, plain_attributes
from planarc.structure.steps import make_steps
from planarc.structure.system import System, Systems
from planarc.structure.tearing import Torn, tear_system
from planarc.structure.thinning import thin_tears


def sort_level(
    systems: Systems,
    system: System,
    attributes: Mapping[Expr, Attributes],
    favoured: frozenset[Expr],
) -> tuple[Step, ...]:
    """`favoured` are the derivatives of the candidates of the level below."""
    rank = [_rank(symbol, attributes, favoured) for symbol in system.unknowns]
    rows = [s.row() for s in system.equations]
    torn = tear_system(rows, rank)
    if torn.residuals:
        torn = thin_tears(rows, torn, _droppable(system, torn, rank, attributes))
    return make_steps(systems, system, torn)


def _droppable(
    system: System, torn: Torn, rank: Sequence[int], attributes: Mapping[Expr, Attributes]
) -> list[int]:
    """The tears that nobody asked to be states, the least wanted ones first."""
    plain = [
        v
        for v in torn.tears
        if rank[v] > 1 and select_of(system.unknowns[v], attributes) < StateSelect.PREFER
    ]
    return sorted(plain, key=lambda v: -rank[v])


def _rank(symbol: Expr, attributes: Mapping[Expr, Attributes], favoured: frozenset[Expr]) -> int:
    select = select_of(symbol, attributes)
    if select is StateSelect.ALWAYS:
        return 0
    if symbol in favoured and select is not StateSelect.NEVER:
        return 1
    found = attributes.get(symbol)
    written = found is not None and found.start_written
    return 2 * (1 + int(StateSelect.ALWAYS) - int(select)) - int(written)


def select_of(symbol: Expr, attributes: Mapping[Expr, Attributes]) -> StateSelect:
    found = attributes.get(symbol)
    return found.select if found else StateSelect.DEFAULT


def derivatives_of_tears(table: Exprs, steps: Sequence[Step]) -> frozenset[Expr]:
    return frozenset(table.der(t) for s in steps if isinstance(s, Block) for t in s.tears)


def describe_candidates(
    dae: Dae, steps: Sequence[Step], attributes: Mapping[Expr, Attributes]
) -> tuple[Candidate, ...]:
    found = []
    for step in steps:
        for symbol in step.tears if isinstance(step, Block) else ():
            a = attributes.get(symbol) or plain_attributes(dae, symbol)
            found.append(
                Candidate(
                    symbol,
                    a.display,
                    a.select,
                    a.start,
                    a.start_written,
                    a.fixed,
                    a.nominal,
                    a.span,
                )
            )
    return tuple(found)


def check_always(
    steps: Sequence[Step],
    attributes: Mapping[Expr, Attributes],
    equations: Sequence[SourceEquation],
    reset: Sequence[Expr] = (),
) -> None:
    """A symbol with StateSelect.always is a candidate, and its block has states enough.

    `reset` are symbols that must be states because a `reinit` sets them.
    """
    wrong = []
    for step in steps:
        if isinstance(step, Assignment):
            wrong.extend(_check_assigned(step, attributes, equations, reset))
            continue
        always = [t for t in step.tears if select_of(t, attributes) is StateSelect.ALWAYS]
        if len(always) > step.free:
            names = ticked(attributes[t].display for t in always)
            wrong.append(
                Diagnostic(
                    "S308",
                    f"{names} cannot all be states: only {step.free} of them "
                    f"{be(step.free)} independent",
                    attributes[always[-1]].span,
                    hint="take `StateSelect.always` away from the others",
                    related=tuple(
                        Related("this equation ties them", equations[r.equation].span)
                        for r in step.residuals
                    ),
                )
            )
        for a in step.inner:
            wrong.extend(_check_assigned(a, attributes, equations, reset))
    if wrong:
        raise PlanarcError(wrong)


def _check_assigned(
    step: Assignment,
    attributes: Mapping[Expr, Attributes],
    equations: Sequence[SourceEquation],
    reset: Sequence[Expr],
) -> list[Diagnostic]:
    if select_of(step.target, attributes) is not StateSelect.ALWAYS:
        return []
    a = attributes[step.target]
    related = (Related("from this equation", equations[step.equation].span),)
    if step.target in reset:
        return [
            Diagnostic(
                "S313",
                f"`{a.display}` is set by `reinit`, but follows from other variables",
                a.span,
                hint="reinit the variable that it follows from",
                related=related,
            )
        ]
    return [
        Diagnostic(
            "S307",
            f"`{a.display}` has `StateSelect.always`, but follows from other variables",
            a.span,
            hint="use `StateSelect.prefer`, or take `always` away from what it follows from",
            related=related,
        )
    ]
