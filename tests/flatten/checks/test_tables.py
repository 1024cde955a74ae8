"""A table whose points were written with commas alone is told, and no other table of one row."""

from __future__ import annotations

import pytest

import planarc


def told(table: str, block: str = "Modelica.Blocks.Tables.CombiTable1Ds") -> list[str | None]:
    text = f"model M\n  {block} t(table={table});\nequation\n  t.u = time;\nend M;\n"
    return [w.hint for w in planarc.load(text).warnings if w.code == "F337"]


def test_the_rows_that_were_meant_are_written() -> None:
    assert told("[-1, 20, 0, 5, 1e0, -1.5]") == [
        "a semicolon ends a row: write `[-1, 20; 0, 5; 1e0, -1.5]`"
    ]


@pytest.mark.parametrize(
    "table",
    [
        "[0, 5]",  # a constant
        "[0, 5, 6]",  # two of them
        "[0, 1, 0, 2]",  # no abscissae
        "[1, 1, 0, 2]",
        "[0, 1; 1, 2]",
        "[0, 2*3, 1, 4]",  # computed, and so thought about
    ],
)
def test_other_tables_are_not_told(table: str) -> None:
    assert told(table) == []


def test_a_matrix_of_another_name_is_not_told() -> None:
    text = "model M\n  parameter Real C[1, 4]=[0, 1, 2, 3];\n  Real y=C[1, 2]*time;\nend M;\n"
    assert not planarc.load(text).warnings
