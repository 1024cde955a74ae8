"""Parts that are far larger than their mechanism: mostly a number in other units was given.

In:   Program, a kernel that holds the start
Out:  a warning (R441) for each of the user's parts with such a length, about its first one

Components declare lengths by `annotation(__planarc(size('radius of gyration' = sqrt(I/m))))`. The
mechanism is measured over its frames and all points that components declare, such as centres of
mass. Where these are all in one place there is nothing to compare with.

Example: a rod of 0.4 m and 1 kg with I = 13400, in kg.mm2 as a drawing program tells it, has a
radius of gyration of 116 m.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.evaluate.value import evaluate
from planarc.ir.dae import Declared
from planarc.ir.expr import Expr
from planarc.ir.kernel import Kernel, Taker
from planarc.ir.places import own_part
from planarc.ir.program import Program
from planarc.solve.messages.text import Reader, taker_of
from planarc.solve.once import once

#: Lengths below this one, in m, suit any mechanism: a heavy rotor whose centre is off by little
#: measures next to nothing by its frames.
_PLAUSIBLE = 3.0
#: Multiple of the mechanism's own size that is hardly meant.
_FAR = 20.0

_Large = tuple[tuple[Declared, float], ...]


def judge_sizes(program: Program, kernel: Kernel) -> Iterator[Diagnostic]:
    """The warnings about lengths that do not suit the mechanism."""
    take, known = _judged(program)
    values = () if take is None else take(kernel.w)
    large = known.get(values)
    if large is None or take is None:
        known.clear()
        large = known[values] = tuple(_large(program, kernel))
    extent, told = _extent(program, kernel) if large else 0.0, set[str]()
    for declared, length in large:
        part = own_part(program, declared.component)
        name = part.name if part else declared.component
        if 0 < extent < length / _FAR and name not in told:
            told.add(name)
            yield Diagnostic(
                "R441",
                f"`{name}` has a {declared.name} of {length:.3g} m, in a mechanism of {extent:.3g} "
                "m",
                part.span if part else None,
                Severity.WARNING,
                hint="lengths are in m, masses in kg, inertias in kg.m2: 1 mm is 1e-3 m, and "
                "1 kg.mm2 is 1e-6 kg.m2",
            )


@once
def _judged(program: Program) -> tuple[Taker | None, dict[tuple[float, ...], _Large]]:
    """What takes the parameters of sizes, and which sizes are large by such values."""
    sizes = [d.value for d in program.declared if d.kind == "size" and isinstance(d.value, Expr)]
    return taker_of(program, sizes), {}


def _large(program: Program, kernel: Kernel) -> Iterator[tuple[Declared, float]]:
    read = Reader(program, kernel, 0.0)
    for declared in program.declared:
        if declared.kind == "size" and isinstance(declared.value, Expr):
            length = _value(read, declared.value)
            if length > _PLAUSIBLE:
                yield declared, length


def _extent(program: Program, kernel: Kernel) -> float:
    """The diagonal of the box around all places."""
    columns = {c.name: c for c in program.columns}

    def leaf(e: Expr) -> float:
        column = columns[repr(e)]
        return column.sign * float(kernel.w[column.slot])

    links = program.mechanism.links if program.mechanism is not None else ()
    frames = [f"{frame}.r" for link in links for frame in link.frames]
    places = [
        tuple(column.sign * float(kernel.w[column.slot]) for column in pair)
        for frame in frames
        if (pair := [columns[n] for i in (1, 2) if (n := f"{frame}[{i}]") in columns])
    ]
    for declared in program.declared:
        if declared.kind == "point" and isinstance(declared.value, tuple):
            point = (e for e in declared.value if isinstance(e, Expr))
            places.append(tuple(_value(lambda e: evaluate(e, leaf), e) for e in point))
    sides = [max(along) - min(along) for along in zip(*places, strict=True)]
    return math.hypot(*sides)


def _value(read: Callable[[Expr], float], e: Expr) -> float:
    """Not a number where there is no value."""
    try:
        return float(read(e))
    except (ArithmeticError, ValueError, KeyError):
        return math.nan
