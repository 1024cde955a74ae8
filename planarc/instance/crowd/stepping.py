"""The steps of a run in Python with crowds, as machine code.

    shared    the functions of a step; the same for all models with crowds
    own       what a model's bodies read, and tables

    px_react(block, apart) -> flag    a step of `Own.SPAN` from `Own.REACH` on; or, with `apart`,
                                      whether no two bodies begin in each other

The run asks for a step at a time (`instance.crowd.stepper`). What does not go well Python does
again, and tells.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, REAL, Code, Value, function, table
from planarc.codegen.native.formulas import declarations
from planarc.codegen.native.machine import Events
from planarc.instance.block import copy_functions
from planarc.instance.crowd.functions import moved_functions
from planarc.instance.crowd.table import crowds_of, table_functions
from planarc.instance.plan import Own, Table
from planarc.ir.program import Program

_OTHERS = """
declare double @llvm.fabs.f64(double)
declare double @llvm.sqrt.f64(double)
declare ptr @calloc(i64, i64)
declare void @free(ptr)
declare i32 @pc_outputs(ptr, double, ptr)
declare i32 @pc_sweep(ptr, ptr, ptr, ptr, ptr, ptr, ptr, i64, i64, double)
declare void @px_feel(ptr, double, ptr)
@px_plan = external constant [0 x i64]
@px_system = external constant [0 x i64]
@px_touches = external constant [0 x i64]
define ptr @px_member(i64 %number) nounwind {
  ret ptr null
}
define void @px_values(ptr %m, i64 %number) nounwind {
  ret void
}
"""
#: Numbers in the table `px_system` before the candidates' slots.
_BEFORE = 5


def texts_of(program: Program) -> Events:
    return Events("crowd", _shared, _own(program), often=True)


def _shared() -> str:
    return "\n".join((_OTHERS, *copy_functions(), *moved_functions(), _react()))


@function("i32 px_react(ptr m, i64 apart)")
def _react(c: Code, m: Value, apart: Value) -> None:
    with c.when(apart.equals(1), leaves=True):
        c.give(c.call(FLAG, "px_apart", m))
    t, h = m.load(REAL, Own.REACH), m.load(REAL, Own.SPAN)
    c.give(c.call(FLAG, "px_moment", m, t, h))


def _own(program: Program) -> str:
    felt, _ = table_functions(program, crowds_of(program))
    numbers = dict.fromkeys(Table, 0) | {
        Table.STATES: program.state_count,
        Table.SIZE: program.size,
        Table.MOVED: len(program.candidates),
    }
    candidates = [c.slot for c in program.candidates]
    return "\n".join(
        (
            declarations(),
            "declare double @pc_past(ptr, i64, i64, double)",
            "declare double @pc_external(i64, i64, i64, ptr)",
            felt,
            table("px_plan", numbers.values()),
            table("px_system", [*[0] * _BEFORE, *candidates]),
        )
    )
