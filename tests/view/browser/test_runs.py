"""Several runs on one page: curves beside curves, ghosts behind the mechanism."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from planarc.cli.app import run

EXAMPLE = Path(__file__).parents[3] / "examples" / "four_bar.pmo"

#: The dark pixels of the stage: ghosts add pale ones.
TINTED = """() => {
  const canvas = document.querySelector("canvas.stage");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  const paper = data.slice(0, 3).join();
  let count = 0;
  for (let i = 0; i < data.length; i += 4) count += data.slice(i, i + 3).join() !== paper;
  return count;
}"""
FRAME = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("runs")


@pytest.fixture
def page_of_three(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(folder)
    page = folder / "a-runs.html"
    if not page.exists():
        for name, length in (("a", 0.4), ("b", 0.35), ("c", 0.3)):
            options = ("--set", f"crank.r={{{length},0}}", "-o", f"{name}.csv", "--no-report")
            assert run(["-q", "simulate", str(EXAMPLE), *options]) == 0
        assert run(["-q", "view", "a.csv", "b.csv", "c.csv", "--no-open"]) == 0
    return page


def test_runs_are_told_by_what_differs_and_lie_beside_each_other(
    page_of_three: Path, open_page: Callable[..., Any], screenshot: Callable[..., Path]
) -> None:
    assert page_of_three.stat().st_size < 1_500_000
    page = open_page(page_of_three)
    labels = page.locator("#runs .chip").all_inner_texts()
    assert labels == [f"crank.r[1] = {length} m" for length in (0.4, 0.35, 0.3)]
    sizes = page.evaluate("planarcPlots.panels.map((p) => [p.curves.length, p.chart.data.length])")
    assert all(columns == 1 + 3 * curves for curves, columns in sizes)
    with_ghosts = page.evaluate(TINTED)
    first = page.locator(".legend b").first
    assert first.inner_text().count("|") == 2
    screenshot(page, "runs", whole=True)
    for i in (1, 2):
        page.locator("#runs .chip").nth(i).click()
    page.evaluate(FRAME)
    assert page.evaluate(TINTED) < with_ghosts
    assert first.inner_text().count("|") == 0


def test_a_kept_curve_is_that_of_its_own_run(
    page_of_three: Path, open_page: Callable[..., Any], folder: Path
) -> None:
    import numpy as np

    from planarc.view.table.files import read_table

    page = open_page(page_of_three)
    time, column = page.evaluate(
        """() => {
          const panel = planarcPlots.panels[0];
          const i = panel.curves.findIndex((c) => c.name === "revB.phi");
          const all = panel.chart.data;
          const rows = all[0].map((t, row) => [t, all[1 + 2 * panel.curves.length + i][row]]);
          const own = rows.filter(([, v]) => v !== undefined && v !== null);
          return [own.map(([t]) => t), own.map(([, v]) => v)];
        }"""
    )
    table = read_table(folder / "c.csv")
    expected = np.degrees(np.interp(time, table.time, table["revB.phi"]))
    assert len(time) > 100
    np.testing.assert_allclose(column, expected, atol=2e-3)


def test_the_table_of_peaks_has_each_run(
    page_of_three: Path, open_page: Callable[..., Any]
) -> None:
    page = open_page(page_of_three)
    heads = page.locator(".about th[colspan]").all_inner_texts()
    assert len(heads) == 3
    row = page.locator(".about tr", has_text="revA force").locator("td").all_inner_texts()
    assert len(row) == 3 * 3 + 1
    assert row[-1] == "N"


@pytest.mark.parametrize("ending", ["csv", "svg"])
def test_what_a_figure_shows_is_saved(
    ending: str, page_of_three: Path, open_page: Callable[..., Any], tmp_path: Path
) -> None:
    page = open_page(page_of_three)
    page.evaluate("planarcPlots.panels.forEach((p) => p.chart.setScale('x', { min: 2, max: 4 }))")
    with page.expect_download() as download:
        page.get_by_label(f"Save Joints as .{ending}").click()
    assert download.value.suggested_filename == f"Joints.{ending}"
    file = tmp_path / f"saved.{ending}"
    download.value.save_as(file)
    text = file.read_text("utf-8")
    if ending == "svg":
        from xml.etree import ElementTree

        paths = ElementTree.fromstring(text).findall("{http://www.w3.org/2000/svg}path")
        curves = [p for p in paths if p.get("fill") == "none"]
        assert len(curves) == 4 * 3
        assert all(len(p.get("d", "")) > 200 for p in curves)
        return
    head, *rows = list(csv.reader(text.splitlines()))
    assert head[0] == "time [s]"
    assert head[1] == "revA.phi [deg] (crank.r[1] = 0.4 m)"
    assert len(head) == 1 + 4 * 3
    times = [float(row[0]) for row in rows]
    assert (min(times) >= 2, max(times) <= 4, len(times) > 100) == (True, True, True)


def test_curves_over_each_other_have_equal_axes(
    page_of_three: Path, open_page: Callable[..., Any], screenshot: Callable[..., Path]
) -> None:
    page = open_page(page_of_three)
    page.get_by_label("Joints, curves over each other").click()
    canvas = page.locator("canvas.phase")
    assert canvas.count() == 1
    page.evaluate(FRAME)
    screenshot(page, "over-each-other", whole=True)
    # A circle stays round: what is drawn of one is as high as it is wide.
    high, wide = page.evaluate(
        """() => {
          const holder = document.createElement("div");
          holder.style.width = "500px";
          document.body.append(holder);
          const angles = Array.from({ length: 200 }, (_, i) => i / 30);
          const line = { x: angles.map(Math.cos), y: angles.map(Math.sin), color: "rgb(255,0,0)" };
          planarc.createPhase(holder, { lines: [line], unit: "m", across: "x", plain: String });
          const canvas = holder.querySelector("canvas");
          const { width, height } = canvas;
          const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
          const red = [];
          for (let i = 0; i < data.length; i += 4) {
            if (data[i] > 200 && data[i + 1] < 60 && data[i + 3] > 200) red.push(i / 4);
          }
          const columns = red.map((i) => i % width);
          const rows = red.map((i) => Math.floor(i / width));
          holder.remove();
          return [rows, columns].map((v) => Math.max(...v) - Math.min(...v));
        }"""
    )
    assert wide > 100
    assert abs(wide - high) <= 2


def test_angles_that_turn_round_have_a_plot_of_their_own(
    page_of_three: Path, open_page: Callable[..., Any]
) -> None:
    page = open_page(page_of_three)
    shown = page.evaluate(
        """() => planarcPlots.panels.filter((p) => p.figure.title === "Joints").map((p) => {
          const spans = p.curves.map((c) => c.values(planarcPlots.panels[0].chart.data[0].length))
            .map((v) => v.filter((x) => x !== null)).map((v) => Math.max(...v) - Math.min(...v));
          return [p.curves.map((c) => c.name), spans.every((s) => s > 360)];
        })"""
    )
    assert shown == [[["revA.phi", "revB.phi"], True], [["revC.phi", "revD.phi"], False]]
