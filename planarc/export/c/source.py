"""A model as C99 that people read: its functions, those that all models share, and a program.

In:   Compiled, Wishes
Out:  Source   texts by file

    model.h      the variables by their places, what a program calls
    model.c      the model: its equations, its tables, its start
    runtime.c    the solution of blocks, the choice of states, the integrator, events
    main.c       runs the experiment and writes outputs as CSV

The texts of LLVM that all exports are made of are translated: there is no other runtime, and
what is computed is the same operations in the same order. Memory is asked for by an instance, and
by the search for its start, which gives it back; nothing is allocated while a model runs.

Raises:    PlanarcError C300 for what cannot be exported, and what a start may raise; UsageError
           V505 for wishes that cannot be met.
"""

from __future__ import annotations

import math
import re
import struct
import textwrap
from collections.abc import Callable, Collection, Iterable
from enum import IntEnum
from typing import TYPE_CHECKING

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.options import RunOptions
from planarc.export.c.body import write_body
from planarc.export.c.listing import Function, Listing, read
from planarc.export.c.rows import declare
from planarc.export.c.statements import Naming
from planarc.export.c.texts import API, COUNT, HEADER, INNER, MAIN, WRITTEN
from planarc.export.image import take_image
from planarc.export.refusal import refuse
from planarc.export.wishes import derivatives, restricted, tolerance_of
from planarc.instance.block import LARGER, OTHER
from planarc.instance.plan import Own, Table
from planarc.ir.frame import Frame, Number
from planarc.runtime import elementary
from planarc.view.storage import no_match

if TYPE_CHECKING:
    from pathlib import Path

    from planarc.compiled import Compiled
    from planarc.export.fmi.variables import Interface
    from planarc.export.wishes import Wishes
    from planarc.ir.program import Program

#: Constants whose words are numbers of both kinds.
_MIXED = "px_image"
_PURE = {row.in_native for row in elementary.TABLE.values() if row.in_native} | {
    "pow", "llvm.fabs.f64", "llvm.sqrt.f64", "llvm.trunc.f64", "llvm.ceil.f64", "llvm.floor.f64",
    "llvm.ctpop.i64", LARGER,
}  # fmt: skip
_ROW = 96
_HEAD = 4096  # characters in which the mark stands
#: Whole numbers from here on are the bits of reals.
_LARGEST = 1 << 52
#: What a program may call.
PUBLIC = ("model_new", "model_set", "model_begin", "model_go", "model_message")


class Source(Data):
    """The files, and what a summary tells."""

    files: dict[str, str]
    inputs: int
    outputs: int
    parameters: int
    states: int


def make_source(compiled: Compiled, wishes: Wishes) -> Source:
    """The files of a model."""
    from planarc.export.c.entries import functions
    from planarc.export.fmi.variables import interface, output_slots
    from planarc.export.module import SHARED, write_whole

    program = restricted(compiled.program, wishes.parameters)
    refuse(program, wishes.stiff)
    image = replace(take_image(compiled), stiff=wishes.stiff)
    shown = interface(program, image.w, image.held, image.selection, wishes.outputs, image.timed,
                      step=image.step)  # fmt: skip
    causes = [v.causality for v in shown.variables]
    if wishes.outputs is not None and "output" not in causes:
        raise no_match("variable that changes", wishes.outputs)
    slots = output_slots(program, wishes.outputs)
    slopes = derivatives(program, slots) if wishes.stiff else None
    entries = functions()
    written = write_whole(program, image, entries, "", tolerance_of(program), slopes, wishes.stiff)
    shared, own = written.texts[:SHARED], written.texts[SHARED:]
    api = API.format(over=int(Own.OVER))
    files = translate(program, read(shared), read(own), entries.names, PUBLIC, api,
                      "`cc -std=c99 -O2 *.c -lm`")  # fmt: skip
    files["main.c"] = _main(program, shown)
    return Source(
        files,
        causes.count("input"),
        causes.count("output"),
        causes.count("parameter") - 1,  # that of the integrator is planarc's own
        program.state_count,
    )


def is_own_source(path: Path) -> bool:
    """Whether a file may be replaced: there is none, or planarc wrote it."""
    try:
        return WRITTEN in path.read_text("utf-8", "replace")[:_HEAD]
    except OSError:
        return not path.exists()


def translate(
    program: Program, shared: Listing, own: Listing, entries: Iterable[str],
    public: Collection[str], api: str, how: str,
) -> dict[str, str]:  # fmt: skip
    """Headers, model and runtime, with only what `entries` call. `api` declares the functions that
    are `public`, `how` says how the files are compiled."""
    slots = _slot_names(program)
    functions = shared.functions | own.functions
    wanted = _reachable(functions, entries)
    naming = Naming(
        _PURE, functions, _word_namer({w: f"V_{name}" for w, (name, _) in slots.items()})
    )
    mine = [f for f in own.functions.values() if f.name in wanted]
    others = [f for f in shared.functions.values() if f.name in wanted]
    tables = {n: v for n, v in own.numbers.items() if n in wanted}
    declared = [f"{declare(f)};" for f in (*mine, *others) if f.name not in public]
    declared += [f"extern const {_typed(n)} {n}[];" for n in tables]
    asked = set().union(*(f.calls() for f in others)) & own.strings.keys()  # from the other file
    declared += [f"extern const char {n}[];" for n in own.strings if n in asked]
    title = _said(program.name)
    header = HEADER.format(
        title=title,
        how=how,
        api=api,
        slots="\n".join(f"    V_{name} = {w}, /* {_said(shown)} */"
                        for w, (name, shown) in slots.items()),
    )  # fmt: skip
    inner = INNER.format(
        own="\n".join((_enum("FRAME", Frame), _enum("OWN", Own))),
        numbers=_enum("NUMBER", Number),
        table=_enum("TABLE", Table),
        declared="\n".join(declared),
    )
    model = [f"/* {title}: equations, tables, start. {WRITTEN}. */", '#include "runtime.h"']
    model += [_numbers(name, values) for name, values in tables.items()]
    model += [_text(n, text, n in asked) for n, text in own.strings.items() if n in wanted]
    model += [write_body(f, naming) for f in mine]
    runtime = [f"/* What all models share. {WRITTEN}. */", '#include "runtime.h"']
    if any("llvm.ctpop.i64" in f.calls() for f in others):
        runtime.append(COUNT)
    runtime += [_text(n, text) for n, text in shared.strings.items() if n in wanted]
    runtime += [write_body(f, naming) for f in others]
    texts = {"model.c": model, "runtime.c": runtime}
    found = {name: "\n\n".join(t.rstrip("\n") for t in text) + "\n" for name, text in texts.items()}
    return {"model.h": header, "runtime.h": inner, **found}


def _reachable(functions: dict[str, Function], roots: Iterable[str]) -> set[str]:
    found: set[str] = set()
    open_ = [*roots]
    while open_:
        name = open_.pop()
        if name not in found:
            found.add(name)
            if name in functions:
                open_ += functions[name].calls()
    return found


def _slot_names(program: Program) -> dict[int, tuple[str, str]]:
    """Identifiers of the variables, and what they are called."""
    found: dict[int, tuple[str, str]] = {0: ("time", "time")}
    taken = {"time"}
    for shown, slot in program.slots.items():
        if slot not in found:
            plain = re.sub(r"[^A-Za-z0-9]+", "_", shown).strip("_")
            name, number = plain, 1
            while name in taken:
                number += 1
                name = f"{plain}_{number}"
            taken.add(name)
            found[slot] = name, shown
    return dict(sorted(found.items()))


def _word_namer(slots: dict[int, str]) -> Callable[[str, str], str]:
    """Names of words whose places are known."""
    frame = {int(f): f"FRAME_{f.name}" for f in Frame} | {int(o): f"OWN_{o.name}" for o in Own}
    arrays = {
        "frame": frame,
        "FRAME_W": slots,
        "FRAME_NUMBERS": {int(n): f"NUMBER_{n.name}" for n in Number if n < Number.FIRST_STATE},
        "@px_plan": {int(t): f"TABLE_{t.name}" for t in Table if t < Table.POINTERS},
    }

    def name(array: str, index: str) -> str:
        return arrays.get(array, {}).get(int(index), "") if index.isdigit() else ""

    return name


def _enum(prefix: str, members: type[IntEnum]) -> str:
    return "\n".join(f"    {prefix}_{m.name} = {int(m)}," for m in members)


def _typed(name: str) -> str:
    return "word" if name == _MIXED else "int64_t"


def _numbers(name: str, values: tuple[int, ...]) -> str:
    """A table; zeros at its end need not be written."""
    used = len(values)
    while used > 1 and values[used - 1] == 0:
        used -= 1
    shown = [_word(v) if name == _MIXED else str(v) for v in values[:used]]
    rows = textwrap.fill(", ".join(shown), _ROW, initial_indent="    ", subsequent_indent="    ",
                         break_long_words=False, break_on_hyphens=False)  # fmt: skip
    return f"const {_typed(name)} {name}[{len(values)}] = {{\n{rows}\n}};"


def _word(value: int) -> str:
    """A number by its bits: no whole number of a model is as large as those of reals are."""
    if abs(value) < _LARGEST:
        return f"{{.i={value}}}"
    real = struct.unpack("<d", struct.pack("<q", value))[0]
    if not math.isfinite(real):
        return f"{{.d={'NAN' if math.isnan(real) else 'INFINITY' if real > 0 else '-INFINITY'}}}"
    return f"{{.d={real!r}}}"


def _text(name: str, text: str, shown: bool = False) -> str:
    return f"{'' if shown else 'static '}const char {name}[] = {_quoted(text)};"


def _quoted(text: str) -> str:
    data = text.encode()
    shown = "".join(
        chr(b) if 32 <= b < 127 and chr(b) not in '"\\?' else f"\\{b:03o}" for b in data
    )
    return f'"{shown}"'


def _said(text: str) -> str:
    """A name, fit for a comment."""
    plain = "".join(c if c.isprintable() else " " for c in text)
    return plain.replace("*/", "* /").replace("/*", "/ *")


def _main(program: Program, shown: Interface) -> str:
    from planarc.solve.settings import resolve

    grid = resolve(program, RunOptions()).grid.tolist()
    slots = {slot: name for slot, (name, _) in _slot_names(program).items()}
    rows = []
    for v in shown.variables:
        if v.causality == "output":
            slot = v.reference % OTHER // 8
            sign = "-1.0" if v.reference % 2 else "1.0"
            rows.append(f"    {{{_quoted(_cell(v.name))}, V_{slots[slot]}, {sign}}},")
    return MAIN.format(
        title=_said(program.name),
        start=repr(grid[0]),
        stop=repr(grid[-1]),
        interval=repr(grid[1] - grid[0] if len(grid) > 1 else 0.0),
        rows=len(grid),
        outputs="\n".join(rows),
    )


def _cell(name: str) -> str:
    """A name in a head of CSV."""
    return '"' + name.replace('"', '""') + '"' if re.search(r'[",]', name) else name
