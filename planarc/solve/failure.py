"""Why a run cannot go on, in words: time, cause, worst equation, fastest states."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from planarc.core.diagnostic import Diagnostic, Related
from planarc.ir.program import EquationInfo, Kernel, Program
from planarc.solve import trouble
from planarc.solve.solvers.integrator import Cause

if TYPE_CHECKING:
    from planarc.solve.run import Run


def constant_not_finite(program: Program, kernel: Kernel) -> str:
    """The first parameter, constant or variable that never changes without a finite value,
    or nothing."""
    # Their slots stand before those of the candidates; a sum tells of all at once.
    end = program.candidates[0].slot if program.candidates else len(kernel.w)
    if math.isfinite(sum(kernel.w[:end])):
        return ""
    for p in program.parameter_slots:
        if not math.isfinite(kernel.w[p.slot]):
            return f"parameter `{p.name}`"
    for c in program.columns:
        if c.constant and not math.isfinite(kernel.w[c.slot]):
            return f"`{c.name}`"
    return ""


def stopped(
    run: Run, t: float, y: Sequence[float], cause: Cause | None, block: int = -1
) -> Diagnostic:
    """The diagnostic for an integrator or equations that cannot go on from `t`."""
    program, kernel = run.program, run.kernel
    if block < 0:
        block = kernel.failed_block
    ydot = [math.nan] * len(y)
    flag = kernel.rhs(t, y, ydot) or kernel.outputs(t, y)
    bad = trouble.first_not_finite(program, kernel) if flag != 0 or not _finite(ydot) else None
    if bad is not None:
        return not_finite(bad, t)
    if flag < 0:
        return Diagnostic(
            "R421",
            f"at t = {t:.6g} s {trouble.without_value(program, kernel)} has no finite value",
            hint="look for a division by something that vanishes",
        )
    if flag == 0 and cause is Cause.NOT_FINITE:
        return Diagnostic(
            "R421",
            f"right after t = {t:.6g} s an equation gives no finite number",
            hint="look for a division by something that vanishes, or the root of a negative "
            "number, beyond this time",
            related=_related(program, kernel, t, block),
        )
    if flag != 0 or cause in _STRETCHING:
        stretched = _stretched(program, kernel, run.selection)
        if stretched >= 0 and (block < 0 or _on_top(program, block) or flag == 0):
            return _block(program, kernel, t, stretched)
    if 0 <= block < len(program.blocks) and (flag != 0 or cause is Cause.BLOCK):
        return _block(program, kernel, t, block)
    names = [program.candidates[i].display for i in run.selection]
    rates = trouble.fastest(names, y, ydot)
    return Diagnostic(
        "R420",
        f"the integration stopped at t = {t:.6g} s: {(cause or Cause.STEP).value}",
        hint=f"the states that moved fastest were {rates}" if rates else None,
        related=_related(program, kernel, t, block),
    )


def _on_top(program: Program, block: int) -> bool:
    return block < len(program.blocks) and program.blocks[block].height == 0


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


def not_finite(info: EquationInfo, t: float) -> Diagnostic:
    return Diagnostic(
        "R421",
        f"at t = {t:.6g} s `{info.text}` gives no finite number",
        info.span,
        hint="look for a division by something that vanishes, or the root of a negative number",
    )


def _block(program: Program, kernel: Kernel, t: float, block: int) -> Diagnostic:
    worst = trouble.worst_equations(program, kernel, t, block)
    parts = list(dict.fromkeys(i.component for _, i in worst if i.component))
    names = trouble.names(parts)
    return Diagnostic(
        "R422",
        f"at t = {t:.6g} s the equations of {names or 'the model'} could not be solved",
        worst[0][1].span if worst else None,
        hint="the mechanism may be stretched or jammed here: look at its position at this time",
        related=tuple(Related(_told(v, i), i.span) for v, i in worst),
    )


def _related(program: Program, kernel: Kernel, t: float, block: int) -> tuple[Related, ...]:
    if not 0 <= block < len(program.blocks):
        return ()
    worst = trouble.worst_equations(program, kernel, t, block)
    return tuple(Related(_told(v, i), i.span) for v, i in worst)


def _told(value: float, info: EquationInfo) -> str:
    if math.isfinite(value):
        return f"`{info.text}` is off by {value:.3g}"
    return f"`{info.text}` is one of them"
