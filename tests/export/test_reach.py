"""A loop is followed however long the steps are that a host asks for, or goes by itself."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import FMU3Model

import planarc
from tests.export.fmus import WAYS, runs_here, simulate
from tests.solve.solvers.test_reach import PUMP

TWO_LOOPS = "PlanarMultiBody.Examples.Loops.TwoLoopsWithRevolutes"
SHOWN = ("revB.phi", "revG.phi", "revG.w")
HERE = ("x86_64-linux", "aarch64-linux")


@runs_here
@pytest.mark.parametrize("interval", [0.1, 3])
@pytest.mark.parametrize("way", WAYS)
def test_a_driven_loop_keeps_its_assembly(tmp_path: Path, way: str, interval: float) -> None:
    path = tmp_path / "Pump.fmu"
    planarc.load(PUMP).export_fmu(path, platforms=HERE)
    shown = ["main.phi", "cylinder.s"]
    result = fmpy.simulate_fmu(path, fmi_type=way, stop_time=12, relative_tolerance=1e-9,
                               output_interval=interval, output=shown)  # fmt: skip
    phi, s = result["main.phi"], result["cylinder.s"]
    assert s == pytest.approx(0.1 * np.cos(phi) + np.sqrt(0.16 - (0.1 * np.sin(phi)) ** 2))


class Host:
    """One that sets states where it likes, and says which it accepts."""

    def __init__(self, path: Path) -> None:
        described = fmpy.read_model_description(path)
        self.names = {v.name: v.valueReference for v in described.modelVariables}
        self.fmu = FMU3Model(
            guid=described.guid,
            unzipDirectory=fmpy.extract(path),
            instanceName="far",
            modelIdentifier=described.modelExchange.modelIdentifier,
        )
        self.fmu.instantiate()
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.fmu.enterContinuousTimeMode()
        self.n = described.numberOfContinuousStates
        self.x = (ctypes.c_double * self.n)()
        self.fmu.getContinuousStates(self.x, self.n)

    def at(self, t: float, x: np.ndarray) -> tuple[float, ...]:
        """The derivatives, and what is shown."""
        self.fmu.setTime(t)
        self.fmu.setContinuousStates((ctypes.c_double * self.n)(*x), self.n)
        rates = (ctypes.c_double * self.n)()
        self.fmu.getContinuousStateDerivatives(rates, self.n)
        return *rates, *self.fmu.getFloat64([self.names[name] for name in SHOWN])

    def follow(self, stop: float, accepted: float) -> list[tuple[float, np.ndarray]]:
        """Times and states in short steps, of which none behind a time is accepted."""
        x, h, points = np.array(self.x), 1e-3, []
        for i in range(round(stop / h)):
            t = i * h
            points.append((t, x))
            k = [np.array(self.at(t, x)[: self.n])]
            if t <= accepted:
                self.fmu.completedIntegratorStep()
            for part in (0.5, 0.5, 1.0):
                k.append(np.array(self.at(t + part * h, x + part * h * k[-1])[: self.n]))
            x = x + h / 6 * (k[0] + 2 * k[1] + 2 * k[2] + k[3])
        return points


@pytest.fixture(scope="module")
def two_loops(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("far") / "TwoLoops.fmu"
    planarc.load(TWO_LOOPS).export_fmu(path, platforms=HERE)
    return path


@pytest.fixture
def host(two_loops: Path) -> Iterator[Host]:
    made = Host(two_loops)
    yield made
    made.fmu.terminate()
    made.fmu.freeInstance()


@runs_here
def test_points_far_from_the_accepted_one(host: Host, two_loops: Path) -> None:
    """Rods turn by more than a rad behind the last point that is accepted, at 0.4 s. All is as
    where each point is accepted, and hangs on nothing that was asked for in between."""
    near = Host(two_loops)
    wanted = [near.at(t, x) for t, x in near.follow(0.6, 1.0)]
    points = host.follow(0.6, 0.4)
    there = [host.at(t, x) for t, x in points]
    assert abs(there[-1][2] - there[400][2]) > 1.0
    for row, (t, x) in reversed([*zip(there, points, strict=True)][401:]):
        assert host.at(t, x) == row
    asked = [near.at(t, x) for t, x in points[401:]]
    assert np.abs(np.array(asked) - np.array(there[401:])).max() < 1e-7
    assert np.abs(np.array(wanted) - np.array(there)).max() < 1e-6


@runs_here
def test_a_point_that_no_way_leads_to_is_discarded(host: Host) -> None:
    """A thousand turns away; behind that the accepted point stays what it was."""
    before = host.at(0.0, np.array(host.x))
    with pytest.raises(FMICallException, match="discard"):
        host.at(0.0, np.array([7e3, 0.0]))
    assert host.at(0.0, np.array(host.x)) == before


@runs_here
@pytest.mark.parametrize("way", WAYS)
def test_a_host_that_tells_of_few_steps(two_loops: Path, way: str) -> None:
    """FMPy tells of none within its intervals."""
    table = simulate(two_loops, way, 4.0)
    result = planarc.load(TWO_LOOPS).simulate(4.0, intervals=100, tolerance=1e-12)
    for name in table.dtype.names[1:]:
        worst = np.abs(table[name] - result[name]).max() / np.ptp(result[name])
        assert worst < 1e-6, name


@runs_here
def test_a_flat_pose_between_two_points_of_a_host(tmp_path: Path) -> None:
    """Parallelograms pass the pose in which they are flat, and could go on as another linkage. (A
    host's step may end in that very pose, where its differences tell nothing: then it gives up, and
    says so. Half of the runs below 5e-9 do.)"""
    path = tmp_path / "Windows.fmu"
    planarc.load("PlanarMultiBody.Examples.Loops.NFourBar").export_fmu(path, platforms=HERE)
    shown = [f"rev[{i}].phi" for i in (1, 2, 3)]
    unpacked = fmpy.extract(path)
    for tolerance in np.logspace(-5, -7, 9).tolist():
        table = fmpy.simulate_fmu(unpacked, fmi_type="ModelExchange", stop_time=10,
                                  relative_tolerance=tolerance, output_interval=0.1,
                                  record_events=False, output=shown)  # fmt: skip
        first, *others = (table[name] for name in shown)
        assert first[-1] < -30
        assert all(np.abs(first - other).max() < 1e-6 for other in others)
