"""Matrices in files: three forms of files, and what may be wrong with them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from planarc.runtime.external import call_texts
from planarc.runtime.external.matrix import Rows

ROWS = [[0.0, 0.0, 5.0], [1.0, 2.5, 6.0], [2.0, 4.0, 7.0]]
TEXT = """\
#1
# two matrices

double curve(3,3)  # the first one
0 0 5  # begin
1, 2.5; 6
2\t4
7
float other ( 1 , 2 )
1e3 -2
"""


def read(file: Path, name: str, delimiter: str = ",", head: int = 0) -> Rows:
    where = [str(file), name, delimiter, head]
    (sizes,) = call_texts("planarc_tableSizes", where)
    (rows,) = call_texts("planarc_table", [*where, *sizes])
    assert sizes == [len(rows), len(rows[0])]
    return rows  # type: ignore[no-any-return]


def test_a_text_holds_matrices_by_name(tmp_path: Path) -> None:
    file = tmp_path / "tables.txt"
    file.write_text("\ufeff" + TEXT, "utf-8")
    assert read(file, "curve") == ROWS
    assert read(file, "other") == [[1000.0, -2.0]]


@pytest.mark.parametrize("form", ["4", "5"])
def test_a_file_of_matlab_holds_matrices_by_name(tmp_path: Path, form: str) -> None:
    file = tmp_path / "tables.mat"
    savemat(file, {"curve": np.array(ROWS), "other": np.array([[1, 2]])}, format=form)
    assert read(file, "curve") == ROWS
    if form == "5":
        savemat(file.with_stem("s"), {"s": {"curve": np.array(ROWS)}})
        assert read(file.with_stem("s"), "s.curve") == ROWS
    assert read(file, "other") == [[1.0, 2.0]]
    where = [str(file), "curve"]
    assert call_texts("ModelicaIO_readMatrixSizes", where) == ([3, 3],)
    assert call_texts("ModelicaIO_readRealMatrix", [*where, 3, 3, True]) == (ROWS,)


def test_a_file_of_values_is_one_matrix(tmp_path: Path) -> None:
    file = tmp_path / "table.csv"
    file.write_text("u;y;z\n0;0;5\n1;2.5;6\n\n2;4;7\n", "utf-8")
    assert read(file, "any", ";", 1) == ROWS


def test_a_file_that_is_written_anew_is_read_anew(tmp_path: Path) -> None:
    file = tmp_path / "table.csv"
    file.write_text("0,1\n", "utf-8")
    assert read(file, "t") == [[0.0, 1.0]]
    file.write_text("0,1\n2,3\n", "utf-8")
    assert read(file, "t") == [[0.0, 1.0], [2.0, 3.0]]


@pytest.mark.parametrize(
    ("name", "text", "reason"),
    [
        ("none.txt", None, "there is no file"),
        ("t.txt", TEXT, "there is no `t` in"),
        ("t.txt", "double t(1,1)\n1\n", "does not begin with `#1`"),
        ("t.txt", "#1\ndouble t(2,2)\n1 2 3\ndouble u(1,1)\n4\n", "has 3 numbers, and not 2\\*2"),
        ("t.txt", "#1\ndouble t(2,2)\n1 2\n3 x\n", "`x` in line 4 of .* is no number"),
        ("t.csv", "1,2\n3\n", "line 2 of .* has 1 numbers, the first has 2"),
        ("t.csv", "u,y\n1,2\n", "`u` in line 1 of .* is no number"),
        ("t.mat", "no matrix", "is no file of MATLAB"),
    ],
)
def test_what_is_wrong_with_a_file_is_told(
    tmp_path: Path, name: str, text: str | None, reason: str
) -> None:
    file = tmp_path / name
    if text is not None:
        file.write_text(text, "utf-8")
    with pytest.raises(ValueError, match=reason):
        read(file, "t")


def test_a_name_in_a_file_of_matlab_must_be_that_of_a_matrix(tmp_path: Path) -> None:
    file = tmp_path / "t.mat"
    savemat(file, {"t": "text", "cube": np.zeros((2, 2, 2))})
    wrong = {"t": "no matrix of numbers", "cube": "no matrix", "u": "no `u`", "t.x": "no `t.x`"}
    for name, reason in wrong.items():
        with pytest.raises(ValueError, match=reason):
            read(file, name)


def test_a_matrix_has_the_size_that_is_asked_for(tmp_path: Path) -> None:
    file = tmp_path / "t.csv"
    file.write_text("1,2\n", "utf-8")
    with pytest.raises(ValueError, match="no matrix of 2 rows and 2 columns"):
        call_texts("planarc_table", [str(file), "t", ",", 0, 2, 2])
