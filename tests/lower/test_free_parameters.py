"""Parameters that get their values at the start (`fixed = false`)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from planarc import compiler, load
from planarc.core.diagnostic import PlanarcError
from planarc.core.options import Backend, RunOptions, Solver
from planarc.request.request import Request


@pytest.fixture(params=list(Backend), ids=[b.value for b in Backend])
def backend(request: pytest.FixtureRequest) -> Any:
    return request.param


def run(text: str, backend: Backend, stop: float = 1.0) -> Any:
    options = RunOptions(stop=stop, tolerance=1e-9, backend=backend)
    result = compiler.run(compiler.compile_model(Request(text=text), backend), options)
    assert result.ended is None
    return result


ELBOW = """
model Elbow "Two rods of length 1 from the origin to a point that moves"
  Real x = 1 + 0.2*sin(time), y = 0.3;
  final parameter Boolean above(fixed = false);
  Real d = sqrt(x*x + y*y), h = sqrt(1 - d*d/4);
  Real side = if above then 1 else -1;
  Real px = x/2 - side*h*y/d, py = y/2 + side*h*x/d;
  parameter Real guess = {guess};
initial equation
  above = guess > 0.15;
end Elbow;
"""


@pytest.mark.parametrize(("guess", "side"), [(0.9, 1), (-0.4, -1)])
def test_a_branch_is_chosen_at_the_start_and_kept(
    guess: float, side: int, backend: Backend
) -> None:
    result = run(ELBOW.format(guess=guess), backend)
    assert np.all(result["above"] == (side > 0))
    assert result["px"] ** 2 + result["py"] ** 2 == pytest.approx(1.0, abs=1e-12)
    assert np.all(np.sign(result["py"] - 0.15) == side)


def test_a_choice_at_the_start_may_depend_on_what_moves_later(backend: Backend) -> None:
    result = run(
        """
model M
  Real x(start = 0.3, fixed = true), v(start = -2, fixed = true);
  parameter Boolean right(fixed = false);
  parameter Integer steps(fixed = false);
  final parameter Boolean left = not right;
initial equation
  right = x > 0;
  steps = if v > 0 then 1 else 2;
equation
  v = der(x);
  der(v) = if left then 1 else -1;
end M;
""",
        backend,
    )
    assert np.all(result["right"] == 1)  # though x is below zero at the end
    assert np.all(result["left"] == 0)
    assert np.all(result["steps"] == 2)
    t = result.time
    assert result["x"] == pytest.approx(0.3 - 2 * t - t * t / 2, abs=1e-8)


def test_a_constant_of_a_spring_follows_from_rest(backend: Backend) -> None:
    """The load m*g rests on the spring at the given length: c = m*g/s."""
    result = run(
        """
model M
  parameter Real c(fixed = false, start = 10), m = 2, g = 9.81;
  final parameter Real omega = sqrt(c/m);
  Real s(start = 0.25, fixed = true), v(start = 0, fixed = true);
initial equation
  der(v) = 0;
equation
  v = der(s);
  m*der(v) = m*g - c*s + (if time > 0.5 then 1 else 0);
end M;
""",
        backend,
        stop=2.0,
    )
    c = 2 * 9.81 / 0.25
    assert result["c"] == pytest.approx(c, rel=1e-9)
    assert result["omega"] == pytest.approx(math.sqrt(c / 2), rel=1e-9)
    late = result.time > 0.5
    phase = math.sqrt(c / 2) * (result.time[late] - 0.5)
    assert result["s"][late] == pytest.approx(0.25 + (1 - np.cos(phase)) / c, abs=1e-7)


def test_evaluate_is_a_wish_that_waits_for_the_start(backend: Backend) -> None:
    result = run(
        """
model M
  final parameter Real n(fixed = false, start = 7) annotation(Evaluate = true);
  Real x(start = 2, fixed = true);
initial equation
  n = 3*x;
equation
  der(x) = n;
end M;
""",
        backend,
    )
    assert result["x"][-1] == pytest.approx(8.0, abs=1e-8)


def test_what_shapes_the_model_cannot_wait_for_the_start(backend: Backend) -> None:
    with pytest.raises(PlanarcError, match=r"`n` gets its value at the start"):
        run(
            """
model M
  parameter Integer n(fixed = false, start = 2);
  Real x[n] = ones(n);
initial equation
  n = 3;
end M;
""",
            backend,
        )


def test_several_results_at_the_start_are_parameters_that_follow(backend: Backend) -> None:
    """(w, d) of an oscillator from its mass and spring; then the step response."""
    result = run(
        """
model M
  function coefficients input Real c; input Real m; output Real w; output Real d[2];
  algorithm w := sqrt(c/m); d := {0.1*w, 1/w}; end coefficients;
  parameter Real c = 8, m = 2;
  parameter Real w(fixed = false), d[2](each fixed = false);
  Real x(start = 1, fixed = true), v(start = 0, fixed = true);
initial equation
  (w, d) = coefficients(c, m);
equation
  v = der(x);
  der(v) = -w^2*x - 2*d[1]*w*v;
end M;
""",
        backend,
        stop=3.0,
    )
    assert result["w"] == pytest.approx(2.0)
    assert result["d[2]"] == pytest.approx(0.5)
    w = 2 * math.sqrt(1 - 0.2**2)
    t = result.time
    expected = np.exp(-0.4 * t) * (np.cos(w * t) + 0.4 / w * np.sin(w * t))
    assert result["x"] == pytest.approx(expected, abs=1e-7)


@pytest.mark.parametrize("begin", [0.0, 1.25])
def test_a_parameter_that_is_the_start_time_can_rule_a_sampler(
    begin: float, backend: Backend
) -> None:
    text = """
model M
  parameter Real f = 4, t0(fixed = false);
  final parameter Real first = t0 + 1/f;
  Integer n(start = 0, fixed = true);
initial equation
  t0 = time;
equation
  when sample(first, 1/f) then
    n = pre(n) + 1;
  end when;
end M;
"""
    options = RunOptions(start=begin, stop=begin + 1.1, backend=backend)
    result = compiler.run(compiler.compile_model(Request(text=text), backend), options)
    assert result["t0"] == pytest.approx(begin)
    assert [e.time for e in result.events] == pytest.approx([begin + k / 4 for k in range(1, 5)])
    assert result["n"][-1] == 4


TRIM = """
model Trim "A mass on a spring whose free length holds it where it starts"
  parameter Real k = 100;
  parameter Real L(fixed = false, start = 1);
  Real q = 2*L, same = L;
  Real x(start = 2, fixed = true), v(start = 0, fixed = true);
initial equation
  der(v)*(1 + 0.1*L^2) = 0;
equation
  der(x) = v;
  der(v) = -9.81 + k*(q/2 - x) - v;
end Trim;
"""


def test_what_the_start_finds_is_no_state_of_the_linear_model(backend: Backend) -> None:
    model = load(TRIM, backend=backend)
    found = model.linearize(outputs="q")
    assert found.values["L"] == pytest.approx(2 + 0.0981)
    assert found.states == ("x", "v")
    assert np.allclose(found.A, np.array([[0.0, 1.0], [-100.0, -1.0]]), rtol=0, atol=1e-6)
    assert np.allclose(found.C, np.zeros((1, 2)), rtol=0, atol=1e-9)
    assert found.stable
    motion = found.motion(0)
    assert np.ptp(motion["L"]) == 0.0 < np.ptp(motion["x"])


def test_what_the_start_finds_is_not_told_among_the_states(backend: Backend) -> None:
    from planarc.cli.summary import moving_states, state_reasons, states

    result = run(TRIM, backend, stop=0.1)
    assert states(moving_states(result)) == "x, v"
    assert "L" not in state_reasons(result)


#: Held starts that hang on a parameter which the start finds, with what they come to: `a` is 3.
HANGING = {
    "follows": ("parameter Real b=a^2; Real x(start=b, fixed=true);", "", {"x": 9}),
    "by a start": ("parameter Real b(start=2*a); Real x(start=b, fixed=true);", "", {"x": 6}),
    "by one start for all": (
        "parameter Real b[2](each start=2*a); Real x[2](start=b, each fixed=true);",
        "",
        {"x[1]": 6, "x[2]": 6},
    ),
    "entries": (
        "Real x[3](start={a, 2*a, 4}, fixed={true, true, false});",
        "x[3] = x[1] + 1;",
        {"x[1]": 3, "x[2]": 6, "x[3]": 4},
    ),
    "function": (
        "function f input Real u; output Real y[2]; algorithm y := {u, u^2}; end f;"
        "parameter Boolean hold=true; Real x[2](start=f(a), each fixed=hold);",
        "",
        {"x[1]": 3, "x[2]": 9},
    ),
    "alias": ("Real x(start=a + 1, fixed=true), y=-x;", "", {"x": 4, "y": -4}),
    "guess": ("Real x(start=2*a);", "x^2 - 10*x + 9 = 0;", {"x": 1}),
}


@pytest.mark.parametrize("case", HANGING.values(), ids=HANGING)
def test_what_is_held_starts_where_the_found_parameter_says(
    case: tuple[str, str, dict[str, float]], backend: Backend
) -> None:
    declared, initial, values = case
    rates = "der(x) = zeros(size(x, 1));" if "x[" in declared else "der(x) = 0;"
    result = run(
        f"""
model M
  parameter Real a(fixed=false, start=1);
  {declared}
initial equation
  a^3 = 27;
  {initial}
equation
  {rates}
end M;
""",
        backend,
    )
    for name, value in values.items():
        assert result[name] == pytest.approx(value, abs=1e-7)


@pytest.mark.parametrize(
    ("condition", "x"), [("x^2 + a = 6", 2.0), ("force = -5", 1.5), ("der(v) = 2", 0.8)]
)
def test_a_held_start_and_its_parameter_are_found_together(
    condition: str, x: float, backend: Backend
) -> None:
    """The start of `x` is all that `a` is for: the condition finds both."""
    result = run(
        f"""
model M
  parameter Real a(fixed=false, start=1);
  Real x(start=a, fixed=true), v(start=0, fixed=true), force=-10*(x - 1);
initial equation
  {condition};
equation
  der(x) = v;
  der(v) = force;
end M;
""",
        backend,
    )
    assert result["x"][0] == result["a"][0] == pytest.approx(x, abs=1e-9)


@pytest.mark.parametrize("solver", [Solver.AUTO, Solver.EXPORTED])
def test_discrete_variables_begin_where_the_found_parameter_says(
    solver: Solver, backend: Backend
) -> None:
    """Held or not; `pre` of them is that value at the start, wherever it is asked for."""
    if (solver, backend) == (Solver.EXPORTED, Backend.NUMPY):
        pytest.skip("what is exported is machine code")
    text = """
model M
  parameter Real a(fixed=false, start=1);
  parameter Integer k(fixed=false), j(fixed=false), l(fixed=false);
  parameter Boolean up(fixed=false);
  discrete Real d(start=2*a, fixed=true), e(start=0, fixed=true), loose(start=a);
  Integer n(start=k, fixed=true), i(start=j, fixed=true), changes(start=0, fixed=true);
  Integer later(start=0);
  Boolean b(start=up, fixed=true);
  Real x(start=0, fixed=true), y=pre(d);
initial equation
  a^3 = 27;
  k = if a > 2 then 7 else 5;
  up = a > 2;
  pre(later) = l + 1;
initial algorithm
  j := 4;
  l := if a > 2 then 8 else 0;
equation
  der(x) = d;
  when {initial(), time > 0.25} then e = pre(d) + 1; end when;
  when change(d) then changes = pre(changes) + 1; end when;
  when time > 0.5 then
    d = pre(d) + 1;
    loose = pre(loose) + 1;
    n = pre(n) + 1;
    i = pre(i) + 1;
    later = pre(later) + 1;
    b = not pre(b);
  end when;
end M;
"""
    options = RunOptions(stop=1.0, tolerance=1e-9, backend=backend, solver=solver)
    result = compiler.run(compiler.compile_model(Request(text=text), backend), options)
    begun = {"d": 6, "e": 7, "y": 6, "loose": 3, "n": 7, "i": 4, "b": 1, "changes": 0, "later": 9}
    ended = {"d": 7, "e": 7, "y": 7, "loose": 4, "n": 8, "i": 5, "b": 0, "changes": 1, "later": 10}
    assert {name: result[name][0] for name in begun} == pytest.approx(begun, abs=1e-8)
    assert {name: result[name][-1] for name in ended} == pytest.approx(ended, abs=1e-7)
    assert result["x"][-1] == pytest.approx(6.5)


def test_a_discrete_start_has_one_value_alone(backend: Backend) -> None:
    text = """
model M
  parameter Real a(fixed=false, start=1);
  discrete Real d(start=a, fixed=true);
initial equation
  a^3 = 27;
  {initial}
equation
  when {condition} then
    d = pre(d) + 1;
  end when;
end M;
"""
    with pytest.raises(PlanarcError, match=r"`pre\(d\)` must be known before the start"):
        run(text.format(initial="", condition="{initial(), time > 0.5}"), backend)
    model = Request(text=text.format(initial="pre(d) = 5;", condition="time > 0.5"))
    result = compiler.run(compiler.compile_model(model, backend), RunOptions(backend=backend))
    assert result.ended is not None
    assert "`d = a` does not hold" in result.ended.message


def test_a_start_that_cannot_be_held_is_told(backend: Backend) -> None:
    with pytest.raises(PlanarcError, match=r"there are 3 of them for 2 states"):
        run(
            """
model M
  parameter Real a(fixed=false, start=1);
  Real x(start=a, fixed=true), y=2*x;
initial equation
  a^3 = 27;
  y = 3;
equation
  der(x) = -x;
end M;
""",
            backend,
        )


def test_a_mechanism_is_held_where_the_found_angle_says(backend: Backend) -> None:
    result = run(
        """
model Pendulum
  parameter Real begin(fixed=false, start=0.3);
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Revolute hinge(phi(start=begin, fixed=true), w(fixed=true));
  PlanarMultiBody.Parts.FixedTranslation rod(r={1, 0});
  PlanarMultiBody.Parts.Body body(m=1, I=0.1);
initial equation
  rod.frame_b.r[2] = 0.5;
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, rod.frame_a);
  connect(rod.frame_b, body.frame_a);
end Pendulum;
""",
        backend,
        stop=0.1,
    )
    assert result["hinge.phi"][0] == pytest.approx(math.pi / 6)
