"""The drive that decides a value through gears: what the user has to know beside the gear.

In:   Program, the slot of a value that the equations give
Out:  name of a component that supplies power and gives what the value is computed from

Example: `load.phi` follows from `gear.phi_a`, which is `drive.flange.phi`: the drive is `drive`.
A torque is none: it is not among what positions and speeds are computed from.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from planarc.ir.expr import Expr, symbols
from planarc.ir.places import own_part, owner
from planarc.ir.program import Let, Program

#: Values that are followed back, at most.
_MOST = 200


def drive_behind(program: Program, slot: int) -> str:
    """The nearest one by the equations, empty where there is none."""
    supplying = {d.component for d in program.declared if d.name == "suppliedPower"}
    if not supplying:
        return ""
    names: dict[int, list[str]] = {}
    for column in program.columns:
        names.setdefault(column.slot, []).append(column.name)
    given, waiting = _given(program), [slot]
    for at in waiting:
        for name in names.get(at, ()):
            for component in _around(name):
                part = own_part(program, component)
                if component in supplying and part is not None:
                    return part.name
        if len(waiting) < _MOST:
            waiting += dict.fromkeys(s for s in given.get(at, ()) if s not in waiting)
    return ""


def _around(name: str) -> Iterator[str]:
    while name := owner(name):
        yield name


def _given(program: Program) -> dict[int, list[int]]:
    """The slots of what each slot, or each unknown of a block, is computed from."""
    slots = {c.name: c.slot for c in program.columns} | dict(program.slots)
    temporaries: dict[str, list[int]] = {}

    def of(value: Expr) -> Iterator[int]:
        for name in map(repr, symbols(value)):
            yield from temporaries.get(name, ())
            if name in slots:
                yield slots[name]

    found: dict[int, list[int]] = {}
    for statement in (s for level in (program.parameters, *program.levels) for s in level):
        if isinstance(statement, Let):
            needs, targets = list(of(statement.value)), [repr(statement.target)]
        else:
            code = program.blocks[statement.block]
            lets = [s for s in code.body if isinstance(s, Let)]
            needs = [slot for let in lets for slot in of(let.value)]
            for info in (program.equations[e] for e in code.equations):
                if isinstance(info.written, str):
                    needs += (slots[n] for n in _NAME.findall(info.written) if n in slots)
                else:
                    needs += (slot for side in info.written for slot in of(side))
            targets = [repr(t) for t in (*code.tears, *(let.target for let in lets))]
        for target in targets:
            if target in slots:
                found.setdefault(slots[target], []).extend(needs)
            else:
                temporaries[target] = needs
    return found


#: A name in the text of an equation.
_NAME = re.compile(r"[A-Za-z_][\w.]*(?:\[[\d,]+\])?(?:\.[A-Za-z_][\w.]*)*")
