"""Assertions that fail, in words; and the one that says why a component has no value.

In:   Program, Kernel at a point where an equation gives no finite number, that equation's component
Out:  the message of the component's own assertion that does not hold there

Example: two rods that would have to reach too far. The height of their hinge over the line between
their ends is the root of a negative number, so that no row comes so far; `assert(D < L1 + L2, ...)`
does not hold there, and says it in mechanical words.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator

from planarc.core.diagnostic import Diagnostic, Related, Severity
from planarc.core.source import NOWHERE
from planarc.ir.dae import Assertion, Dae
from planarc.ir.expr import Expr, postorder, symbols
from planarc.ir.kernel import Kernel
from planarc.ir.places import own_part, owner, point_home
from planarc.ir.program import Program
from planarc.runtime.texts import formatted
from planarc.solve.messages.factors import off_by_a_factor
from planarc.solve.messages.replay import Replay


def assertion_diagnostic(
    model: Dae | Program,
    t: float | None,
    assertion: Assertion,
    message: str,
    kernel: Kernel | None = None,
    leaf: Callable[[Expr], float] | None = None,
) -> Diagnostic:
    """The message of an assertion at a time; None where no run is needed to see it. Where the
    `kernel` has other values than the text, the place is that of the part. `leaf` has the values
    with which it fails."""
    when = "" if t is None else f" at t = {t:.6g} s"
    place = f" in `{assertion.component}`" if assertion.component else ""
    here, is_given = "the assertion stands here", assertion.given is not NOWHERE
    if is_given and isinstance(model, Program) and kernel is not None:
        is_given = not any(_changes(model, kernel, assertion))
    told = f"assertion failed{when}{place}: {message}"
    if not assertion.span.text.startswith("assert"):  # the compiler's own
        told = f"{when.removeprefix(' ')}{place} {message}".strip()
    found = Diagnostic(
        "R430",
        told,
        assertion.given if is_given else assertion.span,
        Severity.WARNING if assertion.warning else Severity.ERROR,
        hint=off_by_a_factor(model, kernel, assertion, message, leaf)
        if leaf is not None and kernel is not None and isinstance(model, Program)
        else None,
        related=(
            *_asked(model, assertion, message),
            *((Related(here, assertion.span),) if is_given else ()),
        ),
    )
    return point_home(model, found, assertion.component, here)


def _changes(program: Program, kernel: Kernel, assertion: Assertion) -> Iterator[str]:
    """Parameters around an assertion that the run was given other values for than the text has."""
    around = assertion.component.split(".")
    for p in program.parameter_slots:
        if p.default is not None and kernel.w[p.slot] != p.default:
            part = owner(p.name).split(".") if owner(p.name) else []
            if all(a == b for a, b in zip(part, around, strict=False)):
                yield p.name


def _asked(model: Dae | Program, assertion: Assertion, message: str) -> Iterator[Related]:
    """The other parts, as the world, whose parameters the assertion asks for and tells of."""
    asked, told = {e.name for e in symbols(assertion.condition)}, re.findall(r"\w+", message)
    slots = model.parameters if isinstance(model, Dae) else model.parameter_slots
    names = (p.name for p in slots if p.name in asked and p.name.rpartition(".")[2] in told)
    own = own_part(model, assertion.component)
    for part in dict.fromkeys(own_part(model, owner(name)) for name in names):
        if part is not None and part != own:
            yield Related(f"`{part.name}` is declared here", part.span)


def broken_assertion(
    program: Program, kernel: Kernel, t: float, component: str
) -> Diagnostic | None:
    """The first assertion of a component that does not hold at this point, of values that are
    known there."""
    own = [a for a in program.assertions if a.component == component and not a.warning]
    if not own:
        return None
    replay = Replay(program, kernel, t)
    replay.first_not_finite()

    def is_broken(condition: Expr) -> bool:
        leaves = [e for e in postorder((condition,)) if not e.args]
        return all(map(math.isfinite, replay.values(leaves))) and replay.values([condition]) == [0]

    assertion = next((a for a in own if is_broken(a.condition)), None)
    if assertion is None:
        return None
    texts = [
        part if isinstance(part, str) else formatted(replay.values([part[0]])[0], part[1])
        for part in assertion.message.parts
    ]
    return assertion_diagnostic(
        program, t, assertion, "".join(texts), kernel, lambda e: replay.values([e])[0]
    )
