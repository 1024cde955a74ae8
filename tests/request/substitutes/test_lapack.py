"""A library whose linear algebra is LAPACK's works with planarc's own in its place."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planarc
from planarc.core.diagnostic import PlanarcError
from planarc.core.resources import stdlib

#: As much of a package of matrices as is asked for here, with nothing behind it.
MATRICES = """\
within Modelica.Math;
package Matrices
  function solve
    input Real A[:, size(A, 1)];
    input Real b[size(A, 1)];
    output Real x[size(b, 1)];
  protected
    Integer info;
  algorithm
    (x, info) := LAPACK.dgesv_vec(A, b);
    assert(info == 0, "the matrix is singular");
  end solve;

  function solve2
    input Real A[:, size(A, 1)];
    input Real B[size(A, 1), :];
    output Real X[size(B, 1), size(B, 2)];
  protected
    Integer info;
  algorithm
    (X, info) := LAPACK.dgesv(A, B);
    assert(info == 0, "the matrix is singular");
  end solve2;

  function det
    input Real A[:, size(A, 1)];
    output Real d;
  external "FORTRAN 77" d = determinant(A);
  end det;

  package LAPACK
    function dgesv_vec
      input Real A[:, size(A, 1)];
      input Real b[size(A, 1)];
      output Real x[size(A, 1)]=b;
      output Integer info;
    external "FORTRAN 77" dgesv(A, x, info);
    end dgesv_vec;
  end LAPACK;
end Matrices;
"""
HEAD = "import Modelica.Math.Matrices.*; import Modelica.Math.Matrices.LAPACK.*;"


@pytest.fixture
def library(tmp_path: Path) -> Path:
    """The embedded library as a user's, with such a package."""
    mathematics = tmp_path / "Modelica" / "Math"
    shutil.copytree(stdlib() / "Modelica", mathematics.parent)
    (mathematics / "Matrices.mo").write_text(MATRICES, "utf-8")
    order = mathematics / "package.order"
    if order.exists():
        order.write_text(f"{order.read_text('utf-8')}Matrices\n", "utf-8")
    return tmp_path


@pytest.fixture(params=["numpy", "native"])
def backend(request: pytest.FixtureRequest) -> str:
    if request.param == "native":
        pytest.importorskip("llvmlite")
    return str(request.param)


def run(body: str, library: Path, backend: str = "numpy", **options: Any) -> planarc.Result:
    text = f"model M\n{HEAD}\n{body}\nend M;"
    return planarc.load(text, libraries=[library], backend=backend).simulate(1.0, **options)


def test_matrices_of_parameters(library: Path, backend: str) -> None:
    text = f"""model M
  {HEAD}
  parameter Real A[2, 2] = [4, 1; 1, 3];
  Real x[2] = solve(A, {{1, 2}}), i[2, 2] = inv(A), d = det(A), l[2], m[2], s[2], e[2], f[2];
  Real full = det([0, 1, 2, 3; 1, 0, 4, 5; 2, 1, 0, 1; 5, 5, 1, 2]);
equation
  (e, f) = dgeev_eigenValues(A);
  s = dgesvd_sigma(A);
  l = dgtsv_vec({{1}}, {{2, 3}}, {{1}}, {{1, 2}});
  m = dgbsv_vec(2, 1, 1, [0, 0; 0, 1; 2, 3; 1, 0], {{1, 2}});
end M;"""
    model = planarc.load(text, libraries=[library], backend=backend)
    for corner in (4.0, 7.0):
        result = model.simulate(1.0, parameters={"A[1,1]": corner})
        a = np.array([[corner, 1], [1, 3]])

        def of(name: str, *shape: int, result: planarc.Result = result) -> Any:
            indices = [",".join(str(k + 1) for k in i) for i in np.ndindex(*shape)]
            return np.array([result[f"{name}[{i}]"][-1] for i in indices]).reshape(shape)

        assert of("x", 2) == pytest.approx(np.linalg.solve(a, [1, 2]))
        assert of("i", 2, 2) == pytest.approx(np.linalg.inv(a))
        assert result["d"][-1] == pytest.approx(np.linalg.det(a))
        assert sorted(of("e", 2)) == pytest.approx(np.linalg.eigvalsh(a))
        assert sorted(of("s", 2)) == pytest.approx(np.linalg.eigvalsh(a))
        assert of("l", 2) == pytest.approx([0.2, 0.6])
        assert of("m", 2) == pytest.approx([0.2, 0.6])
        assert result["full"][-1] == pytest.approx(
            np.linalg.det([[0, 1, 2, 3], [1, 0, 4, 5], [2, 1, 0, 1], [5, 5, 1, 2]])
        )


MOVING = """
  Real x(start=1, fixed=true), s[2], w[2], i[2, 2];
equation
  der(x) = -x;
  s = solve([2 + x, 1; 1, 3 + sin(time)], {{1, x}});
  w = der(s);
  i = inv([2 + x, 1; 1, 3]);""".replace("{{", "{").replace("}}", "}")


def test_what_moves_is_solved_as_equations(library: Path, backend: str) -> None:
    """They can be differentiated: so that a mass may hang on them."""
    result = run(MOVING, library, backend, tolerance=1e-9)

    def solution(t: float) -> Any:
        return np.linalg.solve([[2 + np.exp(-t), 1], [1, 3 + np.sin(t)]], [1, np.exp(-t)])

    for k in (0, -1):
        t, h = result.time[k], 1e-5
        slope = (solution(t + h) - solution(t - h)) / (2 * h)
        assert [result[f"s[{i}]"][k] for i in (1, 2)] == pytest.approx(solution(t), rel=1e-5)
        assert [result[f"w[{i}]"][k] for i in (1, 2)] == pytest.approx(slope, rel=1e-5)
        found = [result[f"i[{i},{j}]"][k] for i in (1, 2) for j in (1, 2)]
        expected = np.linalg.inv([[2 + np.exp(-t), 1], [1, 3]]).ravel()
        assert found == pytest.approx(expected, rel=1e-5)


def test_a_branch_solves_where_it_is_taken(library: Path, backend: str) -> None:
    """Beyond it the matrix is singular."""
    body = """
  function either
    input Real u;
    output Real y[2];
  algorithm
    if u < 0.5 then
      y := solve([max(0, 0.5 - u), 0; 0, 1], {1, 1});
    else
      y := {7, u};
    end if;
  end either;
  Real y[2] = either(time);
  discrete Real z[2](each start=0, each fixed=true);
equation
  when time > 0.2 then
    z = solve([2, 0; 0, time], {1, 1});
  end when;"""
    result = run(body, library, backend)
    assert [result[f"y[{i}]"][-1] for i in (1, 2)] == pytest.approx([7, 1])
    assert result["y[1]"][0] == pytest.approx(2)
    assert [result[f"z[{i}]"][-1] for i in (1, 2)] == pytest.approx([0.5, 5], rel=1e-6)


def test_a_singular_matrix_is_told_at_the_call(library: Path) -> None:
    with pytest.raises(PlanarcError) as caught:
        run("  parameter Real A[2, 2] = [1, 2; 2, 4];\n  Real x[2] = solve(A, {1, 1});", library)
    (found,) = caught.value.diagnostics
    assert found.code == "R430"
    assert "the matrix is singular" in found.message
    assert found.span is not None and found.span.text == "solve(A, {1, 1})"
