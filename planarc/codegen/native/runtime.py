"""The native kernel's functions, in LLVM: the same for every model.

    pc_rhs, pc_outputs, pc_roots, pc_accept, pc_evaluate   see `planarc.ir.kernel.Kernel`
    pc_cv_rhs, pc_cv_roots                                 two of them as CVODE calls them
    pc_cv_differences                                      the Jacobian as CVODE calls it
    pc_past                                                `planarc.runtime.history.History.value`

Newton's method (`newton`) and its elimination (`gauss`), looks at the choice of states (`look`),
the start (`begin`, `differences`, `root`, `motions`), CVODE's steps (`march`). The model's own
functions are `printer`'s.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value, function
from planarc.codegen.native.begin import begin_functions
from planarc.codegen.native.choice import choice_functions
from planarc.codegen.native.differences import difference_functions
from planarc.codegen.native.gauss import solve_functions
from planarc.codegen.native.look import look_functions
from planarc.codegen.native.march import march_function
from planarc.codegen.native.motions import motions_function
from planarc.codegen.native.newton import linear_top_function, newton_functions, open_frame
from planarc.codegen.native.pair import pair_functions
from planarc.codegen.native.reaching import give_where_far
from planarc.codegen.native.root import root_function, seek_function
from planarc.codegen.native.sparse import direct_function
from planarc.codegen.native.sweeps import sweep_function
from planarc.ir.frame import Frame, Mode, Number, Record
from planarc.ir.newton import DIFFERENCE
from planarc.runtime.history import DEGREE, TERMS, Memory

_DECLARED = """
declare double @llvm.fabs.f64(double)
declare double @llvm.sqrt.f64(double)
declare i32 @pc_levels(ptr, double)
declare i32 @pc_rest(ptr, double)
declare i32 @pc_initial(ptr, double, ptr)
declare i32 @pc_zeros(ptr, double, ptr)
@pc_blocks = external constant [0 x i64]
"""


def runtime_text(solver: str | None = None) -> str:
    """The whole module, with another text in the place of elimination where one is given."""
    functions = (
        *newton_functions(),
        direct_function(),
        *((*solve_functions(), *_alone()) if solver is None else (solver,)),
        *pair_functions(),
        *look_functions(),
        *difference_functions(),
        root_function(),
        motions_function(),
        *begin_functions(),
        *choice_functions(),
        _states(),
        _rhs(),
        _outputs(),
        _roots(),
        _accept(),
        _evaluate(),
        _cv_rhs(),
        _cv_roots(),
        _cv_differences(),
        _past(),
        march_function(),
        sweep_function(),
    )
    return _DECLARED + "\n".join(functions)


def _alone() -> tuple[str, ...]:
    """What this process alone has use for."""
    return linear_top_function(), seek_function()


@function("void pc_states(ptr frame, double t, ptr y)")
def _states(c: Code, frame: Value, t: Value, y: Value) -> None:
    """Time and states into the workspace."""
    w, numbers, _, _ = open_frame(frame)
    w.store(t)
    numbers.store(c.constant(-1, INT), Number.FAILED)
    numbers.store(c.constant(-1, INT), Number.OPEN)
    slots = numbers.at(Number.FIRST_STATE)
    with c.loop(numbers.load(INT, Number.STATES)) as i:
        w.store(y.load(REAL, i), slots.load(INT, i))
    c.give()


def _try(c: Code, function: str, *arguments: Value) -> None:
    """Call, and give its flag when that is not 0."""
    flag = c.call(FLAG, function, *arguments)
    with c.when(~flag.equals(0), leaves=True):
        c.give(flag)


@function("i32 pc_rhs(ptr frame, double t, ptr y, ptr d)")
def _rhs(c: Code, frame: Value, t: Value, y: Value, d: Value) -> None:
    c.run("pc_states", frame, t, y)
    _try(c, "pc_levels", frame, t)
    w, numbers, _, _ = open_frame(frame)
    states = numbers.load(INT, Number.STATES)
    slots = numbers.at(states + Number.FIRST_STATE)
    total = c.variable(0.0)
    with c.loop(states) as i:
        value = w.load(REAL, slots.load(INT, i))
        d.store(value, i)
        total.set(total.get() + value * 0.0)
    c.give(c.select(total.get().equals(0.0), c.constant(0, FLAG), c.constant(-1, FLAG)))


@function("i32 pc_outputs(ptr frame, double t, ptr y)")
def _outputs(c: Code, frame: Value, t: Value, y: Value) -> None:
    c.run("pc_states", frame, t, y)
    _try(c, "pc_levels", frame, t)
    c.give(c.call(FLAG, "pc_rest", frame, t))


@function("i32 pc_roots(ptr frame, double t, ptr y, ptr g)")
def _roots(c: Code, frame: Value, t: Value, y: Value, g: Value) -> None:
    c.run("pc_states", frame, t, y)
    _try(c, "pc_levels", frame, t)
    c.give(c.call(FLAG, "pc_zeros", frame, t, g))


@function("i32 pc_evaluate(ptr frame, i64 mode, ptr initial)")
def _evaluate(c: Code, frame: Value, mode: Value, initial: Value) -> None:
    """Everything, with all candidates as they are in the workspace; gives `initial`."""
    w, numbers, _, _ = open_frame(frame)
    t = w.load(REAL)
    numbers.store(c.constant(-1, INT), Number.FAILED)
    numbers.store(mode, Number.MODE)
    flag = c.variable(c.call(FLAG, "pc_levels", frame, t), FLAG)
    numbers.store(c.constant(Mode.SOLVE, INT), Number.MODE)
    with c.when(mode.equals(Mode.GIVEN) & flag.get().equals(0)):
        flag.set(c.call(FLAG, "pc_rest", frame, t))
        with c.when(flag.get().equals(0)):
            flag.set(c.call(FLAG, "pc_initial", frame, t, initial))
    c.give(flag.get())


@function("i32 pc_accept(ptr frame, double t)")
def _accept(c: Code, frame: Value, t: Value) -> None:
    """The present values of all tears that anything starts from become the last accepted ones."""
    w, _, accepted, _ = open_frame(frame)
    table = Value(c, POINTER, "@pc_blocks")
    row = c.variable(c.constant(1, INT), INT)
    with c.loop(table.load(INT)):
        record = table.at(row.get())
        n, total = record.load(INT, Record.TEARS), record.load(INT, Record.TOTAL)
        first = record.load(INT, Record.ACCEPTED)
        slots = record.at(Record.SLOTS)
        given = record.load(INT, Record.LINEAR) > record.load(INT, Record.MODAL)
        with c.when(~given):
            for part in range(3):
                with c.loop(n) as i:
                    slot = slots.load(INT, n * part + i)
                    with c.when(slot >= 0):
                        accepted.store(w.load(REAL, slot), total * part + first + i)
        accepted.store(t, total * 3)
        row.set(row.get() + n * 3 + Record.SLOTS)
    c.give(0)


@function("double pc_past(ptr frame, i64 delay, i64 order, double s)")
def _past(c: Code, frame: Value, delay: Value, order: Value, s: Value) -> None:
    memory = frame.load(POINTER, Frame.PAST)
    bounds = memory.load(POINTER, Memory.BOUNDS)
    least, most = bounds.load(REAL, delay * 2), bounds.load(REAL, delay * 2 + 1)
    asked = c.select(s < least, least, s)
    asked = c.select(asked > most, most, asked)
    begins = memory.load(POINTER, Memory.BEGINS)
    low = c.variable(c.constant(0, INT), INT)
    high = c.variable(memory.load(INT, Memory.PIECES) - 1, INT)
    with c.loop(memory.load(INT, Memory.HALVINGS)):
        middle = (low.get() + high.get() + 1) / 2
        behind = begins.load(REAL, middle) <= asked
        before = high.get()
        low.set(c.select(behind, middle, low.get()))
        high.set(c.select(behind, before, middle - 1))
    piece = low.get()
    scale = memory.load(POINTER, Memory.SCALES).load(REAL, piece)
    x = (s - begins.load(REAL, piece)) * scale
    first = (piece * memory.load(INT, Memory.DELAYS) + delay) * TERMS
    terms = memory.load(POINTER, Memory.TERMS).at(first)
    value = c.variable(0.0)
    with c.loop(order.negative() + TERMS) as i:
        k = i.negative() + DEGREE
        term = c.variable(terms.load(REAL, k))
        with c.loop(order) as j:  # differentiated once more: k*(k - 1)*...
            term.set(term.get() * c.real(k - j))
        value.set(value.get() * x + term.get())
    with c.loop(order):
        value.set(value.get() * scale)
    c.give(value.get(), REAL)


def _vector(frame: Value, vector: Value) -> Value:
    """The numbers of an N_Vector, by SUNDIALS' own function."""
    return frame.load(POINTER, Frame.VECTOR).call(POINTER, vector)


@function("i32 pc_cv_rhs(double t, ptr y, ptr d, ptr frame)")
def _cv_rhs(c: Code, t: Value, y: Value, d: Value, frame: Value) -> None:
    flag = c.call(FLAG, "pc_rhs", frame, t, _vector(frame, y), _vector(frame, d))
    # A trial point may lie outside a formula's domain: let the integrator try a smaller step.
    with c.when(~flag.equals(0), leaves=True):
        c.give(1)
    give_where_far(c, frame, frame.load(POINTER, Frame.ANGLES))
    c.give(0)


@function("i32 pc_cv_roots(double t, ptr y, ptr g, ptr frame)")
def _cv_roots(c: Code, t: Value, y: Value, g: Value, frame: Value) -> None:
    frame.store(g, Frame.ZEROS)
    _try(c, "pc_roots", frame, t, _vector(frame, y), g)
    _, numbers, _, _ = open_frame(frame)
    shifts = frame.load(POINTER, Frame.SHIFTS)
    with c.loop(numbers.load(INT, Number.SHIFTED)) as i:
        g.store(g.load(REAL, i) + shifts.load(REAL, i), i)
    c.give(0)


@function(
    "i32 pc_cv_differences(double t, ptr y, ptr f, ptr matrix, ptr frame, ptr a, ptr b, ptr c)"
)
def _cv_differences(
    c: Code, t: Value, y: Value, f: Value, matrix: Value, frame: Value, a: Value, *_: Value
) -> None:
    """Column by column. CVODE's own steps are some 1e-17 where a state is near zero and steps are
    short: what does not depend on it then does by rounding."""
    numbers = frame.load(POINTER, Frame.NUMBERS)
    y, f, moved = _vector(frame, y), _vector(frame, f), _vector(frame, a)
    out = frame.load(POINTER, Frame.MATRIX).call(POINTER, matrix)
    nominal = frame.load(POINTER, Frame.NOMINAL)
    n = numbers.load(INT, Number.STATES)
    with c.loop(n) as j:
        with c.loop(n) as i:
            moved.store(y.load(REAL, i), i)
        size = c.largest(c.absolute(y.load(REAL, j)), nominal.load(REAL, j))
        there = y.load(REAL, j) + size * DIFFERENCE
        moved.store(there, j)
        step = there - y.load(REAL, j)
        column = out.at(j * n)
        flag = c.call(FLAG, "pc_rhs", frame, t, moved, column)
        with c.when(~flag.equals(0), leaves=True):
            c.give(1)
        with c.loop(n) as i:
            column.store((column.load(REAL, i) - f.load(REAL, i)) / step, i)
    c.give(0)
