"""Faults that a run survives: it says what happened and keeps what it has."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import planarc
from planarc.core.diagnostic import Diagnostic

Stopped = Callable[..., tuple[Diagnostic, planarc.Result]]

BACKENDS = ["numpy", "native"]

SLIDER = """
model Slider "Crank and slider"
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Revolute a(phi(start=1, fixed=true), w(start=1, fixed=true));
  PlanarMultiBody.Joints.Revolute b(phi(start=-1.5));
  PlanarMultiBody.Joints.Revolute c;
  PlanarMultiBody.Joints.Prismatic s(n={1, 0}, s(start=1));
  PlanarMultiBody.Parts.FixedTranslation crank(r={0.3, 0});
  PlanarMultiBody.Parts.FixedTranslation rod(r={1, 0});
  PlanarMultiBody.Parts.Body wheel(m=1, I=0.1);
  PlanarMultiBody.Parts.Body piston(m=1, I=0.1);
equation
  connect(world.frame_b, a.frame_a);
  connect(a.frame_b, crank.frame_a);
  connect(crank.frame_a, wheel.frame_a);
  connect(crank.frame_b, b.frame_a);
  connect(b.frame_b, rod.frame_a);
  connect(rod.frame_b, c.frame_a);
  connect(c.frame_b, s.frame_b);
  connect(world.frame_b, s.frame_a);
  connect(s.frame_b, piston.frame_a);
  when time >= 0.5 then
    reinit(s.s, %s);
  end when;
end Slider;
"""

# The crank's tip gets as far as 1.5 m from the bearing `ground`; rod and rocker reach 1.4 m.
JAMS = """
model Jams "A crank driven to where the other bars do not reach"
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Revolute a(drivenFlange=true, phi(start=0, fixed=true));
  PlanarMultiBody.Joints.Revolute d(phi(start=1.6));
  PlanarMultiBody.Joints.JointRR rod(L=0.8);
  PlanarMultiBody.Parts.FixedTranslation crank(r={0.5, 0});
  PlanarMultiBody.Parts.FixedTranslation rocker(r={0.6, 0});
  PlanarMultiBody.Parts.Fixed ground(r={1, 0});
  PlanarMultiBody.Parts.Body body(m=1, I=0.1);
  Modelica.Mechanics.Rotational.Sources.ConstantSpeed drive(w_fixed=2);
equation
  connect(drive.flange, a.axis);
  connect(world.frame_b, a.frame_a);
  connect(a.frame_b, crank.frame_a);
  connect(crank.frame_b, rod.frame_a);
  connect(rod.frame_b, rocker.frame_b);
  connect(ground.frame_b, d.frame_a);
  connect(d.frame_b, rocker.frame_a);
  connect(rocker.frame_a, body.frame_a);
end Jams;
"""

PENDULUM = """
model Pendulum
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Revolute rev;
  PlanarMultiBody.Parts.Body body(%s);
equation
  connect(world.frame_b, rev.frame_a);
  connect(rev.frame_b, body.frame_a);
end Pendulum;
"""


def load(text: str, backend: str) -> planarc.Model:
    if backend == "native":
        pytest.importorskip("llvmlite")
    return planarc.load(text, backend=backend)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("value", ["sqrt(0.3 - time)", "exp(2000*x)", "log(x - 2)"])
def test_no_number_names_the_equation_and_the_time(
    backend: str, value: str, stopped: Stopped
) -> None:
    text = f"""
    model M
      Real x(start=0, fixed=true);
      Real y;
    equation
      der(x) = y;
      y = if time > 0.5 then {value} else 1;
    end M;
    """
    diagnostic, result = stopped(text, backend, 1)
    assert diagnostic.code == "R421"
    assert diagnostic.message.startswith("at t = 0.5 s `y = ")
    assert diagnostic.span is not None
    assert result.time[-1] == pytest.approx(0.5)


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_body_without_mass_is_named(backend: str) -> None:
    with pytest.raises(planarc.PlanarcError) as caught:
        load(PENDULUM % "m=0, I=0", backend).simulate(1)
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "R410"
    assert "`body`" in diagnostic.message
    assert diagnostic.hint == "`body.I` is 0: give it a value"  # a mass in the joint would not do


def test_a_loose_part_without_mass_is_named_before_it_runs() -> None:
    loose = """
      PlanarMultiBody.Joints.Revolute free;
      PlanarMultiBody.Parts.FixedTranslation rod(r={1, 0});
    equation
      connect(rev.frame_b, free.frame_a);
      connect(free.frame_b, rod.frame_a);
    """
    with pytest.raises(planarc.PlanarcError) as caught:
        planarc.load((PENDULUM % "m=1, I=1").replace("equation\n", loose, 1))
    (diagnostic,) = caught.value.diagnostics
    assert "`rod.frame_b` is connected to nothing" in diagnostic.message
    assert "leave `rod` out" in str(diagnostic.hint)


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_reinit_that_takes_a_loop_apart_ends_the_run(backend: str, stopped: Stopped) -> None:
    diagnostic, result = stopped(SLIDER % "5", backend, 1)
    assert diagnostic.code == "R422"
    assert "at the event at t = 0.5 s" in diagnostic.message
    assert "what `reinit` gives to `s.s`" in diagnostic.message
    assert result.time[-1] == 0.5
    assert np.max(result["s.s"]) < 1.31


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_reinit_that_the_loop_allows_is_followed(backend: str) -> None:
    run = load(SLIDER % "1.1", backend).simulate(0.6)
    after = int(np.searchsorted(run.time, 0.5, side="right")) - 1
    assert run["s.s"][after] == 1.1
    gap = (run["s.s"] - 0.3 * np.cos(run["a.phi"])) ** 2 + (0.3 * np.sin(run["a.phi"])) ** 2
    assert gap == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-9])
@pytest.mark.parametrize("backend", BACKENDS)
def test_a_drive_to_the_end_of_a_mechanisms_reach_jams(backend: str, tolerance: float) -> None:
    """It does not come back from beyond; the rows up to there are right."""
    with pytest.raises(planarc.RunStopped) as caught:
        load(JAMS, backend).simulate(3, tolerance=tolerance)
    (diagnostic,) = caught.value.diagnostics
    reach = np.arccos((1 + 0.5**2 - 1.4**2) / (2 * 0.5)) / 2
    assert diagnostic.code == "R422"
    assert "`rod`" in diagnostic.message
    assert "jammed" in str(diagnostic.hint)
    run = caught.value.result
    assert run.time[-1] == pytest.approx(reach, abs=0.02)
    assert run["a.phi"] == pytest.approx(2 * run.time, abs=1e-5)


@pytest.mark.parametrize("solver", ["cvode-adams", "lsoda", "scipy-bdf"])
def test_no_solver_leaps_over_a_jam(solver: str, stopped: Stopped) -> None:
    """Accelerations without bounds there must not make a start of the bars' angles that
    passes for a solution."""
    text = JAMS.replace(
        "equation", "  Real z(start=0, fixed=true);\nequation\n  der(z) = a.phi;", 1
    )
    diagnostic, run = stopped(text, "native", 3, solver=solver)
    reach = np.arccos((1 + 0.5**2 - 1.4**2) / (2 * 0.5)) / 2
    assert diagnostic.code == "R422"
    assert "`rod`" in diagnostic.message
    assert "`crank` over 0.5 m" in str(diagnostic.hint)
    assert run.time[-1] == pytest.approx(reach, abs=0.02)
    reached = (run["rod.d[1]"] ** 2 + run["rod.d[2]"] ** 2) ** 0.5
    assert reached == pytest.approx(0.8, abs=1e-6)


@pytest.mark.parametrize("backend", BACKENDS)
def test_bouncing_to_a_pile_of_events_keeps_the_rows(backend: str, stopped: Stopped) -> None:
    text = """
    model Ball
      Real h(start=1, fixed=true);
      Real v(start=0, fixed=true);
    equation
      der(h) = v;
      der(v) = -9.81;
      when h <= 0 then
        reinit(v, -0.7*pre(v));
      end when;
    end Ball;
    """
    diagnostic, result = stopped(text, backend, 4)
    first = np.sqrt(2 / 9.81)
    assert diagnostic.code == "R432"
    assert "`h <= 0`" in diagnostic.message
    assert result.time[-1] == pytest.approx(first * (1 + 2 * 0.7 / 0.3), abs=0.01)
    assert result.events[0].time == pytest.approx(first, abs=1e-6)
    assert len(result.events) > 10


@pytest.mark.parametrize("backend", BACKENDS)
def test_an_event_at_the_stop_time_is_taken(backend: str) -> None:
    text = """
    model M
      Real x(start=0, fixed=true);
      discrete Real n(start=0, fixed=true);
    equation
      der(x) = 1;
      when time >= 1 then
        n = pre(n) + 1;
      end when;
    end M;
    """
    run = load(text, backend).simulate(1)
    assert run["n"][-2:].tolist() == [0.0, 1.0]
    assert run.time[-2:].tolist() == [1.0, 1.0]


# The cache --------------------------------------------------------------------------------


def command(cache: Path, file: Path, out: Path) -> subprocess.Popen[bytes]:
    arguments = ["simulate", str(file), "--stop", "0.2", "--output", str(out)]
    return subprocess.Popen(
        [sys.executable, "-m", "planarc", *arguments],
        env={**os.environ, "PLANARC_CACHE_DIR": str(cache)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    )


def test_processes_may_compile_one_model_at_once(tmp_path: Path) -> None:
    file = tmp_path / "pendulum.pmo"
    file.write_text(PENDULUM % "m=1, I=1, r_CM={1, 0}", encoding="utf-8")
    runs = [command(tmp_path / "cache", file, tmp_path / f"{i}.csv") for i in range(3)]
    assert [(r.communicate()[1], r.returncode) for r in runs] == [(b"", 0)] * 3
    first, *others = ((tmp_path / f"{i}.csv").read_bytes() for i in range(3))
    assert others == [first, first]


def test_damaged_entries_are_made_again(tmp_path: Path) -> None:
    file, cache = tmp_path / "pendulum.pmo", tmp_path / "cache"
    file.write_text(PENDULUM % "m=1, I=1, r_CM={1, 0}", encoding="utf-8")
    assert command(cache, file, tmp_path / "0.csv").wait() == 0
    entries = [p for p in cache.rglob("*") if p.is_file()]
    assert entries
    for i, entry in enumerate(entries):
        data = entry.read_bytes()
        middle = len(data) // 2
        flipped = data[:middle] + bytes([data[middle] ^ 255]) + data[middle + 1 :]
        entry.write_bytes((data[:middle], flipped, b"")[i % 3])
    again = command(cache, file, tmp_path / "1.csv")
    assert (again.communicate()[1], again.returncode) == (b"", 0)
    assert (tmp_path / "0.csv").read_bytes() == (tmp_path / "1.csv").read_bytes()


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_a_process_killed_while_it_stores_leaves_no_half_entry(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    writer = (
        "from planarc.core import cache\n"
        "while True:\n"
        "    for b in range(256):\n"
        "        cache.store('models', 'k', bytes([b]) * 3_000_000)\n"
    )
    reader = (
        "from planarc.core import cache\n"
        "data = cache.load('models', 'k')\n"
        "known = data is None or data == b'new'\n"
        "assert known or (len(data) == 3_000_000 and len(set(data)) == 1)\n"
        "cache.store('models', 'k', b'new')\n"
        "assert cache.load('models', 'k') == b'new'\n"
    )
    environment = {**os.environ, "PLANARC_CACHE_DIR": str(cache)}
    for wait in (0.0, 0.004, 0.011):
        process = subprocess.Popen([sys.executable, "-c", writer], env=environment)
        limit = time.monotonic() + 300
        while not (cache / "planarc" / "models").exists() and time.monotonic() < limit:
            time.sleep(0.005)
        time.sleep(wait)
        process.send_signal(signal.SIGKILL)
        process.wait()
        subprocess.run([sys.executable, "-c", reader], env=environment, check=True)
