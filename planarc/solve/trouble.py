"""What messages of a run are made of: lists of names, the worst equation, the fastest state."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from planarc.ir.program import EquationInfo, Kernel, Let, Program, Solve

_MOST_NAMES = 6


def listed(parts: Iterable[str]) -> str:
    """`a`, `a and b`, `a, b and c`."""
    *first, last = list(parts) or [""]
    return f"{', '.join(first)} and {last}" if first else last


def names(items: Sequence[str]) -> str:
    """Names in backticks; of many only the first few."""
    shown = [f"`{n}`" for n in items[:_MOST_NAMES]]
    if len(items) > _MOST_NAMES:
        shown.append(f"{len(items) - _MOST_NAMES} more")
    return listed(shown)


def first_not_finite(program: Program, kernel: Kernel) -> EquationInfo | None:
    """The equation that the kernel says failed, or the first one, in the order of
    evaluation, whose unknown has no finite value."""
    if kernel.failed_equation >= 0:
        return program.equations[kernel.failed_equation]
    for level in (*program.levels, program.rest):
        for statement in level:
            inner = program.blocks[statement.block].body if isinstance(statement, Solve) else ()
            for let in (statement,) if isinstance(statement, Let) else inner:
                slot = program.slots.get(repr(let.target))
                if slot is None or let.equation is None:
                    continue
                if not math.isfinite(kernel.w[slot]):
                    return program.equations[let.equation]
    return None


def without_value(program: Program, kernel: Kernel) -> str:
    """The first variable or parameter of the result that is not finite."""
    for c in program.columns:
        if not math.isfinite(kernel.w[c.slot]):
            return f"`{c.name}`"
    return "an expression of parameters"


def worst_equations(
    program: Program, kernel: Kernel, t: float, block: int, most: int = 3
) -> list[tuple[float, EquationInfo]]:
    """The equations of a block with their residuals at the workspace's values, worst first."""
    code = program.blocks[block]
    infos = [program.equations[e] for e in code.equations]
    if code.height == 0:
        return [(math.nan, info) for info in infos[:most]]
    below = [b for b in program.blocks if b.height > 0]
    r = [0.0] * (sum(len(b.residuals) for b in below) + len(program.initial_residuals))
    kernel.residuals(t, [kernel.w[c.slot] for c in program.candidates], r or [0.0])
    first = sum(len(b.residuals) for b in program.blocks[:block] if b.height > 0)
    pairs = list(zip(r[first : first + len(infos)], infos, strict=False))
    return sorted(pairs, key=lambda p: -abs(p[0]) if math.isfinite(p[0]) else -math.inf)[:most]


def fastest(
    names_of_states: Sequence[str], y: Sequence[float], ydot: Sequence[float], most: int = 3
) -> str:
    """The states that change most quickly, measured by their own size."""
    speed = [abs(d) / max(1.0, abs(v)) for v, d in zip(y, ydot, strict=True)]
    order = sorted(range(len(speed)), key=lambda i: (not math.isnan(speed[i]), -speed[i]))
    return listed(f"`{names_of_states[i]}` (rate {ydot[i]:.3g})" for i in order[:most])
