"""External functions that planarc has of its own, in models that run."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from planarc import compiler
from planarc.core.diagnostic import PlanarcError
from planarc.core.options import Backend, RunOptions
from planarc.request.request import Request
from planarc.runtime import external

FUNCTIONS = """
function eigenvalues
  input Real A[:, size(A, 1)];
  output Real re[size(A, 1)];
  output Real im[size(A, 1)];
protected
  Real vectors[size(A, 1), size(A, 1)];
  Integer info;
external "C" planarc_eigenvalues(size(A, 1), A, re, im, vectors, info);
end eigenvalues;
function random
  input Integer before[2];
  output Real r;
  output Integer after[2];
external "C" ModelicaRandom_xorshift64star(before, after, r);
end random;
function spectrum
  input Real u[:];
  output Integer info;
  output Real amplitudes[div(size(u, 1), 2) + 1];
  output Real phases[div(size(u, 1), 2) + 1];
protected
  Real work[3*size(u, 1)];
external "C" info = ModelicaFFT_kiss_fftr(u, size(u, 1), work, size(work, 1), amplitudes, phases);
end spectrum;
impure function fresh
  input Integer id;
  output Real y;
external "C" y = ModelicaRandom_impureRandom_xorshift1024star(id);
end fresh;
impure function seed
  output Integer s;
external "C" s = ModelicaRandom_automaticGlobalSeed(0.0);
end seed;
function hash
  input String text;
  output Integer h;
external "C" h = ModelicaStrings_hashString(text);
end hash;
function length
  input String text;
  output Integer n;
external "C" n = ModelicaStrings_length(text);
end length;
"""


@pytest.fixture(params=list(Backend), ids=[b.value for b in Backend])
def backend(request: pytest.FixtureRequest) -> Any:
    return request.param


def run(
    text: str, backend: Backend, stop: float = 1.0, name: str | None = None, **values: float
) -> Any:
    options = RunOptions(stop=stop, tolerance=1e-9, backend=backend, values=values)
    result = compiler.run(
        compiler.compile_model(Request(text=FUNCTIONS + text, class_name=name), backend), options
    )
    assert result.ended is None
    return result


def drawn(state: tuple[float, ...], count: int) -> list[float]:
    numbers = []
    for _ in range(count):
        *after, number = external.call_numbers("ModelicaRandom_xorshift64star", state)
        state = tuple(after)
        numbers.append(number)
    return numbers


NOISE = """
model Noise
  parameter Integer seed = 5;
  Integer state[2];
  discrete Real r;
  discrete Real scaled;
initial equation
  pre(state) = {seed, 7};
  r = random(pre(state));
  scaled = 2*r;
equation
  when sample(0.1, 0.1) then
    (r, state) = random(pre(state));
    scaled = 2*r;
  end when;
end Noise;
"""


def test_a_generator_draws_a_number_at_each_sample(backend: Backend) -> None:
    result = run(NOISE, backend, stop=0.99)
    wanted = drawn((5.0, 7.0), 9)
    at = [np.searchsorted(result.time, 0.1 * k + 0.05) for k in range(10)]
    assert result["r"][at].tolist() == [wanted[0], *wanted]
    assert result["scaled"] == pytest.approx(2 * result["r"])


def test_the_seed_can_be_set_without_compiling_again(backend: Backend) -> None:
    result = run(NOISE, backend, stop=0.15, seed=6)
    assert result["r"][-1] == drawn((6.0, 7.0), 1)[0]


def test_equations_call_external_functions_in_both_back_ends(backend: Backend) -> None:
    result = run(
        """
model M
  Integer k = integer(10*time);
  Real r = random({k, 3});
  Real x(start = 0, fixed = true);
equation
  der(x) = r;
end M;
""",
        backend,
    )
    numbers = [drawn((float(k), 3.0), 1)[0] for k in range(10)]
    assert result["x"][-1] == pytest.approx(sum(numbers) / 10, abs=1e-7)


def test_a_spectrum_of_samples_in_the_run(backend: Backend) -> None:
    result = run(
        """
model M
  parameter Integer n = 8;
  Integer k(start = 0, fixed = true);
  Real u = 1.5*cos(2*3.141592653589793*2*time);
  discrete Real row[n](each start = 0, each fixed = true);
  discrete Real a[5](each start = 0, each fixed = true), p[5](each start = 0, each fixed = true);
  Integer info(start = 7, fixed = true);
algorithm
  when sample(0, 1/8) then
    k := pre(k) + 1;
    for i in 1:n loop
      row[i] := if i == k then u else pre(row[i]);
    end for;
    if k == n then
      (info, a, p) := spectrum(row);
    end if;
  end when;
end M;
""",
        backend,
    )
    assert result["info"][-1] == 0
    assert result["a[3]"][-1] == pytest.approx(1.5, abs=1e-6)
    assert max(result[f"a[{i}]"][-1] for i in (1, 2, 4, 5)) < 1e-6
    assert result["p[3]"][-1] == pytest.approx(0.0, abs=1e-6)


def test_calls_that_give_another_value_each_keep_it_between_events(backend: Backend) -> None:
    result = run(
        """
model M
  discrete Real a(start = 0), b(start = 0);
equation
  when sample(0.1, 0.1) then
    a = fresh(1);
    b = fresh(1);
  end when;
end M;
""",
        backend,
        stop=0.99,
    )
    at = [np.searchsorted(result.time, 0.1 * k + 0.05) for k in range(1, 10)]
    numbers = [*result["a"][at].tolist(), *result["b"][at].tolist()]
    assert len(set(numbers)) == 18
    assert len(set(result["a"].tolist())) == 10  # and zero before the first


def test_an_automatic_seed_differs_from_run_to_run(
    backend: Backend, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = """
model M
  final parameter Integer s(fixed = false);
  Real x = s;
initial equation
  s = seed();
end M;
"""
    found = []
    for now in (10**18, 10**18 + 7 * 10**6):
        monkeypatch.setattr("planarc.runtime.external.random.time.time_ns", lambda now=now: now)
        external.call_numbers.cache_clear()
        found.append(run(model, backend)["s"][0])
    assert found[1] - found[0] == 7


def test_texts_are_evaluated_while_compiling(backend: Backend) -> None:
    result = run(
        """
model Seeded
  parameter Integer seed(fixed = false);
  Real y = seed;
initial equation
  seed = hash(getInstanceName());
end Seeded;
model M
  Seeded b;
  parameter String name = "four";
  Real n = length(name + "bar");
end M;
""",
        backend,
        name="M",
    )
    assert result["b.y"][0] == external.call_texts("ModelicaStrings_hashString", ["M.b"])[0]
    assert result["n"][0] == 7


WORDS = """
type Kind = enumeration(low, middle);
model M
  parameter Integer k = 12;
  parameter Real r = 0.5;
  parameter Kind kind = Kind.middle;
  parameter Boolean b = true;
  parameter String form = String(k) + ".3f";
  parameter String name = "a" + String(k) + String(r);
  parameter Integer n[5] = {
    length(String(k)), length(name), length(String(kind) + String(b)),
    length(if k > 20 then "abc" else "a"), length(String(r, format=form))};
  parameter Real free = 2;
  Real y = free*length(String(k)) + 0*time;
end M;
"""


def test_texts_of_parameters_are_known_while_compiling(backend: Backend) -> None:
    result = run(WORDS, backend, name="M")
    assert [result[f"n[{i}]"][0] for i in range(1, 6)] == [2, 6, 10, 1, 12]
    assert result["y"][0] == 4
    changed = WORDS.replace("k = 12", "k = 345").replace("= true", "= false")
    result = run(changed.replace("Kind.middle", "Kind.low"), backend, name="M")
    assert [result[f"n[{i}]"][0] for i in range(1, 6)] == [3, 7, 8, 3, 345]


def test_parameters_in_texts_that_are_evaluated_become_structural() -> None:
    request = Request(text=FUNCTIONS + WORDS, class_name="M")
    slots = {p.name: p for p in compiler.compile_model(request).program.parameter_slots}
    assert all(slots[name].structural for name in ("k", "r", "kind", "b"))
    assert slots["free"].settable


def test_a_function_of_a_text_that_changes_is_refused() -> None:
    text = "model M Integer k = integer(9*time); Integer n = length(String(k)); end M;"
    with pytest.raises(PlanarcError, match="a function of a text that changes while running"):
        run(text, Backend.NUMPY, name="M")


def test_a_derivative_of_an_external_function_is_refused() -> None:
    text = """
model M
  Real x(start = 1, fixed = true);
  Real r[2] = {x, 2*x};
  Integer info;
  Real a[2], p[2];
  Real y = der(a[1]);
equation
  der(x) = -x;
  (info, a, p) = spectrum(r);
end M;
"""
    with pytest.raises(PlanarcError) as caught:
        run(text, Backend.NUMPY)
    assert caught.value.diagnostics[0].code == "G401"
    assert "cannot be differentiated" in caught.value.diagnostics[0].message


def test_a_choice_does_not_evaluate_what_it_leaves(backend: Backend) -> None:
    """At events too, where formulas are evaluated one by one."""
    result = run(
        """
model M
  discrete Real y(start = 0, fixed = true);
equation
  when sample(0, 0.5) then
    y = if time > 2 then sqrt(time - 2) else 1 + 1/(time - 2);
  end when;
end M;
""",
        backend,
    )
    assert result["y"][-1] == pytest.approx(1 - 1)
    assert math.isfinite(result["y"].max())


def test_start_values_that_depend_on_each_other_in_a_circle_are_told() -> None:
    text = """
model M
  discrete Real a, b;
initial equation
  a = 2*b;
  b = a + 1;
equation
  when sample(0.1, 0.1) then
    a = pre(a);
    b = pre(b);
  end when;
end M;
"""
    with pytest.raises(PlanarcError) as caught:
        run(text, Backend.NUMPY)
    assert caught.value.diagnostics[0].code == "L335"


def test_functions_take_as_many_numbers_as_they_need(backend: Backend) -> None:
    """49 entries, and their count: more than a formula's terms in a line."""
    text = """model M
      Real re[7] = eigenvalues(diagonal(1:7)*(1 + time) + fill(0.1, 7, 7));
    end M;"""
    found = run(text, backend)
    matrix = 2 * np.diag(np.arange(1.0, 8)) + 0.1
    ends = sorted(found[f"re[{i}]"][-1] for i in range(1, 8))
    assert ends == pytest.approx(np.linalg.eigvalsh(matrix), rel=1e-12)
