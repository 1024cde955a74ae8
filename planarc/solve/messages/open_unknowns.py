"""Unknowns that the equations leave open in a mode: they may share a load, not rule the motion.

In:   Program, Kernel (which has just solved a singular modal block)
Out:  a warning that names the open unknowns, or an error where the motion depends on them

Two brakes that are stuck on one shaft hold it with s1 + s2 = T. That is one equation for
two unknowns, and the shaft stands still whatever each brake takes: the run goes on. A
part without mass that nothing holds in some mode may move in any way: the run ends.

The open unknowns are moved, and everything is evaluated again: what moves with them
depends on them.
"""

from __future__ import annotations

from collections.abc import Container, Sequence

from planarc.core.diagnostic import Diagnostic, Related, Severity
from planarc.ir.dae import SHARING
from planarc.ir.expr import text
from planarc.ir.kernel import Kernel
from planarc.ir.places import point_home
from planarc.ir.program import EquationInfo, Program
from planarc.solve.messages import trouble

#: Rates of states that differ by more, for open unknowns that differ by one.
DEPENDS = 1e-6
_MOST = 3


def judge_open(
    program: Program, kernel: Kernel, t: float, y: Sequence[float], known: Container[int] = ()
) -> Diagnostic | None:
    """None where the last evaluation left nothing open that can be moved, or only what a block
    shares that is `known`. The workspace holds the point (t, y) and does so afterwards."""
    block = kernel.open_block
    if block < 0:
        return None
    slots = [program.slots[text(tear)] for tear in program.blocks[block].tears]
    rates, moved_rates = [0.0] * len(y), [0.0] * len(y)
    kernel.rhs(t, y, rates)
    values = [kernel.w[s] for s in slots]
    kernel.sway(block, 1.0)
    kernel.rhs(t, y, moved_rates)
    moved = [abs(kernel.w[s] - v) > DEPENDS for s, v in zip(slots, values, strict=True)]
    kernel.sway(block, -1.0)
    kernel.outputs(t, y)
    depends = any(
        abs(a - b) > DEPENDS * max(1.0, abs(a)) for a, b in zip(rates, moved_rates, strict=True)
    )
    accepted = any(SHARING in text(tear) for tear in program.blocks[block].tears)
    if not depends and (accepted or block in known or not any(moved)):
        return None  # redundant joints that are accepted are told once, with what they share
    tears = zip(program.blocks[block].tears, moved, strict=True)
    names = trouble.names([text(tear) for tear, m in tears if m])
    infos = [program.equations[e] for e in program.blocks[block].equations]
    found = (_undetermined if depends else _shared)(program, t, names, infos)
    return point_home(program, found, infos[0].component if infos else "")


def _undetermined(
    program: Program, t: float, names: str, infos: Sequence[EquationInfo]
) -> Diagnostic:
    return Diagnostic(
        "R424",
        f"at t = {t:.6g} s the motion is not determined: in this mode the equations leave "
        f"{names} open",
        infos[0].span if infos else None,
        hint="look for a part without mass that nothing holds in this mode"
        if program.mechanism is not None
        else "look for an unknown that no equation holds in this mode",
        related=tuple(Related(f"`{i.text}`", i.span) for i in infos[:_MOST]),
    )


def _shared(program: Program, t: float, names: str, infos: Sequence[EquationInfo]) -> Diagnostic:
    parts = trouble.components(program, infos)
    return Diagnostic(
        "R425",
        f"at t = {t:.6g} s the equations of {parts or 'the model'} leave {names} open: "
        "several parts hold the same motion, and how they share the load is not determined",
        infos[0].span if infos else None,
        Severity.WARNING,
        hint="the motion is right; make one of the parts elastic where the forces matter",
    )
