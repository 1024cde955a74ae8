"""A page that runs its model itself, in a real browser, from disk."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pytest

import planarc
from planarc.compiler import compile_model, run
from planarc.core.options import RunOptions
from planarc.export.page.page import make_page
from planarc.request.request import Request
from tests.view.browser.conftest import PHONE, settle, until
from tests.view.browser.test_live import POSE, field, slide

ROOT = Path(__file__).parents[3]


@cache
def page_of(file: Path) -> str:
    compiled = compile_model(Request(file))
    return make_page(compiled, run(compiled, RunOptions())).text


@pytest.fixture
def four_bar(tmp_path: Path) -> Path:
    path = tmp_path / "FourBar.html"
    path.write_text(page_of(ROOT / "examples" / "four_bar.pmo"), "utf-8")
    return path


def angle(page: Any, time: float) -> float:
    found: float = page.evaluate(POSE, ["rocker", time])["angle"]
    return found


@cache
def wanted(crank: float, stop: float) -> float:
    """The angle of the rocker at the end of a run of planarc."""
    model = planarc.load(str(ROOT / "examples" / "four_bar.pmo"))
    result = model.simulate(stop, parameters={"crank.r[1]": crank}, tolerance=1e-10)
    return float(result["revD.phi"][-1])


def test_a_slider_runs_the_model_again(
    four_bar: Path, open_page: Callable[..., Any], screenshot: Callable[..., Path]
) -> None:
    page = open_page(four_bar)
    settle(page)
    assert "simulated in" in page.inner_text("#state")
    before = angle(page, 1.0)
    assert before == pytest.approx(wanted(0.4, 1.0), abs=1e-6)
    slide(page, "crank.r[1]", 0.3)
    settle(page)
    after = angle(page, 1.0)
    assert after == pytest.approx(wanted(0.3, 1.0), abs=1e-6)
    assert abs(after - before) > 0.01
    screenshot(page, "own-page")
    page.click("#reset")
    settle(page)
    assert angle(page, 1.0) == before


def test_what_cannot_be_stands_at_its_field(four_bar: Path, open_page: Callable[..., Any]) -> None:
    page = open_page(four_bar)
    settle(page)
    row = field(page, "crank.r[1]")
    row.locator("input[type=text]").fill("30")
    settle(page)
    assert "no start is found with these values: a loop does not close" in row.inner_text()
    assert page.locator("#player.stale").count() == 1
    row.locator("input[type=text]").fill("zero")
    settle(page)
    assert "not a number" in row.inner_text()
    row.locator("input[type=text]").fill("0,35")
    settle(page)
    assert page.locator("#player.stale").count() == 0
    assert angle(page, 1.0) == pytest.approx(wanted(0.35, 1.0), abs=1e-6)


def test_a_run_is_made_no_longer_than_a_page_can_answer(
    four_bar: Path, open_page: Callable[..., Any]
) -> None:
    """A thousand times as long as the experiment of 10 s, also by the address."""
    page = open_page(four_bar)
    settle(page)
    row, stop = field(page, "$stop"), "planarcPlayer.reader.stop"
    for given in ("10001", "1e9", "1e300"):
        row.locator("input[type=text]").fill(given)
        settle(page)
        assert "at most 10000 s" in row.inner_text()
        assert page.evaluate(stop) == 10.0
    row.locator("input[type=text]").fill("40")
    settle(page)
    assert page.evaluate(stop) == 40.0 and "at most" not in row.inner_text()
    other = open_page(f"{four_bar.absolute().as_uri()}#$stop=1e9")
    settle(other)
    told = "the address gives $stop a value that is not taken: at most 10000 s"
    assert told in other.inner_text("#notes")
    assert other.evaluate(stop) == 10.0


def test_the_address_holds_the_values(four_bar: Path, open_page: Callable[..., Any]) -> None:
    page = open_page(four_bar)
    settle(page)
    slide(page, "crank.r[1]", 0.3)
    field(page, "$stop").locator("input[type=text]").fill("2")
    settle(page)
    page.click("#link")
    until(page, "location.hash.length > 1")
    address = page.evaluate("location.href")
    other = open_page(address)
    settle(other)
    assert other.evaluate("planarcPlayer.reader.stop") == 2.0
    assert angle(other, 1.0) == pytest.approx(wanted(0.3, 1.0), abs=1e-6)
    assert other.locator("#reset").is_visible()
    strange = open_page(f"{four_bar.absolute().as_uri()}#no.such=1&crank.r%5B1%5D=-1e")
    settle(strange)
    told = strange.inner_text("#notes")
    assert "the address gives no.such a value that is not taken: not in this model" in told
    assert "the address gives crank.r[1] a value that is not taken: not a number" in told
    assert angle(strange, 1.0) == pytest.approx(wanted(0.4, 1.0), abs=1e-6)


def test_inputs_that_are_no_reals_are_chosen(open_page: Callable[..., Any], tmp_path: Path) -> None:
    text = """model Switched
  type Way = enumeration(back, forth);
  input Boolean on(start=true);
  input Integer n(start=2, max=5);
  input Way way(start=Way.forth);
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Prismatic slide(s(start=0, fixed=true), drivenFlange=true);
  PlanarMultiBody.Parts.BodyShape body(r={0, 1}, m=1, I=1);
  Modelica.Mechanics.Translational.Sources.Speed drive(exact=true);
equation
  drive.v_ref = if on then n*(if way == Way.back then -1 else 1) else 0;
  connect(drive.flange, slide.axis);
  connect(world.frame_b, slide.frame_a);
  connect(slide.frame_b, body.frame_a);
end Switched;
"""
    path = planarc.load(text).export_page(tmp_path / "switched.html")
    page = open_page(path)
    settle(page)

    def end() -> float:
        return float(page.evaluate(POSE, ["body", 1.0])["x"])

    assert end() == pytest.approx(2.0, abs=1e-6)
    field(page, "way").locator("select").select_option(label="back")
    settle(page)
    assert end() == pytest.approx(-2.0, abs=1e-6)
    count = field(page, "n").locator("input[type=text]")
    count.fill("2.5")
    settle(page)
    assert "a whole number" in field(page, "n").inner_text()
    count.fill("6")
    settle(page)
    assert "at most 5" in field(page, "n").inner_text()
    count.fill("3")
    settle(page)
    assert end() == pytest.approx(-3.0, abs=1e-6)
    field(page, "on").locator("select").select_option(label="false")
    settle(page)
    assert end() == pytest.approx(0.0, abs=1e-6)


def test_curves_follow_and_runs_are_kept(four_bar: Path, open_page: Callable[..., Any]) -> None:
    page = open_page(four_bar)
    settle(page)
    page.click("#hold")
    assert page.locator("#runs .chip").count() == 2
    slide(page, "crank.r[1]", 0.3)
    settle(page)
    assert "crank.r[1] = 0.3 m" in page.inner_text("#runs")
    assert page.locator("#plots canvas").count() > 0


def test_an_assertion_ends_the_run_with_its_line(
    tmp_path: Path, open_page: Callable[..., Any]
) -> None:
    file, path = tmp_path / "slow.pmo", tmp_path / "Slow.html"
    file.write_text(
        """
model Slow "A clock that may not run for long"
  parameter Real longest(unit="s")=20 "Longest time";
  Real x(start=0, fixed=true);
equation
  der(x) = 1;
  assert(x < longest, "it took " + String(x - longest) + " s too long");
  annotation(experiment(StopTime=10));
end Slow;
""",
        "utf-8",
    )
    path.write_text(page_of(file), "utf-8")
    page = open_page(path)
    settle(page)
    row = field(page, "longest")
    row.locator("input[type=text]").fill("3.99")
    settle(page)
    told = page.inner_text("#notes")
    assert "assertion failed at t = 4 s: it took 0.01 s too long" in told
    assert 'assert(x < longest, "it took " + String(x - longest) + " s too long");' in told
    assert page.evaluate("planarcPlayer.reader.stop") == 4.0


@pytest.mark.parametrize("dark", [False, True])
def test_a_phone_shows_it(
    four_bar: Path, open_page: Callable[..., Any], screenshot: Callable[..., Path], dark: bool
) -> None:
    page = open_page(four_bar, PHONE, dark=dark)
    settle(page)
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE[0]
    slide(page, "crank.r[1]", 0.3)
    settle(page)
    assert angle(page, 1.0) == pytest.approx(wanted(0.3, 1.0), abs=1e-6)
    screenshot(page, f"own-page-phone{'-dark' if dark else ''}")
