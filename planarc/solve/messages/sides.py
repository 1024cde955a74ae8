"""The side on which curves touch: what to set where a part is meant on the other one.

Whatever is in contact says it by a parameter `switchSide` of its curves.
"""

from __future__ import annotations

from collections.abc import Collection

from planarc.ir.kernel import Kernel
from planarc.ir.program import Program
from planarc.solve.messages.loops import loop_joints

_SIDE = ".switchSide"


def switch(program: Program, contact: str) -> str:
    """What sets the last of a contact's curves to its other side, in backticks; empty of no such
    contact."""
    return _set(contact, curves_of(program, contact))


def other_side(
    program: Program, kernel: Kernel, components: Collection[str], given: float, follows: float
) -> str:
    """The same of a contact in the loops of some components, of which a value is given on one
    side, and follows on the other one. A closed curve is touched from outside."""
    if given * follows >= 0:
        return ""
    values = {p.name: float(kernel.w[p.slot]) for p in program.parameter_slots}
    for joint in loop_joints(program, components):
        flat = [c for c in curves_of(program, joint.name) if not values.get(f"{c}.closed")]
        if found := _set(joint.name, [c for c in flat if not values[c + _SIDE]]):
            return f", or let it touch the other side: {found}"
    return ""


def curves_of(program: Program, contact: str) -> list[str]:
    """The curves of a contact, by their whole names; none of what is no contact."""
    names = (p.name for p in program.parameter_slots if p.name.startswith(f"{contact}."))
    return [name.removesuffix(_SIDE) for name in names if name.endswith(_SIDE)]


def _set(contact: str, curves: list[str]) -> str:
    if not curves:
        return ""
    curve = curves[-1].removeprefix(f"{contact}.")
    return f"`{contact}({curve}(switchSide=true))`"
