"""The march of CVODE in machine code, so that no step comes back to Python.

A call from Python into a compiled function costs 1 us, twice as much as a right-hand
side of a four-bar; a step with its accepted point, a row and a look at the choice of
states would need five of them. The function below is the same as
`integrator.march_steps`, once for all programs: everything that differs is an address
in `Arguments`. It returns when CVODE reports anything but an ordinary step, when the
steps allowed are used up, when the choice of states is to be looked at (`watch`), or
when the kernel could not solve its equations.
"""

from __future__ import annotations

import ctypes as C
import struct
from functools import cache
from typing import Any

from planarc.core import cache as store
from planarc.core.data import Data
from planarc.ir.kernel import Addresses
from planarc.solve.recorder import Recorder
from planarc.solve.refuge import Refuge
from planarc.solve.solvers.sundials import Sundials
from planarc.solve.solvers.watch import GROWN, WORST, Watch

_P, _D, _L = C.c_void_p, C.c_double, C.c_int64


class Arguments(C.Structure):
    """The structure that the code below reads, with all that one call needs."""

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
        ("taken", _L),
        ("failed", _L),
        ("sensitivity", _P),  # `look` of the kernel's addresses
        ("blocks", _P),
        ("block_count", _L),
        ("scales", _P),
        ("bound", _D),
        ("looks", _L),
        ("kept_slots", _P),  # int32, of the refuge
        ("kept_count", _L),
        ("guess", _P),
        ("state", _P),
        ("states", _L),
        ("kept_rows", _P),
        ("edition", _L),  # of the recorder that `rows` and `times` belong to
    )
    #: Objects that must live as long as the addresses above.
    held: tuple[object, ...] = ()


#: `next`, `count`, `taken`, `bound`, `looks` and `failed` are written back through %next_at and
#: so on.
#: Where no row was taken the point reached is accepted as it was evaluated last, when
#: CVODE's corrector converged: it lies within the tolerance, and blocks only start there.
_IR = """
step:
  %done = phi i64 [ 0, %entry ], [ %done_now, %again ]
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
  %evaluated = load double, ptr %workspace
  %is_here = fcmp oeq double %evaluated, %t
  br i1 %is_here, label %tell, label %evaluate

evaluate:
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
  call void @gather(ptr %workspace, ptr %slots, i64 %columns, ptr %line)
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
  store i64 %done_now, ptr %taken_at
  %budget = icmp slt i64 %done_now, %steps
  br i1 %ordinary, label %watch, label %finish

watch:
  %watched = icmp sgt i64 %block_count, 0
  br i1 %watched, label %look, label %again

look:
  %worst = call double %sensitivity(ptr %context, ptr %blocks, i64 %block_count, ptr %scales)
  %before_look = load double, ptr %bound_at
  %good = fcmp ole double %worst, %before_look
  br i1 %good, label %keep, label %ask

ask:
  store i64 1, ptr %looks_at
  br label %finish

keep:
  %ordinary_size = fcmp ole double %worst, WORST
  %grown = fmul double %worst, GROWN
  %bound_here = select i1 %ordinary_size, double WORST, double %grown
  %lower = fcmp olt double %bound_here, %before_look
  %bound_now = select i1 %lower, double %bound_here, double %before_look
  store double %bound_now, ptr %bound_at
  call void @gather(ptr %workspace, ptr %kept_slots, i64 %kept_count, ptr %guess)
  store double %t, ptr %state
  %state_values = getelementptr double, ptr %state, i64 1
  call void @copy(ptr %y_numbers, i64 %states, ptr %state_values)
  store i64 %count_after, ptr %kept_rows
  %kept_next = getelementptr i64, ptr %kept_rows, i64 1
  %next_now = load i64, ptr %next_at
  store i64 %next_now, ptr %kept_next
  br label %again

again:
  br i1 %budget, label %step, label %finish

fail:
  store i64 1, ptr %failed_at
  br label %finish

finish:
  %result = sext i32 %flag to i64
  ret i64 %result
}
"""


#: to[i] = from[slots[i]], and to[i] = from[i].
_COPIES = """
define internal void @gather(ptr %from, ptr %slots, i64 %count, ptr %to) {
entry:
  br label %test
test:
  %i = phi i64 [ 0, %entry ], [ %next, %one ]
  %more = icmp slt i64 %i, %count
  br i1 %more, label %one, label %done
one:
  %slot_at = getelementptr i32, ptr %slots, i64 %i
  %slot32 = load i32, ptr %slot_at
  %slot = sext i32 %slot32 to i64
  %source = getelementptr double, ptr %from, i64 %slot
  %number = load double, ptr %source
  %target = getelementptr double, ptr %to, i64 %i
  store double %number, ptr %target
  %next = add i64 %i, 1
  br label %test
done:
  ret void
}

define internal void @copy(ptr %from, i64 %count, ptr %to) {
entry:
  br label %test
test:
  %i = phi i64 [ 0, %entry ], [ %next, %one ]
  %more = icmp slt i64 %i, %count
  br i1 %more, label %one, label %done
one:
  %source = getelementptr double, ptr %from, i64 %i
  %number = load double, ptr %source
  %target = getelementptr double, ptr %to, i64 %i
  store double %number, ptr %target
  %next = add i64 %i, 1
  br label %test
done:
  ret void
}
"""


def _exact(value: float) -> str:
    return f"0x{struct.pack('>d', value).hex().upper()}"


def _module_text() -> str:
    """The function `march(arguments)`: all fields are loaded first, under their names."""
    kinds = {_P: "ptr", _D: "double", _L: "i64"}
    fields = [(name, kinds[kind]) for name, kind in Arguments._fields_]
    lines = [
        f"%arguments = type {{ {', '.join(kind for _, kind in fields)} }}",
        _COPIES,
        "define i64 @march(ptr %a) {",
        "entry:",
    ]
    for i, (name, kind) in enumerate(fields):
        lines.append(f"  %{name}_at = getelementptr %arguments, ptr %a, i32 0, i32 {i}")
        lines.append(f"  %{name} = load {kind}, ptr %{name}_at")
    body = _IR.replace("WORST", _exact(WORST)).replace("GROWN", _exact(GROWN))
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
        """The arguments that stay the same as long as the run and CVODE's memory do."""
        import numpy as np

        blocks = np.array([kernel.records[i] for i in watch.blocks], dtype=np.int64)
        arguments = Arguments(
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
            sensitivity=kernel.look,
            blocks=blocks.ctypes.data,
            block_count=len(blocks),
            scales=watch.scales.ctypes.data,
            edition=-1,
        )
        arguments.held = (blocks,)
        if watch.refuge is not None:
            _keep_in(watch.refuge, arguments)
        return arguments

    def march(
        self, a: Arguments, limit: float, recorder: Recorder, watch: Watch, steps: int
    ) -> tuple[int, bool, bool]:
        """CVODE's last flag, whether the kernel failed, and whether the choice of states is
        to be looked at; `a.taken` are the steps taken. Rows go to the recorder."""
        recorder.reserve(len(recorder.grid) - recorder.next + 2)
        if a.edition != recorder.edition:
            a.rows = recorder.data.ctypes.data
            a.times = recorder.time.ctypes.data
            a.edition = recorder.edition
        a.limit, a.steps, a.bound = limit, steps, watch.bound
        a.next, a.count, a.taken = recorder.next, recorder.count, 0
        a.failed = a.looks = 0
        flag: int = self._call(C.byref(a))
        recorder.next, recorder.count, watch.bound = a.next, a.count, a.bound
        return flag, bool(a.failed), bool(a.looks)


def _keep_in(refuge: Refuge, a: Arguments) -> None:
    a.kept_slots, a.kept_count = refuge.slots.ctypes.data, len(refuge.slots)
    a.guess, a.state = refuge.guess.ctypes.data, refuge.state.ctypes.data
    a.states, a.kept_rows = len(refuge.state) - 1, refuge.rows.ctypes.data
    a.held = (*a.held, refuge)


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
