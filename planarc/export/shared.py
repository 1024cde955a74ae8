"""The functions that many exported models share, as a text of LLVM.

    the kernel's        `codegen.native.runtime`
    an instance's       `instance`
    the interface's     `export.fmi`

They hang on the interface, on a few traits of a model, and on which of them it calls: where their
objects are known by that (`objects`), no text is written.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from planarc.core.data import Data
from planarc.export.pruned import NONE, prune
from planarc.export.tables import counts, lead
from planarc.instance.plan import Table, crowd_names, is_eventful
from planarc.solve.contact.touches import Points

if TYPE_CHECKING:
    from planarc.export.fmi.entries import Entries
    from planarc.ir.program import Program

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
declare ptr @px_message(ptr, i32)
declare ptr @px_subject(i64)
declare void @px_values(ptr, i64)
declare ptr @calloc(i64, i64)
declare void @free(ptr)
declare void @px_branches(ptr, i64)
declare void @px_lefts(ptr, double)
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


#: What a model's own functions may call: code that many models share has it all.
CALLED = frozenset(
    {"pc_carry", "pc_direct", "pc_linear", "pc_past", "pc_start", "pc_step"}
    | {"px_copy", "px_impact", "px_reinit", "px_warn"}
)


class Traits(Data):
    """What shared functions hang on: whether something touches, or there are delayed signals, a
    crowd, events or derivatives; and whether numbers stand in a file. `none` are pairs of a place
    in the model's plan and its number, which says that there is none of something."""

    touches: bool
    delayed: bool
    crowded: bool
    eventful: bool
    derived: bool
    apart: bool
    none: tuple[tuple[int, int], ...] = ()


def traits_of(program: Program, slopes: bool, derivatives: bool, apart: bool) -> Traits:
    """`slopes`: the model can be differentiated; `derivatives`: that is asked for."""
    known = counts(program) | {Table.SLOPES: int(slopes), Table.STORED: int(apart)}
    crowded = bool(crowd_names(program))
    return Traits(
        touches=bool(Points(program).all),
        delayed=bool(program.delays),
        crowded=crowded,
        eventful=is_eventful(program),
        derived=derivatives and not crowded,
        apart=apart,
        none=tuple((int(place), n) for place, n in known.items() if n in NONE),
    )


class Shared(Data):
    """Those that the interface calls, and those that are `called` from a model's own."""

    traits: Traits
    entries: Entries
    called: frozenset[str]

    @property
    def key(self) -> tuple[str, ...]:
        """What `text` hangs on, besides the state of planarc's files."""
        e = self.entries
        version = (e.by_uri, e.tells, e.as_shown.__qualname__)
        return repr(self.traits), repr(version), e.text(), *sorted({*e.names, *self.called})

    def text(self) -> str:
        text = _whole(self.traits, self.entries)
        return prune(lead(text) if self.traits.apart else text, {*self.entries.names, *self.called})


def _whole(traits: Traits, entries: Entries) -> str:
    from planarc.codegen.native.operations import operate_function
    from planarc.codegen.native.runtime import runtime_text
    from planarc.instance.advance import advance_functions
    from planarc.instance.block import block_functions
    from planarc.instance.contact.functions import contact_functions
    from planarc.instance.crowd.functions import crowd_functions
    from planarc.instance.ends import end_functions
    from planarc.instance.events import event_functions
    from planarc.instance.instants import instant_functions
    from planarc.instance.past.functions import past_functions
    from planarc.instance.reaching import reaching_functions
    from planarc.instance.relations import relation_functions
    from planarc.instance.said import said_functions
    from planarc.instance.settling import settling_functions
    from planarc.instance.slopes import slope_functions
    from planarc.instance.start import start_functions
    from planarc.instance.states import state_functions
    from planarc.instance.steps import step_functions
    from planarc.instance.stiff import stiff_functions
    from planarc.instance.stored import stored_functions
    from planarc.instance.uneventful import uneventful_functions
    from planarc.instance.within import within_functions

    touches, delayed, crowded = traits.touches, traits.delayed, traits.crowded
    apart, events = traits.apart, uneventful_functions()
    if traits.eventful:
        events = (*relation_functions(), *instant_functions(delayed), *settling_functions(),
                  *event_functions(delayed, entries.tells, apart, crowded),
                  *end_functions(), *within_functions())  # fmt: skip
    functions = (
        *block_functions(delayed, apart, crowded),
        *(stored_functions(entries.by_uri, entries.as_shown) if apart else ()),
        *reaching_functions(),
        operate_function(),
        *said_functions(),
        *start_functions(apart),
        *state_functions(),
        *(() if crowded else step_functions(delayed)),
        *advance_functions(delayed, crowded),
        *events,
        *(past_functions(crowded) if delayed else ()),
        *(crowd_functions(delayed) if crowded else contact_functions() if touches else (_APART,)),
        *((*slope_functions(), *stiff_functions()) if traits.derived else (_EXPLICIT,)),
        entries.text(),
    )
    tables = "".join(f"@px_{name} = external constant [0 x i64]\n" for name in _TABLES)
    return "\n".join((runtime_text(_SOLVER), _MODEL, tables, *functions))
