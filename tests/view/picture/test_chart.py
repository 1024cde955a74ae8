"""Curves by matplotlib: panels by unit, labels with units, files that are the same each time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planarc.core.diagnostic import UsageError
from planarc.view.picture.chart import draw_panels, panels_of, table_of, write_chart
from planarc.view.table.table import Table

pytest.importorskip("matplotlib")

TIME = np.linspace(0.0, 1.0, 50)
TABLE = Table(
    TIME,
    {"a.phi": np.sin(TIME), "b.phi": np.cos(TIME), "a.w": TIME, "plain": TIME**2},
    {"a.phi": "rad", "b.phi": "rad", "a.w": "rad/s"},
)


def test_variables_of_one_unit_share_a_panel() -> None:
    from matplotlib.figure import Figure

    panels = panels_of(TABLE, ["a.phi", "a.w", "b.phi", "plain"])
    assert panels == [("a.phi", "b.phi"), ("a.w",), ("plain",)]
    axes = Figure().subplots(3)
    draw_panels(axes, TABLE, panels, "time")
    assert [ax.get_ylabel() for ax in axes] == ["[rad]", "a.w [rad/s]", "plain"]
    assert axes[2].get_xlabel() == "time [s]"
    assert [t.get_text() for t in axes[0].get_legend().get_texts()] == ["a.phi", "b.phi"]
    np.testing.assert_array_equal(axes[0].lines[1].get_ydata(), TABLE["b.phi"])


@pytest.mark.parametrize(
    ("suffix", "head"), [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF")]
)
def test_equal_results_give_equal_files(tmp_path: Path, suffix: str, head: bytes) -> None:
    files = [tmp_path / f"{n}{suffix}" for n in "ab"]
    for file in files:
        write_chart(file, TABLE, ["a.phi", "a.w"], "b.phi")
    assert files[0].read_bytes() == files[1].read_bytes()
    assert files[0].read_bytes().startswith(head)
    assert suffix != ".svg" or "b.phi [rad]" in files[0].read_text("utf-8")


def test_what_cannot_be_drawn_says_why(tmp_path: Path) -> None:
    for name, variable, x, code in (
        ("a.bmp", "a.phi", "time", "V706"),
        ("a.png", "a.fi", "time", "C201"),
        ("a.png", "a.phi", "tim", "C201"),
    ):
        with pytest.raises(UsageError) as caught:
            write_chart(tmp_path / name, TABLE, [variable], x)
        assert caught.value.diagnostics[0].code == code
    assert not list(tmp_path.iterdir())


def test_peaks_of_a_long_result_are_kept(tmp_path: Path, table: Any, result_of: Any) -> None:
    from matplotlib.figure import Figure

    time = np.linspace(0.0, 1.0, 200_000)
    peak = np.zeros_like(time)
    peak[123_457] = 7.0
    axes = Figure().subplots()
    draw_panels([axes], table_of(result_of(table, time, {"p": peak})), [("p",)], "time")
    (line,) = axes.lines
    assert len(line.get_ydata()) < 50_000
    assert max(line.get_ydata()) == 7.0
