"""The code of an exported model: modules of LLVM, of which `objects` makes machine code.

    shared    the kernel's functions     `codegen.native.runtime`
              an instance's              `export.instance`
              the interface's            `export.fmi`
    own       the model's functions      `codegen.native.printer`
              its tables, its image      here

The image and the largest table are the same on all platforms: where they are long, an archive may
hold them once, in a file (`instance.stored`).

All functions but those of the interface are hidden, so that calls between them need no way
through a loader.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Sequence
from functools import partial
from hashlib import sha256
from typing import TYPE_CHECKING

from planarc.codegen.native.assembly import FLAG, POINTER, REAL, SELDOM, Code, Value, table
from planarc.codegen.native.formulas import bit, formula
from planarc.codegen.native.gauss import SMALL, solve_functions
from planarc.codegen.native.operations import operate_function
from planarc.codegen.native.packed import Rows, pack
from planarc.codegen.native.printer import ir, slopes_ir
from planarc.codegen.native.rolling import operations
from planarc.codegen.native.runtime import runtime_text
from planarc.codegen.native.spelled import Speller
from planarc.core.data import Data
from planarc.export.actions import (
    action_functions,
    endings,
    errors,
    ordered_discretes,
    reader,
    spell_values,
)
from planarc.export.delays import delay_functions, delay_messages
from planarc.export.endings import most_values, subjects, templates
from planarc.export.fits import misfit_slots
from planarc.export.image import Image
from planarc.export.instance.block import BYTE, block_functions, load_narrow
from planarc.export.instance.contact.area import kept_words, sizes
from planarc.export.instance.contact.functions import contact_functions
from planarc.export.instance.ends import end_functions
from planarc.export.instance.events import event_functions
from planarc.export.instance.instants import instant_functions
from planarc.export.instance.past.functions import past_functions
from planarc.export.instance.relations import relation_functions
from planarc.export.instance.said import MARK, said_functions
from planarc.export.instance.settling import settling_functions
from planarc.export.instance.slopes import nodes_of, slope_functions
from planarc.export.instance.start import start_functions
from planarc.export.instance.states import state_functions
from planarc.export.instance.steps import step_functions
from planarc.export.instance.stiff import stiff_functions
from planarc.export.instance.stored import stored_bytes, stored_functions
from planarc.export.instance.uneventful import uneventful_functions
from planarc.export.plan import (
    Jam,
    Own,
    Phase,
    Plan,
    Stale,
    is_eventful,
    make_plan,
    rules,
    starts_anew,
)
from planarc.export.pruned import calls_in, prune
from planarc.export.text import text_constant
from planarc.export.touches import touch_functions
from planarc.export.tunable import tunable_parameters
from planarc.ir.dae import INITIAL, START_TIME, TERMINAL
from planarc.ir.derivatives import Head, Scope
from planarc.ir.flat import StateSelect
from planarc.ir.frame import Frame, angles_of_loops, place
from planarc.ir.program import Program
from planarc.solve.contact.touches import Points
from planarc.solve.events.crossings import AHEAD, unknowns
from planarc.solve.start.sharing import FITS

if TYPE_CHECKING:
    from planarc.codegen.slopes import Slopes
    from planarc.export.fmi.entries import Entries


#: The derivatives of a model that has none.
_NOTHING = [len(Head), *(0 for _ in range(len(Head) - 1))]
_NO_SLOPES = """
define i32 @pc_slopes_all(ptr %frame, double %t, ptr %results) nounwind {
  ret i32 1
}
"""
#: So many operations of derivatives pay for the function that carries them out.
_LARGE = 350
#: How many modules do not hang on the model alone.
SHARED = 2
#: So many bytes, packed, pay for a file.
_MANY = 3000
#: In the place of the kernel's.
_SOLVER = """
declare i32 @pc_solve(ptr, ptr, ptr, ptr, ptr, i64)
declare i32 @pc_again(ptr, ptr, ptr, ptr, ptr, ptr, i64, i64, i64)
"""
#: In the place of implicit steps, which nothing can choose there.
_EXPLICIT = """
define i32 @px_stiff(ptr %m, double %t, double %h) nounwind {
  ret i32 1
}
define double @px_stiff_error(ptr %m) nounwind {
  ret double 0x7E37E43C8800759C
}
"""
#: Where nothing touches, nothing is remembered of touches.
_APART = """
define void @px_unstruck(ptr %m) nounwind {
  ret void
}
"""
#: What the functions that all models share call of a model's own, and its tables.
_MODEL = """
declare i32 @pc_parameters(ptr, double)
declare i32 @px_asserts(ptr, double)
declare ptr @px_message(i32)
declare ptr @px_subject(i64)
declare void @px_values(ptr, i64)
declare ptr @calloc(i64, i64)
declare void @free(ptr)
declare void @px_branches(ptr, i64)
declare i32 @px_assign(ptr, double)
declare i64 @px_act(ptr, double)
declare void @px_feel(ptr, double, ptr)
declare void @px_samples(ptr, ptr)
declare i32 @pc_discrete(ptr, double)
declare double @pow(double, double)
declare double @llvm.ceil.f64(double)
declare double @llvm.maximum.f64(double, double)
declare i64 @llvm.ctpop.i64(i64)
declare i32 @pc_slopes_all(ptr, double, ptr)
"""
_TABLES = (
    *("plan", "image", "token", "name", "open", "stay", "follow", "angles"),
    *("nominals", "system", "wanted", "starts", "packed", "seal", "relations", "sampled"),
    "quiet_slots",
    "touches",
)


class Written(Data):
    """The modules as texts, and what is to stand in the file of numbers; nothing where the texts
    hold all."""

    texts: tuple[str, ...]
    stored: bytes


def write_texts(
    program: Program, image: Image, entries: Entries, token: str, tolerance: float,
    slopes: Slopes | None = None, derivatives: bool = True, spelled: bool = False,
) -> tuple[str, ...]:  # fmt: skip
    """The modules as texts that hold all."""
    return write(program, image, entries, token, tolerance, slopes, derivatives, spelled).texts


def write(
    program: Program, image: Image, entries: Entries, token: str, tolerance: float,
    slopes: Slopes | None = None, derivatives: bool = True, spelled: bool = False,
    apart: bool = False,
) -> Written:  # fmt: skip
    """The modules as texts, which are the same for all platforms: what many models share
    (`SHARED`), the model's own, and its derivatives. Without `derivatives` nothing asks for them,
    steps are explicit, and the model's own functions are quick rather than small: a page runs them
    while something is dragged. `spelled`: large models carry out what runs seldom (`spelled`);
    `apart`: many numbers may stand in a file."""
    rows = Rows(Own.ROWS)
    speller, of_values = None, _NO_SLOPES
    if slopes is not None:
        if spelled and sum(map(operations, slopes.named(program.table)[0])) >= _LARGE:
            speller = Speller(rows, math.inf if apart else Speller(rows).most)
        of_values = slopes_ir(program, slopes, Scope.ALL, rows, speller)
    own, stored = _own(program, image, entries, token, tolerance, slopes, rows, derivatives,
                       speller, apart)  # fmt: skip
    shared = _shared(program, entries, derivatives, bool(stored))
    shared = prune(shared, {*entries.names, *calls_in(own)})
    return Written((shared, _solver(program), own, of_values), stored)


def _shared(program: Program, entries: Entries, derivatives: bool, apart: bool) -> str:
    """The kernel's functions, the instance's and the interface's."""
    touches, delayed = bool(Points(program).all), bool(program.delays)
    events = uneventful_functions()
    if is_eventful(program):
        events = (*relation_functions(), *instant_functions(delayed), *settling_functions(),
                  *event_functions(delayed, entries.tells, apart), *end_functions())  # fmt: skip
    functions = (
        *block_functions(delayed, apart),
        *(stored_functions(entries.by_uri, entries.as_shown) if apart else ()),
        operate_function(),
        *said_functions(),
        *start_functions(apart),
        *state_functions(),
        *step_functions(delayed),
        *events,
        *(past_functions() if delayed else ()),
        *(contact_functions() if touches else (_APART,)),
        *((*slope_functions(), *stiff_functions()) if derivatives else (_EXPLICIT,)),
        entries.text(),
    )
    tables = "".join(f"@px_{name} = external constant [0 x i64]\n" for name in _TABLES)
    return "\n".join((runtime_text(_SOLVER), _MODEL, tables, *functions))


def _solver(program: Program) -> str:
    """Elimination: in registers only for the numbers of unknowns that the model has."""
    sizes = {len(b.residuals) for b in program.blocks if b.direct is None}
    smalls = sorted(n for n in sizes if 0 < n <= SMALL)
    return f"declare double @llvm.fabs.f64(double)\n{''.join(solve_functions(smalls))}"


def _own(
    program: Program, image: Image, entries: Entries, token: str, tolerance: float,
    slopes: Slopes | None, rows: Rows, small: bool, speller: Speller | None, apart: bool,
) -> tuple[str, bytes]:  # fmt: skip
    """The model's functions, its tables and its messages; what stands in the file of numbers."""
    # Whatever is spelled is so before the function that carries it out is written, by `ir`.
    judged, felt = _asserts(program, speller), touch_functions(program, speller)
    functions = ir(program, small, rows if small else None, speller)
    tape = _NOTHING if slopes is None else slopes.tape()
    discretes = [n for d in ordered_discretes(program)[0] for n in (d.slot, d.pre, d.start)]
    settable = rules(program, image.held, tunable_parameters(program))
    unpacked = [*nodes_of(program, slopes), *settable, *discretes, *rows.numbers, *tape]
    touches = len(Points(program).all)
    lags = image.lags
    planned = partial(make_plan, program, image.held, len(image.scales), tape, len(rows.numbers),
                      kept_words(touches), sizes(touches, program.state_count),
                      most_values(program), lags)  # fmt: skip
    plan, packed = planned(), pack(unpacked)
    seal = int.from_bytes(sha256(token.encode()).digest()[:7])
    words = _image(program, image, plan, tolerance)
    stored = stored_bytes([seal, *words, *packed]) if apart else b""
    if len(zlib.compress(stored)) > _MANY:
        plan, numbers = planned(len(packed)), ""
    else:
        stored, numbers = b"", table("px_image", words) + table("px_packed", packed)
    name = program.name.encode("ascii", "replace").decode()
    ends, values = templates(program, entries.as_shown)
    late = delay_messages(program, lags)
    ends += [f"at t = {MARK}t6 s {entries.as_shown(text)}" for text in late]
    texts = [("token", token), ("name", name)]
    told = "\n".join(
        (
            functions,
            *(text_constant(f"px_{key}", text) for key, text in texts),
            _tables(program, image, plan, len(unpacked), slopes is not None, len(stored) // 8),
            numbers,
            table("px_seal", [seal]),
            action_functions(program),
            felt,
            delay_functions(program, lags, plan.image, len(ends) - len(late) + 1),
            judged,
            _messages(ends, apart),
            values,
            subjects(program, entries.as_shown),
        )
    )
    return told, stored


def _tables(
    program: Program, image: Image, made: Plan, unpacked: int, slopes: bool, stored: int
) -> str:
    from planarc.solve.states.selector import leaders_of, open_blocks

    placed, points = place(program), Points(program)
    records = [1 + sum(map(len, placed.records[:k])) for k in range(len(placed.records))]
    opened = open_blocks(program)
    tears = [
        program.candidates[program.blocks[i].first + j]
        for i in opened
        for j in range(len(program.blocks[i].tears))
    ]
    followers = leaders_of(program)
    follow = [len(followers)]
    for i, (leader, places) in sorted(followers.items(), key=lambda pair: pair[1][0]):
        row = [places.get(j, 0) for j in range(len(program.blocks[i].tears))]
        follow += [records[i], records[leader], *row]
    nominals = [(c.slot, c.nominal) for c in program.candidates if c.nominal is not None]
    angles = angles_of_loops(program)
    rows = image.system[2] + image.system[3] + image.system[4]
    homes = [n for pair in made.homes for n in pair]
    w = dict(made.homes)[Frame.W]
    reserved = (program.slots.get(name, -1) for name in (INITIAL, TERMINAL, START_TIME))
    numbers = (made.words, program.state_count, program.size, len(opened), len(made.given),
               len(made.given), image.system[1], rows, len(nominals), w - Own.PHASE,
               Own.MARGIN - w, made.room, len(program.relations),
               len(program.relations) - len(image.timed), len(program.discretes),
               len(program.samplers), len(unknowns(program)), *reserved,
               sum(not b.linear for b in program.blocks), len(points.all),
               len(endings(program)) + 1, unpacked, slopes, stored)  # fmt: skip
    relations = [
        n
        for i, r in enumerate(program.relations)
        for n in (
            r.slot,
            int(r.strict),
            int(r.time_only),
            int(i in image.timed),
            int(r.component in points.components),
        )
    ]
    return "".join(
        (
            table("px_plan", (*map(int, numbers), len(made.homes), *homes)),
            table("px_open", (records[i] for i in opened)),
            table("px_stay", (int(c.select is StateSelect.ALWAYS) for c in tears)),
            table("px_follow", follow),
            table("px_angles", (len(angles), *(n for pair in angles for n in pair))),
            table("px_nominals", (n for pair in nominals for n in pair)),
            table("px_system", image.system),
            table("px_wanted", (start for _, start in made.given)),
            table("px_starts", (start for _, start in made.given)),
            table("px_relations", relations),
        )
    )


def _image(program: Program, image: Image, made: Plan, tolerance: float) -> list[int]:
    """The words behind the pointers."""
    words = [0] * made.image
    words[Own.PHASE] = Phase.INSTANTIATED
    words[Own.STALE] = Stale.START if starts_anew(program) else Stale.ALL
    words[Own.AHEAD] = _bits(AHEAD * (image.span or 1.0))
    words[Own.TOLERANCE], words[Own.BOUND] = _bits(tolerance), _bits(image.bound)
    words[Own.STOP], words[Own.STIFF] = _bits(1e300), _bits(float(image.stiff))
    homes = dict(made.homes)
    arrays = {Own.Y: image.states, Own.SCALES: image.scales, Frame.W: image.w,
              Frame.NUMBERS: image.numbers, Frame.ACCEPTED: image.accepted}  # fmt: skip
    for which, array in arrays.items():
        for i, value in enumerate(array):
            words[homes[which] + i] = int(value) if which is Frame.NUMBERS else _bits(float(value))
    return words[Own.PHASE :]


def _bits(value: float) -> int:
    found: int = struct.unpack("<q", struct.pack("<d", value))[0]
    return found


def _asserts(program: Program, speller: Speller | None) -> str:
    """Which assertion fails first, counted from 1, or which condition that was left out."""
    c = Code("px_asserts", FLAG, ((POINTER, "frame"), (REAL, "t")))
    frame, t = c.arguments
    conditions = [a.condition for a in errors(program)]
    truths = Value(c, POINTER, "%truths")
    if spell_values(program, conditions, speller, c, truths):
        c.place(REAL, len(conditions), truths.text)
        with c.loop(len(conditions)) as i, c.when(~bit(c, truths.load(REAL, i)), leaves=True):
            c.give(c.flag(i + 1))
    else:
        leaf = reader(program, frame.load(POINTER, Frame.W), t)
        for k, condition in enumerate(conditions, 1):
            with c.when(~bit(c, formula(c, condition, leaf)), leaves=True):
                c.give(k)
    first = len(endings(program)) + len(Jam) * len(Points(program).all) + 1
    for k, slot in enumerate(misfit_slots(program), first):
        off = c.absolute(frame.load(POINTER, Frame.W).load(REAL, slot))
        with c.when(~(off <= FITS), leaves=True):
            c.give(k)
    c.give(0)
    return c.text(SELDOM)


def _messages(texts: Sequence[str], together: bool) -> str:
    """The messages of assertions and the like, by their numbers from 1; `together`: one behind the
    other, which takes less code and is less easy to read."""
    c = Code("px_message", POINTER, ((FLAG, "number"),))
    number = c.arguments[0]
    if together:
        whole = "\0".join(texts)
        constants = [text_constant("px_messages", whole)]
        left, first = c.variable(number, FLAG), Value(c, POINTER, "@px_messages")
        with c.loop(len(whole.encode())) as i:
            with c.when(left.get().equals(1), leaves=True):
                c.give(c.emit(POINTER, f"getelementptr i8, ptr {first.text}, i64 {i.text}"))
            with c.when(load_narrow(c, BYTE, first, i).equals(0)):
                left.set(left.get() - 1)
    else:
        constants = [text_constant(f"px_message_{i}", text) for i, text in enumerate(texts, 1)]
        for k in range(1, len(texts) + 1):
            with c.when(number.equals(k), leaves=True):
                c.give(Value(c, POINTER, f"@px_message_{k}"))
    c.give(Value(c, POINTER, "null"))
    return "\n".join((*constants, c.text(SELDOM)))
