"""A model in Python: what it has, runs of it, and requests that are wrong."""

from __future__ import annotations

import math
import pickle
import subprocess
import sys
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planarc
from planarc import Model, PlanarcError, Result, RunStopped, UsageError
from planarc.api.variant import Recompiled

ROOT = Path(__file__).parents[2]


def test_the_import_loads_nothing_heavy() -> None:
    code = (
        "import sys, planarc; "
        "print([m for m in ('numpy', 'scipy', 'sympy', 'lark', 'llvmlite', 'typer', 'pandas')"
        " if m in sys.modules])"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


def test_every_public_name_is_there() -> None:
    for name in planarc.__all__:
        assert getattr(planarc, name) is not None
        assert name in dir(planarc)
    with pytest.raises(AttributeError, match="lod"):
        planarc.lod  # noqa: B018


def test_a_model_from_a_file_a_class_and_a_text() -> None:
    path = ROOT / "examples" / "pendulum.pmo"
    by_path, by_name = planarc.load(path), planarc.load(str(path))
    by_text = planarc.load(path.read_text("utf-8"))
    results = [m.simulate(1) for m in (by_path, by_name, by_text)]
    assert {m.name for m in (by_path, by_name, by_text)} == {"Pendulum"}
    for result in results[1:]:
        assert np.array_equal(result.rows.data, results[0].rows.data)


def test_a_file_may_have_any_name(tmp_path: Path) -> None:
    path = tmp_path / "my model of a pendulum.pmo"
    path.write_bytes((ROOT / "examples" / "pendulum.pmo").read_bytes())
    assert planarc.load(str(path)).name == "Pendulum"


def test_parameters_and_variables_tell_what_they_are(pendulum: Model) -> None:
    mass = pendulum.parameters["bob.m"]
    assert (mass.value, mass.unit, mass.settable, mass.structural) == (2.0, "kg", True, False)
    assert pendulum.parameters["world.gravityType"].structural
    angle = pendulum.variables["hinge.phi"]
    assert (angle.start, angle.value, angle.unit) == (0.5, 0.5, "rad")
    acceleration = pendulum.variables["hinge.z"].value
    assert acceleration is not None
    assert acceleration == pytest.approx(-2 * 9.81 * 0.7 * math.cos(0.5) / (0.3 + 2 * 0.49))
    assert set(pendulum.states) == {"hinge.phi", "hinge.w"}


def test_energy_is_that_of_the_values_given(pendulum: Model) -> None:
    m, start = 5.0, 1.1
    result = pendulum.simulate(2, parameters={"bob.m": m}, start={"hinge.phi": start})
    phi, w = result["hinge.phi"], result["hinge.w"]
    energy = 0.5 * (0.3 + m * 0.49) * w**2 + m * 9.81 * 0.7 * np.sin(phi)
    assert phi[0] == start
    assert result.parameters["bob.m"] == m
    assert np.ptp(energy) < 1e-4 * np.ptp(m * 9.81 * 0.7 * np.sin(phi))


def test_an_input_is_a_function_a_table_or_a_number(lag: Model) -> None:
    # 2*dx/dt = u - x, x(0) = 1:  u = t gives x = t - 2 + 3*exp(-t/2), u = 4: x = 4 - 3*exp(-t/2)
    ramp = {"tolerance": 1e-9}
    for given in (lambda t: t, ([0.0, 5.0], [0.0, 5.0]), [(0, 0), (1, 1), (5, 5)]):
        result = lag.simulate(3, inputs={"u": given}, **ramp)
        exact = result.time - 2 + 3 * np.exp(-result.time / 2)
        assert np.max(np.abs(result["x"] - exact)) < 1e-7
    result = lag.simulate(3, inputs={"u": 4}, **ramp)
    assert np.max(np.abs(result["x"] - 4 + 3 * np.exp(-result.time / 2))) < 1e-7
    assert np.allclose(result["y"], result["x"] + 8)
    assert (lag.inputs, lag.outputs) == (("u",), ("x", "y"))


@pytest.mark.parametrize("given", [lambda: 0.5, lambda t, x: x])
def test_an_input_is_a_function_of_the_time_alone(lag: Model, given: Any) -> None:
    with pytest.raises(UsageError, match=r"C211.*the function for `u` takes `\(") as caught:
        lag.simulate(1, inputs={"u": given})
    assert caught.value.__cause__ is None and caught.value.__suppress_context__
    assert "lambda t: ..." in str(caught.value)


def test_an_input_that_nothing_drives_keeps_its_start_value() -> None:
    model = planarc.load("model M input Real u(start=3); Real y = 2*u; end M;")
    assert set(model.simulate(1)["y"]) == {6}
    assert set(model.simulate(1, start={"u": 4})["y"]) == {8}
    assert set(model.simulate(1, start={"u": 4}, inputs={"u": 5})["y"]) == {10}


@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_a_derivative_of_an_input_follows_from_what_is_given(backend: str) -> None:
    model = planarc.load("model M input Real u; Real y = der(u); end M;", backend=backend)
    assert model.inputs == ("u", "der(u)")
    assert set(model.simulate(2)["y"]) == set(model.simulate(2, inputs={"u": 3})["y"]) == {0}
    lines = model.simulate(2, inputs={"u": ([0, 1, 2], [0, 2, 2])})
    assert np.array_equal(lines["y"], np.where(lines.time < 1, 2.0, 0.0))
    smooth = model.simulate(2, inputs={"u": math.sin})
    assert np.max(np.abs(smooth["y"] - np.cos(smooth.time))) < 1e-9
    given = model.simulate(2, inputs={"u": math.sin, "der(u)": 5})
    assert np.array_equal(given["u"], np.sin(given.time)) and set(given["y"]) == {5}


def test_a_position_that_is_an_input_gives_the_force_along_it() -> None:
    model = planarc.load(
        "model M input Real s; Real x = s; Real v = der(x); Real f = 2*der(v); end M;"
    )
    times = np.linspace(0, 2, 41)
    for given in (math.sin, (times, np.sin(times))):
        run = model.simulate(2, inputs={"s": given})
        assert np.max(np.abs(run["f"] + 2 * np.sin(run.time))) < 5e-3
        assert np.max(np.abs(run["v"] - np.cos(run.time))) < 1e-4
    assert model.linearize(outputs=["f"]).D.tolist() == [[0, 0, 2]]


def test_array_parameters_take_sequences(lag: Model) -> None:
    result = lag.simulate(1, parameters={"c": [3, 4]}, inputs={"u": 1})
    assert np.allclose(result["y"], 3 * result["x"] + 4)


@pytest.mark.filterwarnings("error")
def test_a_structural_parameter_compiles_again_and_says_so(pendulum: Model) -> None:
    with pytest.warns(Recompiled, match="`world.gravityType` is structural"):
        result = pendulum.simulate(1, parameters={"world.gravityType": "NoGravity"})
    assert np.max(np.abs(result["hinge.w"])) == 0.0
    assert result.name == "Pendulum"
    again = pendulum.simulate(1, parameters={"world.gravityType": "NoGravity"})
    same = pendulum.simulate(1, parameters={"world.gravityType": "UniformGravity"})
    assert np.max(np.abs(again["hinge.w"])) == 0.0
    assert np.max(np.abs(same["hinge.w"])) > 1.0


WRONG: list[tuple[str, Callable[[Model], Any], str]] = [
    ("parameter", lambda m: m.simulate(parameters={"bob.n": 1}), "did you mean `bob.m`"),
    ("variable", lambda m: m.simulate(start={"hinge.ph": 1}), "did you mean `hinge.phi`"),
    ("nan", lambda m: m.simulate(parameters={"bob.m": math.nan}), "must be a finite number"),
    ("text", lambda m: m.simulate(parameters={"bob.m": "heavy"}), "takes a number, not `heavy`"),
    ("shape", lambda m: m.simulate(parameters={"bob.r_CM": [1, 2, 3]}), "takes 2 numbers"),
    ("scalar", lambda m: m.simulate(parameters={"bob.m": [1, 2]}), "one number, not 2: "),
    ("no file", lambda m: m.simulate(0).animate(speed=2), "belongs to a picture in a file"),  # type: ignore[call-overload]
    ("no mapping", lambda m: m.simulate(parameters=[1]), "given by name"),  # type: ignore[arg-type]
    ("confused", lambda m: m.simulate(parameters={"hinge.phi": 1}), "not a parameter"),
    ("literal", lambda m: m.simulate(parameters={"world.gravityType": "No"}), "NoGravity"),
    ("time", lambda m: m.simulate("long"), "takes a number"),  # type: ignore[arg-type]
    ("backwards", lambda m: m.simulate(-1), "before the start"),
    ("solver", lambda m: m.simulate(solver="cvode-bfd"), "did you mean `cvode-bdf`"),
    ("input", lambda m: m.simulate(inputs={"u": 1}), "no input `u`"),
    ("inputs", lambda m: m.simulate(inputs=3), "given by name"),  # type: ignore[arg-type]
    ("folder", lambda m: m.simulate(0).to_csv("."), "it is a folder"),
    ("result", lambda m: m.simulate(0)["hinge.fi"], "did you mean `hinge"),
    ("empty", lambda m: planarc.load(" "), "not nothing"),
    ("nothing", lambda m: planarc.load(3), "not int"),  # type: ignore[arg-type]
    ("file", lambda m: planarc.load("nowhere.pmo"), "no file `nowhere.pmo`"),
]


@pytest.mark.parametrize("wrong", [w[1:] for w in WRONG], ids=[w[0] for w in WRONG])
def test_a_wrong_request_says_what_is_wrong(pendulum: Model, wrong: Any) -> None:
    request, words = wrong
    with pytest.raises(UsageError) as caught:
        request(pendulum)
    told = " ".join(f"{d.message} {d.hint}" for d in caught.value.diagnostics)
    assert words in told


def test_a_wrong_model_carries_its_diagnostics() -> None:
    with pytest.raises(PlanarcError) as caught:
        planarc.load("model M Real x; equation der(x) = y; end M;")
    (found,) = caught.value.diagnostics
    assert found.span is not None
    assert "`y`" in found.message


def test_a_wrong_input_says_where(lag: Model) -> None:
    for given, words in (
        (lambda t: "a", "no finite number"),
        (lambda t: 1 / (t - t), "ZeroDivisionError"),
        ([1, 2, 3], "table"),
        (([1, 0], [0, 1]), "ascend"),
    ):
        with pytest.raises(UsageError, match=words):
            lag.simulate(1, inputs={"u": given})


def test_what_was_computed_before_a_failure_is_kept() -> None:
    model = planarc.load(
        "model Breaks Real x(start=0, fixed=true); equation der(x) = 1;"
        ' assert(x < 0.5, "too far"); end Breaks;'
    )
    with pytest.raises(RunStopped) as caught:
        model.simulate(1)
    assert "too far" in str(caught.value)
    assert caught.value.result.time[-1] == pytest.approx(0.5, abs=0.01)


def test_threads_may_share_a_model(pendulum: Model) -> None:
    starts = [0.1 * i for i in range(16)]

    def run(start: float) -> Any:
        return pendulum.simulate(1, start={"hinge.phi": start}).rows.data

    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(run, starts))
    for start, data in zip(starts, together, strict=True):
        assert np.array_equal(data, run(start))


def test_a_model_can_be_sent_to_another_process(pendulum: Model) -> None:
    copy = pickle.loads(pickle.dumps(pendulum))
    assert np.array_equal(copy.simulate(1).rows.data, pendulum.simulate(1).rows.data)


def test_another_run_costs_little(
    four_bar: Model, steps_of: Callable[[Callable[[], object]], int]
) -> None:
    """In calls of functions, most of the run being native; the benchmarks allow 1.5 ms."""
    results: list[Result] = []

    def run() -> None:
        start = {"revA.phi": 1 + 1e-3 * len(results)}
        results.append(four_bar.simulate(10, tolerance=1e-6, intervals=500, start=start))

    run()
    assert steps_of(run) < 2_100
    assert results[-1].statistics.steps < 2_000


def test_back_ends_agree(four_bar: Model) -> None:
    native, numpy = (four_bar.simulate(1, backend=b, tolerance=1e-9) for b in ("native", "numpy"))
    assert numpy.statistics.backend == "numpy"
    assert np.max(np.abs(native["revD.phi"] - numpy["revD.phi"])) < 1e-7


def test_warnings_of_python_are_not_raised_by_a_plain_run(pendulum: Model) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pendulum.simulate(1)


def test_the_package_tells_its_version() -> None:
    from importlib.metadata import version

    assert planarc.__version__ == version("planarc")


def test_the_only_example_of_a_package_is_taken() -> None:
    text = """package P
      model A Real x(start=1, fixed=true); equation der(x) = -x; end A;
      model B extends A; annotation(experiment(StopTime=1)); end B;
    end P;"""
    assert planarc.load(text).name == "P.B"
    with pytest.raises(planarc.UsageError, match=r"C107.*`P\.A`, `P\.B`"):
        planarc.load(text.replace("annotation(experiment(StopTime=1));", ""))


@pytest.mark.parametrize("u", [2.0, lambda t: 2.0], ids=["number", "function"])
def test_inputs_of_a_model_whose_states_switch(u: Any) -> None:
    text = """model Saw input Real u; Real x(start=0, fixed=true); equation der(x) = u;
    when x > 0.2 then reinit(x, 0); end when; end Saw;"""
    result = planarc.load(text).simulate(0.95, inputs={"u": u})
    assert len(result.events) == 9
    assert result["x"][-1] == pytest.approx(0.1, abs=1e-6)
