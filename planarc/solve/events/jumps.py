"""Positions that jump at an event though nothing sets them anew: the forces are not counted.

In:   the positions before and after an event
Out:  a warning R438, once a run

A position is a variable of which the equations hold the second derivative. A `reinit` may set it,
and then it is meant; but where a drive with a jump in its signal moves a mechanism, its speed is
infinite for an instant, and no equation says so: each branch of the signal is differentiated alone.

Example: `Position(exact=true)` on a step.
"""

from __future__ import annotations

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.core.prose import listed
from planarc.ir.flat import Part
from planarc.ir.kernel import Kernel
from planarc.ir.places import own_part, owner
from planarc.ir.program import Program
from planarc.solve.once import once

_JUMP = 1e-5  # in m or rad, or as a share of the larger value: smaller ones are rounding


class Jumps:
    """What is known of a run's positions."""

    def __init__(self, program: Program, kernel: Kernel) -> None:
        self._program, self._kernel = program, kernel
        self._watched = _positions(program)
        self._told = False

    def positions(self) -> list[float]:
        w = self._kernel.w
        return [float(w[slot]) for slot in self._watched.values()]

    def judge(self, t: float, before: list[float]) -> tuple[Diagnostic, ...]:
        """The warning, if the first position jumps at `t`."""
        if self._told:
            return ()
        for name, old, new in zip(self._watched, before, self.positions(), strict=True):
            if abs(new - old) > _JUMP * max(1.0, abs(old), abs(new)):
                self._told = True
                return (self._jumped(name, old, new, t),)
        return ()

    def _jumped(self, name: str, old: float, new: float, t: float) -> Diagnostic:
        program = self._program
        part, drives = own_part(program, owner(name)), _drives(program, self._watched[name])
        given = listed(f"`{p.name}`" for p in drives)
        return Diagnostic(
            "R438",
            f"`{name}` jumps from {old:.4g} to {new:.4g} at t = {t:.6g} s: "
            "the forces that this takes are infinite, and not counted",
            drives[0].span if drives else part.span if part else None,
            Severity.WARNING,
            hint=f"let {given or 'what drives it'} move it without jumps, for example by "
            "`KinematicPTP2`",
        )


def _drives(program: Program, slot: int) -> list[Part]:
    """The user's parts beside the mechanism that have this position for a variable: the drive, and
    the block with its signal."""
    mechanism = program.mechanism
    if mechanism is None:
        return []
    frames = [f for link in mechanism.links for f in link.frames]
    frames += [f for joint in mechanism.joints for f in joint.frames]
    inside = {*map(owner, frames), *(j.name for j in mechanism.joints)}
    inside |= {name.partition(".")[0] for name in inside}
    owners = dict.fromkeys(owner(c.name) for c in program.columns if c.slot == slot)
    parts = (own_part(program, o) for o in owners)
    found = {p.name: p for p in parts if p is not None and p.name not in inside}
    return list(found.values())


@once
def _positions(program: Program) -> dict[str, int]:
    """The slots of positions, by name."""
    slots = {c.name: c.slot for c in program.columns} | dict(program.slots)
    positions = (n[8:-2] for n in program.slots if n.startswith("der(der("))
    return {n: slots[n] for n in positions if n in slots}
