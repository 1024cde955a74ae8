"""The four-bar as one would write it by hand: one equation for the crank's angle.

What the integrator itself costs, whatever the compiler: the same CVODE with the same
settings, steps in machine code and 501 rows of the two states, but a right-hand side
without blocks, constraints and variables that nobody asks for. The loop is closed by two
circles that meet, and the principle of virtual power gives the crank's acceleration.

    python tests/benchmarks/hand_written.py
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import count
from time import process_time
from types import SimpleNamespace
from typing import Any

import numpy as np

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value
from planarc.codegen.native.march import march_function

STATES, ROWS, STOP = 2, 501, 10.0
CRANK, COUPLER, ROCKER, GROUND = 0.4, 0.9, 0.8, 1.0
MASSES, INERTIAS, GRAVITY = (1.0, 2.0, 1.5), (0.0134, 0.14, 0.08), 9.81


@dataclass(frozen=True)
class Vector:
    """Two numbers of a function while it is written."""

    x: Value
    y: Value

    def __add__(self, other: Vector) -> Vector:
        return Vector(self.x + other.x, self.y + other.y)

    def __sub__(self, other: Vector) -> Vector:
        return Vector(self.x - other.x, self.y - other.y)

    def __mul__(self, factor: Value | float) -> Vector:
        return Vector(self.x * factor, self.y * factor)

    def dot(self, other: Vector) -> Value:
        return self.x * other.x + self.y * other.y

    def turned(self) -> Vector:
        """By a right angle to the left: the velocity of a point that turns with 1 rad/s."""
        return Vector(self.y.negative(), self.x)


def acceleration(c: Code, phi: Value, w: Value) -> Value:
    """Of the crank, rad/s2."""
    one = c.constant(1.0, REAL)
    b = Vector(c.call(REAL, "cos", phi), c.call(REAL, "sin", phi)) * CRANK
    across = Vector(c.constant(GROUND, REAL) - b.x, b.y.negative())
    square = across.dot(across)
    along = (square + (COUPLER**2 - ROCKER**2)) / (square * 2.0)
    height = c.call(REAL, "llvm.sqrt.f64", (one / square) * COUPLER**2 - along * along)
    e = across * along + across.turned() * height  # the coupler, from B to C
    f = e - across  # the rocker, from D to C
    # Speeds of coupler and rocker for a crank of 1 rad/s, and their biases for w.
    ef, fe = e.turned().dot(f), f.turned().dot(e)
    beta2 = b.turned().dot(f).negative() / ef
    beta3 = b.turned().dot(e) / fe
    w1, w2, w3 = w * w, (w * beta2) * (w * beta2), (w * beta3) * (w * beta3)
    alpha2 = (w1 * b.dot(f) + w2 * e.dot(f) - w3 * f.dot(f)) / ef
    alpha3 = (w3 * f.dot(e) - w1 * b.dot(e) - w2 * e.dot(e)) / fe
    s = e * 0.5 + e.turned() * (0.1 / COUPLER)
    centre, half = b * 0.5, f * 0.5
    speeds = (centre.turned(), b.turned() + s.turned() * beta2, half.turned() * beta3)
    biases = (
        centre * w1.negative(),
        s.turned() * alpha2 - b * w1 - s * w2,
        half.turned() * alpha3 - half * w3,
    )
    inertia = beta2 * beta2 * INERTIAS[1] + beta3 * beta3 * INERTIAS[2] + INERTIAS[0]
    power = (alpha2 * beta2 * INERTIAS[1] + alpha3 * beta3 * INERTIAS[2]).negative()
    for mass, u, bias in zip(MASSES, speeds, biases, strict=True):
        inertia = inertia + u.dot(u) * mass
        power = power - (u.y * GRAVITY + bias.dot(u)) * mass
    return power / inertia


def text(get_array: int) -> str:
    """The march and the functions that it calls; the context is the workspace: time, phi, w."""
    cv_rhs = Code(
        "pc_cv_rhs", FLAG, [(REAL, "t"), (POINTER, "y"), (POINTER, "d"), (POINTER, "context")]
    )
    t, y, d, context = cv_rhs.arguments
    pointer = f"inttoptr (i64 {get_array} to ptr)"
    y, d = (cv_rhs.emit(POINTER, f"call ptr {pointer}(ptr {v.text})") for v in (y, d))
    cv_rhs.give(cv_rhs.call(FLAG, "pc_rhs", context, t, y, d))
    rhs = Code("pc_rhs", FLAG, [(POINTER, "context"), (REAL, "t"), (POINTER, "y"), (POINTER, "d")])
    _, _, y, d = rhs.arguments
    phi, w = y.load(REAL), y.load(REAL, 1)
    d.store(w)
    d.store(acceleration(rhs, phi, w), 1)
    rhs.give(0)
    outputs = Code("pc_outputs", FLAG, [(POINTER, "context"), (REAL, "t"), (POINTER, "y")])
    context, t, y = outputs.arguments
    for place, value in enumerate((t, y.load(REAL), y.load(REAL, 1))):
        context.store(value, place)
    outputs.give(0)
    accept = Code("pc_accept", FLAG, [(POINTER, "context"), (REAL, "t")])
    accept.give(0)
    arguments = [(POINTER, "frame"), (POINTER, "blocks"), (INT, "count"), (POINTER, "scales")]
    look = Code("pc_watch", REAL, arguments)
    look.give(0.0, REAL)
    pure = "nounwind willreturn memory(none)"
    names = f"declare double @sin(double) {pure}\ndeclare double @cos(double) {pure}\n"
    names += "declare double @llvm.sqrt.f64(double)\n"
    own = (cv_rhs, rhs, outputs, accept, look)
    return names + "".join(function.text() for function in own) + march_function()


@cache
def linked() -> Any:
    """The engine that holds the functions."""
    import llvmlite.binding as llvm

    from planarc.solve.solvers.sundials import open_sundials

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    module = llvm.parse_assembly(text(open_sundials().address("N_VGetArrayPointer")))
    module.triple = llvm.get_process_triple()
    machine = llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=llvm.get_host_cpu_features().flatten(), opt=3
    )
    options = llvm.create_pipeline_tuning_options(speed_level=3)
    llvm.create_pass_builder(machine, options).getModulePassManager().run(
        module, llvm.create_pass_builder(machine, options)
    )
    engine = llvm.create_mcjit_compiler(module, machine)
    engine.finalize_object()
    return engine


def simulate(phi: float, tolerance: float = 1e-6) -> Any:
    """The recorder, after a run from rest."""
    from planarc.ir.kernel import Addresses, Capabilities
    from planarc.solve.recorder import Recorder
    from planarc.solve.solvers.cvode import Cvode
    from planarc.solve.solvers.integrator import Outcome, Settings
    from planarc.solve.solvers.watch import Watch

    engine, w = linked(), np.zeros(1 + STATES)
    at = engine.get_function_address
    addresses = Addresses(
        cv_rhs=at("pc_cv_rhs"),
        cv_roots=0,
        march=at("pc_march"),
        records=(),
        context=w.ctypes.data,
        workspace=w.ctypes.data,
    )
    machine: Any = SimpleNamespace(addresses=lambda vector_numbers: addresses)
    kernel: Any = SimpleNamespace(w=w, capabilities=Capabilities(machine=machine))
    columns = [SimpleNamespace(slot=s, constant=False) for s in (1, 2)]
    program: Any = SimpleNamespace(columns=columns)
    recorder = Recorder(program, kernel, np.linspace(0.0, STOP, ROWS))
    integrator = Cvode(kernel, STATES, Settings(tolerance, STOP, 0), adams=False)
    integrator.restart(0.0, [phi, 0.0], [tolerance] * STATES, ())
    while True:
        march = integrator.march(STOP, recorder, Watch([]), 1 << 16)
        if march.outcome is not Outcome.BUDGET:
            break
    assert march.outcome is Outcome.LIMIT, march
    w[:] = integrator.t, *integrator.y
    recorder.take(STOP)
    integrator.close()
    return recorder


def seconds(starts: Any, runs: int) -> float:
    """CPU seconds of the quickest of some runs, each from another start angle."""
    times = []
    for _ in range(1 + runs):
        phi = next(starts)
        begin = process_time()
        simulate(phi)
        times.append(process_time() - begin)
    return min(times[1:])


if __name__ == "__main__":
    print(f"{1e3 * seconds((1.0 + 1e-4 * i for i in count()), 20):.2f} ms")
