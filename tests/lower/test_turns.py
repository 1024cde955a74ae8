"""Loops whose end is known only while the model runs, against the same loops in Python."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipk

import planarc

ANOMALY = """
  function anomaly "The eccentric anomaly of a planet, by Newton's method"
    input Real M;
    input Real e;
    output Real E;
  algorithm
    E := M;
    while abs(E - e*sin(E) - M) > 1e-13 loop
      E := E - (E - e*sin(E) - M)/(1 - e*cos(E));
    end while;
  end anomaly;
"""

MEETING = """
  function meeting "Where x1^2 + x2 = 3 + p and x1 + 1 = x2^2, by Newton's method of two unknowns"
    input Real p;
    output Real x[2];
  protected
    Real r[2];
    Real J[2, 2];
  algorithm
    x := {1, 1};
    r := {1, 1};
    while max(abs(r)) > 1e-12 loop
      r := {x[1]^2 + x[2] - 3 - p, x[1] - x[2]^2 + 1};
      J := [2*x[1], 1; 1, -2*x[2]];
      x := x - solution(J, r);
    end while;
  end meeting;
  function solution
    input Real A[:, size(A, 1)];
    input Real b[size(A, 1)];
    output Real x[size(A, 1)];
  protected
    Integer info;
  external "C" planarc_solution(size(A, 1), 1, A, b, x, info);
  end solution;
"""


def run(body: str, stop: float = 1.0, intervals: int = 40, **options: Any) -> planarc.Result:
    """A run of machine code, which is that of NumPy."""
    text = f"model M\n{body}\nend M;"
    native, python = (
        planarc.load(text, backend=b).simulate(stop, intervals=intervals, **options)
        for b in ("native", "numpy")
    )
    for name in native.names:
        assert native[name] == pytest.approx(python[name], rel=1e-9, abs=1e-9), name
    return native


def refused(body: str, stop: float = 1.0) -> planarc.Diagnostic:
    with pytest.raises(planarc.PlanarcError) as problem:
        planarc.load(f"model M\n{body}\nend M;").simulate(stop, intervals=10)
    return problem.value.diagnostics[0]


def collatz(n: float) -> float:
    turns = 0
    while n != 1:
        n = n // 2 if n % 2 == 0 else 3 * n + 1
        turns += 1
    return turns


def pairs(x: float) -> float:
    """What two loops find that are left by `break` and `return`."""
    i = turns = 0
    while True:
        i, j = i + 1, 0
        while j < i:
            j, turns = j + 1, turns + 1
            if i * j > x:
                return 1000 * turns + 10 * i + j
            if j > 3:
                break


def halves(x: float) -> float:
    n, h = 0, [0.0, 0.0]
    while x > 1:
        x /= 2
        n += 1
        h[n % 2] = x
    return n + 100 * h[0] + 10000 * h[1]


def series(x: float) -> float:
    total = 0.0
    for i in range(1, int(x * 50) + 1):
        total += 0.9**i / i
        if total > 2.2:
            break
    return total


def backwards(x: float) -> float:
    total = 0.0
    for i in range(int(x), 0, -2):
        total = 2 * total + i
    return total + 7000


@pytest.mark.parametrize(
    ("of", "text"),
    [
        (
            collatz,
            """function f input Real x; output Real y; protected Real m; algorithm
              m := floor(x); y := 0;
              while m <> 1 loop
                if mod(m, 2) == 0 then m := m/2; else m := 3*m + 1; end if;
                y := y + 1;
              end while;
            end f;""",
        ),
        (
            pairs,
            """function f input Real x; output Real y; protected Integer i, j, turns; algorithm
              i := 0; turns := 0;
              while true loop
                i := i + 1; j := 0;
                while j < i loop
                  j := j + 1; turns := turns + 1;
                  if i*j > x then y := 1000*turns + 10*i + j; return; end if;
                  if j > 3 then break; end if;
                end while;
              end while;
            end f;""",
        ),
        (
            halves,
            """record S Real a; Integer n; Real h[2]; end S;
            function f input Real x; output Real y; protected S s; algorithm
              s := S(x, 0, {0, 0});
              while s.a > 1 loop
                s.a := s.a/2; s.n := s.n + 1; s.h[1 + mod(s.n, 2)] := s.a;
              end while;
              y := s.n + 100*s.h[1] + 10000*s.h[2];
            end f;""",
        ),
        (
            series,
            """function f input Real x; output Real y; algorithm
              y := 0;
              for i in 1:integer(50*x) loop
                y := y + 0.9^i/i;
                if y > 2.2 then break; end if;
              end for;
            end f;""",
        ),
        (
            backwards,
            """function f input Real x; output Real y; protected Integer i; algorithm
              y := 0; i := 7;
              for i in integer(x):-2:1 loop y := 2*y + i; end for;
              y := y + 1000*i;
            end f;""",
        ),
    ],
    ids=lambda p: "" if isinstance(p, str) else p.__name__,
)
def test_a_loop_computes_what_it_does_in_python(of: Callable[[float], float], text: str) -> None:
    result = run(f"{text}\nReal x = 1.3 + 30*time; Real y = f(x);")
    expected = [of(math.floor(x) if of is collatz else x) for x in result["x"]]
    assert result["y"] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("enough", ["", "if y > 100 then break; end if;"])
def test_ranges_of_real_numbers_have_the_entries_that_known_ones_have(enough: str) -> None:
    """0:0.1:0.3 has four, though three steps are 0.30000000000000004."""
    result = run(
        f"""function f input Real stop; output Real y; algorithm
          y := 0;
          for x in 0:0.1:stop loop y := y + 1; {enough} end for;
        end f;
        Real y = f(min(0.3, 1 + time)); Real z = f(min(0.7, 1 + time));"""
    )
    assert set(result["y"]) == {4}
    assert set(result["z"]) == {8}


def test_matrices_go_from_turn_to_turn() -> None:
    result = run(
        """function exponential input Real A[2, 2]; output Real E[2, 2];
          protected Real T[2, 2]; Integer k;
          algorithm
            E := identity(2); T := identity(2); k := 1;
            while max(abs(T)) > 1e-15 loop T := T*A/k; E := E + T; k := k + 1; end while;
          end exponential;
        Real E[2, 2] = exponential({{0, time}, {-time, 0}});""",
        3,
    )
    assert result["E[1,1]"] == pytest.approx(np.cos(result.time), abs=1e-14)
    assert result["E[1,2]"] == pytest.approx(np.sin(result.time), abs=1e-14)


def test_functions_with_loops_are_called_in_loops() -> None:
    """The arithmetic-geometric mean by Legendre's relation, and its slope."""
    result = run(
        """function root input Real c; output Real x; algorithm
            x := 1 + c; while abs(x*x - c) > 1e-14 loop x := (x + c/x)/2; end while; end root;
          function mean input Real a; input Real b; output Real m = a;
          protected Real n = b; Real t;
          algorithm
            while abs(m - n) > 1e-14 loop t := (m + n)/2; n := root(m*n); m := t; end while;
          end mean;
        Real m = mean(1, 0.1 + time); Real slope = der(m);""",
        4,
    )

    def mean(b: np.ndarray) -> np.ndarray:
        return math.pi / 4 * (1 + b) / ellipk(((1 - b) / (1 + b)) ** 2)

    b = 0.1 + result.time
    assert result["m"] == pytest.approx(mean(b), rel=1e-13)
    assert result["slope"] == pytest.approx((mean(b + 1e-5) - mean(b - 1e-5)) / 2e-5, rel=1e-8)


def anomalies(m: np.ndarray) -> np.ndarray:
    """The solutions of Kepler's equation at an eccentricity of 0.5."""
    return np.array(
        [brentq(lambda x, m=m: x - 0.5 * math.sin(x) - m, -1, 9, xtol=1e-14) for m in m]
    )


def test_a_loop_is_differentiated_twice() -> None:
    """Also where it takes no turn: at the start the anomaly is 0, its rate 2."""
    result = run(f"{ANOMALY}\nReal E = anomaly(time, 0.5); Real v = der(E); Real a = der(v);", 5)
    truth = anomalies(result.time)
    speed = 1 / (1 - 0.5 * np.cos(truth))
    assert result["E"] == pytest.approx(truth, abs=1e-12)
    assert result["v"] == pytest.approx(speed, abs=1e-10)
    assert result["a"] == pytest.approx(-0.5 * np.sin(truth) * speed**3, abs=1e-9)


def test_derivatives_that_do_not_settle_are_those_of_the_turns_taken() -> None:
    """Where x is 0, at half the time, turns would leave y as it is, and add to its derivative."""
    result = run(
        """function f input Real x; input Real first; output Real y = first; algorithm
            while y < 0.25 loop y := y + x; end while;
          end f;
        Real y = f(time + 0.01, 0); Real v = der(y);
        Real z = f(time - 0.5, 0.3); Real w = der(z);"""
    )
    assert result["v"] == pytest.approx(np.ceil(0.25 / (result.time + 0.01)))
    assert 0.5 in result.time
    assert set(result["w"]) == {0}


def test_equations_are_solved_through_a_loop() -> None:
    result = run(f"{ANOMALY}\nReal m(start=0.2); equation anomaly(m, 0.5) + m = time + 0.1;", 5)
    m = result["m"]
    assert anomalies(m) + m == pytest.approx(result.time + 0.1, abs=1e-10)


def test_linear_equations_are_solved_in_each_turn() -> None:
    result = run(f"{MEETING}\nReal x[2] = meeting(time);")
    x, y = result["x[1]"], result["x[2]"]
    assert x**2 + y == pytest.approx(3 + result.time, abs=1e-12)
    assert x + 1 == pytest.approx(y**2, abs=1e-12)


@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_turns_that_call_what_has_no_derivative_have_none(backend: str) -> None:
    text = f"model M\n{MEETING}\nReal x[2] = meeting(time); Real v = der(x[1]);\nend M;"
    with pytest.raises(planarc.PlanarcError, match="G401") as refused:
        planarc.load(text, backend=backend).simulate(1)
    span = refused.value.diagnostics[0].span
    assert span is not None
    assert span.text == "meeting(time)"


def test_functions_that_are_not_pure_are_not_called_by_turns() -> None:
    """Each of their calls draws a number of its own, and a turn stands for all."""
    found = refused(
        """impure function drawn input Integer id; output Real y;
          external "C" y = ModelicaRandom_impureRandom_xorshift1024star(id); end drawn;
        impure function f input Real c; output Real n; protected Real s; algorithm
          n := 0; s := 0;
          while s < c loop s := s + drawn(1); n := n + 1; end while;
        end f;
        discrete Real n(start=0, fixed=true);
        equation when sample(0.1, 0.3) then n = f(20*time); end when;"""
    )
    assert found.code == "L322"
    assert "a function that is not pure" in found.related[-1].message


def test_events_are_found_by_what_a_loop_gives() -> None:
    body = """Real E = anomaly(time, 0.5); Real z(start=0, fixed=true);
      Integer n(start=0, fixed=true);
    equation
      der(z) = if E > 2 then 1 else 0;
      when E > 1 then n = pre(n) + 1; end when;"""
    result = run(f"{ANOMALY}\n{body}", 5)
    assert result["z"][-1] == pytest.approx(5 - (2 - 0.5 * math.sin(2)), abs=1e-9)
    assert result["n"][-1] == 1


def test_algorithms_of_models_and_whens_have_such_loops() -> None:
    result = run(
        """Real x = 10*time + 0.6; Real y; Real k; Integer last(start=-1, fixed=true);
        algorithm
          y := x; k := 0;
          while y > 1 loop y := y/2; k := k + 1; end while;
        algorithm
          when sample(1, 1) then
            last := 0;
            while 2^last < x loop last := last + 1; end while;
          end when;""",
        5.5,
    )
    assert result["k"] == pytest.approx(np.maximum(0, np.ceil(np.log2(result["x"]))))
    assert result["last"][-1] == 6  # 64 is the first power above 50.6


def test_discrete_variables_are_not_set_by_a_loop_between_events() -> None:
    found = refused(
        """Real y; Integer k;
        algorithm
          y := 10*time; k := 0;
          while y > 1 loop y := y/2; k := k + 1; end while;"""
    )
    assert found.code == "L322"
    assert "the discrete variable `k`" in found.related[-1].message


def test_parameters_that_a_loop_reads_are_set_without_compiling_anew() -> None:
    model = planarc.load(
        f"model M\n{ANOMALY}\nparameter Real e = 0.5; Real E = anomaly(time, e); end M;"
    )
    for e in (0.5, 0.2):
        end = model.simulate(2, parameters={"e": e})["E"][-1]
        assert end - e * math.sin(end) == pytest.approx(2, abs=1e-12)
    assert [p.structural for p in model.program.parameter_slots] == [False]


def test_what_is_not_asked_for_does_not_turn() -> None:
    """The loop has no end where x is negative."""
    result = run(
        """function f input Real x; output Real y; algorithm
          y := x; while y < 1 loop y := 2*y; end while; end f;
        Real x = time - 0.5; Real y = if noEvent(x > 0.01) then f(x) else 0;"""
    )
    assert result["y"].max() >= 1
    assert result["y"][0] == 0


def test_a_loop_without_end_is_told_where_it_begins_to_have_none() -> None:
    found = refused(
        """function f input Real x; output Real y; algorithm
            y := 0;
            while y >= 0 loop y := y + 1; if x < 0.5 and y > 3 then break; end if; end while;
          end f;
        Real z(start=0, fixed=true); equation der(z) = f(time);"""
    )
    assert found.code == "R430"
    assert found.message == (
        "at t = 0.5 s `while y >= 0` in function `M.f` does not end within 100000 turns"
    )
    assert found.span is not None
    assert found.span.text.startswith("while y >= 0 loop")


def test_assertions_of_a_turn_tell_its_values() -> None:
    found = refused(
        """function f input Real x; output Real y; algorithm
            y := x;
            while y > 0.01 loop
              assert(y < 0.5 or y > 0.61, "y is " + String(y));
              y := y/2;
            end while;
          end f;
        Real y = f(2.5 - time);"""
    )
    assert found.code == "R430"
    assert found.message == "assertion failed at t = 0.1 s: y is 0.6"


def test_a_variable_that_no_turn_has_set_is_told() -> None:
    found = refused(
        """function f input Real x; output Real y; protected Real last; algorithm
            y := x;
            while y > 0.5 loop last := y; y := y/2; end while;
            y := last;
          end f;
        Real y = f(1.2 - time);"""
    )
    assert (found.code, found.message) == (
        "R430",
        "at t = 0.7 s `last` is used before it has a value",
    )


def test_a_subscript_that_leaves_its_array_in_a_turn_is_told() -> None:
    found = refused(
        """function f input Integer n; input Real t[:]; output Real y; algorithm
            y := 0;
            for i in n:n + 10*n loop y := y + t[i]; if y > 10 then break; end if; end for;
          end f;
        Real y = f(integer(10*time) + 1, {5, 5, 5, 2, 0, 0, 1});"""
    )
    assert found.code == "R430"
    assert found.message == "at t = 0.2 s the subscript 8 is outside of 1 to 7"


def test_a_search_may_trust_that_it_finds() -> None:
    """In a table that ends above all that is looked for; what is not is told when it is."""
    body = """function f input Real x; input Real t[:]; output Integer i; algorithm
        i := 1;
        while t[i] < x loop i := i + 1; end while;
      end f;
    Real x = 5*time; Real y = f(x, {0, 1, 2, LAST});"""
    result = run(body.replace("LAST", "5"))
    ends = [0, 1, 2, 5]
    assert list(result["y"]) == [1 + next(i for i in range(4) if ends[i] >= x) for x in result["x"]]
    found = refused(body.replace("LAST", "3"))
    assert found.message == "at t = 0.6 s the subscript 5 is outside of 1 to 4"


def test_what_is_not_a_number_is_not_taken_for_the_end_of_a_loop() -> None:
    found = refused(
        """function f input Real x; output Real y; protected Real z; algorithm
            z := 0; y := 1;
            while sqrt(0.35 - x) + z < 3 loop z := z + 1; y := y + 1; end while;
          end f;
        Real y = f(time);"""
    )
    assert found.code == "R421"


@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_a_loop_whose_values_get_lost_says_so(backend: str) -> None:
    """Roots are taken until there is none, at which no comparison is true or false."""
    text = """model M
      function f input Real x; output Real y; algorithm
        y := x;
        while y < 3 loop y := sqrt(y - 0.2); end while;
      end f;
      Real y = f(0.25 - 0.01*time);
    end M;"""
    with pytest.raises(planarc.PlanarcError) as problem:
        planarc.load(text, backend=backend).simulate(1)
    assert problem.value.diagnostics[0].message == (
        "at t = 0 s `while y < 3` in function `M.f` hangs on what is not a number"
    )


def test_a_size_that_turns_change_is_told_beside_the_loop() -> None:
    found = refused(
        """function f input Real u; output Real y; protected Real a[:]; algorithm
            a := {0};
            while sum(a) < u loop a := cat(1, a, {1}); end while;
            y := sum(a);
          end f;
        Real y = f(time);"""
    )
    assert found.code == "L322"
    assert found.related[-1].message.startswith("nor can it stay a loop: a size of `a`")


#: The radius of a cam, and the follower that it lifts off.
CAM = """model Cam
  import PlanarMultiBody.{Contacts, Curves, Joints, Parts};
  function egg
    extends PlanarMultiBody.Interfaces.partialCurveRadius;
    RADIUS
  end egg;
  inner PlanarMultiBody.World world;
  Joints.Revolute axle(phi(start=0.3, fixed=true), w(start=14, fixed=true));
  Parts.Body disc(m=2, I=0.05);
  Joints.Prismatic guide(n={0, 1}, s(start=0.14, fixed=true), v(start=0, fixed=true));
  Parts.Body follower(m=0.3, I=0.01);
  Contacts.CurveCurveContact contact(
    redeclare Curves.Polar curve1(R=0.1, redeclare function radius = egg),
    redeclare Curves.Circle curve2(R=0.02), e=0.3);
equation
  connect(world.frame_b, axle.frame_a);
  connect(axle.frame_b, disc.frame_a);
  connect(world.frame_b, guide.frame_a);
  connect(guide.frame_b, follower.frame_a);
  connect(axle.frame_b, contact.frame_a);
  connect(guide.frame_b, contact.frame_b);
end Cam;
"""
FORMULA = "algorithm radius := (-1 + sqrt(1 + 1.2*(0.1 + 0.02*cos(phi))))/0.6;"
SEARCH = """protected Real miss; algorithm
    radius := 0.1;
    miss := 1;
    while abs(miss) > 1e-15 loop
      miss := radius + 0.3*radius^2 - 0.1 - 0.02*cos(phi);
      radius := radius - miss/(1 + 0.6*radius);
    end while;"""


def test_speeds_are_linear_where_a_curve_is_searched_for() -> None:
    """A cam that is given by what its radius fulfils touches as the one of a formula does."""
    formula, search = (planarc.load(CAM.replace("RADIUS", r)) for r in (FORMULA, SEARCH))
    linear = [[b.linear for b in m.program.blocks] for m in (formula, search)]
    assert linear[0] == linear[1]
    first, second = (m.simulate(0.5, tolerance=1e-9) for m in (formula, search))
    assert [e.time for e in second.events] == pytest.approx([e.time for e in first.events])
    assert second["guide.s"][-1] == pytest.approx(first["guide.s"][-1], abs=1e-6)
