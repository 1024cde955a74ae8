"""What decides a variable that a user wants to set: for messages about wrong settings.

In:   Program, the variable's name
Out:  a hint, or names of variables whose start values have an effect

Example: `motor.w` follows from the parameter `motor.w_fixed`.
"""

from __future__ import annotations

from collections.abc import Sequence

from planarc.ir.mechanism import GROUND
from planarc.ir.places import owner
from planarc.ir.program import Program


def given_by(program: Program, name: str) -> str | None:
    """What to set where a parameter has the name of a variable, or of one that is the same, and an
    addition to it; e.g. `w_fixed` of a motor, for the speed of its hinge."""
    slot = next((c.slot for c in program.columns if c.name == name), None)
    same = [c.name for c in program.columns if c.slot == slot]
    known = [p.name for p in program.parameter_slots if p.settable]
    given = next((p for p in known if any(p.startswith(f"{n}_") for n in (*same, name))), None)
    if given is not None and given.endswith("]"):
        return f"did you mean the parameter `{given.partition('[')[0]}`?"
    return None if given is None else f"set `{given}`, which gives it"


def not_to_be_set(program: Program, name: str) -> tuple[str, str] | None:
    """What is told of a parameter that no value can be given, and a hint."""
    if any(name == text or name.startswith(f"{text}[") for text in program.texts):
        value = f'{{"{name}": \'"..."\'}}'
        message = f"`{name}` is a String, which the model is compiled with"
        return message, f"write another one into the model, or in Python take `variant({value})`"
    if any(c.at_start and c.display == name for c in program.candidates):
        message = f"`{name}` is found at the start (`fixed=false`): no value can be given"
        return message, f"set `{name}.start`, from which it is looked for"
    return None


def deciding(program: Program, name: str) -> Sequence[str]:
    """The candidates that may decide a variable: of the joints that hold its part, nearest to the
    ground first, those of its unit; else the nearest names."""
    units = {c.name: c.unit for c in program.columns}
    mechanism = program.mechanism
    holding = set(mechanism.joints_at({owner(name)}) if mechanism else ())
    links = {j.name: j.links for j in mechanism.joints} if mechanism else {}
    near = [c.display for c in program.candidates if owner(c.display) in holding]
    near = [n for n in near if units.get(n) == units.get(name)]
    if near:
        return sorted(near, key=lambda n: GROUND not in links[owner(n)])[:2]
    from planarc.core.nearest import nearest

    return nearest(name, [c.display for c in program.candidates], cutoff=0.0)


def start_meant(program: Program, name: str) -> str | None:
    """The question after a start value that is asked for by another name: `phi_start`, `phi0`."""
    for ending in ("_start", "_0", "0", "Start", "start"):
        variable = name.removesuffix(ending)
        if variable != name and any(c.name == variable for c in program.columns):
            return f"did you mean `{variable}.start`?"
    return None
