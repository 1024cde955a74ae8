"""A guess that the start moved far: what was found is hardly what was meant.

In:   Program, a kernel that holds the start, the uses of the start values
Out:  a warning (R442) about the one that moved absurdly far, a note about one that is written and
      was left on another side, or None; a warning about a speed that was asked for and not kept,
      and about anything asked for that an initial equation decides

Only coordinates of joints count: shafts behind gears may well be many turns away. An angle counts
where its start is written, since only then its turns were meant; a way is compared with the parts.

Examples: `slide(s(start=-3000))`, in mm, of a crank of 0.1 m begins 3 km away. The follower of a
cam whose frames are exchanged begins at -0.11 m below the shaft, and not at 0.1 m above it.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from itertools import chain
from math import isclose, pi, remainder

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.core.unit import turns
from planarc.ir.kernel import Kernel
from planarc.ir.mechanism import SPEEDS
from planarc.ir.once import once
from planarc.ir.places import declaration, owner
from planarc.ir.program import CandidateSlot, FixedSlot, Program
from planarc.ir.result import Held
from planarc.solve.start.longest import lengths_of_parts

#: Turns that a guess hardly moves by.
_TURNS = 10
#: Multiple of the longest part that a guess hardly moves by.
_FAR = 1000.0
#: The difference, beside 1 and beside the value, of what is kept.
_KEPT = 1e-6
#: Parts of a written place from which another one is on the other side, or nothing is left of it.
_OTHER_SIDE, _NOTHING = 0.5, 0.1


def judge_moved(
    program: Program, kernel: Kernel, held: Sequence[Held], given: Collection[int] = ()
) -> Diagnostic | None:
    """The warning about the guess that moved farthest, where that is absurd; or about what was
    `given` for this run, by the slot of its start value, and is not kept."""
    moved = [guess for guess in held if not guess.held and guess.value != guess.start]
    if not moved:
        return None
    found = max(_absurd(program, kernel, moved), key=lambda f: f[0], default=None)
    if found is None:
        return _not_kept(program, kernel, moved, given) or _on_another_side(program, moved)
    _, guess, candidate, by = found
    return Diagnostic(
        "R442",
        f"the start moved `{guess.name}` from {guess.start:.6g} to {guess.value:.6g}, by {by}",
        declaration(program, candidate.start_name, candidate.span),
        Severity.WARNING,
        hint=f"give `{guess.name}` a start value near to where the mechanism is to begin, or check "
        "lengths and units",
    )


def _absurd(
    program: Program, kernel: Kernel, moved: Sequence[Held]
) -> Iterator[tuple[float, Held, CandidateSlot, str]]:
    """Guesses that moved absurdly far: by how many times what is plausible, and that in words."""
    coordinates = _coordinates(program)
    longest: float | None = None
    for guess in moved:
        way = abs(guess.value - guess.start)
        if guess.name not in coordinates:
            continue
        candidate, unit = coordinates[guess.name]
        if unit == "rad" and candidate.start_written and way > 2 * pi * _TURNS:
            yield way / (2 * pi * _TURNS), guess, candidate, turns(way)
        elif unit == "m":
            if longest is None:
                longest = max(lengths_of_parts(program, kernel).values(), default=0.0)
            if way > _FAR * longest > 0:
                by = f"{way:.4g} m, and its parts are {longest:.3g} m long"
                yield way / (_FAR * longest), guess, candidate, by


def _not_kept(
    program: Program, kernel: Kernel, moved: Sequence[Held], given: Collection[int]
) -> Diagnostic | None:
    """The warning about the first such speed. A place that is given may be meant as a guess, but
    not where an initial equation says something else."""
    initial = bool(program.initial_residuals)
    places = _started(program) if initial else _speeds(program)
    for guess in moved:
        place = places.get(guess.name)
        if place is None or place.start not in given:
            continue
        if isclose(guess.value, guess.start, rel_tol=_KEPT, abs_tol=_KEPT):
            continue
        from planarc.solve.messages.loops import given_of

        joint = guess.name.rpartition(".")[0]
        giver = given_of(program, kernel, [joint], SPEEDS).rpartition("which ")[2]
        why = f"{giver} it" if giver else "it follows so from what else is held"
        hint = None if giver else "leave it out, or set what is held instead"
        if initial and not giver:
            why = "initial equations decide it"
            hint = "write a `start` without parameters that they find, and `fixed=true`, in their "
            hint += "place: such a start can be set"
        return Diagnostic(
            "R442",
            f"`{guess.name}` starts at {guess.value:.4g}, and not at {guess.start:.4g}, which was "
            f"asked for: {why}",
            declaration(program, place.start_name, place.span),
            Severity.WARNING,
            hint=hint,
        )
    return None


def _on_another_side(program: Program, moved: Sequence[Held]) -> Diagnostic | None:
    """The note about the guess that moved farthest, beside its own size. Of redundant joints that
    share what they hold more is told."""
    if program.sharing is not None:
        return None
    coordinates = _coordinates(program)
    far: list[tuple[float, Held, CandidateSlot]] = []
    for guess in moved:
        candidate, unit = coordinates.get(guess.name, (None, ""))
        if candidate is None or not candidate.start_written:
            continue
        way = guess.value - guess.start
        if unit == "rad" and guess.name.endswith(".phi"):
            way = remainder(way, 2 * pi) / (pi / 2)
        elif guess.name.endswith(".s") and guess.start:
            part = guess.value / guess.start
            way = 1.0 - part if part < -_OTHER_SIDE or abs(part) < _NOTHING else 0.0
            way /= 1.0 - _NOTHING
        else:
            continue
        far.append((abs(way), guess, candidate))
    farthest = max(far, key=lambda f: f[0], default=None)
    if farthest is None or farthest[0] < 1.0:
        return None
    _, guess, candidate = farthest
    return Diagnostic(
        "R442",
        f"`{guess.name}` starts at {guess.value:.4g}, far from {guess.start:.4g} as it is written "
        "and not fixed",
        declaration(program, candidate.start_name, candidate.span),
        Severity.NOTE,
        hint="if that is not meant, look at the directions, lengths and sides by which the parts "
        "are connected; else write what follows",
    )


@once
def _started(program: Program) -> dict[str, CandidateSlot | FixedSlot]:
    """All with a start value by their names."""
    slots: Iterator[CandidateSlot | FixedSlot] = chain(program.candidates, program.fixed)
    return {c.display: c for c in slots}


@once
def _speeds(program: Program) -> dict[str, CandidateSlot | FixedSlot]:
    """Speeds with a start value by their names."""
    slots: Iterator[CandidateSlot | FixedSlot] = chain(program.candidates, program.fixed)
    return {c.display: c for c in slots if c.display.rpartition(".")[2] in SPEEDS}


@once
def _coordinates(program: Program) -> dict[str, tuple[CandidateSlot, str]]:
    """Places of joints among the candidates, with their units."""
    if program.mechanism is None:
        return {}
    joints = {joint.name for joint in program.mechanism.joints}
    units = {c.name: c.unit for c in program.columns}
    return {
        c.display: (c, unit)
        for c in program.candidates
        if owner(c.display) in joints and (unit := units.get(c.display)) in ("rad", "m")
    }
