"""The march of CVODE in machine code, so that no step comes back to Python.

A call from Python into a compiled function costs 1 us, as much as ten right-hand
sides of a four-bar; a step with its accepted point and a row would need four of
them. The function below is the same as `integrator.march_steps`, once for all
programs: everything that differs is an address in `Arguments`. It returns when
CVODE reports anything but an ordinary step, when the steps allowed are used up, or
when the kernel could not solve its equations.
"""

from __future__ import annotations

import ctypes as C
from functools import cache
from typing import Any

from planarc.core import cache as store
from planarc.core.data import Data
from planarc.ir.program import Addresses
from planarc.solve.recorder import Recorder
from planarc.solve.solvers.integrator import AT_REST, Watch
from planarc.solve.solvers.sundials import Sundials

_P, _D, _L = C.c_void_p, C.c_double, C.c_int64


class Arguments(C.Structure):
    """What one call needs, as the structure that the code below reads."""

    _fields_ = (
        ("memory", _P),  # of CVODE
        ("y", _P),  # N_Vector
        ("y_numbers", _P),
        ("dense", _P),  # N_Vector for interpolated states and scratch
        ("dense_numbers", _P),
        ("context", _P),
        ("workspace", _P),
        ("slots", _P),  # int32
        ("grid", _P),
        ("rows", _P),
        ("times", _P),
        ("cvode", _P),
        ("interpolate", _P),
        ("rhs", _P),
        ("outputs", _P),
        ("accept", _P),
        ("time", _P),  # where CVODE writes the time reached
        ("limit", _D),
        ("near", _D),  # rows nearer than this to a root or the limit are left to Python
        ("columns", _L),
        ("grid_end", _L),
        ("next", _L),
        ("count", _L),
        ("steps", _L),
        ("failed", _L),
        ("watched", _P),  # int32: slots
        ("reference", _P),
        ("watch_count", _L),
        ("watch_limit", _D),
        ("paced", _P),  # int32: slots of velocities
        ("pace_weights", _P),
        ("pace_count", _L),
        ("pace_bound", _D),
        ("edition", _L),  # of the recorder that `rows` and `times` belong to
    )


#: `next`, `count` and `failed` are written back through %next_at, %count_at, %failed_at.
_IR = """
step:
  %done = phi i64 [ 0, %entry ], [ %done_now, %pace ]
  %flag = call i32 %cvode(ptr %memory, double %limit, ptr %y, ptr %time, i32 2)
  %bad = icmp slt i32 %flag, 0
  br i1 %bad, label %finish, label %reached

reached:
  %t = load double, ptr %time
  %zero_flag = icmp eq i32 %flag, 0
  %warning = icmp eq i32 %flag, 99
  %ordinary = or i1 %zero_flag, %warning
  %before = fsub double %t, %near
  %until = select i1 %ordinary, double %t, double %before
  %count_before = load i64, ptr %count_at
  br label %row

accepted:
  %rhs_flag = call i32 %rhs(double %t, ptr %y, ptr %dense, ptr %context)
  %rhs_bad = icmp ne i32 %rhs_flag, 0
  br i1 %rhs_bad, label %fail, label %tell

tell:
  %accept_flag = call i32 %accept(ptr %context, double %t)
  br label %after_step

row:
  %here = load i64, ptr %next_at
  %more = icmp slt i64 %here, %grid_end
  br i1 %more, label %row_time, label %after_rows

row_time:
  %due_at = getelementptr double, ptr %grid, i64 %here
  %due = load double, ptr %due_at
  %is_due = fcmp ole double %due, %until
  br i1 %is_due, label %row_take, label %after_rows

row_take:
  %dky_flag = call i32 %interpolate(ptr %memory, double %due, i32 0, ptr %dense)
  %row_flag = call i32 %outputs(ptr %context, double %due, ptr %dense_numbers)
  %row_bad = icmp ne i32 %row_flag, 0
  br i1 %row_bad, label %fail, label %row_copy

row_copy:
  %filled = load i64, ptr %count_at
  %stamp = getelementptr double, ptr %times, i64 %filled
  store double %due, ptr %stamp
  %offset = mul i64 %filled, %columns
  %line = getelementptr double, ptr %rows, i64 %offset
  br label %copy

copy:
  %column = phi i64 [ 0, %row_copy ], [ %column_next, %copy_one ]
  %copying = icmp slt i64 %column, %columns
  br i1 %copying, label %copy_one, label %row_done

copy_one:
  %slot_at = getelementptr i32, ptr %slots, i64 %column
  %slot32 = load i32, ptr %slot_at
  %slot = sext i32 %slot32 to i64
  %from = getelementptr double, ptr %workspace, i64 %slot
  %number = load double, ptr %from
  %to = getelementptr double, ptr %line, i64 %column
  store double %number, ptr %to
  %column_next = add i64 %column, 1
  br label %copy

row_done:
  %filled_next = add i64 %filled, 1
  store i64 %filled_next, ptr %count_at
  %row_accept_flag = call i32 %accept(ptr %context, double %due)
  %here_next = add i64 %here, 1
  store i64 %here_next, ptr %next_at
  br label %row

after_rows:
  %count_after = load i64, ptr %count_at
  %no_row = icmp eq i64 %count_after, %count_before
  %needs_point = and i1 %ordinary, %no_row
  br i1 %needs_point, label %accepted, label %after_step

after_step:
  %done_now = add i64 %done, 1
  %budget = icmp slt i64 %done_now, %steps
  %again = and i1 %ordinary, %budget
  br i1 %again, label %watch, label %finish

watch:
  %index = phi i64 [ 0, %after_step ], [ %index_next, %watch_one ]
  %watching = icmp slt i64 %index, %watch_count
  br i1 %watching, label %watch_one, label %pace

watch_one:
  %watched_at_one = getelementptr i32, ptr %watched, i64 %index
  %watched32 = load i32, ptr %watched_at_one
  %watched_slot = sext i32 %watched32 to i64
  %present_at = getelementptr double, ptr %workspace, i64 %watched_slot
  %present = load double, ptr %present_at
  %past_at = getelementptr double, ptr %reference, i64 %index
  %past = load double, ptr %past_at
  %way = fsub double %present, %past
  %length = call double @llvm.fabs.f64(double %way)
  %far = fcmp ogt double %length, %watch_limit
  %index_next = add i64 %index, 1
  br i1 %far, label %finish, label %watch

pace:
  %k = phi i64 [ 0, %watch ], [ %k_next, %pace_next ]
  %slowest = phi double [ 0.0, %watch ], [ %slowest_next, %pace_next ]
  %was_solved = phi i1 [ true, %watch ], [ %solved, %pace_next ]
  %pacing = icmp slt i64 %k, %pace_count
  br i1 %pacing, label %pace_one, label %step

pace_one:
  %paced_at_one = getelementptr i32, ptr %paced, i64 %k
  %paced32 = load i32, ptr %paced_at_one
  %paced_slot = sext i32 %paced32 to i64
  %velocity_at = getelementptr double, ptr %workspace, i64 %paced_slot
  %velocity = load double, ptr %velocity_at
  %weight_at = getelementptr double, ptr %pace_weights, i64 %k
  %weight = load double, ptr %weight_at
  %solved = fcmp ogt double %weight, 0.0
  %weighed = fmul double %velocity, %weight
  %pace_here = call double @llvm.fabs.f64(double %weighed)
  br i1 %solved, label %pace_solved, label %pace_free

pace_free:
  %before_this = select i1 %was_solved, double 0.0, double %slowest
  %faster = fcmp ogt double %pace_here, %before_this
  %slowest_now = select i1 %faster, double %pace_here, double %before_this
  br label %pace_next

pace_solved:
  %allowed = fmul double %pace_bound, %slowest
  %over = fcmp ogt double %pace_here, %allowed
  %moving = fcmp ogt double %pace_here, AT_REST
  %too_fast = and i1 %over, %moving
  br i1 %too_fast, label %finish, label %pace_next

pace_next:
  %slowest_next = phi double [ %slowest_now, %pace_free ], [ %slowest, %pace_solved ]
  %k_next = add i64 %k, 1
  br label %pace

fail:
  store i64 1, ptr %failed_at
  br label %finish

finish:
  %result = sext i32 %flag to i64
  ret i64 %result
}
"""


def _module_text() -> str:
    """The function `march(arguments)`: all fields are loaded first, under their names."""
    kinds = {_P: "ptr", _D: "double", _L: "i64"}
    fields = [(name, kinds[kind]) for name, kind in Arguments._fields_]
    lines = [
        f"%arguments = type {{ {', '.join(kind for _, kind in fields)} }}",
        "declare double @llvm.fabs.f64(double)",
        "define i64 @march(ptr %a) {",
        "entry:",
    ]
    for i, (name, kind) in enumerate(fields):
        lines.append(f"  %{name}_at = getelementptr %arguments, ptr %a, i32 0, i32 {i}")
        lines.append(f"  %{name} = load {kind}, ptr %{name}_at")
    body = _IR.replace("AT_REST", f"{AT_REST:e}")
    return "\n".join([*lines, "  br label %step", body])


class Where(Data):
    """CVODE's memory, its vectors (states, and scratch), and where it writes the time."""

    memory: int
    y: int
    dense: int
    time: C.c_double


class Driver:
    """The compiled march; holds the engine that owns its code."""

    def __init__(self, sundials: Sundials, engine: Any) -> None:
        self._engine = engine
        address = engine.get_function_address("march")
        self._call = C.CFUNCTYPE(_L, C.POINTER(Arguments))(address)
        self._cvode = sundials.address("CVode")
        self._interpolate = sundials.address("CVodeGetDky")
        self._numbers = sundials.N_VGetArrayPointer

    def prepare(
        self, where: Where, kernel: Addresses, recorder: Recorder, watch: Watch
    ) -> Arguments:
        """What stays the same as long as the run and CVODE's memory do."""
        return Arguments(
            memory=where.memory,
            y=where.y,
            y_numbers=self._numbers(where.y),
            dense=where.dense,
            dense_numbers=self._numbers(where.dense),
            context=kernel.context,
            workspace=kernel.workspace,
            slots=recorder.slots.ctypes.data,
            grid=recorder.grid.ctypes.data,
            cvode=self._cvode,
            interpolate=self._interpolate,
            rhs=kernel.cv_rhs,
            outputs=kernel.outputs,
            accept=kernel.accept,
            time=C.addressof(where.time),
            near=recorder.near,
            columns=len(recorder.slots),
            grid_end=len(recorder.grid),
            watched=watch.slots.ctypes.data,
            reference=watch.reference.ctypes.data,
            watch_count=len(watch.slots),
            paced=watch.speeds.ctypes.data,
            pace_weights=watch.weights.ctypes.data,
            pace_count=len(watch.speeds),
            edition=-1,
        )

    def march(
        self, a: Arguments, limit: float, recorder: Recorder, watch: Watch, steps: int
    ) -> tuple[int, bool]:
        """CVODE's last flag, and whether the kernel failed. Rows go to the recorder."""
        recorder.reserve(len(recorder.grid) - recorder.next + 2)
        if a.edition != recorder.edition:
            a.rows = recorder.data.ctypes.data
            a.times = recorder.time.ctypes.data
            a.edition = recorder.edition
        a.limit, a.steps, a.watch_limit, a.pace_bound = limit, steps, watch.limit, watch.bound
        a.next, a.count, a.failed = recorder.next, recorder.count, 0
        flag: int = self._call(C.byref(a))
        recorder.next, recorder.count = a.next, a.count
        return flag, bool(a.failed)


@cache
def open_driver(sundials: Sundials) -> Driver | None:
    """Linked once in a process; None where there is no llvmlite."""
    try:
        import llvmlite.binding as llvm
    except ImportError:
        return None
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target = llvm.Target.from_triple(llvm.get_process_triple())
    machine = target.create_target_machine(opt=1, codemodel="jitdefault", jit=True)
    empty = llvm.parse_assembly("")
    empty.triple = llvm.get_process_triple()
    engine = llvm.create_mcjit_compiler(empty, machine)
    engine.add_object_file(llvm.ObjectFileRef.from_data(_object(llvm, machine)))
    engine.finalize_object()
    return Driver(sundials, engine)


def _object(llvm: Any, machine: Any) -> bytes:
    """The compiled function for any processor of this kind, kept between processes."""
    text, triple = _module_text(), llvm.get_process_triple()
    version = ".".join(map(str, llvm.llvm_version_info))
    key = store.key("driver", text, triple, version)
    known = store.load("driver", key)
    if known is None:
        module = llvm.parse_assembly(text)
        module.triple = triple
        module.verify()
        known = bytes(machine.emit_object(module))
        store.store("driver", key, known)
    return known
