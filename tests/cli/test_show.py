"""`planarc show`: what a class is made of."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from planarc.cli.app import run

ARM = """model Arm "A lever"
  parameter Real L(unit="m") = 2 "Length";
  Real x(start=1, fixed=true) "Way";
equation
  der(x) = -x/L;
  annotation(experiment(StopTime=1));
end Arm;
"""


def test_a_component_is_shown_with_units_defaults_and_descriptions(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(["show", "PlanarMultiBody.Parts.Body"]) == 0
    lines = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    assert lines[0] == 'model PlanarMultiBody.Parts.Body "Rigid body with mass and inertia"'
    assert any(line.startswith("m ") and line.endswith(" kg Mass") for line in lines)
    assert lines.index("Parameters") < lines.index("Connectors") < lines.index("Variables")


def test_a_model_tells_what_can_be_set(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "arm.pmo").write_text(ARM, "utf-8")
    assert run(["show", str(tmp_path / "arm.pmo")]) == 0
    lines = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    assert "1 equation, 1 state" in lines
    assert "L 2 m Length" in lines
    assert "x.start 1 Way at the start, held exactly" in lines
    assert run(["show", str(tmp_path / "arm.pmo"), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["parameters"][0] | {"type": ""} == {
        "name": "L", "type": "", "value": "2", "unit": "m", "description": "Length", "from": None
    }  # fmt: skip
    assert [s["name"] for s in told["settable"]] == ["L", "x.start"]
    assert told["counts"] == {"equations": 1, "states": 1}


def test_a_wrong_model_is_shown_as_far_as_its_text_tells(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "arm.pmo").write_text(ARM.replace("-x/L", "-y/L"), "utf-8")
    assert run(["show", str(tmp_path / "arm.pmo")]) == 0
    shown = capsys.readouterr()
    assert "Length" in shown.out
    assert shown.err.startswith("error[F210]")


def test_packages_and_partial_classes_are_shown_too(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = "package P model A end A; partial model B parameter Real r = 1; end B; end P;"
    (tmp_path / "p.pmo").write_text(text, "utf-8")
    assert run(["show", str(tmp_path / "p.pmo")]) == 0
    assert capsys.readouterr().out.split() == ["package", "P", "Classes", "P.A", "P.B"]
    assert run(["show", str(tmp_path / "p.pmo"), "B"]) == 0
    assert capsys.readouterr().out.startswith("partial model P.B")
    assert run(["show", "PlanarMultiBody.Parts.Bodi"]) == 2
    assert "did you mean `PlanarMultiBody.Parts.Body`" in capsys.readouterr().err
