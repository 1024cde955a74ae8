"""A result that was written to a file, as if its run had just ended.

In:   Table      the numbers of a .csv or .mat file, of planarc or another tool
      Compiled   the model that made them, or nothing
Out:  Result

A file holds numbers; what is drawn, units and descriptions are the model's. With the model the
numbers of the file count, and where it has none (a .csv holds no parameters) the values that
the model gives to what never changes. Without one there are curves and nothing that moves.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from msgspec.structs import fields, replace

from planarc.compiled import Compiled
from planarc.compiler import compile_model
from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError, usage_error
from planarc.core.options import fastest_backend
from planarc.core.prose import counted, ticked
from planarc.core.source import model_files
from planarc.ir.dae import Kind
from planarc.ir.expr import Exprs
from planarc.ir.kernel import Kernel
from planarc.ir.program import Column, Program
from planarc.ir.result import Result, Statistics
from planarc.request.request import Request
from planarc.solve.settings import compiles_again, differs
from planarc.view.table.origin import Origin
from planarc.view.table.table import Table

#: A model belongs to a file when at least this part of its varying variables is in it.
_SHARE = 0.5
_WORST = 3

_READ = Statistics("read from a file", "none")


class Restored(Data):
    """`kernel` stands at the parameters of the run; None without a model."""

    result: Result
    kernel: Kernel | None
    notes: tuple[str, ...] = ()


def find_request(name: str, folders: Sequence[Path], libraries: Sequence[Path]) -> Request | None:
    """The model of a class name: a file beside the result that declares it, or a library's.

    None where there is none, or several files declare it.
    """
    if re.fullmatch(r"\w+(\.\w+)+", name):
        return Request(None, name, tuple(libraries))
    if not re.fullmatch(r"\w+", name):
        return None
    declares = re.compile(rf"^\s*(?:partial\s+)?(?:model|class|block)\s+{name}\b", re.MULTILINE)
    found = [path for path in _model_files(folders) if declares.search(_text(path))]
    return Request(found[0], name, tuple(libraries)) if len(found) == 1 else None


def of_origin(origin: Origin) -> Request | None:
    """The request that made a result; None where its file is not there any more."""
    if origin.file is not None and not origin.file.is_file():
        return None
    libraries = tuple(folder for folder in origin.libraries if folder.exists())
    return Request(origin.file, origin.model, libraries)


def _model_files(folders: Sequence[Path]) -> list[Path]:
    different = {folder.resolve(): folder for folder in folders}
    return sorted(p for folder in different.values() for p in model_files(folder) if p.is_file())


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""


def restore(table: Table, name: str, compiled: Compiled | None) -> Restored:
    """The result of a table. Raises UsageError C290 where the numbers are not of that model."""
    if compiled is None:
        return Restored(_bare(table, name), None)
    return _of_model(table, name, compiled)


def compile_request(request: Request) -> Compiled:
    """The compiled model, with native code where it can be had."""
    return compile_model(request, fastest_backend())


def _of_model(table: Table, name: str, compiled: Compiled) -> Restored:
    program = compiled.program
    _refuse_stranger(table, name, program)
    kernel = compiled.load()
    # Parameters that the file tells, then all that follow from them.
    told = {} if table.origin is None else table.origin.parameters
    for p in program.parameter_slots:
        if p.name in table and len(table.time):
            kernel.w[p.slot] = float(table[p.name][0])
        elif p.name in told and p.settable:
            kernel.w[p.slot] = told[p.name]
        elif p.default is not None:
            kernel.w[p.slot] = p.default
    kernel.parameters()
    known = {c.slot: c for c in program.columns if c.name in table}
    varying = [c for c in known.values() if not (c.constant or _same(table[c.name]))]
    constants = {c.slot: float(kernel.w[c.slot]) for c in program.columns}
    # What varies and is not in the file is not known at all.
    lost = {c.name for c in program.columns if not c.constant and c.slot not in known}
    program = replace(program, columns=tuple(c for c in program.columns if c.name not in lost))
    own = sorted(c for c in lost if not c.startswith("$"))
    shown = ticked(own[:_WORST])
    note = f"{name} does not hold {counted(len(own), 'variable')} of the model, such as {shown}"
    result = _result(program, table, known.values(), varying, constants)
    return Restored(result, kernel, (note,) if own else ())


def _result(
    program: Program,
    table: Table,
    columns: Iterable[Column],
    varying: Sequence[Column],
    constants: dict[int, float],
) -> Result:
    """The rows of `varying` columns; of others the first number that is there."""
    data = np.empty((len(table.time), len(varying)))
    for i, column in enumerate(varying):
        data[:, i] = column.sign * table[column.name]
    stored = {c.slot: i for i, c in enumerate(varying)}
    if len(table.time):
        constants |= {c.slot: float(c.sign * table[c.name][0]) for c in columns}
    constants = {slot: value for slot, value in constants.items() if slot not in stored}
    return Result(program, table.time, data, stored, constants, _READ)


def _refuse_stranger(table: Table, name: str, program: Program) -> None:
    own = [c.name for c in program.columns if not c.constant and not c.name.startswith("$")]
    there = sum(n in table for n in own)
    if own and there < _SHARE * len(own):
        raise usage_error(
            "C290",
            f"`{name}` is no result of `{program.name}`: it holds {there} of the model's"
            f" {counted(len(own), 'variable')}",
            hint="give the model that made it with `--model`",
        )


def _bare(table: Table, name: str) -> Result:
    """A result of curves only, with units as far as the file tells them."""
    names = [n for n in table.columns if n != "time"]
    slots = {n: i for i, n in enumerate(names)}
    columns = tuple(
        Column(n, i, 1, Kind.REAL, table.units.get(n, ""), constant=_same(table[n]))
        for n, i in slots.items()
    )
    # All else that a program must hold is a list, here an empty one.
    empty: dict[str, Any] = {field.name: () for field in fields(Program) if field.required}
    own = {"name": table.model or name, "table": Exprs(), "size": len(slots), "slots": slots}
    program = Program(**empty | own | {"columns": columns})
    return _result(program, table, columns, [c for c in columns if not c.constant], {})


def _same(values: Any) -> bool:
    return bool(len(values) and (values == values[0]).all())


def compile_guess(request: Request, table: Table) -> Compiled | None:
    """A model that was only guessed; None where it does not compile, or is another one."""
    try:
        compiled = _as_told(request, compile_request(request), table)
        _refuse_stranger(table, "", compiled.program)
    except PlanarcError:
        return None
    return compiled


def _as_told(request: Request, compiled: Compiled, table: Table) -> Compiled:
    """The model with the structural parameters of the run."""
    told = {} if table.origin is None else table.origin.parameters
    program = compiled.program
    structural = [
        p for p in program.parameter_slots if p.name in told and compiles_again(program, p)
    ]
    if not structural:
        return compiled
    kernel = compiled.load()
    kernel.parameters()
    values = {p.name: told[p.name] for p in structural if differs(kernel, p, told[p.name])}
    if not values:
        return compiled
    from planarc.api.variant import compile_like, texts_of, variant_of

    backend = fastest_backend()
    texts = texts_of(request, compiled.program, values, backend)
    return compile_like(variant_of(request, texts), backend, compiled.program, values)
