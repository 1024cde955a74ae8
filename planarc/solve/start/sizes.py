"""Parts that are far larger than their mechanism: mostly a number in other units was given.

In:   Program, a kernel that holds the start
Out:  a warning (R441) for each of the user's parts with such a length, about its first one

Components declare lengths by `annotation(__planarc(size('radius of gyration' = sqrt(I/m))))`. The
mechanism is measured over its frames and all points that components declare, such as centres of
mass. Where these are all in one place there is nothing to compare with. A spring says how long it
is at the start, too: `size('length without load'(of = s) = L)`.

Example: a rod of 0.4 m and 1 kg with I = 13400, in kg.mm2 as a drawing program tells it, has a
radius of gyration of 116 m.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping

from planarc.core.diagnostic import Diagnostic, Oversized, Severity
from planarc.evaluate.value import evaluate
from planarc.ir.dae import WHEEL, Declared
from planarc.ir.expr import Expr
from planarc.ir.kernel import Kernel, Taker
from planarc.ir.once import once
from planarc.ir.places import own_part
from planarc.ir.program import Column, Program
from planarc.solve.messages.text import taker_of

#: Lengths below this one, in m, suit any mechanism: a heavy rotor whose centre is off by little
#: measures next to nothing by its frames.
_PLAUSIBLE = 3.0
#: What a part with mass declares of its inertia begins so.
RADIUS = "radius of gyration"
#: Multiple of the mechanism's own size that is hardly meant.
_FAR = 20.0
#: The same of a radius of gyration: that of a part is hardly larger than what carries it.
_WIDE = 5.0
#: Multiple of its length without load to which hardly anything is stretched at the start.
_STRETCHED = 100.0

_OF = ".of"
#: Declarations with their values: those that are large, and those of what is stretched far.
_Found = tuple[tuple[tuple[Declared, float], ...], tuple[tuple[Declared, float, float], ...]]


def judge_sizes(program: Program, kernel: Kernel) -> Iterator[Diagnostic]:
    """The warnings about lengths that do not suit the mechanism."""
    take, known = _judged(program)
    values = () if take is None else take(kernel.w)
    found = known.get(values)
    if found is None or take is None:
        known.clear()
        found = known[values] = _find(program, kernel)
    if found != ((), ()):
        yield from _told(program, kernel, *found)


def _told(
    program: Program,
    kernel: Kernel,
    large: Iterable[tuple[Declared, float]],
    stretched: Iterable[tuple[Declared, float, float]],
) -> Iterator[Diagnostic]:
    extent, told = _extent(program, kernel), set[str]()
    messages = [
        (d, f"has a {d.name} of {length:.3g} m, in a mechanism of {extent:.3g} m")
        for d, length in large
        if 0 < extent < length / (_WIDE if d.name.startswith(RADIUS) else _FAR)
    ]
    messages += [
        (d, f"is {now:.3g} m long at the start, {now / length:.3g} times its {d.name}")
        for d, length, now in stretched
    ]
    for declared, message in messages:
        part = own_part(program, declared.component)
        name = part.name if part else declared.component
        if name not in told:
            told.add(name)
            yield Oversized(
                "R441",
                f"`{name}` {message}",
                part.span if part else None,
                Severity.WARNING,
                hint="masses are in kg, inertias in kg.m2: 1 kg.cm2 is 1e-4 kg.m2, and 1 kg.mm2 "
                "is 1e-6"
                if declared.name.startswith(RADIUS)
                else "lengths are in m: 1 mm is 1e-3 m",
            )


@once
def _judged(program: Program) -> tuple[Taker | None, dict[tuple[float, ...], _Found]]:
    """What takes the values that sizes follow from, and what is told of such values."""
    sizes = [d.value for d in program.declared if d.kind == "size" and isinstance(d.value, Expr)]
    return taker_of({name: c.slot for name, c in _columns(program).items()}, sizes), {}


def _find(program: Program, kernel: Kernel) -> _Found:
    read = reader_of(program, kernel)
    sizes = {
        (d.component, d.name): (d, value_of(read, d.value))
        for d in program.declared
        if d.kind == "size" and isinstance(d.value, Expr)
    }
    # Of wheels that are too large what they touch tells: belts and gears say that they do not fit.
    apart = (found for (_, name), found in sizes.items() if not name.endswith(_OF))
    lengths = [(d, length) for d, length in apart if not d.name.startswith(WHEEL)]
    large = tuple((d, length) for d, length in lengths if length > _PLAUSIBLE)
    pairs = ((d, length, sizes.get((d.component, d.name + _OF))) for d, length in lengths)
    stretched = tuple(
        (d, length, now[1])
        for d, length, now in pairs
        if now is not None and now[1] > _STRETCHED * length > 0
    )
    return large, stretched


def _extent(program: Program, kernel: Kernel) -> float:
    """The diagonal of the box around all places."""
    columns, read = _columns(program), reader_of(program, kernel)
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
            places.append(tuple(value_of(read, e) for e in point))
    sides = [max(along) - min(along) for along in zip(*places, strict=True)]
    return math.hypot(*sides)


@once
def _columns(program: Program) -> Mapping[str, Column]:
    return {c.name: c for c in program.columns}


def reader_of(program: Program, kernel: Kernel) -> Callable[[Expr], float]:
    """What evaluates an expression of variables at the workspace's point."""
    columns = _columns(program)

    def leaf(e: Expr) -> float:
        column = columns[repr(e)]
        return column.sign * float(kernel.w[column.slot])

    return lambda e: float(evaluate(e, leaf))


def value_of(read: Callable[[Expr], float], e: Expr) -> float:
    """Not a number where there is no value."""
    try:
        return read(e)
    except (ArithmeticError, ValueError, KeyError):
        return math.nan
