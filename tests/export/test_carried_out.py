"""What assertions and touches of FMUs read, carried out from numbers: the same, bit by bit."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest

from planarc.compiler import compile_model
from planarc.request.request import Request
from tests.export.fmus import runs_here, written

CRADLE = "PlanarMultiBody.Examples.Contacts.NewtonsCradle"
#: Enough assertions and derivatives; the one at place 30 fails late.
LIMITED = """
model Limited
  parameter Real k[12] = {1 + 0.1*i for i in 1:12};
  parameter Real most[40] = {if i == 30 then 0.5 else 10 + i for i in 1:40};
  Real x[12](each start=1, each fixed=true);
  Real y = sum(x[i]^2*sin(k[i]*x[i]) for i in 1:12);
equation
  for i in 1:12 loop
    der(x[i]) = k[i]*sin(x[i])*x[mod(i, 12) + 1]*exp(-x[mod(i + 4, 12) + 1]^2*time);
  end for;
  for i in 1:40 loop
    assert(if i == 30 then time < most[i] else x[mod(i, 12) + 1] < most[i],
           "too far: " + String(most[i]));
  end for;
  annotation(experiment(StopTime=1));
end Limited;
"""


def runs(
    request: Request, folder: Path, monkeypatch: pytest.MonkeyPatch, stop: float
) -> tuple[list[np.ndarray], list[bytes]]:
    """With and without carrying out."""
    model, rows, codes = compile_model(request), [], []
    for least in (1, 1 << 30):
        monkeypatch.setattr("planarc.instance.actions.SHORTEST_SELDOM", least)
        monkeypatch.setattr("planarc.export.module._LARGE", 0)
        path = written(folder / f"{least}.fmu", model, 3)
        rows.append(fmpy.simulate_fmu(path, fmi_type="CoSimulation", stop_time=stop))
        codes.append(path.read_bytes())
    return rows, codes


@runs_here
def test_touches_feel_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rows, codes = runs(Request(class_name=CRADLE), tmp_path, monkeypatch, 0.5)
    assert rows[0].tobytes() == rows[1].tobytes() and len(codes[0]) < len(codes[1])


@runs_here
def test_the_same_assertion_fails_with_its_value(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rows, codes = runs(Request(text=LIMITED), tmp_path, monkeypatch, 0.4)
    assert rows[0].tobytes() == rows[1].tobytes() and len(codes[0]) < len(codes[1])
    for least in (1, 1 << 30):
        told: list[str] = []

        def log(*given: object, told: list[str] = told) -> None:
            told.append(given[-1].decode())  # type: ignore[attr-defined]

        with pytest.raises(Exception, match="DoStep"):
            fmpy.simulate_fmu(tmp_path / f"{least}.fmu", fmi_type="CoSimulation", stop_time=0.8,
                              logger=log)  # fmt: skip
        assert any("too far: 0.5" in text for text in told), told
