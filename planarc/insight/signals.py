"""Signals that give an angle in degrees, or a speed in rpm, to what takes it in radian.

In:   Dae
Out:  warnings S324

A source has numbers without a unit, so that nothing else tells what was meant. Only such a number
is doubted that people write in degrees or rpm, and only that of a source that is connected
directly, or to a controller that compares it with what is measured in radian.

Example: `Ramp ramp(height=90)` at the input `phi_ref` of a drive, which makes 14 turns of it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.core.unit import RPM, looks_like_rpm, turns
from planarc.ir.dae import Dae, Parameter
from planarc.ir.expr import Op
from planarc.ir.places import declared_part, owner

#: What all blocks call their inputs: `u`, `u1`, `u_s`, `u[2]`. Whatever takes one is no source.
_INPUT = re.compile(r"\.u(\d+|_\w+)?(\[\d+\])?$")
#: Angles that nobody means in radian.
_DEGREES = (30, 45, 60, 90, 120, 135, 150, 180, 270, 360)


#: The two inputs of blocks that take a difference.
_COMPARED = {"u1": "u2", "u2": "u1", "u_s": "u_m", "u_m": "u_s"}


def find_misread(dae: Dae) -> Iterator[Diagnostic]:
    units = {v.name: v.unit for v in dae.variables}
    units |= _compared(dae, units)
    taking = {owner(v.name) for v in dae.variables if _INPUT.search(v.name)}
    told: set[str] = set()
    for equation in dae.equations:
        ends = equation.left, equation.right
        if not (equation.generated and all(end.is_symbol for end in ends)):
            continue
        for end, other in (ends, ends[::-1]):
            unit = units.get(end.name)
            if unit is None or unit not in _LOOKS or units.get(other.name) != "":
                continue
            source = declared_part(dae, owner(other.name))
            if source is None or source.name in told or source.name in taking:
                continue
            numbers = ((p, _number(p)) for p in dae.parameters if p.component == source.name)
            looks, how, function = _LOOKS[unit]
            for parameter, number in numbers:
                if number is None or not looks(number):
                    continue
                told.add(source.name)
                yield Diagnostic(
                    "S324",
                    f"`{source.name}` gives {number:g} to `{end.name}`, which is in {unit}: "
                    f"{how(number)}",
                    source.span,
                    Severity.WARNING,
                    hint=f"if {_MEANT[unit]} are meant, write "
                    f"`Modelica.Units.Conversions.{function}({number:g})` for "
                    f"`{parameter.name.rpartition('.')[2]}`",
                )
                break


def _compared(dae: Dae, units: Mapping[str, str]) -> dict[str, str]:
    """The units of what is measured, for the inputs with which controllers compare it."""
    controllers = {p.name for p in dae.parts if p.class_name.endswith(_CONTROLLERS)}
    found: dict[str, str] = {}
    for equation in dae.equations if controllers else ():
        ends = equation.left, equation.right
        if not (equation.generated and all(end.is_symbol for end in ends)):
            continue
        for end, other in (ends, ends[::-1]):
            block, _, name = end.name.rpartition(".")
            unit = units.get(other.name, "")
            if block in controllers and name in _COMPARED and unit in _LOOKS:
                found[f"{block}.{_COMPARED[name]}"] = unit
    return found


_CONTROLLERS = (".Feedback", ".LimPID")


def _number(p: Parameter) -> float | None:
    """The number of a parameter without unit; of a table none in the first column, of times."""
    if p.unit or p.value.op is not Op.CONST or isinstance(p.value.data, bool | str):
        return None
    return None if p.name.endswith(",1]") else float(p.value.data)


def _is_right(angle: float) -> bool:
    return abs(angle) in _DEGREES


def _as_rpm(speed: float) -> str:
    return f"{speed / RPM:.0f} rpm"


_LOOKS: Mapping[str, tuple[Callable[[float], bool], Callable[[float], str], str]] = {
    "rad": (_is_right, turns, "from_deg"),
    "rad/s": (looks_like_rpm, _as_rpm, "from_rpm"),
}
_MEANT = {"rad": "degrees", "rad/s": "rpm"}
