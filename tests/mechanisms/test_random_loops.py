"""Random algebraic loops: each row of a run fulfils each equation, on both back ends."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import planarc

SIZE = 4
FUNCTIONS = ("sin", "cos", "tanh", "atan")

_unknowns = st.sampled_from([*(f"x{i}" for i in range(SIZE)), "y", "time"])
_term = st.builds(
    lambda gain, function, inside: f"{gain}*{function}({inside})" if function else inside,
    st.sampled_from(["0.3", "0.2", "(-0.4)", "1", "p"]),
    st.sampled_from(FUNCTIONS),
    _unknowns,
)
#: Each unknown is a sum of bounded functions of all of them; some are one function alone, as
#: `x1 = cos(x2)`: then what Newton's method works out on its way is a variable of the model.
_right = st.one_of(
    st.builds("{}({})".format, st.sampled_from(FUNCTIONS), _unknowns),
    st.builds(" + ".join, st.lists(_term, min_size=1, max_size=3)),
)


@given(st.lists(_right, min_size=SIZE, max_size=SIZE), st.booleans())
@settings(max_examples=100, deadline=None)
def test_every_row_fulfils_every_equation(rights: list[str], moving: bool) -> None:
    """`moving`: y is a state, and not a variable of the time alone: then the run has no steps."""
    text = "model M\n  parameter Real p = 0.25;\n"
    text += f"  Real {', '.join(f'x{i}' for i in range(SIZE))};\n"
    text += "  Real y(start=0.5, fixed=true);\n" if moving else "  Real y;\n"
    text += f"equation\n  {'der(y) = cos(time) - 0.1*y' if moving else 'y = sin(time)'};\n"
    text += "".join(f"  x{i} = {right};\n" for i, right in enumerate(rights)) + "end M;\n"
    for backend in ("native", "numpy"):
        try:
            result = planarc.load(text, backend=backend).simulate(1.0, intervals=5)
        except planarc.PlanarcError:
            continue  # as of a loop without a solution
        for k, time in enumerate(result["time"]):
            values = {f"x{i}": float(result[f"x{i}"][k]) for i in range(SIZE)}
            values |= {"y": float(result["y"][k]), "time": float(time), "p": 0.25}
            for i, right in enumerate(rights):
                found = eval(right, {f: getattr(math, f) for f in FUNCTIONS} | values)
                assert values[f"x{i}"] == pytest.approx(found, abs=1e-6), (backend, right)
