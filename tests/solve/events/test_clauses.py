"""What when-clauses set: who gives a discrete variable its value, and when it is kept."""

from __future__ import annotations

import pytest

import planarc


@pytest.fixture(params=["numpy", "native"])
def backend(request: pytest.FixtureRequest) -> str:
    if request.param == "native":
        pytest.importorskip("llvmlite")
    return str(request.param)


def run(body: str, backend: str, stop: float) -> planarc.Result:
    return planarc.load(f"model M\n{body}\nend M;", backend=backend).simulate(stop, intervals=10)


def test_what_no_clause_sets_in_the_end_is_kept(backend: str) -> None:
    """The second clause takes back what made the first one act: one instant, one solution."""
    result = run(
        """
  Real x(start=-1, fixed=true);
  Boolean z(start=true, fixed=true), v(start=true, fixed=true);
equation
  der(x) = 1;
  when x > 0 and z then
    v = false;
  end when;
  when x > 0 then
    z = false;
  end when;""",
        backend,
        2.0,
    )
    assert result["z"][-1] == 0
    assert result["v"].tolist() == [1.0] * len(result.time)


@pytest.mark.parametrize("rest", ["", "Boolean late = time > 5;"])
def test_the_start_ends(backend: str, rest: str) -> None:
    result = run(
        f"""
  Real x(start=0, fixed=true);
  {rest}
equation
  der(x) = if initial() then 1 else -1;""",
        backend,
        1.0,
    )
    assert result["x"][-1] == pytest.approx(-1.0, abs=1e-12)
