"""Exported models with clocked parts: as planarc runs them."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

import planarc
from planarc.compiled import Compiled
from planarc.compiler import compile_model
from planarc.export.page.module import make_module
from planarc.request.request import Request
from tests.export.fmus import WAYS, runs_here, simulate, written
from tests.export.test_c import Run, needs_compiler, run  # noqa: F401
from tests.export.test_wasm import needs_node, of_node

ARM = """
model Arm "A pendulum that a sampled controller lifts; each quarter of a rad is counted"
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Revolute hinge(
    phi(start=-1.5, fixed=true), w(fixed=true), drivenFlange=true);
  PlanarMultiBody.Parts.BodyShape rod(r={0.5, 0}, r_CM={0.25, 0}, m=1, I=0.02);
  Modelica.Mechanics.Rotational.Sources.Torque drive(useSupport=false);
  parameter Real k = 20 "Stiffness of the controller, N.m/rad";
  output Real phi = hinge.phi;
  output Real tau "Torque of the drive, N.m";
  output Integer slow(start=0), teeth(start=0);
  Real y, e, dy, i(start=0), reference(start=0), tooth(start=-1.5);
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, rod.frame_a);
  when Clock(1, 47) then
    y = sample(hinge.phi);
    e = superSample(reference) - y;
    i = previous(i) + interval()*e;
    dy = (y - previous(y))/interval();
  end when;
  when Clock(5, 47) then
    reference = previous(reference) + 0.05;
    slow = previous(slow) + 1;
  end when;
  tau = hold(k*e + 10*i - 2*dy);
  drive.tau = tau;
  connect(drive.flange, hinge.axis);
  when Clock(abs(hinge.phi - hold(tooth)) > 0.25) then
    tooth = sample(hinge.phi);
    teeth = previous(teeth) + 1;
  end when;
  annotation(experiment(StopTime=2, Interval=0.005));
end Arm;
"""
NAMES = ("phi", "tau", "slow", "teeth")


@cache
def compiled() -> Compiled:
    return compile_model(Request(Path("Arm.pmo"), text=ARM))


@cache
def reference() -> planarc.Result:
    return planarc.load(ARM).simulate(2, intervals=400, tolerance=1e-11)


def between_ticks(times: np.ndarray) -> np.ndarray:
    """Where no event is near, of a table at multiples of a step."""
    events = np.unique(reference()["time"][1:][np.diff(reference()["time"]) == 0])
    return np.array([np.min(np.abs(events - t)) > 2e-3 for t in times])


def test_the_exported_solver_runs_it_too() -> None:
    found = planarc.load(ARM).simulate(2, intervals=400, solver="exported")
    assert found["teeth"][-1] == reference()["teeth"][-1] > 5
    for name in NAMES:
        np.testing.assert_allclose(
            [found.at(name, t) for t in (0.41, 0.975, 1.505, 1.995)],
            [reference().at(name, t) for t in (0.41, 0.975, 1.505, 1.995)],
            atol=1e-6,
        )


@runs_here
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("version", (2, 3))
def test_a_run_of_an_fmu_is_the_one_of_planarc(tmp_path: Path, way: str, version: int) -> None:
    table = simulate(written(tmp_path / "arm.fmu", compiled(), version), way, 2.0)
    kept = between_ticks(np.asarray(table["time"]))
    assert kept.sum() > 20
    for name in NAMES:
        there = np.array([reference().at(name, t) for t in table["time"]])
        np.testing.assert_allclose(table[name][kept], there[kept], atol=1e-5, err_msg=name)


@needs_compiler
def test_a_run_of_c_is_the_one_of_planarc(run: Run, tmp_path: Path) -> None:  # noqa: F811
    lines = run(planarc.load(ARM).export_c(tmp_path / "c")).stdout.splitlines()
    names = [n.strip('"') for n in lines[0].split(",")]
    last = dict(zip(names, map(float, lines[-1].split(",")), strict=True))
    for name in NAMES:
        assert last[name] == pytest.approx(reference()[name][-1], abs=1e-5), name


@needs_node
def test_a_page_runs_it(tmp_path: Path) -> None:
    names = ("hinge.phi", "y", "slow", "teeth")
    slots = [compiled().program.slots[name] for name in names]
    times = [0.015 * i for i in range(134)]
    (plain,) = of_node(tmp_path, make_module(compiled()).code, slots, ([], times))
    kept = between_ticks(np.array(times))
    for name, column in zip(names, plain["columns"], strict=True):
        there = np.array([reference().at(name, t) for t in times])
        np.testing.assert_allclose(np.array(column)[kept], there[kept], atol=1e-5, err_msg=name)
