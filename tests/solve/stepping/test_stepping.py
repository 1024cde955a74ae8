"""What a step is made of: matrices, neighbours, impulses, each by its law."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.sparse import csr_array

import planarc
from planarc.core.options import RunOptions
from planarc.solve.stepping.angles import sine_and_cosine
from planarc.solve.stepping.crowd import Near
from planarc.solve.stepping.impulses import solve_impulses
from planarc.solve.stepping.ports import Ports

FREE = """
model Free
  import PlanarMultiBody.*;
  inner World world;
  parameter Integer n=12;
  Parts.Body ball[n](m={0.5*i for i in 1:n}, I={0.1*i for i in 1:n}, each r_CM={0.1, 0},
    r(start={{i, 0} for i in 1:n}, each fixed=true), v(each fixed=true), phi(each fixed=true),
    w(each fixed=true));
  Contacts.Crowd crowd(n=n, R=fill(0.1, n), walls=[-1, -1, 20, -1]);
equation
  connect(ball.frame_a, crowd.frame_a);
  connect(world.frame_b, crowd.frame_b);
end Free;
"""
LOOP = """
model Loop
  import PlanarMultiBody.*;
  inner World world;
  Joints.Revolute a(phi(start=1.2, fixed=true), w(start=1, fixed=true));
  Parts.BodyShape crank(m=1, r={0.4, 0}, r_CM={0.2, 0}, I=0.02);
  Joints.Revolute b;
  Parts.BodyShape rod(m=2, r={1, 0}, r_CM={0.5, 0.1}, I=0.1);
  Joints.Revolute c;
  Parts.BodyShape arm(m=1, r={0.8, 0}, r_CM={0.4, 0}, I=0.05);
  Joints.Revolute d;
  Parts.Fixed ground(r={1, 0});
  Contacts.Crowd crowd(n=2, R={0.02, 0.02}, walls=[-9, -9, 9, -9]);
equation
  connect(world.frame_b, a.frame_a);
  connect(a.frame_b, crank.frame_a);
  connect(crank.frame_b, b.frame_a);
  connect(b.frame_b, rod.frame_a);
  connect(rod.frame_b, c.frame_a);
  connect(c.frame_b, arm.frame_a);
  connect(arm.frame_b, d.frame_a);
  connect(ground.frame_b, d.frame_b);
  connect(crank.frame_b, crowd.frame_a[1]);
  connect(rod.frame_b, crowd.frame_a[2]);
  connect(world.frame_b, crowd.frame_b);
end Loop;
"""


def opened(text: str, backend: str) -> tuple[Any, Any, np.ndarray]:
    """The ports of a model at its start, with its kernel and states."""
    model = planarc.load(text, backend=backend)
    stepper = model.stepper(1e-3, backend=backend)
    run = stepper._run  # its kernel is where the model starts
    return Ports(run.program, run.kernel), run.kernel, np.array(run.states.values())


@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_free_bodies_answer_with_their_own_masses(backend: str) -> None:
    """With the centre of mass off the frame: J*M^-1*J' by hand. Three evaluations show it all."""
    ports, kernel, y = opened(FREE, backend)
    calls, outputs = [], kernel.outputs
    kernel.outputs = lambda t, at: (calls.append(t), outputs(t, at))[1]
    found = ports.respond(0.0, y, ports.groups >= 0)
    assert found is not None and len(calls) == 3
    v = found.velocity.toarray()
    for i in range(12):
        m, inertia, s = 0.5 * (i + 1), 0.1 * (i + 1), 0.1
        j = np.array([[1, 0, 0], [0, 1, -s], [0, 0, 1.0]])  # the frame by the centre of mass
        own = j @ np.diag([1 / m, 1 / m, 1 / inertia]) @ j.T
        at = slice(3 * i, 3 * i + 3)
        np.testing.assert_allclose(v[at, at], own, atol=1e-10)
        v[at, at] = 0
    assert not v.any()


@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_a_loop_answers_as_its_constraints_say(backend: str) -> None:
    """One degree of freedom: J = velocities of the ports per speed of the crank, M the kinetic
    energy of that speed."""
    ports, kernel, y = opened(LOOP, backend)
    kernel.outputs(0.0, y)
    found = ports.respond(0.0, y, ports.groups >= 0)
    kernel.outputs(0.0, y)
    j = ports.velocity(kernel.w)  # the speed of the crank is 1 rad/s
    program = ports.program

    def of(name: str) -> float:
        column = next(c for c in program.columns if c.name == name)
        return float(column.sign * kernel.w[column.slot])

    m = 0.0
    for name, mass, inertia in (("crank", 1, 0.02), ("rod", 2, 0.1), ("arm", 1, 0.05)):
        speed = [of(f"{name}.body.v_CM[{i}]") for i in (1, 2)]
        m += mass * (speed[0] ** 2 + speed[1] ** 2) + inertia * of(f"{name}.body.w") ** 2
    assert found is not None
    np.testing.assert_allclose(found.velocity.toarray(), np.outer(j, j) / m, atol=1e-9)


def test_sines_are_right_and_the_same_everywhere() -> None:
    """Some digits by their bits, as other processors and languages have to give them."""
    angles = np.append(np.random.default_rng(17).uniform(-300, 300, 10_000), [0.0, 1e5, -1e5])
    sine, cosine = sine_and_cosine(angles)
    np.testing.assert_allclose(sine, np.sin(angles), rtol=0, atol=2.3e-16)
    np.testing.assert_allclose(cosine, np.cos(angles), rtol=0, atol=2.3e-16)
    known = sine_and_cosine(np.array([0.5, 2.0, -3.0]))
    assert [[float(v).hex() for v in values] for values in known] == [
        ["0x1.eaee8744b05f0p-2", "0x1.d18f6ead1b446p-1", "-0x1.210386db6d55bp-3"],
        ["0x1.c1528065b7d50p-1", "-0x1.aa22657537205p-2", "-0x1.fae04be85e5d2p-1"],
    ]


def test_neighbours_grow_with_the_number_of_bodies() -> None:
    rng = np.random.default_rng(17)
    sizes, counts = (100, 400, 1600, 6400), []
    for n in sizes:
        middles = rng.uniform(0, 0.1 * np.sqrt(n), (n, 2))
        bounds = np.append(rng.uniform(0.03, 0.05, n), 9.0)  # and one wall
        pairs = Near(bounds).pairs(np.vstack([middles, [[-20.0, 0.0]]]), 0.01)
        counts.append(len(pairs))
        if n == 100:
            apart = np.hypot(*(middles[:, None] - middles[None]).T)
            near = apart < bounds[:n, None] + bounds[None, :n] + 0.01
            assert {tuple(sorted(p)) for p in pairs.tolist() if max(p) < n} == {
                (i, j) for i, j in zip(*np.nonzero(near), strict=True) if i < j
            }
    assert np.polyfit(np.log(sizes), np.log(counts), 1)[0] < 1.1


def a_pile(rng: Any, contacts: int) -> tuple[csr_array, Any, Any]:
    j = rng.normal(size=(2 * contacts, 2 * contacts + 3))
    j[rng.uniform(size=j.shape) < 0.6] = 0
    return csr_array(j @ j.T + 0.1 * np.eye(2 * contacts)), rng.normal(size=2 * contacts), (
        rng.uniform(0, 0.4, contacts)
    )  # fmt: skip


def test_impulses_obey_the_law() -> None:
    """By machine code and without: both are the same sweeps."""
    rng = np.random.default_rng(17)
    sweep = planarc.load(FREE, backend="native").compiled().load().capabilities.machine.sweep
    for _ in range(50):
        k = int(rng.integers(1, 6))
        a, b, mu = a_pile(rng, k)
        begin = np.zeros(2 * k)
        x = solve_impulses(a, b, mu, begin, 1e-12, None)
        np.testing.assert_allclose(solve_impulses(a, b, mu, begin, 1e-12, sweep), x, atol=1e-12)
        u, n, t = a @ x + b, x[::2], x[1::2]
        assert n.min() >= 0 and (np.abs(t) <= mu * n + 1e-12).all()
        assert u[::2].min() > -1e-8 and np.abs(n * u[::2]).max() < 1e-8
        slides = np.abs(u[1::2]) > 1e-8
        np.testing.assert_allclose(
            t[slides], -np.sign(u[1::2][slides]) * (mu * n)[slides], atol=1e-9
        )


def test_ordinary_runs_import_nothing_of_it() -> None:
    import subprocess
    import sys

    text = "model M Real x(start=1, fixed=true); equation der(x) = -x; end M;"
    program = f"import sys, planarc; planarc.load({text!r}).simulate(stop_time=1);"
    program += "print(any('stepping.' in m and 'solve.stepping' in m for m in sys.modules))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.strip() == "False", done.stderr


def test_the_options_are_the_same_by_the_command_and_in_python() -> None:
    result = planarc.load(FREE).simulate(0.1, contact="stepping", fixed_step=1e-3)
    assert "stepping (steps of 0.001 s)" in result.rows.statistics.solver
    assert RunOptions().contact is None
