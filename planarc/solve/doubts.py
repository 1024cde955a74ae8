"""What is asked of a run and may well be a mistake, though it can be done.

In:   Program, RunOptions
Out:  warnings   of values outside of their bounds, or as if in degrees or rpm (R409), and of an
                 interval that is longer than the run (R403)
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.core.options import RunOptions
from planarc.core.unit import RPM, looks_like_degrees, looks_like_rpm, of_per_cent, turns
from planarc.ir.program import Program
from planarc.solve.settings import DEFAULT_INTERVALS, columns_of, parameters_of


def doubts(program: Program, options: RunOptions) -> tuple[Diagnostic, ...]:
    """The warnings of a request."""
    return (*_doubted_interval(program, options), *_doubted_values(program, options))


def _doubted_interval(program: Program, options: RunOptions) -> Iterator[Diagnostic]:
    given, interval = program.experiment, options.interval
    start = given.start if options.start is None else options.start
    length = (given.stop if options.stop is None else options.stop) - start
    if interval is not None and interval > length > 0:
        message = f"the rows lie {interval:g} s apart, but the run lasts {length:g} s only"
        hint = f"give a part of it, such as `--interval {length / DEFAULT_INTERVALS:g}`"
        yield Diagnostic("R403", message, None, Severity.WARNING, hint)


def _doubted_values(program: Program, options: RunOptions) -> tuple[Diagnostic, ...]:
    if not (options.values or options.starts):
        return ()
    known, columns = parameters_of(program), columns_of(program) if options.starts else {}
    units = {n: columns[n].unit for n in options.starts if n in columns}
    found: list[tuple[str, str | None]] = []
    for name, value in options.values.items():
        low, high = known[name].minimum, known[name].maximum
        if low is not None and value < low:
            found.append((f"`{name}` = {value:g} lies below its minimum {low:g}", None))
        elif high is not None and value > high:
            share = of_per_cent(value, high, known[name].unit)
            hint = None if share is None else f"if per cent are meant, give {share:.6g}"
            found.append((f"`{name}` = {value:g} lies above its maximum {high:g}", hint))
    angles = [(n, v) for n, v in options.values.items() if known[n].unit == "rad"]
    angles += [(n, v) for n, v in options.starts.items() if units.get(n) == "rad"]
    for name, value in angles:
        if looks_like_degrees(value):
            message = f"`{name}` = {value:g} is in radian, {turns(value)}"
            found.append((message, f"if degrees are meant, give {math.radians(value):.6g}"))
    for name, value in options.starts.items():
        if units.get(name) == "rad/s" and looks_like_rpm(value):
            message = f"`{name}` = {value:g} is in rad/s, {value / RPM:.0f} rpm"
            found.append((message, f"if rpm are meant, give {value * RPM:.6g}"))
    return tuple(Diagnostic("R409", m, None, Severity.WARNING, hint) for m, hint in found)
