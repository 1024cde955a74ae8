"""Between which limits the values of variables lie, and how large they are, as the model says.

In:   Program, the values at the start
Out:  Declared   limits and size of each name

Names of one value may say different things. A name has the limits that it declares itself, and is
a variable of its own where these are not those of the name before it. Where a variable declares
none, it has those that all names of its value with its unit leave together, turned round where it
has the other sign.

    x(min=0); y(max=5), y = x; z = -x                    x: 0 to ..., y: ... to 5, z: -5 to 0

Limits that follow from parameters are left out where a host may set these: what is described of
a model stays as it was at export. Left out is also what the start itself oversteps.

Reference: FMI 3.0.2, section 2.4.4, and FMI 2.0.4, section 2.2.3 (min, max, nominal); of names of
one value, FMI 2.0.4, section 2.2.7: "aliased variables may have different attributes".
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import ceil, floor, isfinite

from planarc.evaluate.value import evaluate
from planarc.instance.plan import is_settable
from planarc.ir.dae import Kind
from planarc.ir.expr import Expr, symbols, text
from planarc.ir.program import Column, Let, Program

Range = tuple[float | None, float | None]
_OPEN: Range = (None, None)
#: Whole numbers of FMI are in 4 bytes.
_WHOLE = 1 << 31


class Declared:
    """What the variables of a program declare; parameters do it by themselves."""

    def __init__(self, program: Program, w: Sequence[float]) -> None:
        free = _settable(program)

        def number(e: Expr | None, fixed: bool = True) -> float | None:
            if e is None or (fixed and any(text(s) in free for s in symbols(e))):
                return None
            try:
                value = float(evaluate(e, lambda s: w[program.slots[text(s)]]))
            except (ArithmeticError, KeyError, ValueError):
                return None
            return value if isfinite(value) else None

        self._own: dict[str, Range] = {}
        self._sizes: dict[str, float] = {}
        for told in program.limits:
            found = number(told.minimum), number(told.maximum)
            if found != _OPEN:
                self._own[told.name] = found
            size = number(told.nominal, fixed=False)
            if size:
                self._sizes[told.name] = abs(size)
        self._shared: dict[tuple[int, str], Range] = {}
        for c in program.columns:
            if c.name in self._own:
                low, high = turned(self._own[c.name], c.sign)
                least, most = self._shared.get((c.slot, c.unit), _OPEN)
                self._shared[c.slot, c.unit] = _of(max, least, low), _of(min, most, high)

    def limits(self, column: Column, value: float) -> Range:
        """Those of a name, which has a value at the start."""
        if column.constant or column.kind is Kind.BOOLEAN:
            return _OPEN
        found = self._own.get(column.name)
        if found is None:
            shared = self._shared.get((column.slot, column.unit), _OPEN)
            found = turned(shared, column.sign)
        return kept(found, value, column.kind is not Kind.REAL)

    def declares(self, column: Column) -> bool:
        """Whether a name has limits of its own."""
        return column.name in self._own and not column.constant

    def size(self, columns: Sequence[Column]) -> float | None:
        """The size of a value: what the first of its names says that says something."""
        return next((self._sizes[c.name] for c in columns if c.name in self._sizes), None)


def turned(limits: Range, sign: int) -> Range:
    """The limits of a value with a sign."""
    low, high = limits
    if sign > 0:
        return limits
    return None if high is None else 0.0 - high, None if low is None else 0.0 - low


def kept(limits: Range, value: float, whole: bool) -> Range:
    """The limits that a host may be told: they contain the start and each other."""
    low, high = limits
    if whole:
        low = None if low is None or low < -_WHOLE else float(ceil(low))
        high = None if high is None or high >= _WHOLE else float(floor(high))
    if low is not None and high is not None and low > high:
        return _OPEN
    return (
        None if low is None or value < low else low,
        None if high is None or value > high else high,
    )


def _of(choose: Callable[[float, float], float], a: float | None, b: float | None) -> float | None:
    if a is None or b is None:
        return b if a is None else a
    return choose(a, b)


def _settable(program: Program) -> frozenset[str]:
    """The parameters that a host may set, and what is computed from these."""
    found = {p.name for p in program.parameter_slots if is_settable(p)}
    for s in program.parameters:
        if isinstance(s, Let):
            if any(text(e) in found for e in symbols(s.value)):
                found.add(text(s.target))
        else:
            found |= {p.name for p in program.parameter_slots}
    return frozenset(found)
