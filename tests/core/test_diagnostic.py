"""Errors as Python shows them: with places and hints, across processes, in a notebook."""

from __future__ import annotations

import pickle
import re

import pytest

import planarc
from planarc.core.diagnostic import Diagnostic, PlanarcError

WRONG = """model Wrong
  Real x;
equation
  der(x) = speed;
end Wrong;
"""


def raised(text: str) -> PlanarcError:
    with pytest.raises(PlanarcError) as caught:
        planarc.load(text)
    return caught.value


def test_an_error_in_python_says_where_and_what_as_the_command_line_does() -> None:
    said = str(raised(WRONG)).splitlines()
    assert said[0] == "error[F210]: unknown name `speed` in `Wrong`"
    assert said[1].endswith("<text>:4:12")
    assert said[3].endswith("|   der(x) = speed;")


def test_a_name_that_is_not_there_is_told_as_other_errors_are() -> None:
    model = planarc.load("model Free Real x; equation der(x) = 1; end Free;")
    with pytest.raises(KeyError) as caught:
        model.variables["y"]
    said = str(caught.value).splitlines()
    assert said[0] == "error[C201]: there is no variable `y`"
    assert said[1].startswith("  hint: choose among `x`")


def test_an_error_crosses_processes_whole() -> None:
    error = raised(WRONG)
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)


def test_a_stopped_run_crosses_processes_with_what_it_computed() -> None:
    stopping = 'model Stops Real x(start=1, fixed=true); equation der(x) = 1; assert(x < 1.5, "");'
    with pytest.raises(planarc.RunStopped) as caught:
        planarc.load(f"{stopping} end Stops;").simulate(1)
    again = pickle.loads(pickle.dumps(caught.value))
    assert isinstance(again, planarc.RunStopped)
    assert again.result["x"][-1] == pytest.approx(1.5, abs=1e-3)


def test_a_notebook_shows_the_users_line_in_the_place_of_a_traceback() -> None:
    model = planarc.load("model Free Real x; equation der(x) = 1; end Free;")
    with pytest.raises(PlanarcError) as caught:
        model.simulate(1, parameters={"y": 2.0})
    shown = re.sub("\033.*?m", "", "\n".join(caught.value._render_traceback_()))
    assert "model.simulate(1, parameters=" in shown
    assert "there is no parameter `y`" in shown
    assert "values.py" not in shown and "_scalars" not in shown


def test_several_diagnostics_are_all_told() -> None:
    error = PlanarcError([Diagnostic("P1", "first"), Diagnostic("P2", "second", hint="do so")])
    assert str(error) == "error[P1]: first\n\nerror[P2]: second\n  hint: do so"
