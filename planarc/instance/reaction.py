"""The event iteration of a run in Python, as machine code.

    shared    relations, settling, touches of `instance`; the same for all models that touch,
              and for all others
    own       the model's actions, what its touches read, and tables

Both call the kernel's functions. What switches, and when, the run finds by itself; it asks for
the iteration at that instant (`instance.reactor`), and decides itself what is doubtful
(`Own.DOUBT`), what ends the run, and what has no solution.
"""

from __future__ import annotations

from functools import partial

from planarc.codegen.native.assembly import table
from planarc.codegen.native.formulas import declarations
from planarc.codegen.native.machine import Events
from planarc.instance.actions import action_functions
from planarc.instance.block import copy_functions
from planarc.instance.plan import Table, crowd_names
from planarc.instance.relations import relation_table, zero_functions
from planarc.instance.settling import settling_functions
from planarc.instance.touches import touch_functions
from planarc.ir.program import Program
from planarc.solve.contact.touches import Points
from planarc.solve.events.crossings import unknowns

_KERNEL = """
declare double @llvm.fabs.f64(double)
declare double @llvm.sqrt.f64(double)
declare double @pow(double, double)
declare i64 @llvm.ctpop.i64(i64)
declare i32 @pc_outputs(ptr, double, ptr)
declare i32 @pc_rhs(ptr, double, ptr, ptr)
declare i32 @pc_roots(ptr, double, ptr, ptr)
declare i32 @pc_discrete(ptr, double)
"""
_MODEL = """
declare void @px_lefts(ptr, double)
declare void @px_branches(ptr, i64)
declare i32 @px_assign(ptr, double)
declare i64 @px_act(ptr, double)
@px_plan = external constant [0 x i64]
@px_relations = external constant [0 x i64]
@px_sampled = external constant [0 x i64]
@px_quiet_slots = external constant [0 x i64]
"""
#: Messages are put together in Python.
_TOUCHES = """
declare void @px_feel(ptr, double, ptr)
@px_touches = external constant [0 x i64]
define void @px_values(ptr %m, i64 %number) nounwind {
  ret void
}
"""
_PAST = """
declare double @pc_past(ptr, i64, i64, double)
declare double @pc_external(i64, i64, i64, ptr)
"""


def texts_of(program: Program) -> Events | None:
    """The texts; None where nothing switches. Of crowds, those of their steps."""
    if not program.switches:
        return None
    if crowd_names(program):
        from planarc.instance.crowd.stepping import texts_of as steps_of

        return steps_of(program)
    touches = bool(Points(program).all)
    kind = "touches" if touches else "relations"
    return Events(kind, partial(shared_text, touches), own_text(program))


def shared_text(touches: bool) -> str:
    """The functions that models share."""
    from planarc.instance.contact.functions import contact_functions
    from planarc.instance.events import reaction_functions

    functions = (
        *copy_functions(),
        *zero_functions(),
        *settling_functions(asks=True),
        *reaction_functions(),
        *((_TOUCHES, *contact_functions(asks=True)) if touches else ()),
    )
    return "\n".join((_KERNEL, _MODEL, *functions))


def own_text(program: Program) -> str:
    """Those of a model, and its tables."""
    points = Points(program)
    numbers = dict.fromkeys(Table, 0) | {
        Table.STATES: program.state_count,
        Table.SIZE: program.size,
        Table.RELATIONS: len(program.relations),
        Table.DISCRETES: len(program.discretes),
        Table.SAMPLES: len(program.samplers),
        Table.QUIET: len(unknowns(program)),
        Table.TOUCHES: len(points.all),
        Table.JAMS: 1,
    }
    return "\n".join(
        (
            declarations(),
            _PAST,
            action_functions(program, asks=True),
            touch_functions(program) if points.all else "",
            table("px_plan", numbers.values()),
            relation_table(program, ()),
        )
    )
