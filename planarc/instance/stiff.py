"""An integrator for stiff models, in LLVM: a Rosenbrock method of order 4 with an error of order 3.

    px_stiff(block, t, h) -> flag       a step, as `steps.px_stages`
    px_stiff_error(block) -> ratio      its largest error beside what is allowed
    px_jacobian(block, t, out) -> flag  of the states' derivatives by the states, row by row

With J the Jacobian and E = I/(g*h) - J, each stage solves E*K_i = f(t + n_i*h, y + sum a_ij*K_j)
+ sum (c_ij/h)*K_j + h*d_i*df/dt: there is nothing to iterate. Very stiff parts die out at once.
Where the model has no exact derivatives, J is a difference; so is df/dt. The states within such a
step are not known as exactly as its end: good enough to look there for crossings (`within`), which
steps that end there then show.

Reference: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer
1996, section IV.7 (RODAS).
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value, function
from planarc.codegen.native.newton import open_frame
from planarc.instance.block import larger, nominal_of, plan, whole
from planarc.instance.plan import Look, Own, Table
from planarc.instance.relations import looked
from planarc.instance.slopes import has_slopes
from planarc.instance.steps import BEGIN, TRIAL, vector
from planarc.ir.derivatives import CHUNK, Passing
from planarc.ir.frame import Number
from planarc.ir.newton import DIFFERENCE

_GAMMA = 0.25
NODES = (0.0, 0.386, 0.21, 0.63, 1.0, 1.0)
_OF_TIME = (0.25, -0.1043, 0.1035, -0.0362, 0.0, 0.0)
#: The last stages begin where the one before ended: y + sum a_5j*K_j + K_5, and + K_6 at the end.
_ROWS = (
    (),
    (1.544,),
    (0.9466785280815826, 0.2557011698983284),
    (3.314825187068521, 2.896124015972201, 0.9986419139977817),
    (1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950),
    (1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 1.0),
)
_BEFORE = (
    (),
    (-5.6688,),
    (-2.430093356833875, -0.2063599157091915),
    (-0.1073529058151375, -9.594562251023355, -20.47028614809616),
    (7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160),
    (8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136,
     -6.058818238834054),
)  # fmt: skip
#: The stages whose zero functions are kept, as of `steps.NOTED`.
NOTED = {1: Look.EARLIER, 3: Look.LATER}
#: What is stiff is not followed as closely as the rest: least relative error of a step.
_LEAST = 1e-8
#: A step so short has no length: its states are those that it begins with.
_POINT = 1e-100


def stiff_functions() -> tuple[str, ...]:
    return _jacobian(), _inverse(), _stiff(), _error()


class _Room:
    """Arrays that are no state: E, its inverse, and vectors."""

    def __init__(self, c: Code, m: Value) -> None:
        self.n = n = plan(c, Table.STATES)
        self.matrix = m.load(POINTER, Own.PASSING).load(POINTER, Passing.MOVED)
        self.inverse = self.matrix.at(n * n)
        self.sizes = self.inverse.at(n * n)
        self.of_time, self.right, self.last = (self.sizes.at(n * k) for k in (1, 2, 3))


@function("i32 px_jacobian(ptr m, double t, ptr out)")
def _jacobian(c: Code, m: Value, t: Value, out: Value) -> None:
    """At the point at which the workspace was evaluated last, the begin of a step."""
    n = plan(c, Table.STATES)
    w, numbers, _, _ = open_frame(m)
    states = numbers.at(Number.FIRST_STATE)
    exact = c.variable(0, INT)
    with c.when(has_slopes(c)):
        c.run("px_seed", m, (n + (CHUNK - 1)) / CHUNK * CHUNK)
        with c.loop(n) as j:
            c.call(FLAG, "px_move", m, w.at(states.load(INT, j)), j, c.constant(1.0, REAL))
        total = c.variable(0.0)
        with c.when(c.call(FLAG, "px_pass", m).equals(0)):
            with c.loop(n) as i:
                rate = w.at(states.load(INT, n + i))
                with c.loop(n) as j:
                    slope = c.call(REAL, "px_moved", m, rate, j)
                    total.set(total.get() + slope * 0.0)
                    out.store(slope, i * n + j)
            with c.when(total.get().equals(0.0)):
                exact.set(whole(c, 1))
    with c.when(exact.get().equals(1), leaves=True):
        c.give(0)
    slopes, trial, begin = vector(c, m, 0), vector(c, m, TRIAL), vector(c, m, BEGIN)
    moved = vector(c, m, 1)
    with c.loop(n) as j:
        c.run("px_copy", trial, begin, n)
        x = begin.load(REAL, j)
        there = x + larger(c, c.absolute(x), nominal_of(c, m, j)) * DIFFERENCE
        trial.store(there, j)
        flag = c.call(FLAG, "pc_rhs", m, t, trial, moved)
        with c.when(~flag.equals(0), leaves=True):
            c.give(flag)
        with c.loop(n) as i:
            change = moved.load(REAL, i) - slopes.load(REAL, i)
            out.store(change / (there - x), i * n + j)
    c.give(0)


@function("i32 px_inverse(ptr m, double h)")
def _inverse(c: Code, m: Value, h: Value) -> None:
    """Of E, in whose place the Jacobian stands."""
    room, n = _Room(c, m), plan(c, Table.STATES)
    size = 1.0 / (h * _GAMMA)
    with c.loop(n) as i, c.loop(n) as j:
        on = i.equals(j)
        diagonal = c.select(on, size, c.constant(0.0, REAL))
        room.matrix.store(diagonal - room.matrix.load(REAL, i * n + j), i * n + j)
        room.inverse.store(c.select(on, c.constant(1.0, REAL), 0.0), i * n + j)
    c.give(c.call(FLAG, "pc_eliminate", room.matrix, room.inverse, room.sizes, n, n, n))


@function("i32 px_stiff(ptr m, double t, double h)")
def _stiff(c: Code, m: Value, t: Value, h: Value) -> None:
    """The new states stand where those of a trial do, their slopes behind the others."""
    room, n = _Room(c, m), plan(c, Table.STATES)
    begin, trial = vector(c, m, BEGIN), vector(c, m, TRIAL)
    first = vector(c, m, 0)
    stages = [*(vector(c, m, k) for k in range(1, 6)), room.last]

    def attempt(flag: Value) -> None:
        with c.when(~flag.equals(0), leaves=True):
            c.give(flag)

    attempt(c.call(FLAG, "pc_rhs", m, t, begin, first))
    with c.when(h < _POINT, leaves=True):
        c.run("px_copy", trial, begin, n)
        with c.loop(n) as i:
            room.last.store(0.0, i)
        c.give(c.call(FLAG, "pc_rhs", m, t + h, trial, vector(c, m, 6)))
    attempt(c.call(FLAG, "px_jacobian", m, t, room.matrix))
    later = t + larger(c, c.absolute(t), c.constant(1.0, REAL)) * DIFFERENCE
    flag = c.call(FLAG, "pc_rhs", m, later, begin, room.of_time)
    with c.loop(n) as i:
        change = (room.of_time.load(REAL, i) - first.load(REAL, i)) / (later - t)
        room.of_time.store(c.select(flag.equals(0), change, 0.0), i)
    attempt(c.call(FLAG, "px_inverse", m, h))
    for k, stage in enumerate(stages):
        if k:
            with c.loop(n) as i:
                terms = [stages[j].load(REAL, i) * a for j, a in enumerate(_ROWS[k])]
                trial.store(sum(terms, begin.load(REAL, i)), i)
            attempt(c.call(FLAG, "pc_rhs", m, t + h * NODES[k], trial, room.right))
            if k in NOTED:
                with c.when(plan(c, Table.SWINGS) > 0):
                    c.call(FLAG, "pc_zeros", m, t + h * NODES[k], looked(c, m, NOTED[k]))
        with c.loop(n) as i:
            own = (room.right if k else first).load(REAL, i)
            before = [stages[j].load(REAL, i) * a for j, a in enumerate(_BEFORE[k])]
            own = own + h * _OF_TIME[k] * room.of_time.load(REAL, i)
            room.right.store(own + sum(before, c.constant(0.0, REAL)) / h, i)
        with c.loop(n) as i:
            total = c.variable(0.0)
            with c.loop(n) as j:
                entry = room.inverse.load(REAL, i * n + j)
                total.set(total.get() + entry * room.right.load(REAL, j))
            stage.store(total.get(), i)
    with c.loop(n) as i:
        trial.store(trial.load(REAL, i) + room.last.load(REAL, i), i)
    c.give(c.call(FLAG, "pc_rhs", m, t + h, trial, vector(c, m, 6)))


@function("double px_stiff_error(ptr m)")
def _error(c: Code, m: Value) -> None:
    room, n = _Room(c, m), plan(c, Table.STATES)
    begin, trial = vector(c, m, BEGIN), vector(c, m, TRIAL)
    tolerance = larger(c, m.load(REAL, Own.TOLERANCE), c.constant(_LEAST, REAL))
    worst = c.variable(0.0)
    with c.loop(n) as i:
        size = larger(c, c.absolute(begin.load(REAL, i)), c.absolute(trial.load(REAL, i)))
        allowed = tolerance * (size + nominal_of(c, m, i))
        worst.set(larger(c, c.absolute(room.last.load(REAL, i)) / allowed, worst.get()))
    c.give(worst.get(), REAL)
