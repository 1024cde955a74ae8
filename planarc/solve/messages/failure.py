"""Why a run cannot go on, in words: time, cause, worst equation, fastest states."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Exhausted
from planarc.ir.kernel import Kernel
from planarc.ir.mechanism import SPEEDS
from planarc.ir.places import owner, point_home
from planarc.ir.program import EquationInfo, Program
from planarc.solve import effort
from planarc.solve.messages import trouble
from planarc.solve.messages.assertion import broken_assertion
from planarc.solve.messages.hollows import too_big
from planarc.solve.messages.jammed import jammed
from planarc.solve.messages.loops import (
    given_in_loop,
    is_closed,
    joints_of,
    loop_names,
)
from planarc.solve.solvers.integrator import Cause


class Scene(Data):
    """All that is known of a run when it cannot go on."""

    program: Program
    kernel: Kernel
    selection: Sequence[int]  # the candidates that are states
    span: float  # of the run, in seconds
    errors: Sequence[float]  # of each state in the last step, as a part of its tolerance
    row: Mapping[int, float]  # the last one, by slot
    row_time: float = -math.inf  # that of the last row
    way: float | None = None  # seconds that the last `STRETCH` steps went, where they creep


def stopped(
    scene: Scene, t: float, y: Sequence[float], cause: Cause | None, block: int = -1
) -> Diagnostic:
    """The diagnostic for an integrator or equations that cannot go on from `t`."""
    program, kernel = scene.program, scene.kernel
    if block < 0:
        block = kernel.failed_block
    ydot = [math.nan] * len(y)
    flag = kernel.rhs(t, y, ydot) or _flag(scene, t, y) or (0 if _finite(ydot) else -1)
    place = Place(t, "at", _fastest(scene, y, ydot if flag == 0 else ()))
    if flag < 0 and (first := _first_without(scene, t, y)) is not None:
        flag, t = first
        block, place = kernel.failed_block, replace(place, t=t)
    if flag == 0:
        stretched = _stretched(program, kernel, scene.selection) if cause in _STRETCHING else -1
        if stretched >= 0:
            return _block(program, kernel, place, stretched, row=scene.row)
        worst = _worst(scene, y, ydot)
        beyond = _beyond(scene, t, y, ydot, FAR_BEYOND if cause in _OF_VALUES else BEYOND)
        if beyond is not None:
            flag, t = beyond
            block, place = kernel.failed_block, replace(place, when="right after")
        elif cause is not Cause.BLOCK or block < 0:
            # Rates of a driven loop grow beyond all bounds where it reaches no farther.
            if cause is Cause.POLE and (jammed := _jammed_loop(scene, ydot)) >= 0:
                return _block(program, kernel, place, jammed, row=scene.row)
            if scene.way is not None:
                return _creeps(program, place, scene.way, scene.span, worst)
            away = max(trouble.paces(y, ydot), default=0.0) * scene.span
            return _given_up(program, place, cause or Cause.STEP, worst, away > _RUNAWAY)
    if flag < 0:
        return not_finite(program, kernel, place, t)
    stretched = _stretched(program, kernel, scene.selection)
    on_top = 0 <= block < len(program.blocks) and program.blocks[block].height == 0
    block = stretched if stretched >= 0 and on_top else block
    return _block(program, kernel, place, block, t, scene.row)


def _jammed_loop(scene: Scene, ydot: Sequence[float]) -> int:
    """The block of a driven loop of which the fastest state is a coordinate; else -1."""
    state = max(zip(map(abs, ydot), scene.selection, strict=True), default=(0.0, -1))[1]
    for number, code in enumerate(scene.program.blocks):
        if code.height and code.residuals and code.first <= state < code.first + len(code.tears):
            parts = _parts_of_loop(scene.program, number)
            return number if given_in_loop(scene.program, scene.kernel, parts, SPEEDS) else -1
    return -1


def _first_without(scene: Scene, t: float, y: Sequence[float]) -> tuple[int, float] | None:
    """The kernel's flag at the first point without values on the straight way from the last row,
    which has some, to `y`, and its time; None where it is not known. The workspace is left
    there."""
    candidates = [scene.program.candidates[i] for i in scene.selection]
    if not scene.row_time < t or any(c.slot not in scene.row for c in candidates):
        return None
    begin = [scene.row[c.slot] for c in candidates]

    def flag_at(part: float) -> int:
        point = [a + part * (b - a) for a, b in zip(begin, y, strict=True)]
        return _flag(scene, scene.row_time + part * (t - scene.row_time), point)

    if flag_at(0.0) != 0:
        return None
    flag, part = _narrowed(flag_at, 0.0, 1.0)
    return flag, scene.row_time + part * (t - scene.row_time)


def _narrowed(flag_at: Callable[[float], int], good: float, bad: float) -> tuple[int, float]:
    """The flag at the first place that has no values, and that place, between one that has some
    and one that has none."""
    for _ in range(_HALVINGS):
        middle = (good + bad) / 2
        good, bad = (good, middle) if flag_at(middle) != 0 else (middle, bad)
    return flag_at(bad), bad


def _flag(scene: Scene, t: float, y: Sequence[float]) -> int:
    """The kernel's flag of all that rows and events need."""
    zeros = [0.0] * len(scene.program.relations)
    return scene.kernel.outputs(t, y) or scene.kernel.roots(t, y, zeros)


class Place(Data):
    """The time at which it happened, and the states that moved fastest then."""

    t: float
    when: str = "at"
    fastest: str = ""

    def __str__(self) -> str:
        return f"{self.when} t = {self.t:.6g} s"

    def hint(self, advice: str = "") -> str | None:
        """The hint, with advice, if there is any."""
        told = f"the states that moved fastest were {self.fastest}" if self.fastest else ""
        return "; ".join(part for part in (advice, told) if part) or None


# What is worst --------------------------------------------------------------------------------


def _fastest(scene: Scene, y: Sequence[float], ydot: Sequence[float]) -> str:
    """The fastest states by the derivatives here, or where there are none, by the last row."""
    candidates, row = [scene.program.candidates[i] for i in scene.selection], scene.row
    if not ydot:
        candidates = [c for c in candidates if c.slot in row and c.derivative in row]
        y = [row[c.slot] for c in candidates]
        ydot = [row[c.derivative] for c in candidates]
    return trouble.fastest([c.display for c in candidates], y, ydot)


def _worst(
    scene: Scene, y: Sequence[float], ydot: Sequence[float]
) -> tuple[str, EquationInfo] | None:
    """The state with the largest error, or the fastest, and the equation that moves it."""
    if not y:
        return None
    sizes = [abs(e) for e in scene.errors]
    if len(sizes) != len(y) or not _finite(sizes) or not any(sizes):
        sizes = trouble.paces(y, ydot)
    candidates = scene.program.candidates
    state = scene.selection[sizes.index(max(sizes))]
    slot = candidates[state].derivative
    higher = {c.slot: c.derivative for c in candidates}
    while slot in higher:  # of an angle it is not w = der(phi) that is wrong
        slot = higher[slot]
    found = candidates[state]
    info = trouble.determining(scene.program, scene.kernel, slot)
    return found.display, info or EquationInfo("", found.span, owner(found.display))


#: How far beyond the last point what cannot be evaluated is looked for, as a part of the
#: run, in general and where the integrator says that it met such a point.
BEYOND, FAR_BEYOND = 1e-6, 1e-1
_OF_VALUES = (Cause.NOT_FINITE, Cause.BLOCK)
#: Halvings of the way from a point that has values to one that has none.
_HALVINGS = 24
#: States may move so far on the way, relative to their size.
_WAY = 1e-2


def _beyond(
    scene: Scene, t: float, y: Sequence[float], ydot: Sequence[float], furthest: float
) -> tuple[int, float] | None:
    """The kernel's flag at the first point beyond, along the motion, that cannot be
    evaluated, and its time. The workspace is left there."""
    room = max((pace for pace in trouble.paces(y, ydot)), default=0.0)
    kernel, scratch = scene.kernel, [0.0] * len(y)

    def flag_at(h: float) -> int:
        moved = [a + h * d for a, d in zip(y, ydot, strict=True)]
        flag = kernel.rhs(t + h, moved, scratch) or _flag(scene, t + h, moved)
        return flag or (0 if _finite(scratch) else -1)

    good, h = 0.0, 1e-15 * scene.span
    while h <= furthest * scene.span and h * room <= _WAY:
        if flag_at(h) != 0:
            flag, h = _narrowed(flag_at, good, h)
            return flag, t + h
        good, h = h, 4 * h
    return None


#: What becomes of an integrator where unknowns are hardly determined any more.
_STRETCHING = (Cause.BLOCK, Cause.CONVERGENCE, Cause.ERROR_TEST)


def _stretched(program: Program, kernel: Kernel, selection: Sequence[int]) -> int:
    """A block of constraints that hardly determine their unknowns, or -1.

    In such a position accelerations and forces have no value, and the block of these is
    the one that fails; what the user can do something about is the mechanism.
    """
    import numpy as np

    for i, block in enumerate(program.blocks):
        if block.height > 0 and block.residuals:
            g = np.array(kernel.jacobian(i), dtype=float)
            if np.all(np.isfinite(g)):
                solved = [j for j in range(len(block.tears)) if block.first + j not in selection]
                least = np.linalg.svd(g[:, solved], compute_uv=False)[-1]
                if least < 1e-2 * np.linalg.svd(g, compute_uv=False)[0]:
                    return i
    return -1


def _finite(values: Sequence[float]) -> bool:
    return all(map(math.isfinite, values))


# Messages -------------------------------------------------------------------------------------


def _given_up(
    program: Program,
    place: Place,
    cause: Cause,
    worst: tuple[str, EquationInfo] | None,
    runs_away: bool,
) -> Diagnostic:
    """The integrator found no step, though everything has a value."""
    message = f"the integration stopped {place}: {cause.value}{_moved_by(worst)}"
    code = "R421" if cause is Cause.NOT_FINITE else "R420"
    advice = ""
    if runs_away and worst:
        way = "keep what is divided by away from 0" if "/" in worst[1].text else "bound its growth"
        advice = f"`{worst[0]}` grows beyond all bounds here, a pole: end the run before, or {way}"
    found = Exhausted(code, message, worst[1].span if worst else None, hint=place.hint(advice))
    return point_home(program, found, worst[1].component if worst else "")


#: A state that moves by so many times its size in a run of this rate has a pole.
_RUNAWAY = 1e6


def _creeps(
    program: Program, place: Place, way: float, span: float, worst: tuple[str, EquationInfo] | None
) -> Diagnostic:
    """The integrator goes on, but a stretch of steps brings the run forward by next to nothing."""
    gone = max(way, 0.0)
    message = f"the integration stopped {place}: {effort.STRETCH:,} steps bring the run forward by "
    message += f"{gone:.3g} s of {span:g} s"
    if gone > 0:
        message += f": it would take {effort.STRETCH * span / gone:.0e} steps".replace("e+", "e")
    advice = (
        "ask for a shorter run or a larger `--tolerance`; slow down what is fast, or make "
        "smooth what jumps"
    )
    where = worst[1].span if worst else None
    found = Exhausted("R426", message + _moved_by(worst), where, hint=place.hint(advice))
    return point_home(program, found, worst[1].component if worst else "")


def _moved_by(worst: tuple[str, EquationInfo] | None) -> str:
    if worst is None:
        return ""
    by = f", which `{worst[1].text}` moves" if worst[1].text else ""
    return f"; `{worst[0]}` was worst{by}"


def not_finite(program: Program, kernel: Kernel, place: Place, t: float) -> Diagnostic:
    """The message about a value that is not finite at the workspace's point, of time `t`."""
    info = trouble.first_not_finite(program, kernel, t)
    advice = trouble.advice_of_values(info.text if info else "")
    if info is not None and info.ticks:
        advice += ", or for equations at this tick that no values fit"
    if info is None:
        name = trouble.without_value(program, kernel)
        return Diagnostic("R421", f"{place} {name} has no finite value", hint=place.hint(advice))
    said = broken_assertion(program, kernel, t, info.component)
    if said is not None:
        return said
    message = f"{place} `{info.text}` gives no finite number"
    found = Diagnostic("R421", message, info.span, hint=place.hint(advice))
    return point_home(program, found, info.component)


def _block(
    program: Program,
    kernel: Kernel,
    place: Place,
    block: int,
    t: float | None = None,
    row: Mapping[int, float] | None = None,
) -> Diagnostic:
    """A block without solution at the workspace's point, of time `t`, after the last row."""
    worst = []
    if 0 <= block < len(program.blocks):
        worst = trouble.worst_equations(program, kernel, place.t if t is None else t, block)
    infos = [i for _, i in worst]
    subject = trouble.subject(trouble.components(program, infos), infos)
    around = _loop_around(program, block)
    if around:
        subject = f"the equations of the loop of {around}"
    advice = "these equations may have no solution from here on: look for what comes to its end"
    if program.mechanism is not None:
        advice = "the mechanism may be stretched or jammed here: look at its position at this time"
    found = trouble.Unsolved(
        "R422",
        f"{place} {subject} could not be solved",
        worst[0][1].span if worst else None,
        hint=place.hint(advice),
        related=trouble.related(worst),
    )
    loop = _driven_loop(program, block)
    contacts = [i.component for i in infos]
    hollow = too_big(program, kernel, (*contacts, *_parts_of_loop(program, block)), row or {})
    if loop:
        message = f"{place} the loop of {loop} cannot be closed"
        advice = (
            "what drives it asks for a position that its parts do not reach: end the run before, "
        )
        advice += "or change lengths or the motion"
        given = given_in_loop(program, kernel, _joints_of(program, block))
        message += f" with {given}" if given else ""
        found = replace(found, message=message, hint=advice)
    elif around and program.blocks[block].height:
        parts = _parts_of_loop(program, block)
        if speed := given_in_loop(program, kernel, parts, SPEEDS):
            message = f"{place} the loop of {around} cannot be closed any further with {speed}"
            found = replace(found, message=message)
            found = jammed(found, program, kernel, parts)
    if hollow:
        found = replace(found, hint=hollow)
    return point_home(program, found, worst[0][1].component if worst else "")


def unsolved_block(program: Program, block: int) -> str:
    """What is known of a block without solution before any run: the loop that it closes."""
    if loop := _driven_loop(program, block):
        return f"the loop of {loop} cannot be closed"
    around = _loop_around(program, block)
    subject = f"the equations of the loop of {around}" if around else "the equations"
    return f"{subject} could not be solved"


def _loop_around(program: Program, block: int) -> str:
    """The loop, in words, in which the equations of a block stand; nothing where it is in none."""
    parts = _parts_of_loop(program, block)
    return loop_names(program, parts) if is_closed(program, parts) else ""


def _parts_of_loop(program: Program, block: int) -> list[str]:
    """The components whose equations stand in a block, or joints of theirs that close a loop."""
    if not 0 <= block < len(program.blocks):
        return []
    equations = program.blocks[block].equations
    parts = list(dict.fromkeys(program.equations[e].component for e in equations))
    return parts if is_closed(program, parts) else joints_of(program, parts)


def _driven_loop(program: Program, block: int) -> str:
    """The loop, in words, whose conditions a block holds, if no coordinate of it is free."""
    code = program.blocks[block] if 0 <= block < len(program.blocks) else None
    if code is None or not code.height or code.free:
        return ""
    parts = _joints_of(program, block)
    return loop_names(program, parts) if is_closed(program, parts) else ""


def _joints_of(program: Program, block: int) -> list[str]:
    """The components whose coordinates a block of conditions is solved for."""
    code = program.blocks[block]
    tears = program.candidates[code.first : code.first + len(code.tears)]
    return [owner(c.display) for c in tears]
