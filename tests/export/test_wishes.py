"""What is asked of an export: inputs, outputs, parameters, platforms."""

from __future__ import annotations

import re
import zipfile
from pathlib import Path
from xml.etree import ElementTree as Xml

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

import planarc
from planarc.export.fmu import PLATFORMS
from tests.export.fmus import runs_here

FLYWHEEL = """
model Flywheel "A wheel on a hinge, without gravity"
  inner PlanarMultiBody.World world(g=0);
  PlanarMultiBody.Joints.Revolute hinge(phi(start=0.5, fixed=true), w(start=2, fixed=true));
  PlanarMultiBody.Parts.Body wheel(m=1, I=0.25);
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, wheel.frame_a);
end Flywheel;
"""


@pytest.fixture(scope="module")
def flywheel() -> planarc.Model:
    return planarc.load(FLYWHEEL)


def described(path: Path) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for v in fmpy.read_model_description(path).modelVariables:
        found.setdefault(v.causality, []).append(v.name)
    return found


@runs_here
def test_a_torque_that_is_zero_becomes_an_input(flywheel: planarc.Model, tmp_path: Path) -> None:
    path = flywheel.export_fmu(tmp_path / "a", inputs=["hinge.tau"], outputs=["hinge.phi"])
    assert path == tmp_path / "a.fmu" and described(path)["input"] == ["hinge.tau"]
    table = fmpy.simulate_fmu(path, stop_time=2.0, start_values={"hinge.tau": -0.75})
    t = table["time"]
    assert table["hinge.phi"] == pytest.approx(0.5 + 2 * t - 1.5 * t**2, abs=1e-8)


@runs_here
def test_a_coordinate_becomes_an_input_with_its_derivatives(
    flywheel: planarc.Model, tmp_path: Path
) -> None:
    path = flywheel.export_fmu(
        tmp_path / "a.fmu", inputs=["hinge.phi"], outputs=["wheel.frame_a.t"]
    )
    names = ["hinge.phi", "der(hinge.phi)", "der(hinge.phi,2)"]
    assert described(path)["input"] == names
    kinds = [("time", float), *((n, float) for n in names)]
    signal = np.array([(0.0, 0.0, 1.0, 8.0), (1.0, 0.0, 1.0, 8.0)], dtype=kinds)
    table = fmpy.simulate_fmu(path, stop_time=1.0, input=signal)
    assert table["wheel.frame_a.t"][-1] == pytest.approx(0.25 * 8)


def test_names_and_patterns_choose_what_a_host_sees(
    flywheel: planarc.Model, tmp_path: Path
) -> None:
    path = flywheel.export_fmu(
        tmp_path / "a.fmu",
        outputs=r"hinge[.](phi|w)$",
        parameters=re.compile(r"^wheel[.][mI]$"),
        platforms=["x86_64-windows", "x86_64-linux"],
    )
    found = described(path)
    assert found["output"] == ["hinge.phi", "hinge.w"]
    assert found["parameter"] == ["wheel.m", "wheel.I", "_stiff"]
    with zipfile.ZipFile(path) as archive:
        folders = {n.split("/")[1] for n in archive.namelist() if n.startswith("binaries/")}
    assert folders == {"x86_64-windows", "x86_64-linux"}


def test_version_2_has_the_platforms_that_it_knows(flywheel: planarc.Model, tmp_path: Path) -> None:
    path = flywheel.export_fmu(tmp_path / "a.fmu", fmi=2)
    with zipfile.ZipFile(path) as archive:
        folders = {n.split("/")[1] for n in archive.namelist() if n.startswith("binaries/")}
    assert folders == {kind.older for kind in PLATFORMS.values() if kind.older}


def test_people_find_the_model_in_the_archive(flywheel: planarc.Model, tmp_path: Path) -> None:
    path = flywheel.export_fmu(tmp_path / "a.fmu", platforms=["x86_64-linux"])
    with zipfile.ZipFile(path) as archive:
        assert archive.read("extra/planarc/model.pmo").decode() == FLYWHEEL
        page = archive.read("documentation/index.html").decode()
    assert "A wheel on a hinge, without gravity" in page and "<svg" in page
    for name in ("hinge.phi", "wheel.m"):
        assert f"<td><code>{name}</code>" in page


def test_frames_whose_variables_are_shown_are_terminals(
    flywheel: planarc.Model, tmp_path: Path
) -> None:
    names = [f"wheel.frame_a.{n}" for n in ("phi", "f[2]")]
    path = flywheel.export_fmu(tmp_path / "a.fmu", outputs=names, platforms=["x86_64-linux"])
    assert validate_fmu(str(path)) == []
    with zipfile.ZipFile(path) as archive:
        root = Xml.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
    (terminal,) = root.iter("Terminal")
    assert terminal.get("name") == "wheel.frame_a"
    kinds = {m.get("variableName"): m.get("variableKind") for m in terminal}
    assert kinds == dict(zip(names, ("signal", "inflow"), strict=True))


@pytest.mark.parametrize(
    ("wish", "told"),
    [
        ({"path": 3}, "C202"),
        ({"path": "a.zip"}, "V506"),
        ({"path": "no folder/a.fmu"}, "V501.*there is no folder"),
        ({"path": "."}, "V501"),
        ({"fmi": 1}, "C302"),
        ({"fmi": 2, "platforms": ["aarch64-darwin"]}, "C302.*knows no `aarch64-darwin`"),
        ({"platforms": []}, "C302.*needs a platform"),
        ({"platforms": "linux64"}, "C201.*no platform `linux64`"),
        ({"platforms": 64}, "C202"),
        ({"outputs": ["hinge.psi"]}, "C201.*no output `hinge.psi`"),
        ({"outputs": "psi"}, "V505.*no variable that changes"),
        ({"outputs": []}, "C202.*`outputs` names none"),
        ({"parameters": []}, "C202.*`parameters` names none"),
        ({"outputs": "[.*"}, "C114"),
        ({"parameters": "^hinge.phi$"}, "V505.*no parameter that an FMU can set"),
        ({"inputs": ["hinge.psi"]}, "C201.*no variable `hinge.psi`"),
        ({"inputs": ["wheel.frame_a.t"]}, "C301"),
        ({"inputs": 3}, "C202"),
        ({"output": "phi"}, "C201.*did you mean `outputs`"),
    ],
)
def test_what_cannot_be_done_is_told(
    flywheel: planarc.Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    wish: dict[str, object], told: str,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    with pytest.raises(planarc.UsageError, match=f"(?s){told}"):
        flywheel.export_fmu(**{"path": "a.fmu"} | wish)
    assert list(tmp_path.iterdir()) == []


def test_outputs_are_to_match_beside_the_models_own(tmp_path: Path) -> None:
    model = planarc.load("model M output Real x(start=1, fixed=true); equation der(x) = -x; end M;")
    with pytest.raises(planarc.UsageError, match=r"V505.*matches `psi`"):
        model.export_fmu(tmp_path / "M.fmu", outputs="psi")
