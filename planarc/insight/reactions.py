"""Parts of the user's own that pull or turn others out of nothing, against the third law.

In:   Result
Out:  warnings R443, each at the equation of the torques

The forces of a part without mass balance, and so do its torques about any point: those of its
frames, and those that its forces have by the way from frame to frame. A part whose own equation
says how its torques balance, and whose forces balance in the run, is looked at; others may have
mass, or stand on the ground.

Example: `0 = frame_a.t + frame_b.t` of a rigid link that is 1 m long. Its pendulum turns for ever.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.ir.expr import Expr, Op, postorder
from planarc.ir.once import once
from planarc.ir.places import is_own
from planarc.ir.program import EquationInfo, Program

if TYPE_CHECKING:
    from planarc.insight.values import Values
    from planarc.ir.result import Result

#: Parts of the largest that a sum of forces is, which balances, and one of torques, which does not.
_BALANCED, _UNBALANCED = 1e-6, 1e-2
#: Torques in N.m below which a sum is rounding.
_ROUNDING = 1e-9


def judge_reactions(result: Result) -> Iterator[Diagnostic]:
    """A warning for each part whose torques do not balance though its equation says how."""
    balances = torque_balances(result.program)
    if not balances or len(result.time) < 2:
        return
    from planarc.insight.values import Values

    values = Values(result)
    for info, frames in balances:
        missing = _missing(values, frames)
        if missing > 0.0:
            yield _unbalanced(info, frames, missing)


@once
def torque_balances(program: Program) -> list[tuple[EquationInfo, Sequence[str]]]:
    """The equations that say how the torques of a part of the user's own balance which has several
    frames, each with these."""
    own = [e for e in program.equations if e.component and is_own(program, e.span)]
    if not own:
        return []
    from planarc.insight.connectors import FRAME, find_connectors, grouped, owner

    connectors = find_connectors(c.name for c in program.columns)
    frames = grouped((c for c, pairs in connectors.items() if pairs is FRAME), owner)
    ends = ((e, frames.get(e.component, ())) for e in own)
    return [(e, of) for e, of in ends if len(of) > 1 and _says_how(e.written, of)]


def _says_how(written: str | Iterable[Expr], frames: Sequence[str]) -> bool:
    """Whether an equation is the balance of all torques of these frames, and of nothing else than
    these and their forces."""
    if isinstance(written, str):
        return False
    sides = tuple(written)
    torques = {f"{frame}.t" for frame in frames}
    forces = {f"{frame}.f[{i}]" for frame in frames for i in (1, 2)}
    names = {e.name for e in postorder(sides) if e.is_symbol}
    return torques <= names and all(_is_of(side, torques, forces) for side in sides)


def _is_of(e: Expr, torques: Collection[str], forces: Collection[str]) -> bool:
    """Whether each term is a torque, or has a force for a factor."""
    if e.op is Op.CONST:
        return bool(e.data == 0)
    if e.is_symbol:
        return e.name in torques
    if e.op in (Op.ADD, Op.NEG):
        return all(_is_of(a, torques, forces) for a in e.args)
    return e.op is Op.MUL and any(a.is_symbol and a.name in forces for a in e.args)


def _missing(values: Values, frames: Sequence[str]) -> float:
    """The largest torque in N.m that the frames' forces and torques add up to about a point; 0
    where they balance, or where the forces do not."""
    import numpy as np

    nothing = 0.0 * values.time
    moment, sum_x, sum_y = nothing, nothing, nothing
    turning = pulling = 0.0  # the largest torque and force there are
    x0, y0 = values.pair(frames[0], "r")
    for frame in frames:
        (x, y), (fx, fy) = values.pair(frame, "r"), values.pair(frame, "f")
        lever, torque = (x - x0) * fy - (y - y0) * fx, values.get(f"{frame}.t")
        moment, sum_x, sum_y = moment + lever + torque, sum_x + fx, sum_y + fy
        turning = max(turning, float(np.max(np.abs(lever))), float(np.max(np.abs(torque))))
        pulling = max(pulling, float(np.max(np.hypot(fx, fy))))
    if not np.max(np.hypot(sum_x, sum_y)) <= _BALANCED * pulling:
        return 0.0
    missing = float(np.max(np.abs(moment)))
    return missing if missing > max(_UNBALANCED * turning, _ROUNDING) else 0.0


def _unbalanced(info: EquationInfo, frames: Sequence[str], missing: float) -> Diagnostic:
    first, second = (frame.rpartition(".")[2] for frame in frames[:2])
    return Diagnostic(
        "R443",
        f"`{info.component}` turns what it joins out of nothing, with up to {missing:.3g} N.m: its "
        "forces add up to 0, its torques about a point do not",
        info.span,
        Severity.WARNING,
        hint=f"with `d = {second}.r - {first}.r`, the torques of a part without mass are "
        f"`0 = {first}.t + {second}.t + d[1]*{second}.f[2] - d[2]*{second}.f[1]`",
    )
