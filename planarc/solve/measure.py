"""The measure of lengths that suits a mechanism: 1 m, or one of its own where it is far smaller or
far larger.

In:   Program, a kernel that holds the parameters
Out:  the measure in m, a power of 2; and by which power of it a quantity is measured

What is compared with a radian at the start, and what an error of a run is measured by, must not
depend on the unit of length: the same mechanism in another size begins in the same way. So all
that has to do with lengths is measured by L^n, where m^n is in its unit: positions and their
derivatives by L, forces too, as masses and times are not measured otherwise. A mechanism is as long
as the longest of the lengths that stand in the slopes of its loops: of cranks and rods, but not the
places of bearings, nor what is far longer than most, as the radius of a curve that is nearly
straight. Where its loops differ the one nearest to 1 m counts, so that none is lost beside another.

Example: a four-bar whose longest bar has 2e-6 m is measured by 2^-19 m, which makes that 1.05.

Promises:  the measure is 1 m for every mechanism of `SHORTEST` to `LONGEST`, and a power of 2 for
           others: numbers are measured without rounding.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from itertools import chain
from typing import TYPE_CHECKING

from planarc.core.unit import parse
from planarc.ir.expr import Expr, Op, postorder
from planarc.ir.kernel import Kernel, Taker, taker
from planarc.ir.once import once
from planarc.ir.program import BlockCode, Let, Program
from planarc.ir.sparse import entries_of
from planarc.runtime.elementary import TABLE, Units

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

#: Lengths of loops, in m, that are measured in m.
SHORTEST, LONGEST = 0.125, 4.0
#: Multiple of the median of a loop's lengths up to which a length counts.
BEYOND = 100.0
#: Functions whose values are measured as their arguments are, or by a root of that.
_OF_ARGUMENTS = (Units.KEPT, Units.SAME, Units.ROOT)


def length_of(program: Program, kernel: Kernel) -> float:
    """The measure of lengths, in m."""
    take, counts = _lengths(program)
    values, longest, first = list(map(abs, take(kernel.w))), list[float](), 0
    for count in counts:
        own = sorted(v for v in values[first : first + count] if 0.0 < v < math.inf)
        first += count
        if own:
            most = BEYOND * own[(len(own) - 1) // 2]
            longest.append(max(v for v in own if v <= most))
    if not longest:
        return 1.0
    length = min(max(min(longest), 1.0), max(longest))
    suits = SHORTEST <= length <= LONGEST
    return 1.0 if suits else math.ldexp(1.0, round(math.log2(length)))


def sizes_of_slots(program: Program, length: float, slots: Iterable[int]) -> list[float]:
    """The sizes by which the values of some slots are measured."""
    if length == 1.0:
        return [1.0 for _ in slots]
    powers = _powers_of_slots(program)
    return [length ** powers.get(slot, 0.0) for slot in slots]


def sizes_of_errors(program: Program, length: float, slots: Iterable[int]) -> list[float]:
    """Those by which errors of states are measured: of positions and their derivatives. A voltage
    has m2 in its unit, and is no smaller beside a small mechanism."""
    ways = _ways(program) if length != 1.0 else frozenset[int]()
    return [length if slot in ways else 1.0 for slot in slots]


def sizes_of_candidates(program: Program, length: float) -> Vector:
    import numpy as np

    if length == 1.0:
        return np.ones(len(program.candidates))
    return np.array(sizes_of_slots(program, length, (c.slot for c in program.candidates)))


def sizes_of_rows(program: Program, length: float) -> Vector:
    """Those of the residuals of blocks below the top, then of the initial equations."""
    import numpy as np

    if length == 1.0:
        below = sum(len(b.residuals) for b in program.blocks if b.height > 0)
        return np.ones(below + len(program.initial_residuals))
    return np.array([length**power for power in _powers_of_rows(program)])


# Lengths


@once
def _lengths(program: Program) -> tuple[Taker, tuple[int, ...]]:
    """What takes the lengths that stand in the conditions of loops, and how many of each block."""
    metre = parse("m")
    slots = {p.name: p.slot for p in program.parameter_slots if parse(p.unit) == metre}
    given = {repr(s.target): s.value for s in program.parameters if isinstance(s, Let)}
    tops = _tops(program)
    found = [_own_lengths(b, given, slots) for b in tops]
    return taker([slot for own in found for slot in own]), tuple(map(len, found))


def _tops(program: Program) -> Iterator[BlockCode]:
    """The blocks of positions that hold conditions."""
    candidates = program.candidates
    rates = {c.derivative for c in candidates}
    for block in program.blocks:
        if block.height > 0 and block.residuals:
            own = candidates[block.first : block.first + len(block.tears)]
            if rates.isdisjoint(c.slot for c in own):
                yield block


def _own_lengths(
    block: BlockCode, given: Mapping[str, Expr], slots: Mapping[str, int]
) -> list[int]:
    """The slots of the lengths in the slopes of a block; where there are none, in its residuals."""
    own = {repr(let.target): let.value for let in (*block.body, *block.jacobian_body)}
    slopes = [e for *_, e in block.jacobian]
    slopes += [] if block.direct is None else entries_of(block.direct)
    slopes += [] if slopes else [let.value for let in block.jacobian_body]
    for begin in (slopes, list(block.residuals)):
        names = _reached(begin, {**given, **own}, slots)
        if names:
            return [slots[name] for name in names]
    return []


def _reached(begin: list[Expr], given: Mapping[str, Expr], ends: Mapping[str, int]) -> list[str]:
    """The names among `ends` from which expressions follow."""
    found, waiting = dict[str, None](), list(begin)
    while waiting:
        for e in postorder((waiting.pop(),)):
            name = "" if e.args else repr(e)
            if name and name not in found:
                found[name] = None
                if name in given and name not in ends:
                    waiting.append(given[name])
    return [name for name in found if name in ends]


# Powers


def _power(unit: str) -> float | None:
    """The power of m in a unit; None where it is not known."""
    dimension = parse(unit)
    return None if dimension is None else float(dimension[0])


@once
def _powers_of_slots(program: Program) -> dict[int, float]:
    known = _known(program)
    found = {c.slot: known[c.name] for c in program.columns if c.name in known}
    for c in program.candidates:
        if c.slot in found:
            found.setdefault(c.derivative, found[c.slot])
    return found


@once
def _ways(program: Program) -> frozenset[int]:
    """The slots of what is in m, m/s and so on."""
    found = ((c.slot, parse(c.unit)) for c in program.columns)
    return frozenset(slot for slot, d in found if d and d[0] == 1 and not any((d[1], *d[3:])))


@once
def _powers_of_rows(program: Program) -> list[float]:
    known, blocks = _known(program), [b for b in program.blocks if b.height > 0]
    rows = [power for b in blocks for power in _rows_of_block(program, b, known)]
    return [*rows, *(_power_of(e, known) or 0.0 for e in program.initial_residuals)]


@once
def _known(program: Program) -> Mapping[str, float]:
    """The powers of variables by their names: those in their units, else what follows for them."""
    known = {c.name: n for c in program.columns if (n := _power(c.unit)) is not None}
    known |= {p.name: n for p in program.parameter_slots if (n := _power(p.unit)) is not None}
    bodies = ((*b.body, *b.jacobian_body) for b in program.blocks if b.height > 0)
    statements = program.parameters, *program.levels, *bodies, program.rest, program.initial
    for let in chain.from_iterable(statements):
        if isinstance(let, Let) and (power := _power_of(let.value, known)) is not None:
            known.setdefault(let.target.name, power)
    return known


def _rows_of_block(
    program: Program, block: BlockCode, known: Mapping[str, float]
) -> Iterator[float]:
    """By the residuals, which say nothing where their constant parts are zero; then by the slopes,
    or by the equations as they are written."""
    slopes: dict[int, list[float]] = {}
    for i, j, slope in block.jacobian:
        power, own = _power_of(slope, known), _power_of(block.tears[j], known)
        if power is not None or own is not None:
            slopes.setdefault(i, []).append((power or 0.0) + (own or 0.0))
    for i, (residual, number) in enumerate(zip(block.residuals, block.equations, strict=True)):
        written = program.equations[number].written
        sides = () if isinstance(written, str) else written
        told = (_power_of(e, known) for e in (residual, *sides))
        powers = [power for power in told if power is not None] + slopes.get(i, [])
        yield powers[0] if powers else 0.0


def _power_of(e: Expr, known: Mapping[str, float]) -> float | None:
    """The power of m by which an expression is measured; None of what fits beside any, as 0."""
    found = dict[Expr, float | None]()
    for node in postorder((e,)):
        found[node] = _power_by_parts(node, [found[a] for a in node.args], known)
    return found[e]


def _power_by_parts(e: Expr, parts: list[float | None], known: Mapping[str, float]) -> float | None:
    told = [p for p in parts if p is not None]
    match e.op:
        case Op.SYMBOL | Op.PRE:
            return known.get(e.name)
        case Op.ADD | Op.NEG:
            return told[0] if told else None
        case Op.IF:
            return next((p for p in parts[1:] if p is not None), None)
        case Op.MUL:
            return sum(told) if told else None
        case Op.DIV:
            return (parts[0] or 0.0) - (parts[1] or 0.0) if told else None
        case Op.POW:
            exponent = e.args[1]
            power = float(exponent.data) if exponent.is_const else 1.0
            return None if parts[0] is None else parts[0] * power
        case Op.CALL:
            units = TABLE[e.data].units
            part = 0.5 if units is Units.ROOT else 1.0
            return told[0] * part if told and units in _OF_ARGUMENTS else 0.0
    return None
