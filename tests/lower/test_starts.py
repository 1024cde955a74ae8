"""Initial equations that decide discrete variables, or must hold for them."""

from __future__ import annotations

from typing import Any

import pytest

from planarc import compiler
from planarc.core.diagnostic import PlanarcError
from planarc.core.options import Backend, RunOptions
from planarc.request.request import Request


@pytest.fixture(params=list(Backend), ids=[b.value for b in Backend])
def backend(request: pytest.FixtureRequest) -> Any:
    return request.param


def run(body: str, backend: Backend, stop: float = 2.0) -> Any:
    text = f"model M\n{body}\nend M;\n"
    compiled = compiler.compile_model(Request(text=text), backend)
    result = compiler.run(compiled, RunOptions(stop=stop, backend=backend))
    if result.ended is not None:
        raise PlanarcError(result.ended)
    return result


STEP = """
  Boolean active, now, next, before;
initial equation
  pre(next) = pre(now);
  pre(before) = pre(now);
  active = {first};
equation
  {chain}
  next = now and time < 1;
  when time > 0.5 then
    before = not pre(before);
  end when;
"""


@pytest.mark.parametrize("first", ["true", "false"])
@pytest.mark.parametrize(
    "chain",
    [
        "active = now; now = pre(next);",
        "now = active; now = pre(next);",
        "now = pre(next); active = now;",
    ],
)
def test_a_value_is_followed_to_what_decides_it(first: str, chain: str, backend: Backend) -> None:
    """Values before the start that are the same are decided together, in any order."""
    found = run(STEP.format(first=first, chain=chain), backend)
    starts = {name: bool(found[name][0]) for name in ("active", "now", "next", "before")}
    assert starts == dict.fromkeys(starts, first == "true")
    assert not found["active"][-1]
    assert bool(found["before"][-1]) == (first != "true")


def test_not_of_a_value_is_followed_too(backend: Backend) -> None:
    found = run(
        """
  Boolean idle, busy;
initial equation
  idle = false;
equation
  idle = not pre(busy);
  busy = time < 1;
""",
        backend,
    )
    assert not found["idle"][0]


@pytest.mark.parametrize("sign, k", [("x > 0", 5), ("not x > 0", 3), ("p", 5), ("not p", 3)])
def test_a_value_reads_what_equations_give_at_the_start(sign: str, k: int, backend: Any) -> None:
    """Not the start value of that variable, which nothing reads."""
    found = run(
        f"""
  parameter Boolean p = true;
  Real x(start = 1, fixed = true);
  Boolean b, c;
  Integer k;
initial equation
  k = if b then 5 else 3;
equation
  der(x) = -1;
  b = not c;
  c = not ({sign});
  when time > 1.5 then
    k = 0;
  end when;
""",
        backend,
    )
    assert found["k"][0] == k
    assert found["k"][-1] == 0


HYSTERESIS = """
  Real x(start = {x}, fixed = true);
  Boolean on;
initial equation
  on = true;
equation
  on = x > 0.9 or pre(on) and x > 0.1;
  der(x) = if on then -1 else 1;
"""


def test_a_mode_is_what_it_was_where_it_can_be(backend: Backend) -> None:
    assert run(HYSTERESIS.format(x=0.5), backend)["on"][0]
    with pytest.raises(PlanarcError, match=r"R430.*`on = true` does not hold"):
        run(HYSTERESIS.format(x=0.05), backend)


@pytest.mark.parametrize(
    "declared, initial, told",
    [
        ("Integer k(start = 3, fixed = true)", "k = 5", "k = 5"),
        ("discrete Real k", "k = 5; pre(k) = 4", r"pre\(k\) = 4"),
        ("Integer k; Boolean b = time < 1", "k = 1; b = false", "b = false"),
    ],
)
def test_what_cannot_hold_is_refused(
    declared: str, initial: str, told: str, backend: Backend
) -> None:
    when = "when time > 1.5 then k = 0; end when;"
    with pytest.raises(PlanarcError, match=f"R430.*the initial equation `{told}` does not hold"):
        run(f"{declared};\ninitial equation\n{initial};\nequation\n{when}", backend)


def test_the_same_said_twice_is_said_once(backend: Backend) -> None:
    found = run(
        """
  discrete Real m(start = 2.5, fixed = true);
initial equation
  m = 2.5;
  pre(m) = 2.5;
equation
  when time > 1 then
    m = pre(m) + 1;
  end when;
""",
        backend,
    )
    assert list(found["m"][[0, -1]]) == [2.5, 3.5]


@pytest.mark.parametrize("held", ["true", "false"])
def test_a_parameter_says_whether_a_start_is_held(held: str, backend: Backend) -> None:
    result = run(
        f"""
  parameter Boolean held = {held};
  parameter Boolean given[2] = {{held, not held}};
  Real x(start=2, fixed=given[1]), y(start=3, fixed=given[2]);
initial equation
  x + y = 10;
equation
  der(x) = -x;
  der(y) = -y;""",
        backend,
    )
    expected = (2, 8) if held == "true" else (7, 3)
    assert (result["x"][0], result["y"][0]) == pytest.approx(expected)
    slots = {p.name: p for p in result.program.parameter_slots}
    assert slots["held"].structural


def test_what_is_found_at_the_start_cannot_say_that_a_start_is_held(backend: Backend) -> None:
    with pytest.raises(PlanarcError, match="`fixed` of `x` must be known"):
        run(
            """
  parameter Boolean held(fixed=false);
  Real x(start=2, fixed=held);
initial equation
  held = x > 0;
equation
  der(x) = -x;""",
            backend,
        )


@pytest.mark.parametrize("found", ["true", "false"])
def test_a_parameter_says_whether_another_is_found_at_the_start(
    found: str, backend: Backend
) -> None:
    result = run(
        f"""
  parameter Boolean found = {found};
  parameter Real length(start=1, fixed=not found);
  Real x(start=2, fixed=true);
initial equation
  if found then
    length = x + 1;
  end if;
equation
  der(x) = -length;""",
        backend,
    )
    assert result["x"][-1] == pytest.approx(2 - 2 * (3 if found == "true" else 1))


def test_the_value_before_the_start_may_come_from_unknowns(backend: Backend) -> None:
    """As a hold begins: with what its input is then."""
    result = run(
        """
  Real u = x + 2*time, x(start=3, fixed=true);
  discrete Real held, before;
initial equation
  pre(held) = u;
  pre(before) = u;
equation
  der(x) = 1;
  when time >= 1 then
    held = u;
    before = pre(held);
  end when;""",
        backend,
    )
    assert result["held"][[0, -1]] == pytest.approx([3, 6])
    assert result["before"][[0, -1]] == pytest.approx([3, 3])


def test_a_value_before_a_clause_of_the_start_comes_from_parameters(backend: Backend) -> None:
    with pytest.raises(PlanarcError, match=r"the start value of `pre\(held\)` must be"):
        run(
            """
  Real x(start=3, fixed=true);
  discrete Real held;
initial equation
  pre(held) = x;
equation
  der(x) = 1;
  when {initial(), time >= 1} then
    held = pre(held) + x;
  end when;""",
            backend,
        )
