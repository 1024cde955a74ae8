"""Runs that take absurdly many steps say so: when, where the jump stands, what would be better."""

from __future__ import annotations

import re

import pytest

import planarc
from planarc.core.diagnostic import Diagnostic, Severity
from planarc.solve import effort
from planarc.solve.messages import labour

BACKENDS = ["numpy", "native"]

RUBBING = """model Rubbing
  Real x(start=0, fixed=true), v(start=1, fixed=true);
equation
  der(x) = v;
  der(v) = JUMP + 0.1*sin(3*time);
end Rubbing;
"""
TURNING = """model Turning
  parameter Real w = 1e5;
  Real x(start=1, fixed=true), v(start=0, fixed=true);
equation
  der(x) = w*v;
  der(v) = -w*x;
end Turning;
"""


def told(text: str, backend: str, stop: float) -> list[Diagnostic]:
    if backend == "native":
        pytest.importorskip("llvmlite")
    warnings = planarc.load(text, backend=backend).simulate(stop).warnings
    return [w for w in warnings if w.code == "R427"]


@pytest.fixture
def short_stretches(monkeypatch: pytest.MonkeyPatch) -> None:
    """A twentieth of the steps: what is said depends on ratios only."""
    monkeypatch.setattr(effort, "STRETCH", effort.STRETCH // 20)
    for name in ("CREEP_PART", "ABSURD_PART", "LONG_PART"):
        monkeypatch.setattr(effort, name, getattr(effort, name) / 20)
    monkeypatch.setattr(labour, "HOPELESS_PART", labour.HOPELESS_PART / 20)


@pytest.mark.usefixtures("short_stretches")
@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("jump", "named"),
    [
        ("-2*sign(v)", "`sign`"),
        ("-2*noEvent(if v > 0 then 1 else -1)", "a relation without event"),
    ],
)
def test_a_jump_that_holds_a_state(jump: str, named: str, backend: str) -> None:
    stop = 0.55 if backend == "native" else 0.5175  # differences tell less of the jump
    (found,) = told(RUBBING.replace("JUMP", jump), backend, stop)
    assert found.severity is Severity.WARNING
    assert found.message.startswith("between t = 0.5")
    assert f" steps: {named} in `der(v) = -2*" in found.message
    assert found.span is not None
    assert found.span.line == 5
    assert "`BearingFriction`" in str(found.hint)
    assert "move fastest are `v` (rate " in str(found.hint)


@pytest.mark.usefixtures("short_stretches")
def test_a_jump_that_nobody_would_wait_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """The run ends with its rows, and says at what."""
    monkeypatch.setattr(labour, "HOPELESS", 20)
    model = planarc.load(RUBBING.replace("JUMP", "-2*sign(v)"))
    with pytest.raises(planarc.RunStopped) as stopped:
        model.simulate(100.0, intervals=1000)
    result = stopped.value.result
    ended = result.ended
    assert ended is not None
    assert (ended.code, ended.severity) == ("R427", Severity.ERROR)
    assert re.match(
        r"from t = 0\.5\d* s on the run would take [\d,]+ million steps: ", ended.message
    )
    assert "`sign` in `der(v) = -2*sign(v)" in ended.message
    assert ended.span is not None
    assert ended.span.line == 5
    assert [w for w in result.warnings if w.code == "R427"] == []
    assert 0.5 <= result.time[-1] < 1.0


@pytest.mark.usefixtures("short_stretches")
@pytest.mark.parametrize("backend", BACKENDS)
def test_nothing_is_said_of_what_turns_fast(backend: str) -> None:
    assert told(TURNING, backend, 0.02) == []


def test_absurd_without_a_jump(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(labour, "ABSURD", 5)
    monkeypatch.setattr(effort, "ABSURD_PART", 0.1)
    (found,) = told(TURNING, "native", 0.2)
    assert " steps" in found.message
    assert found.span is None
    assert "slow down what is fast" in str(found.hint)


def test_a_part_that_sticks_is_quick() -> None:
    text = "model M extends Modelica.Mechanics.Translational.Components.MassWithStopAndFriction("
    text += "m=1, L=0, smax=9, smin=-9, F_prop=0, F_Coulomb=2, F_Stribeck=0, fexp=1, "
    text += "s(start=0, fixed=true), v(start=1, fixed=true)); end M;"
    result = planarc.load(text).simulate(2.0)
    assert result.statistics.steps < 1000
    assert not [w for w in result.warnings if w.code == "R427"]
