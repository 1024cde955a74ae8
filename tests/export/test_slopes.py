"""Derivatives that an FMU gives: against planarc's own, against differences, and transposed."""

from __future__ import annotations

import ctypes
import re
from pathlib import Path
from xml.etree import ElementTree as Xml
from zipfile import ZipFile

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu
from msgspec.structs import replace

from planarc.api.model import Model
from planarc.core.options import Backend
from planarc.export import module
from planarc.request.request import Request
from tests.export.fmus import EXAMPLES, runs_here

OUTPUTS = ("revA.phi", "revC.w", "coupler.frame_b.f[1]", "revB.z")
#: An oscillator whose force follows from a nonlinear loop of equations.
LOOP = """
model Loop
  input Real u(start=0.3);
  output Real y, z;
  Real x(start=1, fixed=true), v(start=0.5, fixed=true);
equation
  der(x) = v;
  der(v) = -y + 2*z;
  y + y^3 = x + z*sin(v);
  z + exp(0.1*y) = x*u;
end Loop;
"""


@pytest.fixture(scope="module")
def four_bar() -> Model:
    request = Request(EXAMPLES / "four_bar.pmo")
    return Model(replace(request, inputs=("revA.tau",)), Backend.NATIVE)


class Exported:
    """An instance at the start, and what its description tells of references."""

    def __init__(self, model: Model, folder: Path, version: int, outputs: tuple[str, ...]) -> None:
        wanted = re.compile("|".join(f"^{re.escape(name)}$" for name in outputs))
        path = model.export_fmu(folder / "a.fmu", fmi=version, outputs=wanted)
        told = fmpy.read_model_description(path)
        kind = FMU3Slave if version == 3 else FMU2Slave
        self.fmu = kind(guid=told.guid, unzipDirectory=fmpy.extract(path),
                        modelIdentifier=told.coSimulation.modelIdentifier)  # fmt: skip
        self.fmu.instantiate()
        if version == 2:
            self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.version, self.told = version, told
        self.of = {v.name: v.valueReference for v in told.modelVariables}
        self.states = [v.variable.derivative.valueReference for v in told.derivatives]
        self.rates = [v.variable.valueReference for v in told.derivatives]

    def along(self, unknowns: list[int], knowns: list[int], seed: list[float]) -> list[float]:
        if self.version == 3:
            return self.fmu.getDirectionalDerivative(unknowns, knowns, seed)
        u, k = (
            (ctypes.c_uint32 * len(unknowns))(*unknowns),
            (ctypes.c_uint32 * len(knowns))(*knowns),
        )
        out = (ctypes.c_double * len(unknowns))()
        given = (ctypes.c_double * len(knowns))(*seed)
        self.fmu.fmi2GetDirectionalDerivative(
            self.fmu.component, u, len(unknowns), k, len(knowns), given, out
        )
        return list(out)

    def jacobian(self, unknowns: list[int], knowns: list[int]) -> np.ndarray:
        return np.array([self.along(unknowns, [k], [1.0]) for k in knowns]).T


@runs_here
@pytest.mark.parametrize("version", (2, 3))
def test_they_are_those_of_planarc(four_bar: Model, tmp_path: Path, version: int) -> None:
    one = Exported(four_bar, tmp_path, version, OUTPUTS)
    linear = four_bar.linearize(outputs=OUTPUTS)
    knowns = [*one.states, one.of["revA.tau"]]
    unknowns = [*one.rates, *(one.of[name] for name in OUTPUTS)]
    wanted = np.block([[linear.A, linear.B], [linear.C, linear.D]])
    found = one.jacobian(unknowns, knowns)
    assert found == pytest.approx(wanted, rel=1e-12, abs=1e-12)
    together = np.array(one.along(unknowns, knowns, [0.5, -2.0, 3.0]))
    assert together == pytest.approx(wanted @ [0.5, -2.0, 3.0], rel=1e-11)


@runs_here
def test_what_is_carried_out_is_what_is_compiled(
    four_bar: Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """To the last bit."""
    found = []
    for folder, least in ((tmp_path / "spelled", 0), (tmp_path / "code", 1 << 30)):
        folder.mkdir()
        monkeypatch.setattr(module, "_LARGE", least)
        one = Exported(four_bar, folder, 3, OUTPUTS)
        unknowns = [*one.rates, *(one.of[name] for name in OUTPUTS)]
        found.append(one.jacobian(unknowns, [*one.states, one.of["revA.tau"]]))
    assert np.array_equal(*found) and np.isfinite(found[0]).all()


def test_what_implicit_steps_ask_for_is_compiled(
    four_bar: Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = []
    for least in (0, 1 << 30):
        monkeypatch.setattr(module, "_LARGE", least)
        made.append(four_bar.export_fmu(tmp_path / "a.fmu", stiff=True).read_bytes())
    assert made[0] == made[1]


@runs_here
def test_through_a_loop_they_are_limits_of_differences(tmp_path: Path) -> None:
    one = Exported(Model(Request(text=LOOP), Backend.NATIVE), tmp_path, 3, ("y", "z"))
    fmu, u = one.fmu, one.of["u"]
    unknowns = [one.of["y"], one.of["z"], *one.rates]
    exact = np.array(one.along(unknowns, [u], [1.0]))
    values = []
    for by in (1e-5, -1e-5):
        fmu.setFloat64([u], [0.3 + by])
        values.append(np.array(fmu.getFloat64(unknowns)))
    assert exact == pytest.approx((values[0] - values[1]) / 2e-5, rel=1e-8)
    assert np.abs(exact[:2]).min() > 0.01


@runs_here
def test_the_adjoint_is_the_transposed(four_bar: Model, tmp_path: Path) -> None:
    one = Exported(four_bar, tmp_path, 3, OUTPUTS)
    knowns = [*one.states, one.of["revA.tau"]]
    unknowns = [*one.rates, *(one.of[name] for name in OUTPUTS)]
    jacobian = one.jacobian(unknowns, knowns)
    weights = [float(k + 1) for k in range(len(unknowns))]
    found = one.fmu.getAdjointDerivative(unknowns, knowns, weights)
    assert np.array(found[: len(knowns)]) == pytest.approx(jacobian.T @ weights, rel=1e-12)


@runs_here
def test_what_has_no_derivative_is_told(four_bar: Model, tmp_path: Path) -> None:
    one = Exported(four_bar, tmp_path, 3, OUTPUTS)
    y, u = one.of["revA.phi"], one.of["revA.tau"]
    for unknown, known in ((y, one.of["crank.r[1]"]), (one.of["revD.phi"], u), (y, 2**24 - 8)):
        with pytest.raises(fmpy.fmi1.FMICallException):
            one.along([unknown], [known], [1.0])
    assert one.along([y], [u], [1.0]) == [0.0]


def structure(path: Path) -> dict[str, dict[str, str] | None]:
    """What outputs and derivatives depend on, by names."""
    told = fmpy.read_model_description(path)
    found: dict[str, dict[str, str] | None] = {}
    for unknown in (*told.outputs, *told.derivatives):
        known = unknown.dependencies
        kinds = unknown.dependenciesKind or []
        found[unknown.variable.name] = None if known is None else {
            v.name: kind for v, kind in zip(known, kinds, strict=True)}  # fmt: skip
    return found


@pytest.mark.parametrize("version", (2, 3))
def test_the_description_says_what_depends_on_what(tmp_path: Path, version: int) -> None:
    text = """
model Chain
  parameter Real m=2, x0=1;
  input Real u, idle;
  output Real y=3*x, z=x*u, sum=p + q, still=time;
  Real x(start=x0, fixed=true, nominal=1e-3), v(start=0, fixed=true), far(start=0, fixed=true);
  Real p, q;
equation
  der(x) = v;
  m*der(v) = u;
  der(far) = -far;
  p + q^3 = x;
  q - p = sin(far);
end Chain;
"""
    model = Model(Request(text=text), Backend.NATIVE)
    path = model.export_fmu(tmp_path / "a.fmu", fmi=version)
    assert structure(path) == {
        "y": {"x": "constant"},
        "z": {"u": "dependent", "x": "dependent"},
        "sum": {"far": "dependent", "x": "dependent"},
        "still": {"time": "constant"},
        "v": {"v": "constant"},  # der(x) has its value
        "der(v)": {"u": "tunable"},
        "der(far)": {"far": "constant"},
    }
    told = {v.name: v for v in fmpy.read_model_description(path).modelVariables}
    assert (told["m"].variability, told["x0"].variability) == ("tunable", "fixed")
    assert float(told["x"].nominal) == 1e-3


DRIVEN = """
model Driven
  parameter Real m=2;
  input Real u(start=0.4);
  output Real clock=3*time, loud=x*sin(time), sum=p + q, free=x;
  Real x(start=1, fixed=true), v(start=0, fixed=true);
  Real p, q;
  Modelica.Blocks.Sources.CombiTimeTable table(table=[0, 0; 1, 2; 2, 0],
    smoothness=Modelica.Blocks.Types.Smoothness.ContinuousDerivative);
equation
  der(x) = v;
  m*der(v) = u + table.y[1];
  p + q^3 = x*exp(time);
  q - p = sin(v);
end Driven;
"""


@pytest.mark.parametrize("version", (2, 3))
def test_the_description_says_what_depends_on_the_time(tmp_path: Path, version: int) -> None:
    """The standard counts the independent variable among what is known."""
    text = re.sub(r"  Modelica.*?;\n", "", DRIVEN, flags=re.S).replace("table.y[1]", "5*time")
    path = Model(Request(text=text), Backend.NATIVE).export_fmu(tmp_path / "a.fmu", fmi=version)
    assert validate_fmu(str(path)) == []
    known = structure(path)
    assert known == {
        "clock": {"time": "constant"},
        "loud": {"time": "dependent", "free": "dependent"},  # x by its name as an output
        "sum": dict.fromkeys(("time", "free", "v"), "dependent"),
        "free": {"free": "constant"},
        "v": {"v": "constant"},
        "der(v)": {"time": "tunable", "u": "tunable"},
    }
    if version == 2:  # the standard wants them in the order of the variables
        with ZipFile(path) as archive:
            root = Xml.fromstring(archive.read("modelDescription.xml"))
        for unknown in root.iter("Unknown"):
            listed = [int(k) for k in unknown.get("dependencies", "").split()]
            assert listed == sorted(listed)


@runs_here
@pytest.mark.parametrize("version", (2, 3))
def test_by_the_time_they_are_limits_of_differences(tmp_path: Path, version: int) -> None:
    """Through a loop, and through a table."""
    path = Model(Request(text=DRIVEN), Backend.NATIVE).export_fmu(tmp_path / "a.fmu", fmi=version)
    told = fmpy.read_model_description(path)
    fmu = fmpy.instantiate_fmu(fmpy.extract(path), told, "ModelExchange")
    if version == 2:
        fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    (fmu.updateDiscreteStates if version == 3 else fmu.newDiscreteStates)()
    fmu.enterContinuousTimeMode()
    get = fmu.getFloat64 if version == 3 else fmu.getReal
    unknowns = [u.variable.valueReference for u in (*told.outputs, *told.derivatives)]
    values = []
    for t in (0.3 + 1e-5, 0.3 - 1e-5, 0.3):
        fmu.setTime(t)
        values.append(np.array(get(unknowns)))
    exact = fmu.getDirectionalDerivative(unknowns, [0], [1.0])
    assert exact == pytest.approx((values[0] - values[1]) / 2e-5, rel=1e-7)
    assert np.count_nonzero(exact) == 4  # clock, loud, sum and der(v)
    if version == 3:
        rows = [fmu.getAdjointDerivative([u], [0], [1.0])[0] for u in unknowns]
        assert rows == pytest.approx(exact, rel=1e-12)


@runs_here
def test_a_tunable_parameter_acts_at_once(tmp_path: Path) -> None:
    """A mass that is doubled on its way, while its start is kept."""
    one = Exported(four_bar_free(), tmp_path, 3, ("revA.phi", "revA.z"))
    fmu, of = one.fmu, one.of
    told = {v.name: v.variability for v in one.told.modelVariables}
    assert (told["rockerBody.m"], told["rocker.r[1]"]) == ("tunable", "fixed")
    fmu.doStep(currentCommunicationPoint=0.0, communicationStepSize=0.3)
    before = fmu.getFloat64([of["revA.phi"], of["revA.z"]])
    fmu.setFloat64([of["rockerBody.m"]], [50.0])
    after = fmu.getFloat64([of["revA.phi"], of["revA.z"]])
    assert after[0] == before[0] and abs(after[1] - before[1]) > 1.0
    with pytest.raises(fmpy.fmi1.FMICallException):
        fmu.setFloat64([of["rocker.r[1]"]], [0.9])


def four_bar_free() -> Model:
    return Model(Request(EXAMPLES / "four_bar.pmo"), Backend.NATIVE)
