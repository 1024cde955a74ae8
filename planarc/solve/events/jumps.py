"""What jumps at an event, though its derivative is in the equations and nothing sets it anew.

In:   the values before and after an event of all that is differentiated, for the states before it:
      what an impact changes may jump
Out:  a warning R438, once a run

A `reinit` may set a variable anew, and then it is meant; but where a drive with a jump in its
signal moves a mechanism, its speed is infinite for an instant, and no equation says so: each branch
of the signal is differentiated alone. The same holds of any signal and its derivative.

Example: `Position(exact=true)` on a step.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.core.prose import listed
from planarc.core.source import Span
from planarc.ir.flat import Part
from planarc.ir.kernel import Kernel
from planarc.ir.once import once
from planarc.ir.places import is_own, own_part, owner
from planarc.ir.program import Program

_JUMP = 1e-5  # in m or rad, or as a share of the larger value: smaller ones are rounding


class Jumps:
    """What is known of a run's positions."""

    def __init__(self, program: Program, kernel: Kernel) -> None:
        self._program, self._kernel = program, kernel
        self._watched = _differentiated(program)
        self._told = False

    def values(self) -> list[float]:
        w = self._kernel.w
        return [] if self._told else [float(w[slot]) for slot in self._watched.values()]

    def judge(self, t: float, before: list[float], after: list[float]) -> tuple[Diagnostic, ...]:
        """The warning, if the first of them jumps at `t`."""
        if self._told:
            return ()
        for name, old, new in zip(self._watched, before, after, strict=True):
            if abs(new - old) > _JUMP * max(1.0, abs(old), abs(new)):
                self._told = True
                return (self._jumped(name, old, new, t),)
        return ()

    def _jumped(self, name: str, old: float, new: float, t: float) -> Diagnostic:
        program, slot = self._program, self._watched[name]
        part, drives = own_part(program, owner(name)), _drives(program, slot)
        if not drives and name.startswith("der("):  # who gives the angle gives the speed
            drives = _drives(program, program.slots.get(name[4:-1], slot))
        given = listed(f"`{p.name}`" for p in drives)
        place = drives[0].span if drives else part.span if part else _derived(program, name)
        speed = name.startswith("der(") and bool(drives)
        moves = speed or f"der(der({name}))" in program.slots
        moves = moves and program.mechanism is not None
        lost = "the forces that this takes are" if moves else "its derivative is then"
        shown = name if not name.startswith("der(") else _column(program, slot) or name
        return Diagnostic(
            "R438",
            f"`{shown}` jumps from {old:.4g} to {new:.4g} at t = {t:.6g} s: "
            f"{lost} infinite, and not counted",
            place,
            Severity.WARNING,
            hint=f"let {given or 'what drives it'} move it without jumps, for example by "
            f"`KinematicPTP2`{self._ways_out(drives, name.startswith('der('))}"
            if drives or moves
            else "smooth what jumps, or leave its derivative out",
        )

    def _ways_out(self, drives: Iterable[Part], speed: bool) -> str:
        """What parameters of the drive and of its signal may be set to, where a `speed` jumps, or
        a position."""
        slots, told = {c.name: c.slot for c in self._program.columns}, ""
        for part in drives:
            smoothness, extrapolation = f"{part.name}.smoothness", f"{part.name}.extrapolation"
            if smoothness in slots and speed:
                told += f"; or give `{part.name}` `smoothness = "
                told += "Modelica.Blocks.Types.Smoothness.ContinuousDerivative`"
            at = slots.get(extrapolation, -1)
            if at >= 0 and not speed and self._kernel.w[at] == _PERIODIC:
                told += f"; a table that repeats, as `{part.name}`, ends with the value with "
                told += "which it begins"
            if f"{part.name}.exact" in slots:
                told += f"; or let `{part.name}(exact = false)` follow it"
        return told


#: The value of `extrapolation` of a table that repeats.
_PERIODIC = 3


def _column(program: Program, slot: int) -> str | None:
    """The first name of a variable in the results."""
    return next((c.name for c in program.columns if c.slot == slot), None)


def _derived(program: Program, name: str) -> Span | None:
    """The equation that asks for the derivative of a variable of the model itself."""
    asked = f"der({name})"
    found = (e.span for e in program.equations if asked in e.text and is_own(program, e.span))
    return next(found, None)


def _drives(program: Program, slot: int) -> list[Part]:
    """The user's parts beside the mechanism that have this position for a variable: the drive, and
    the block with its signal; not a sensor that it passes."""
    mechanism = program.mechanism
    if mechanism is None:
        return []
    frames = [f for link in mechanism.links for f in link.frames]
    frames += [f for joint in mechanism.joints for f in joint.frames]
    inside = {*map(owner, frames), *(j.name for j in mechanism.joints)}
    inside |= {name.partition(".")[0] for name in inside}
    owners = dict.fromkeys(owner(c.name) for c in program.columns if c.slot == slot)
    parts = [(own_part(program, o), o) for o in owners]
    ends = Counter(p.name for p, o in parts if p is not None and p.name != o)
    found = {p.name: p for p, _ in parts if p and p.name not in inside and ends[p.name] < 2}
    return list(found.values())


@once
def _differentiated(program: Program) -> dict[str, int]:
    """The slots of all that has a derivative, by name; positions before speeds. What is hidden in a
    part counts by what it moves: the time within a path may well begin at a speed of 1."""
    slots = {c.name: c.slot for c in program.columns} | dict(program.slots)
    hidden = {c.name for c in program.columns if c.protected and "." in c.name}
    hidden |= {f"der({name})" for name in hidden}
    names = (n[4:-1] for n in program.slots if n.startswith("der("))
    seen = (n for n in names if n in slots and n not in hidden)
    return {n: slots[n] for n in sorted(seen, key=lambda n: n.startswith("der("))}
