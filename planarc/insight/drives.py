"""What drives a mechanism: its efforts and its power over a run.

In:   Result, whose components declare the power that they supply
Out:  Drive   a component, the names of its efforts, and its power

A drive is whatever declares `suppliedPower` and gives some. Its efforts are the torques and
forces in that power, of variables that are equal or opposite the one that is read most easily.

Example: of `suppliedPower=-flange.tau*der(flange.phi)` of `motor`, `motor.tau` is the effort.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from planarc.core.arrays import Vector
from planarc.core.data import Data
from planarc.insight.values import Values
from planarc.ir.dae import Declared
from planarc.ir.expr import Expr, Op, postorder
from planarc.ir.result import Result

_EFFORTS = ("N.m", "N")


class Drive(Data):
    name: str  # of the component
    efforts: tuple[str, ...]
    power: Vector  # W


def find_drives(result: Result, values: Values | None = None) -> tuple[Drive, ...]:
    """The drives of a run, in the order of the model."""
    if len(result.time) < 2:
        return ()
    values = values or Values(result)
    with np.errstate(all="ignore"):
        declared = values.declared("energy")
    found = []
    for d in result.program.declared:
        power = declared.get(d.component, {}).get("suppliedPower") if d.kind == "energy" else None
        if d.name == "suppliedPower" and power is not None:
            rows = values.full(power)
            if np.isfinite(rows).all() and rows.any():
                found.append(Drive(d.component, tuple(_efforts(result, d)), rows))
    return tuple(found)


def _efforts(result: Result, declared: Declared) -> Iterator[str]:
    """Torques and forces that vary, each once."""
    columns, done = result.columns, set()
    symbols = postorder((declared.value,)) if isinstance(declared.value, Expr) else ()
    for e in symbols:
        name = e.data[0] if e.op is Op.SYMBOL and not e.data[1] else ""
        column = columns.get(name)
        if column is None or column.unit not in _EFFORTS or column.slot in done:
            continue
        done.add(column.slot)
        if column.slot in result.stored and result[name].any():
            same = (n for n, c in columns.items() if c.slot == column.slot)
            own = [n for n in same if n.startswith(f"{declared.component}.")]
            yield min(own or [name], key=lambda n: (n.count("."), len(n)))
