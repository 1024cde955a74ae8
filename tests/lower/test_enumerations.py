"""`Kind(i)` is the literal of that number, also where the number changes while the model runs."""

from __future__ import annotations

import pytest

import planarc

TEXT = """
type Kind = enumeration(low, middle, high);
function after
  input Kind k;
  output Kind next;
algorithm
  next := Kind(Integer(k) + 1);
end after;
"""


@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_the_number_may_change(backend: str) -> None:
    body = "Integer i=if time > 0.5 then 3 else 1; Kind k=Kind(i); "
    body += "Real y=if k == Kind.high then 1 else 2"
    model = planarc.load(f"{TEXT}model M\n  {body};\nend M;\n", "M", backend=backend)
    result = model.simulate(1.0)
    assert (result["k"][0], result["k"][-1]) == (1, 3)
    assert (result["y"][0], result["y"][-1]) == (2, 1)


@pytest.mark.parametrize(
    ("declared", "expected"),
    [
        ("constant Kind k=after(Kind.low)", 2),
        ("parameter Integer i=3; parameter Kind k=Kind(i)", 3),
        ("Kind k=after(if time > 0.5 then Kind.middle else Kind.low)", 3),
        ("Kind k(start=Kind.low); equation when time > 0.5 then k = after(pre(k)); end when", 2),
    ],
)
def test_numbers_of_literals_are_computed(declared: str, expected: int) -> None:
    result = planarc.load(f"{TEXT}model M\n  {declared};\nend M;\n", "M").simulate(1.0)
    assert result["k"][-1] == expected


def test_a_number_of_no_literal_ends_the_run() -> None:
    text = f"{TEXT}model M\n  Integer i=if time > 0.5 then 4 else 1;\n  Kind k=Kind(i);\nend M;\n"
    with pytest.raises(planarc.PlanarcError, match="the number 4 is outside of 1 to 3"):
        planarc.load(text, "M").simulate(1.0)


@pytest.mark.parametrize("variability", ["constant", "parameter"])
def test_a_known_number_of_no_literal_is_refused(variability: str) -> None:
    text = f"{TEXT}model M\n  {variability} Integer i=4;\n  Kind k=Kind(i);\nend M;\n"
    with pytest.raises(planarc.PlanarcError, match="`Kind` has no value 4"):
        planarc.load(text, "M")
