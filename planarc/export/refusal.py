"""What cannot be exported yet: told with the line and the reason, never exported wrongly.

In:   Program
Out:  PlanarcError C300 with a diagnostic for each reason, UsageError R483 for implicit steps of
      a model with a crowd, or nothing
"""

from __future__ import annotations

from collections.abc import Iterator

from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.core.source import NOWHERE, Span
from planarc.instance.plan import crowd_names
from planarc.ir.closing import applied
from planarc.ir.dae import Assertion, Impact, Kind, Reinit, SetDiscrete
from planarc.ir.expr import postorder
from planarc.ir.program import Let, Program
from planarc.solve.stepping.refusal import no_implicit_steps

_HINT = "simulate it with `planarc simulate`; exported models cannot do this yet"

_KINDS = {
    Kind.BOOLEAN: "Boolean and no Real",
    Kind.INTEGER: "Integer and no Real",
    Kind.ENUMERATION: "an enumeration and no Real",
    Kind.STRING: "a String and no Real",
    Kind.REAL: "discrete",
}


def refuse(program: Program, stiff: bool = False) -> None:
    """Raise what stands in the way of an export, with implicit steps where it is to be `stiff`."""
    found = [
        Diagnostic("C300", f"{what} cannot be exported", span if span is not NOWHERE else None,
                   hint=_HINT)
        for what, span in _reasons(program)
    ]  # fmt: skip
    if found:
        raise PlanarcError(found)
    if stiff and (crowds := crowd_names(program)):
        raise no_implicit_steps(crowds[0])


def _reasons(program: Program) -> Iterator[tuple[str, Span]]:
    acting = [a for when in program.whens for *_, found in when.branches for a in found]
    for d in program.discretes:
        if d.given is not None:
            yield f"the input `{d.name}`, which is {_KINDS[d.kind]},", d.given
    lists = (program.parameters, *program.levels, program.rest, program.initial, program.roots,
             program.discrete)  # fmt: skip
    lets = [s for statements in lists for s in statements if isinstance(s, Let)]
    lets += [s for block in program.blocks for s in (*block.body, *block.jacobian_body)]
    tangents = [block.tangent for block in program.blocks if block.tangent is not None]
    lets += [s for tangent in tangents for s in tangent.body]
    formulas = [s.value for s in lets] + [a.condition for a in program.assertions]
    formulas += [*program.initial_residuals, *(e for tangent in tangents for e in tangent.entries)]
    for block in program.blocks:
        formulas += [*block.residuals, *(e for *_, e in block.jacobian)]
    formulas += [r.zero for r in program.relations]
    formulas += [a.value for a in acting if isinstance(a, SetDiscrete | Reinit)]
    formulas += [a.condition for a in acting if isinstance(a, Assertion)]
    formulas += [e for a in acting if isinstance(a, Impact) for e in a.arguments]
    formulas += [e for _, *pair, _ in program.samplers for e in pair]
    called = dict.fromkeys(name for e in postorder(formulas) for name, *_ in applied(e))
    for name in called:
        yield f"the function `{name}`, which planarc computes in Python,", program.span
