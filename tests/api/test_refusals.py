"""Refusals of the Python interface that depend on the system or on other processes."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import planarc
from planarc.api import variant
from planarc.api.analysis import drive
from planarc.catalog.handbook.page import write_handbook
from planarc.core.diagnostic import UsageError
from planarc.ir.expr import Exprs
from planarc.study import workers
from planarc.study.journal import Journal
from planarc.view.page.report import write_report
from planarc.view.scene import make_scene

CART = "model Cart Real x = time; end Cart;"


def test_native_code_without_its_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(UsageError, match="C207"):
        planarc.load(CART, backend="native")


def test_an_element_that_would_follow_its_parameters_no_longer() -> None:
    computed: Any = SimpleNamespace(name="n[2]", settable=False, structural=False)
    with pytest.raises(UsageError, match="C205"):
        variant._refuse_computed([computed], {"n[1]": 3.0})


def test_a_coordinate_whose_torque_no_equation_leaves_open() -> None:
    given: Any = SimpleNamespace(table=Exprs(), equations=(), variables=())
    with pytest.raises(UsageError, match="C247"):
        drive._with_motions(given, ["hinge.phi"], {"hinge.phi": "hinge.tau"}, [None])


def test_a_journal_that_another_study_is_writing(tmp_path: Path) -> None:
    first = Journal(tmp_path / "journal", "key")
    with pytest.raises(UsageError, match="C234"):
        Journal(tmp_path / "journal", "key")
    assert first.done == {}


def test_a_metric_that_no_process_can_be_sent(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(sys, "platform", "darwin")
    payload: Any = lambda result: 0.0  # noqa: E731
    with pytest.raises(UsageError, match="C236"):
        workers._hand_over(payload, tmp_path)


def test_a_report_of_a_curve_that_is_not_there(tmp_path: Path) -> None:
    result = planarc.load(CART).simulate().rows
    with pytest.raises(UsageError, match="V102"):
        write_report(tmp_path / "cart.html", result, make_scene(result), curves=["y"])


def test_a_handbook_in_a_folder_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="V103"):
        write_handbook(tmp_path / "nowhere" / "handbook.html", "Parts", [])


@pytest.mark.parametrize(
    ("call", "said", "hint"),
    [
        (lambda m: m.simulate(stoptime=1), "`simulate` has no keyword `stoptime`", "stop_time"),
        (lambda m: m.simulate(tol=1e-6), "`simulate` has no keyword `tol`", "tolerance"),
        (lambda m: m.simulate(duration=1), "`simulate` has no keyword `duration`", "stop_time"),
        (lambda m: m.linearize(qq=1), "`linearize` has no keyword `qq`", "choose among"),
        (lambda m: m.run(stop_time=1), "`run` has no keyword", "`simulate(stop_time=...)` has one"),
        (lambda m: m.simulate().at("x"), "`at` lacks `times`", "at(name, times)"),
        (lambda m: m.simulate().plot("x", y="x"), "`plot` has no keyword `y`", "choose among"),
        (lambda m: planarc.read("x.csv", source="y"), "`read` has no keyword", "`path`, `model`"),
        (lambda m: planarc.load("x.pmo", library="y"), "`load` has no keyword", "libraries"),
        (lambda m: planarc.sweep(m, {}, worker=2), "`sweep` has no keyword `worker`", "workers"),
        (lambda m: planarc.random({"k": (1, 2)}, cnt=2), "`random` has no keyword", "count"),
    ],
)
def test_a_misspelt_keyword_names_the_nearest(call: Any, said: str, hint: str) -> None:
    model = planarc.load("model M parameter Real k = 1; Real x = k*time; end M;")
    with pytest.raises(planarc.UsageError) as problem:
        call(model)
    assert isinstance(problem.value, TypeError)
    (found,) = problem.value.diagnostics
    assert found.code == "C201" and said in found.message and hint in (found.hint or "")


def test_run_says_what_it_takes() -> None:
    model = planarc.load("model M Real x = time; end M;")
    with pytest.raises(planarc.UsageError, match="RunOptions") as problem:
        model.run(3)  # type: ignore[arg-type]
    assert "simulate(stop_time=...)" in (problem.value.diagnostics[0].hint or "")


def test_names_of_the_interface_that_are_not_there_name_those_that_are() -> None:
    model = planarc.load(CART)
    with pytest.raises(AttributeError, match="no attribute `execute`: did you mean `simulate`"):
        _ = model.execute
    with pytest.raises(AttributeError, match=r"write `model.simulate\(\).plot`"):
        _ = model.plot
    with pytest.raises(AttributeError, match=r"read `model.parameters\[.m.k.\]`"):
        planarc.load("model A model M parameter Real k = 1; end M; M m; end A;").m.k = 2
    with pytest.raises(AttributeError, match=r"no attribute `m`: write `\[.m.k.\]`"):
        _ = planarc.load("model A model M parameter Real k = 1; end M; M m; end A;").parameters.m
    with pytest.raises(AttributeError, match=r"never changes: .* `simulate\(parameters="):
        model.set_parameter("m", 2)
    with pytest.raises(UsageError, match=r"numpy\.linspace"):
        planarc.sweep(model, {"m": "1:5"})
    with pytest.raises(UsageError, match="takes `stop_time` without a name"):
        model.simulate(0, 10)  # type: ignore[misc]
    with pytest.raises(UsageError, match="a text, not int"):
        _ = model.simulate()[0]
    with pytest.raises(AttributeError, match="did you mean `to_pandas`"):
        _ = model.simulate().to_dataframe
    with model.stepper() as stepper, pytest.raises(UsageError, match="the model has no inputs"):
        stepper["x"] = 1


def test_values_of_a_model_are_given_to_runs() -> None:
    """Who sets one, as in other tools, is told how a run gets another one."""
    model = planarc.load(
        "model M parameter Real m = 1; Real x(start=1); equation der(x) = m; end M;"
    )
    with pytest.raises(UsageError, match=r'C202.*\n.*simulate\(parameters=\{"m": ...\}\)'):
        setattr(model.parameters["m"], "value", 3.0)  # noqa: B010 - a read-only field, for mypy
    with pytest.raises(UsageError, match=r'simulate\(start=\{"x": ...\}\)'):
        setattr(model.variables["x"], "start", 3.0)  # noqa: B010


def test_functions_of_the_package_are_looked_for_in_a_model() -> None:
    with pytest.raises(AttributeError, match=r"planarc\.sweep\(model, "):
        planarc.load(CART).sweep("m", [1, 2])  # type: ignore[attr-defined]
