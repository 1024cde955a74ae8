"""Messages of FMUs: their values are written as planarc writes them."""

from __future__ import annotations

import random
from functools import cache
from pathlib import Path

import fmpy
import pytest
from fmpy.fmi3 import FMU3Slave

import planarc
from planarc.api.model import Model
from planarc.core.diagnostic import PlanarcError
from planarc.runtime.texts import formatted
from tests.export.fmus import EXAMPLES, runs_here

#: Of which the digit behind the last one is a 5 alone.
TIES = (0.5, 1.5, 0.005, 999999.5, 99999.95)
FORMS = ("", ".3g", ".12g", ".0f", ".2f")
TELLS = f"""
model Tells
  parameter Real x=1;
  parameter Boolean b=true;
  output Real y=x;
equation
  assert(b, "%" + String(not b) + "|" + {
    ' + "|" + '.join(f'String(x, format="{form}")' if form else "String(x)" for form in FORMS)
});
end Tells;
"""
CHOOSES = """
model Chooses "A text that a run chooses, values of the instant of an event, and what resets them"
  output Real x(start=0, fixed=true);
equation
  der(x) = 1;
  when x > 0.5 then
    assert(x < 0.4, (if x > 0.4 then "right # 1" else "left") + " at " + String(x) + ", " +
      String(x > 0.1));
    reinit(x, 0);
  end when;
end Chooses;
"""


@cache
def tells() -> Model:
    return planarc.load(TELLS)


class Told:
    """The messages of instances of an archive."""

    def __init__(self, path: Path) -> None:
        self.description = fmpy.read_model_description(path)
        self.names = {v.name: v.valueReference for v in self.description.modelVariables}
        self.unpacked = fmpy.extract(path)
        self.texts: list[str] = []

    def instance(self) -> FMU3Slave:
        identifier = self.description.coSimulation.modelIdentifier
        fmu = FMU3Slave(guid=self.description.guid, unzipDirectory=self.unpacked,
                        modelIdentifier=identifier)  # fmt: skip
        fmu.instantiate(logMessage=lambda *given: self.texts.append(given[-1].decode()))
        return fmu


def numbers() -> list[float]:
    r = random.Random(3)
    found = [0.0, 1.0, -1.0, 0.1, 123456.0, 1234567.0, 999999.5, 99999.95, 1e-4, 9.9999999e-5,
             1e100, -2.5e-300, 0.5, 1.5, 0.005, 100.0, 1e15, 12345.678, 5e-8]  # fmt: skip
    found += [r.uniform(-1, 1) * 10.0 ** r.randint(-12, 14) for _ in range(300)]
    return found


def expected(x: float) -> str:
    return "|".join(["%true", *(formatted(x, form) for form in FORMS)])


@runs_here
def test_numbers_are_written_as_planarc_writes_them(tmp_path: Path) -> None:
    wrong: list[tuple[float, str, str, str]] = []
    told = Told(tells().export_fmu(tmp_path / "a.fmu"))
    for x in numbers():
        fmu = told.instance()
        fmu.setFloat64([told.names["x"]], [x])
        fmu.setBoolean([told.names["b"]], [False])
        fmu.enterInitializationMode()
        with pytest.raises(fmpy.fmi1.FMICallException):
            fmu.exitInitializationMode()
        fmu.freeInstance()
        message = told.texts[-1].removeprefix("assertion failed at t = 0 s: ").split("|")
        for form, found, wanted in zip(("b", *FORMS), message, expected(x).split("|"), strict=True):
            if found != wanted:
                wrong.append((x, form, found, wanted))
    # Ties, and digits of very large numbers that they do not have.
    assert all(abs(x) >= 1e12 or x in TIES for x, f, *_ in wrong), wrong
    for _, _, found, wanted in wrong:
        assert abs(float(found) - float(wanted)) <= 1.01 or found == pytest.approx(wanted, rel=1e-5)


@runs_here
@pytest.mark.parametrize("fmi", (2, 3))
@pytest.mark.parametrize("way", ("CoSimulation", "ModelExchange"))
def test_a_message_is_that_of_a_run(tmp_path: Path, way: str, fmi: int) -> None:
    """The values are those of the instant at which the assertion failed, before a `reinit`."""
    model = planarc.load(CHOOSES)
    with pytest.raises(PlanarcError) as failed:
        model.simulate(1)
    told: list[str] = []
    path = model.export_fmu(tmp_path / "a.fmu", fmi=fmi, platforms=None)
    with pytest.raises(fmpy.fmi1.FMICallException):
        fmpy.simulate_fmu(str(path), fmi_type=way, stop_time=1,
                          logger=lambda *given: told.append(given[-1].decode()))  # fmt: skip
    assert failed.value.diagnostics[0].message == told[0].replace("##", "#")
    assert "right # 1 at 0.5, true" in told[0].replace("##", "#")


@runs_here
def test_a_loop_that_opens_is_named_with_its_instant(tmp_path: Path) -> None:
    """A crank that a motion turns beyond where its loop closes."""
    path = planarc.load(EXAMPLES / "four_bar.pmo").export_fmu(tmp_path / "a.fmu")
    told = Told(path)
    fmu = told.instance()
    fmu.setFloat64([told.names["coupler.r[1]"]], [50.0])
    fmu.enterInitializationMode()
    with pytest.raises(fmpy.fmi1.FMICallException):
        fmu.exitInitializationMode()
    assert "no start is found" in told.texts[-1]
