"""What messages of a run are made of: lists of names, the worst equation, the fastest state."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from planarc.core.diagnostic import Diagnostic, Related
from planarc.core.prose import listed
from planarc.ir.kernel import Kernel
from planarc.ir.places import own_names
from planarc.ir.program import (
    EquationInfo,
    Let,
    Program,
    Solve,
    Statement,
)

_MOST_NAMES = 6


class Unsolved(Diagnostic):
    """A block that has no solution."""


def names(items: Sequence[str]) -> str:
    """Names in backticks; of many only the first few."""
    shown = [f"`{n}`" for n in items[:_MOST_NAMES]]
    if len(items) > _MOST_NAMES:
        shown.append(f"{len(items) - _MOST_NAMES} more")
    return listed(shown)


def components(program: Program, infos: Sequence[EquationInfo]) -> str:
    """The components in which equations stand, as the user knows them."""
    return names(own_names(program, (i.component for i in infos if i.component)))


def subject(names: str, infos: Sequence[EquationInfo]) -> str:
    """What could not be solved: the equations of components, else the one that is worst."""
    if names or not infos:
        return f"the equations of {names or 'the model'}"
    return f"`{infos[0].text}`"


#: An equation that is off by less is as good as met with the values from before.
_MET = 1e-6


def is_off(value: float) -> bool:
    return math.isfinite(value) and abs(value) > _MET


def related(worst: Sequence[tuple[float, EquationInfo]]) -> tuple[Related, ...]:
    """The worst of several equations, and a single one that is off, with their places."""
    return tuple(Related(told(v, i), i.span) for v, i in worst if len(worst) > 1 or is_off(v))


def told(value: float, info: EquationInfo) -> str:
    if is_off(value):
        return f"`{info.text}` is off by {value:.3g}"
    return f"`{info.text}` is one of them"


def values(items: Sequence[tuple[str, float]]) -> str:
    """Names with their values in backticks; of many only the first few."""
    shown = [f"`{n}` = {v:.4g}" for n, v in items[:_MOST_NAMES]]
    if len(items) > _MOST_NAMES:
        shown.append(f"{len(items) - _MOST_NAMES} more")
    return listed(shown)


def first_not_finite(program: Program, kernel: Kernel, t: float) -> EquationInfo | None:
    """The equation that the kernel says failed, or the first one, in the order of
    evaluation, that gives no finite number; or a relation with such a side."""
    from planarc.solve.messages.replay import Replay

    replay, told = Replay(program, kernel, t), kernel.failed_equation
    found = replay.first_not_finite()
    # A kernel that had not come so far takes what is not stored yet for what failed.
    is_stale = kernel.failed_block < 0 <= found and told in replay.finite
    if told >= 0 and not is_stale:
        return program.equations[told]
    if found >= 0:
        return program.equations[found]
    relation = replay.first_relation()
    if relation is None:
        return None
    return EquationInfo(relation.text, relation.span, relation.component)


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
    infos = [program.equations[e] for e in program.blocks[block].equations]
    from planarc.solve.messages.replay import Replay

    pairs = list(zip(Replay(program, kernel, t).residuals(block), infos, strict=False))
    return sorted(pairs, key=lambda p: -abs(p[0]) if math.isfinite(p[0]) else -math.inf)[:most]


def determining(program: Program, kernel: Kernel, slot: int) -> EquationInfo | None:
    """The equation that gives a value: its assignment, or the equation of the block it is
    solved in that depends on it most, compared with what else that one depends on."""
    told = (program.parameters, *program.levels, program.rest)  # the last: for results only
    for statement in (s for level in told for s in level):
        lets: Sequence[Statement] = (statement,)
        if isinstance(statement, Solve):
            code = program.blocks[statement.block]
            tears = [program.slots[repr(tear)] for tear in code.tears]
            if slot in tears and code.equations:
                rows = kernel.jacobian(statement.block)
                shares = [_share(row, tears.index(slot)) for row in rows]
                return program.equations[code.equations[shares.index(max(shares))]]
            lets = code.body
        for let in lets:
            if not isinstance(let, Let) or let.equation is None:
                continue
            if program.slots.get(repr(let.target)) == slot:
                return program.equations[let.equation]
    return None


def _share(row: Sequence[float], k: int) -> float:
    whole = sum(map(abs, row))
    return abs(row[k]) / whole if math.isfinite(whole) and whole > 0 else 0.0


def fastest(
    names_of_states: Sequence[str], y: Sequence[float], ydot: Sequence[float], most: int = 3
) -> str:
    """The states that change most quickly, measured by their own size."""
    speed = paces(y, ydot)
    order = [i for i in sorted(range(len(speed)), key=lambda i: -speed[i]) if speed[i] > 0]
    return listed(f"`{names_of_states[i]}` (rate {ydot[i]:.3g})" for i in order[:most])


def paces(y: Sequence[float], ydot: Sequence[float]) -> list[float]:
    """How quickly each state changes, measured by its own size; without a value, infinitely."""
    speeds = (abs(d) / max(1.0, abs(v)) for v, d in zip(y, ydot, strict=True))
    return [math.inf if math.isnan(s) else s for s in speeds]


def advice_of_values(equation: str) -> str:
    """What may have no value in an equation, by the functions that it calls."""
    functions = {
        r"\b(acos|asin)\(": "a sine or cosine beyond -1 to 1",
        r"\b(log|log10)\(": "the logarithm of what is not positive",
        r"\bsqrt\(": "the root of a negative number",
        r"\^": "a power of a negative number",
        r"/": "a division by something that vanishes",
    }
    found = [what for form, what in functions.items() if re.search(form, equation)]
    all_ = ("a division by something that vanishes", "the root of a negative number")
    return f"look for {listed(found or all_, 'or')}"
