"""The code of an exported model: modules of LLVM, of which `objects` makes machine code.

    shared    the kernel's functions     `codegen.native.runtime`
              an instance's              `instance`
              the interface's            `export.fmi`
    own       the model's functions      `codegen.native.printer`
              its tables, its image      here

The image and the largest table are the same on all platforms: where they are long, an archive may
hold them once, in a file (`instance.stored`).

All functions but those of the interface are hidden, so that calls between them need no way
through a loader.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Sequence
from functools import cache, partial
from hashlib import sha256
from typing import TYPE_CHECKING

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, SELDOM, Code, Value, table
from planarc.codegen.native.carried import Carrier
from planarc.codegen.native.flags import SMALL
from planarc.codegen.native.formulas import bit, formula
from planarc.codegen.native.gauss import solve_functions
from planarc.codegen.native.packed import Rows, pack
from planarc.codegen.native.printer import ir, slopes_ir, weight
from planarc.core.data import Data
from planarc.export.crowds import member_names
from planarc.export.delays import delay_functions, delay_messages
from planarc.export.endings import most_values, subjects, templates
from planarc.export.fits import misfit_slots
from planarc.export.image import Image
from planarc.export.pruned import asked_in
from planarc.export.shared import Shared, traits_of
from planarc.export.tables import (
    home_words,
    image_words,
    lead,
    message_in_text,
    messages_by_number,
    plan_table,
    tables_of,
    take_tables,
    text_words,
)
from planarc.export.tunable import tunable_parameters
from planarc.instance.actions import (
    action_functions,
    carry_values,
    errors,
    first_misfit,
    first_warning,
)
from planarc.instance.clauses import ordered_discretes, reader
from planarc.instance.contact.area import kept_words, sizes
from planarc.instance.crowd import layout as crowd
from planarc.instance.crowd.table import Crowds, table_functions
from planarc.instance.plan import (
    Lags,
    Own,
    crowd_names,
    distances,
    make_plan,
    rules,
)
from planarc.instance.said import MARK
from planarc.instance.slopes import nodes_of
from planarc.instance.stored import stored_bytes
from planarc.instance.text import text_constant
from planarc.instance.touches import touch_functions
from planarc.ir.derivatives import Head, Scope
from planarc.ir.frame import Frame
from planarc.ir.program import Program
from planarc.solve.contact.touches import Points
from planarc.solve.start.sharing import FITS

if TYPE_CHECKING:
    from planarc.codegen.slopes import Slopes
    from planarc.export.fmi.entries import Entries


#: The derivatives of a model that has none.
_NOTHING = (len(Head), *(0 for _ in range(len(Head) - 1)))
_NO_SLOPES = """
define i32 @pc_slopes_all(ptr %frame, double %t, ptr %results) nounwind {
  ret i32 1
}
"""
#: Models of so many operations pay for the function that carries them out.
_LARGE = 800
#: How many modules do not hang on the model alone.
SHARED = 2
#: So many bytes, packed, pay for a file.
_MANY = 3000


class Written(Data):
    """The modules: what many models share, elimination, the model's own functions, its derivatives;
    and what is to stand in the file of numbers, nothing where the texts hold all."""

    shared: Shared
    solver: str
    own: str
    derivatives: str
    stored: bytes = b""

    @property
    def texts(self) -> tuple[str, ...]:
        return self.shared.text(), self.solver, self.own, self.derivatives


class Derived(Data):
    """The derivatives of a model: their module as text, and the numbers that go with it. `rows`
    begin with the place of the first operation of what their `carrier` was told."""

    text: str = _NO_SLOPES
    tape: Sequence[int] = _NOTHING
    nodes: Sequence[int] = ()
    rows: Sequence[int] = (0,)
    carrier: Carrier | None = None
    exist: bool = False


def derived(program: Program, lags: Lags | None, slopes: Slopes | None, spelled: bool) -> Derived:
    """What else a model's derivatives are. It may be made aside of all that `write` writes."""
    nodes = nodes_of(program, slopes)
    if slopes is None:
        return Derived(nodes=nodes)
    rows = Rows(Own.SLOPE_ROWS)
    rows.numbers.append(0)  # what is told late is no row that others may share
    carrier = _carrier(program, lags, spelled, joins=True)
    text = slopes_ir(program, slopes, Scope.ALL, rows, carrier)
    return Derived(text, slopes.tape(), nodes, rows.numbers, carrier, True)


def write_whole(
    program: Program, image: Image, entries: Entries, token: str, tolerance: float,
    slopes: Slopes | None = None, derivatives: bool = True, spelled: bool = False,
) -> Written:  # fmt: skip
    """The modules, whose texts hold all."""
    found = derived(program, image.lags, slopes, spelled)
    return write(
        program, image, entries, lambda: token, tolerance, lambda: found, derivatives, spelled
    )


def write(
    program: Program, image: Image, entries: Entries, token: Callable[[], str], tolerance: float,
    slopes: Callable[[], Derived], derivatives: bool = True, spelled: bool = False,
    apart: bool = False,
) -> Written:  # fmt: skip
    """The modules, which are the same for all platforms. Without `derivatives` nothing asks for
    them, steps are explicit, and the model's own functions are quick rather than small: a page runs
    them while something is dragged. The `token` is asked for late, the `slopes` once and behind it.
    `spelled`: large models carry out what runs seldom (`spelled`); `apart`: many numbers may stand
    in a file."""
    slopes = cache(slopes)
    own, stored = _own(program, image, entries, token, tolerance, slopes, derivatives,
                       _carrier(program, image.lags, spelled), apart)  # fmt: skip
    traits = traits_of(program, slopes().exist, derivatives, bool(stored))
    shared = Shared(traits, entries, frozenset(asked_in(own)))
    return Written(shared, solver_text(program), own, slopes().text, stored)


def _carrier(
    program: Program, lags: Lags | None, wanted: bool, joins: bool = False
) -> Carrier | None:
    """What carries out a large model's statements."""
    if not wanted or not is_large(program):
        return None
    return Carrier(Own.OPERATIONS, *distances(program, lags), joins)


def is_large(program: Program) -> bool:
    """Whether it takes so much to compute that numbers of it stand in a file, most likely."""
    return weight(program) >= _LARGE


def solver_text(program: Program) -> str:
    """Elimination: in registers only for the numbers of unknowns that the model has."""
    sizes = {len(b.residuals) for b in program.blocks if b.direct is None}
    smalls = sorted(n for n in sizes if 0 < n <= SMALL)
    return f"declare double @llvm.fabs.f64(double)\n{''.join(solve_functions(smalls))}"


def _own(
    program: Program, image: Image, entries: Entries, token: Callable[[], str], tolerance: float,
    slopes: Callable[[], Derived], small: bool, carrier: Carrier | None, apart: bool,
) -> tuple[str, bytes]:  # fmt: skip
    """The model's functions, its tables and its messages; what stands in the file of numbers."""
    rows = Rows(Own.ROWS)
    judged, crowds = _asserts(program, carrier, entries.warns), crowd_names(program)
    if crowds:
        felt, listed = table_functions(program, Crowds(program, image.selection), carrier)
        kept, area = crowd.kept_words(listed), crowd.sizes(listed, program)
    else:
        felt, touches = touch_functions(program, carrier), len(Points(program).all)
        kept, area = kept_words(touches), sizes(touches, program.state_count)
    functions = "\n".join(
        (ir(program, small, rows if small else None, carrier),
         *tables_of(program, image), action_functions(program, warns=entries.warns), felt)
    )  # fmt: skip
    discretes = [n for d in ordered_discretes(program)[0] for n in (d.slot, d.pre, d.start)]
    settable = rules(program, image.held, tunable_parameters(program))
    lags = image.lags
    ends, values = templates(program, entries.as_shown, entries.warns)
    late = delay_messages(program, lags)
    ends += [f"at t = {MARK}t6 s {entries.as_shown(text)}" for text in late]
    seal = int.from_bytes(sha256(token().encode()).digest()[:7])
    found = slopes()
    of_slopes, constants = [*found.rows], []
    if carrier is not None:
        if found.carrier is not None:
            of_slopes[0] = carrier.join(found.carrier)
        functions, constants = f"{functions}\n{carrier.text(rows)}", carrier.constants
    unpacked = [*found.nodes, *settable, *discretes, *rows.numbers, *of_slopes, *found.tape]
    planned = partial(make_plan, program, image.held, len(image.scales), found.tape,
                      (len(rows.numbers), len(of_slopes)), kept, area, most_values(program), lags,
                      0 if carrier is None else carrier.room, len(constants),
                      0 if carrier is None else carrier.words)  # fmt: skip
    told, stored, plan = messages_by_number(ends, apart), b"", planned()
    words, packed = image_words(program, image, plan, tolerance, constants), pack(unpacked)
    if apart and len(zlib.compress(stored_bytes([*words, *packed]))) > _MANY:
        functions, led = take_tables(functions)
        unpacked += [n for numbers in led.values() for n in numbers]
        packed, letters = pack(unpacked), text_words(ends)
        homes = home_words(planned(tables=led, packed=len(packed)))
        plan = planned(tables=led, packed=len(packed), letters=len(letters) + len(homes))
        words = image_words(program, image, plan, tolerance, constants)
        stored = stored_bytes([seal, *words, *packed, *letters, *home_words(plan)])
        numbers, told = "", message_in_text()
    else:
        numbers = table("px_image", words) + table("px_packed", packed)
    name = program.name.encode("ascii", "replace").decode()
    texts = [("token", token()), ("name", name)]
    own = "\n".join(
        (
            functions,
            *(text_constant(f"px_{key}", text) for key, text in texts),
            plan_table(program, image, plan, len(unpacked), found.exist, len(stored) // 8),
            numbers,
            table("px_seal", [seal]),
            delay_functions(program, lags, plan.image, len(ends) - len(late) + 1),
            judged,
            told,
            values,
            subjects(program, entries.as_shown),
            member_names(program, image.selection, entries.as_shown) if crowds else "",
        )
    )
    return lead(own) if stored else own, stored


def _asserts(program: Program, carrier: Carrier | None, warns: bool) -> str:
    """Which assertion fails first, counted from 1, or which condition that was left out. Those that
    only warn are told where none fails, each once."""
    c = Code("px_asserts", FLAG, ((POINTER, "frame"), (REAL, "t")))
    frame, t = c.arguments
    conditions = [a.condition for a in errors(program)]
    count = len(conditions)
    conditions += [a.condition for a in program.assertions if a.warning and warns]
    truths = Value(c, POINTER, "%truths")
    if carry_values(program, conditions, carrier, c, truths):
        c.place(REAL, len(conditions), truths.text)
        with c.loop(count) as i, c.when(~bit(c, truths.load(REAL, i)), leaves=True):
            c.give(c.flag(i + 1))
        mild = (bit(c, truths.load(REAL, k)) for k in range(count, len(conditions)))
    else:
        leaf = reader(program, frame.load(POINTER, Frame.W), t)
        for k, condition in enumerate(conditions[:count], 1):
            with c.when(~bit(c, formula(c, condition, leaf)), leaves=True):
                c.give(k)
        mild = (bit(c, formula(c, condition, leaf)) for condition in conditions[count:])
    for k, slot in enumerate(misfit_slots(program), first_misfit(program)):
        off = c.absolute(frame.load(POINTER, Frame.W).load(REAL, slot))
        with c.when(~(off <= FITS), leaves=True):
            c.give(k)
    told = frame.load(POINTER, Own.WARNED)
    for k, (number, holds) in enumerate(enumerate(mild, first_warning(program))):
        with c.when(~holds & told.load(INT, k).equals(0)):
            told.store(c.constant(1, INT), k)
            c.run("px_warn", frame, c.constant(number, INT))
    c.give(0)
    return c.text(SELDOM)
