"""Lengths in other units, or diameters for radii, behind an assertion that fails.

In:   Program, Assertion, the values of the leaves of its condition where it fails
Out:  a hint, where it would hold if the lengths that its component was given were other ones by
      just that factor; else None

Lengths that the code was made for, as its structure hangs on them, stand as numbers in a condition:
such ones are taken for lengths where the message names parameters that have no name there.

Example: wheels of Ra = 50 and Rb = 100, whose axes are 0.15 m apart. With a thousandth of both they
mesh, and with nothing in between.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any

from planarc.core.data import Data
from planarc.core.prose import both, listed
from planarc.evaluate.operations import VALUES
from planarc.evaluate.value import apply_function, evaluate
from planarc.ir.dae import Assertion
from planarc.ir.expr import Expr, Op, postorder
from planarc.ir.kernel import Kernel
from planarc.ir.places import owner
from planarc.ir.program import Program

#: From mm to m; factors beside it with which an assertion does not hold that is about just that.
_MILLI, _BESIDE_MILLI = 1e-3, 3e-2
#: From a diameter to a radius, and those beside it.
_HALF, _BESIDE_HALF = 0.5, (0.4, 0.7)


class _Length(Data):
    """A length that a component was given."""

    name: str
    value: float
    description: str


def off_by_a_factor(
    program: Program,
    kernel: Kernel,
    assertion: Assertion,
    message: str,
    leaf: Callable[[Expr], float],
) -> str | None:
    """What would let an assertion hold: a thousandth, or half, of the lengths that were given."""
    condition, component = assertion.condition, assertion.component
    if not component:
        return None
    slots = {p.name: p for p in program.parameter_slots}
    leaves = [e for e in postorder((condition,)) if not e.args and repr(e) in slots]
    scaled = {n for e in leaves if slots[n := repr(e)].unit == "m" and owner(n) == component}
    given = [
        _Length(n.rpartition(".")[2], float(leaf(e)), slots[n].description)
        for e in leaves
        if (n := repr(e)) in scaled and slots[n].settable
    ]
    fixed = [] if scaled else _as_numbers(program, kernel, component, message)

    def holds(factor: float) -> bool:
        def value(e: Expr) -> float:
            return leaf(e) * (factor if repr(e) in scaled else 1.0)

        try:
            return bool(_evaluate(condition, value, factor if fixed else 1.0))
        except (ArithmeticError, ValueError, KeyError):
            return False

    lengths = [length for length in given or fixed if length.value]
    return _hint(lengths, holds) if lengths else None


def _as_numbers(program: Program, kernel: Kernel, component: str, message: str) -> list[_Length]:
    """The lengths that a message names, of which conditions hold the values only."""
    told = {f"{component}.{word}" for word in re.findall(r"\w+", message)}
    return [
        _Length(p.name.rpartition(".")[2], float(kernel.w[p.slot]), p.description)
        for p in program.parameter_slots
        if p.structural and p.unit == "m" and not p.final and p.name in told
    ]


def _evaluate(e: Expr, leaf: Callable[[Expr], float], factor: float) -> Any:
    """The value of a condition, numbers that are compared or added taken `factor` times."""
    if e.op is Op.CONST:
        return e.data * factor
    if e.op in (Op.LESS, Op.LESS_EQUAL, Op.ADD, Op.NEG) or (e.op is Op.CALL and e.data == "abs"):
        args = [_evaluate(a, leaf, factor) for a in e.args]
        return apply_function(e, args) if e.op is Op.CALL else VALUES[e.op](*args)
    return evaluate(e, leaf)


def _hint(given: Sequence[_Length], holds: Callable[[float], bool]) -> str | None:
    def told(factor: float) -> str:
        return listed(f"`{p.name}={p.value * factor:.4g}`" for p in given)

    if holds(_MILLI) and not holds(_BESIDE_MILLI):
        return f"it holds with {told(_MILLI)}: lengths are in m, 1 mm is 1e-3 m"
    if holds(1 / _MILLI) and not holds(1 / _BESIDE_MILLI):
        names = both([p.name for p in given])
        return f"it holds with a thousand times {names}: look for another length that is in mm"
    radii = all("radius" in p.description.lower() for p in given)
    if radii and holds(_HALF) and not any(map(holds, _BESIDE_HALF)):
        return f"it holds with {told(_HALF)}: give radii, which are half of the diameters"
    return None
