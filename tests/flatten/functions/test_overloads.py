"""Operator records: a model's complex numbers beside Python's."""

from __future__ import annotations

import cmath
import re
from pathlib import Path

import numpy as np
import pytest

import planarc

CASES = Path(__file__).parents[2] / "language" / "ch14_operators" / "14_operators.case"
#: The operator record of these cases, with a division and a power.
RECORD = re.search(r"^operator record C .*?^end C;\n", CASES.read_text("utf-8"), re.M | re.S)
assert RECORD is not None
DIVISION = """
  encapsulated operator function '/'
    import C;
    input C a;
    input C b;
    output C c;
  protected
    Real size = b.re^2 + b.im^2;
  algorithm
    c := C((a.re*b.re + a.im*b.im)/size, (a.im*b.re - a.re*b.im)/size);
  end '/';
  encapsulated operator function '^'
    import C;
    input C a;
    input Integer n;
    output C c = C(1);
  algorithm
    for i in 1:n loop
      c := c*a;
    end for;
  end '^';
end C;
"""
COMPLEX = RECORD[0].removesuffix("end C;\n") + DIVISION


def run(body: str, **options: object) -> planarc.Result:
    return planarc.load(f"{COMPLEX}\nmodel M\n{body}\nend M;").simulate(2, intervals=20)


def number(result: planarc.Result, name: str) -> np.ndarray:
    return result[f"{name}.re"] + 1j * result[f"{name}.im"]


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("z + w", lambda z, w: z + w),
        ("z - w", lambda z, w: z - w),
        ("-z", lambda z, w: -z),
        ("+z", lambda z, w: z),
        ("z*w", lambda z, w: z * w),
        ("z/w", lambda z, w: z / w),
        ("2*z", lambda z, w: 2 * z),
        ("z*2 - 1", lambda z, w: 2 * z - 1),
        ("1/z", lambda z, w: 1 / z),
        ("z^3", lambda z, w: z**3),
        ("-z^2*w", lambda z, w: -(z**2) * w),
        ("z - w - 1.5*z", lambda z, w: z - w - 1.5 * z),
        ("if noEvent(time > 1) then z else w", None),
    ],
)
def test_operators_are_those_of_complex_numbers(written: str, meant: object) -> None:
    result = run(f"C z = C(cos(3*time), time); C w = C(2, 1 - time); C x = {written};")
    z, w = number(result, "z"), number(result, "w")
    expected = meant(z, w) if callable(meant) else np.where(result.time > 1, z, w)
    assert number(result, "x") == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_arrays_and_matrices() -> None:
    result = run(
        """C z[2] = {C(time, 1), C(2, time)};
        C A[2, 3] = {{z[1], C(1), z[2]}, {C(0, 1), z[1], z[1]}};
        C a[2] = 2*z - z; C b[2] = z.*z ./ {2*z[1], C(1)}; C s = z*z; C m[3] = z*A;
        C P[2, 2] = A*transpose(A); C t = sum(z) + product(z) + sum(k*z[k] for k in 1:2);"""
    )
    z = [number(result, f"z[{k}]") for k in (1, 2)]
    one = np.ones_like(z[0])
    A = [[z[0], one, z[1]], [1j * one, z[0], z[0]]]
    assert number(result, "a[2]") == pytest.approx(z[1])
    assert number(result, "b[1]") == pytest.approx(z[0] / 2)
    assert number(result, "s") == pytest.approx(z[0] ** 2 + z[1] ** 2)
    assert number(result, "m[3]") == pytest.approx(z[0] * A[0][2] + z[1] * A[1][2])
    inner = sum(a * b for a, b in zip(A[0], A[1], strict=True))
    assert number(result, "P[2,1]") == pytest.approx(inner)
    assert number(result, "t") == pytest.approx(sum(z) + z[0] * z[1] + z[0] + 2 * z[1])


def test_a_closed_loop_of_links_is_one_equation() -> None:
    """r1*exp(i*a) + r2*exp(i*b) = d: a slider-crank, whose slide is on the real axis."""
    result = run(
        """function turned input Real r; input Real phi; output C z = C(r*cos(phi), r*sin(phi));
          algorithm end turned;
        Real a = 0.4 + 2*time; Real b(start=-0.1); Real x(start=1.2);
        equation turned(0.3, a) + turned(1, b) = C(x);"""
    )
    a = result["a"]
    b = -np.arcsin(0.3 * np.sin(a))
    assert result["b"] == pytest.approx(b, abs=1e-9)
    assert result["x"] == pytest.approx(0.3 * np.cos(a) + np.cos(b), abs=1e-9)


def test_states_and_events_of_operator_records() -> None:
    """z' = (i - 0.1)*z, turned by a right angle at an event."""
    result = run(
        """C z(re(start=1, fixed=true), im(fixed=true)); C rate = C(-0.1, 1)*z;
        equation
          der(z.re) = rate.re; der(z.im) = rate.im;
          when time > 1 then
            reinit(z.re, -z.im); reinit(z.im, z.re);
          end when;"""
    )
    end = cmath.exp((1j - 0.1) * 2) * 1j
    assert number(result, "z")[-1] == pytest.approx(end, rel=1e-5)


def test_constants_parameters_and_texts() -> None:
    with pytest.raises(planarc.PlanarcError, match="p is 3 \\+ 6j, not 3 \\+ 6i"):
        run(
            """constant C k = C(1, 2); parameter C p = 3*k;
            equation
              assert(p == k, "p is " + String(p, unit="j") + ", not " + String(p));"""
        )


def test_functions_take_and_give_operator_records_in_loops() -> None:
    """The square root by Newton's method, turn by turn until it has converged."""
    result = run(
        """function root input C z; output C w = C(1, 0.1); protected C d; algorithm
            d := w*w - z;
            while d.re^2 + d.im^2 > 1e-24 loop
              w := w - d/(2*w);
              d := w*w - z;
            end while;
          end root;
        C z = C(1 + time, sin(3*time)); C w = root(z);"""
    )
    assert number(result, "w") == pytest.approx(np.sqrt(number(result, "z")), rel=1e-11)
