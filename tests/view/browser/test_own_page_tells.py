"""What a page that runs its model itself tells of a run: events, peaks, warnings, its end."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planarc
from planarc.api.result import Result, RunStopped
from planarc.export.page.page import make_page
from planarc.stages import study
from planarc.view.page.typeset import number, typeset, unit
from tests.view.browser.conftest import settle
from tests.view.browser.test_live import field

ROOT = Path(__file__).parents[3]

BALL = """
model Ball "Falls on a plate and is thrown up again"
  parameter Real e(min=0, max=1)=0.8 "What a bounce leaves of the velocity";
  parameter Integer most=3 "Bounces until it rests";
  Real h(start=1, fixed=true), v(start=0, fixed=true);
  Integer n(start=0, fixed=true);
  Boolean ticked(start=false, fixed=true);
equation
  der(h) = v;
  der(v) = -9.81;
  when h < 0 then
    reinit(v, -e*pre(v));
    n = pre(n) + 1;
  end when;
  when sample(0.25, 0.5) then
    ticked = not pre(ticked);
  end when;
  when n >= most then
    terminate("bounce " + String(n) + " of " + String(most) + ", e = " + String(e, format=".2f"));
  end when;
  assert(v < 3, "v is " + String(v) + " m/s", AssertionLevel.warning);
  assert(e > 0.05, "e = " + String(e) + " leaves nothing");
  annotation(experiment(StopTime=2, Tolerance=1e-9));
end Ball;
"""
#: What acts on the page through its texts, were they markup.
EVIL = "</script><script>window.pwned=1</script><img src=x onerror=window.pwned=2>"


@cache
def model_of(text: str) -> planarc.Model:
    return planarc.load(text)


@pytest.fixture
def open_model(open_page: Callable[..., Any], tmp_path: Path) -> Callable[[str], Any]:
    """`open_model(text or path)` opens the page of a model, its first run done."""

    def opened(text: str) -> Any:
        model = model_of(text)
        path = tmp_path / "page.html"
        path.write_text(make_page(model.compiled(), model.simulate().rows).text, "utf-8")
        page = open_page(path)
        settle(page)
        return page

    return opened


def give(page: Any, name: str, value: float) -> None:
    field(page, name).locator("input[type=text]").fill(str(value))
    settle(page)


def events_of(page: Any) -> list[tuple[float, str]]:
    lines = page.locator("#events li").all()
    return [
        (float(line.locator("button").inner_text().removesuffix(" s")),
         line.locator("span").inner_text())
        for line in lines
    ]  # fmt: skip


def told_by(result: Result) -> list[tuple[float, str]]:
    return [(e.time, typeset(", ".join(e.causes)).replace("`", "")) for e in result.rows.events]


def assert_same_events(page: Any, result: Result) -> None:
    found, wanted = events_of(page), told_by(result)
    assert [text for _, text in found] == [text for _, text in wanted]
    assert [t for t, _ in found] == pytest.approx([t for t, _ in wanted], rel=2e-6)
    marks = page.locator(".marks i").count()
    assert marks == len({round(t, 9) for t, _ in wanted})


def test_events_are_listed_and_marked_for_each_run(open_model: Callable[[str], Any]) -> None:
    page = open_model(BALL)
    assert_same_events(page, model_of(BALL).simulate())
    assert "sample(0.25, 0.5)" in page.inner_text("#events")
    give(page, "e", 0.3)
    assert_same_events(page, model_of(BALL).simulate(parameters={"e": 0.3}))
    first, _ = events_of(page)[1]
    page.evaluate("planarcPlayer.pause()")
    page.locator("#events button").nth(1).click()
    assert page.evaluate("planarcPlayer.time") == pytest.approx(first, rel=1e-5)


def test_jumps_stand_where_they_are(open_model: Callable[[str], Any]) -> None:
    """Rows before and behind an event have its time: nothing is drawn between."""
    page = open_model(BALL)
    found = page.evaluate(
        """() => {
          const { time } = planarcPlayer.reader;
          return Array.from(time).filter((t, i) => time[i + 1] === t);
        }"""
    )
    result = model_of(BALL).simulate()
    assert found == pytest.approx([e.time for e in result.rows.events], rel=1e-7)


def test_touches_are_told_as_planarc_tells_them(open_model: Callable[[str], Any]) -> None:
    name = str(ROOT / "examples" / "cam_lift_off.pmo")
    page, result = open_model(name), model_of(name).simulate()

    def strong(told: list[tuple[float, str]]) -> list[tuple[float, str]]:
        """The blows that are more than a tremble; of these planarc is less exact than the page."""
        return [(t, s) for t, s in told if "impact of 0.0" not in s and "rests" not in s]

    found, wanted = strong(events_of(page)), strong(told_by(result))
    assert [text for _, text in found] == [text for _, text in wanted]
    assert [t for t, _ in found] == pytest.approx([t for t, _ in wanted], abs=1e-4)
    assert any("impact of" in text and "N·s" in text for _, text in found)


def test_an_impact_is_told_once(open_model: Callable[[str], Any]) -> None:
    """Where nothing strikes, what touched last still has its impulse."""
    name = str(ROOT / "examples" / "geneva_drive.pmo")
    told, wanted = events_of(open_model(name)), told_by(model_of(name).simulate())
    turns = [(round(t, 4), text) for t, text in wanted if " turn" in text]
    assert turns and [(round(t, 4), text) for t, text in told if " turn" in text] == turns


def test_components_name_their_events(open_model: Callable[[str], Any]) -> None:
    text = """
    model Slip
      import Modelica.Units.SI;
      inner PlanarMultiBody.World world;
      model Grip "Holds until it is pulled too hard"
        extends PlanarMultiBody.Interfaces.PartialOneFrame_a;
        parameter Real most=2;
        Boolean holds = time < most;
      equation
        frame_a.f = {0, 0};
        frame_a.t = 0;
        annotation(__planarc(event('lets go' = not holds)));
      end Grip;
      Grip grip;
      PlanarMultiBody.Joints.Revolute joint(phi(start=0, fixed=true), w(start=1, fixed=true));
      PlanarMultiBody.Parts.Body body(m=1, r_CM={0.5, 0});
    equation
      connect(world.frame_b, joint.frame_a);
      connect(joint.frame_b, body.frame_a);
      connect(body.frame_a, grip.frame_a);
      annotation(experiment(StopTime=3));
    end Slip;
    """
    page = open_model(text)
    assert_same_events(page, model_of(text).simulate())
    assert page.inner_text("#events").split("\n")[-1] == "grip lets go"
    give(page, "grip.most", 1.5)
    assert events_of(page) == [(1.5, "grip lets go")]
    give(page, "grip.most", 4)
    assert not page.locator("#events").is_visible()


def test_peaks_are_those_of_the_run_that_is_shown(open_model: Callable[[str], Any]) -> None:
    name = str(ROOT / "examples" / "four_bar.pmo")
    page = open_model(name)

    def assert_same(result: Result) -> None:
        rows = [line.inner_text().split("\t") for line in page.locator("#peaks tr").all()[1:]]
        peaks = study(result.rows).peaks
        assert [row[0] for row in rows] == [p.name for p in peaks]
        for (_, *told, kind), p in zip(rows, peaks, strict=True):
            assert kind.strip() == unit(p.unit)
            numbers = [float(text.replace("−", "-")) for text in told]
            assert numbers == pytest.approx([p.value, p.time, p.rms], rel=2e-3)
            assert len(told[0]) == len(number(p.value))

    assert_same(model_of(name).simulate(tolerance=1e-9))
    give(page, "crank.r[1]", 0.3)
    assert_same(model_of(name).simulate(parameters={"crank.r[1]": 0.3}, tolerance=1e-9))


def test_warnings_are_told_with_their_values(open_model: Callable[[str], Any]) -> None:
    page, model = open_model(BALL), model_of(BALL)
    (warned,) = model.simulate().rows.warnings
    told = page.locator("#notes .warning").inner_text()
    assert told.split(" (")[0] == warned.message.split(" (")[0]
    assert "(once, " in told and told.endswith(" s in all)")
    give(page, "e", 0.3)
    assert page.locator("#notes .warning").count() == 0
    assert not model.simulate(parameters={"e": 0.3}).rows.warnings


def test_an_end_that_the_model_wants_is_a_remark(open_model: Callable[[str], Any]) -> None:
    page, model = open_model(BALL), model_of(BALL)
    give(page, "e", 0.3)
    result = model.simulate(parameters={"e": 0.3})
    assert result.rows.ended is not None
    remark = page.locator("#notes .remark").inner_text()
    assert remark == result.rows.ended.message
    assert remark.endswith("bounce 3 of 3, e = 0.30")
    assert page.locator(".state.wrong").count() == 0
    assert page.evaluate("planarcPlayer.reader.stop") == pytest.approx(result.time[-1], rel=1e-7)


def test_parameters_that_cannot_be_are_named(open_model: Callable[[str], Any]) -> None:
    page, model = open_model(BALL), model_of(BALL)
    give(page, "e", 0.01)
    with pytest.raises(RunStopped) as stopped:
        model.simulate(parameters={"e": 0.01})
    message = stopped.value.diagnostics[0].message
    assert page.inner_text("#notes .error").startswith(message)
    assert "e = 0.01 leaves nothing" in message


def test_bodies_that_overlap_are_named_with_their_depth(open_model: Callable[[str], Any]) -> None:
    text = "model Drop extends PlanarMultiBody.Examples.Contacts.BouncingBall; end Drop;"
    page, model = open_model(text), model_of(text)
    assert field(page, "ball.frame_a.r[2].start").count() == 1
    give(page, "ball.frame_a.r[2].start", 0.0123)
    with pytest.raises(planarc.PlanarcError) as stopped:
        model.simulate(start={"ball.frame_a.r[2]": 0.0123})
    told = stopped.value.diagnostics[0].message
    assert page.inner_text("#notes .error").startswith(told.replace("`", ""))
    assert re.search("overlap by 0[.]0[0-9]+ m", told)


def test_texts_of_a_model_stay_texts(open_model: Callable[[str], Any]) -> None:
    text = f"""
    model 'a<b>"c' "{EVIL.replace('"', "'")}"
      parameter Real '<img src=x onerror=window.pwned=3>'=1 "{EVIL}";
      Real x(start=0, fixed=true);
      Boolean above = x > '<img src=x onerror=window.pwned=3>' "{EVIL}";
    equation
      der(x) = 1;
      assert(x < 1.5, "{EVIL}" + String(x), AssertionLevel.warning);
      when x > 1.8 then
        terminate("{EVIL}");
      end when;
      annotation(experiment(StopTime=2));
    end 'a<b>"c';
    """
    page = open_model(text)
    assert EVIL in page.inner_text("#notes .warning")
    assert EVIL in page.inner_text("#notes .remark")
    assert "onerror" in page.inner_text("#events")
    assert page.evaluate("window.pwned") is None
    assert page.locator("img").count() == 0


def test_numbers_are_written_as_c_writes_them(open_model: Callable[[str], Any]) -> None:
    page = open_model(BALL)
    values = [0.0, 1.0, -2.5, 1e-5, 123456.7, 1234567.0, 9.9999995, -1.5e-12, 3.14159265, 1e20]
    assert page.evaluate("(v) => v.map((x) => planarc.general(x))", values) == [
        f"{v:g}" for v in values
    ]
    assert np.isfinite(values).all()
