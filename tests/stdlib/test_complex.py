"""Complex numbers of the library, against those of Python."""

from __future__ import annotations

import cmath
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

import planarc

OPERATORS: dict[str, Callable[[complex, complex], complex]] = {
    "z + w": lambda z, w: z + w,
    "z - w": lambda z, w: z - w,
    "-z": lambda z, w: -z,
    "z*w": lambda z, w: z * w,
    "z/w": lambda z, w: z / w,
    "z^w": lambda z, w: z**w,
    "2*z - 1": lambda z, w: 2 * z - 1,
    "z*z*z": lambda z, w: z**3,
    "{z, w}*{w, w}": lambda z, w: z * w + w * w,
    "sum({z, w, z})": lambda z, w: 2 * z + w,
    "sum(Complex(k) for k in 1:0)": lambda z, w: 0,
    "sqrt(z)": lambda z, w: cmath.sqrt(z),
    "exp(z)": lambda z, w: cmath.exp(z),
    "log(z)": lambda z, w: cmath.log(z),
    "conj(z)*j": lambda z, w: z.conjugate() * 1j,
    "fromPolar(abs(z), arg(z))": lambda z, w: z,
    "Complex(real(z), imag(w))": lambda z, w: complex(z.real, w.imag),
    "Modelica.ComplexMath.sum({z, w}) + product({z, w})": lambda z, w: z + w + z * w,
}


@cache
def result() -> planarc.Result:
    listed = "\n".join(f"  Complex x{k} = {e};" for k, e in enumerate(OPERATORS))
    text = f"""model Numbers
  import Modelica.ComplexMath.{{j, sqrt, exp, log, conj, fromPolar, abs, arg, real, imag, product}};
  Complex z = Complex(2*cos(time + 0.3), sin(3*time));
  Complex w = Complex(time - 1.5, 1);
{listed}
end Numbers;
"""
    return planarc.load(text).simulate(3, intervals=30)


def number(name: str) -> np.ndarray:
    return result()[f"{name}.re"] + 1j * result()[f"{name}.im"]


@pytest.mark.parametrize("k", range(len(OPERATORS)), ids=list(OPERATORS))
def test_operators_and_functions_are_those_of_complex_numbers(k: int) -> None:
    of = list(OPERATORS.values())[k]
    expected = [of(z, w) for z, w in zip(number("z"), number("w"), strict=True)]
    assert number(f"x{k}") == pytest.approx(np.array(expected), rel=1e-12, abs=1e-12)


def test_a_slider_crank_is_one_complex_equation() -> None:
    text = """model Loop
      import Modelica.ComplexMath.fromPolar;
      Real crank = 0.4 + 2*time; Real rod(start=-0.1); Real slide(start=1.2);
      Real speed = der(slide);
    equation
      fromPolar(0.3, crank) + fromPolar(1, rod) = Complex(slide);
    end Loop;
    """
    run = planarc.load(text).simulate(3, intervals=30)
    crank, rod = run["crank"], -np.arcsin(0.3 * np.sin(run["crank"]))
    turn = -0.3 * np.cos(crank) * 2 / np.cos(rod)
    assert run["rod"] == pytest.approx(rod, abs=1e-9)
    assert run["speed"] == pytest.approx(-0.6 * np.sin(crank) - np.sin(rod) * turn, abs=1e-8)


def test_comparisons_and_texts() -> None:
    text = """model Told
      parameter Complex p = Complex(1.5, -2);
    equation
      assert(p == Complex(1.5, 2) or p <> p, "p is " + String(p) + ", in short "
        + String(p, name="i", significantDigits=1));
    end Told;
    """
    with pytest.raises(planarc.PlanarcError, match=r"p is 1\.5 - 2\*j, in short 2 - 2\*i"):
        planarc.load(text).simulate(1)


def test_inputs_and_outputs_of_a_model_may_be_complex() -> None:
    text = """model Gain
      input Complex u;
      output Complex y = Complex(0, 2)*u;
    protected
      output Complex hidden = u;
    end Gain;
    """
    model = planarc.load(text)
    assert model.inputs == ("u.re", "u.im")
    assert model.outputs == ("y.re", "y.im")
    run = model.simulate(1, inputs={"u.re": lambda t: t, "u.im": 3.0})
    assert run["y.re"][-1] == pytest.approx(-6)
    assert run["y.im"][-1] == pytest.approx(2)
