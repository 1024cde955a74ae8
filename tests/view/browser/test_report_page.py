"""The report in a real browser: it plays, seeks, zooms, and shows what the result says."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planarc
from planarc.cli.job import write_page
from planarc.view.scene import make_scene

FOUR_BAR = "PlanarMultiBody.Examples.Loops.FourBar"
CAM = "PlanarMultiBody.Examples.CurveCurveJoint.CamFollower"
PHONE = (390, 844)

Opener = Callable[..., Any]


@pytest.fixture(scope="module")
def results() -> Callable[[str], Any]:
    known: dict[str, Any] = {}

    def of(name: str) -> Any:
        if name not in known:
            model = planarc.load(name)
            known[name] = model.simulate().rows, model.compiled().load()
        return known[name]

    return of


@pytest.fixture
def report(results: Callable[[str], Any], open_page: Opener, tmp_path: Path) -> Callable[..., Any]:
    def make(name: str = FOUR_BAR, **options: Any) -> tuple[Any, Any]:
        result, kernel = results(name)
        path = tmp_path / "report.html"
        write_page(path, result, kernel)
        page = open_page(path, **options)
        wait(page, "window.planarcPlayer !== undefined")
        return page, result

    return make


def wait(page: Any, condition: str, argument: Any = None) -> None:
    """Until it holds. (playwright's own waiting needs `eval`, which the page forbids.)"""
    for _ in range(6000):
        if page.evaluate(f"(a) => {condition}", argument):
            return
        page.wait_for_timeout(50)
    raise AssertionError(f"in vain: {condition}")


def next_frame(page: Any) -> None:
    """Until what was done last is drawn."""
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


def pose(page: Any, component: str) -> Any:
    return page.evaluate("name => planarcPlayer.pose(name)", component)


def test_the_slider_moves_the_mechanism_to_the_positions_of_the_result(
    report: Callable[..., Any],
) -> None:
    page, result = report()
    for t in (0.0, 1.37, 6.2, 10.0):
        page.evaluate(
            """t => {
              const slider = document.querySelector("input.time");
              slider.value = t;
              slider.dispatchEvent(new Event("input"));
            }""",
            t,
        )
        wait(page, "Math.abs(planarcPlayer.time - a) < 1e-9", t)
        shown = pose(page, "rocker.frameTranslation.shape")
        angle = np.interp(t, result.time, result["rocker.body.phi"])
        assert shown["angle"] == pytest.approx(angle, abs=1e-5)
        assert (shown["x"], shown["y"]) == pytest.approx((1.0, 0.0), abs=1e-6)
        # Drawn with the next frame:
        wait(page, "document.querySelector('output.clock').textContent.includes(a)", f"{t:.2f} s")


def test_it_plays_pauses_and_steps_by_keys_alone(report: Callable[..., Any]) -> None:
    page, _ = report()
    page.keyboard.press("Space")
    wait(page, "planarcPlayer.time > 0.1")
    page.keyboard.press("Space")
    assert page.evaluate("planarcPlayer.playing") is False
    page.keyboard.press("Home")
    page.keyboard.press("ArrowRight")
    assert page.evaluate("planarcPlayer.time") == pytest.approx(0.05)
    page.keyboard.press("Shift+ArrowRight")
    assert page.evaluate("planarcPlayer.time") == pytest.approx(0.55)
    page.keyboard.press("End")
    assert page.evaluate("planarcPlayer.time") == pytest.approx(10.0)


def test_zoom_and_pan_keep_what_is_under_the_pointer_and_fit_shows_all(
    report: Callable[..., Any],
) -> None:
    page, _ = report()
    first = page.evaluate("({...planarcPlayer.view})")
    box = page.locator("canvas.stage").bounding_box()
    page.mouse.move(box["x"] + 100, box["y"] + 100)
    page.mouse.wheel(0, -400)
    wait(page, "planarcPlayer.view.scale > 1.5 * a", first["scale"])
    near = page.evaluate("({...planarcPlayer.view})")
    dx, dy = 100 - box["width"] / 2, 100 - box["height"] / 2
    for view in (first, near):
        view["under"] = (view["x"] + dx / view["scale"], view["y"] - dy / view["scale"])
    assert near["under"] == pytest.approx(first["under"], abs=0.02)
    page.mouse.down()
    page.mouse.move(box["x"] + 160, box["y"] + 70)
    page.mouse.up()
    moved = page.evaluate("({...planarcPlayer.view})")
    assert moved["x"] == pytest.approx(near["x"] - 60 / near["scale"])
    assert moved["y"] == pytest.approx(near["y"] - 30 / near["scale"])
    page.keyboard.press("f")
    assert page.evaluate("({...planarcPlayer.view})") == first_view(first)


def first_view(view: Any) -> Any:
    return {key: view[key] for key in ("x", "y", "scale")}


def test_a_click_in_a_curve_goes_there_and_the_line_follows(report: Callable[..., Any]) -> None:
    page, result = report()
    plot = page.locator(".u-over").first
    box = plot.bounding_box()
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    wait(page, "planarcPlayer.time > 1")
    time = page.evaluate("planarcPlayer.time")
    assert time == pytest.approx(5.0, abs=0.05)
    page.mouse.move(5, 5)
    next_frame(page)
    told = page.locator(".legend b").first.inner_text()
    angle = np.degrees(np.interp(time, result.time, result["revA.phi"]))
    assert float(told.split()[0].replace("−", "-")) == pytest.approx(angle, rel=2e-3)
    line = page.locator(".now").first.bounding_box()
    assert line["x"] + line["width"] / 2 == pytest.approx(box["x"] + box["width"] / 2, abs=3)


def test_a_searched_variable_becomes_a_curve(report: Callable[..., Any]) -> None:
    page, _ = report()
    page.locator("#variables > summary").click()
    page.get_by_label("Search variables").fill("coupler.body.w")
    page.locator("#tree label", has_text="coupler.body.w").first.locator("input").check()
    chosen = page.locator(".figure", has_text="Chosen")
    assert "rad/s" in chosen.inner_text()
    # Letters typed into the search are no commands.
    assert page.evaluate("planarcPlayer.playing") is False


def test_layers_are_drawn_where_the_numbers_say(report: Callable[..., Any]) -> None:
    page, result = report()
    page.evaluate("planarcPlayer.setTime(2.0); planarcPlayer.setLayer('velocities', true)")
    mark = page.evaluate(
        """() => {
          const layer = planarcPlayer.layers.find((l) => l.id === "velocities");
          const m = layer.members.find((m) => m.name === "coupler.body centre");
          planarcPlayer.reader.seek(2.0);
          return ["x", "y", "u", "v"].map((k) => planarcPlayer.reader.at(m[k]));
        }"""
    )
    names = [f"coupler.body.{v}[{i}]" for v in ("r_0CM", "v_CM") for i in (1, 2)]
    row = int(np.argmin(abs(result.time - 2.0)))
    assert mark == pytest.approx([result[n][row] for n in names], rel=1e-5)
    page.get_by_role("button", name="Paths").click()
    assert page.get_by_role("button", name="Paths").get_attribute("aria-pressed") == "true"


def test_a_key_tells_how_long_the_forces_are_that_components_draw(
    report: Callable[..., Any],
) -> None:
    page, result = report("PlanarMultiBody.Examples.Loops.PistonEngine")
    next_frame(page)
    key = page.locator(".chips .key[title]")
    value, _, unit = key.inner_text().partition(" ")
    wide = page.evaluate(
        """() => document.querySelector(".chips .key[title] b").getBoundingClientRect().width"""
    )
    scale = page.evaluate("planarcPlayer.view.scale")
    metres = make_scene(result).scales[0].metres
    assert unit == "N"
    assert 20 < wide == pytest.approx(float(value) * metres * scale, rel=1e-3)
    page.evaluate("document.querySelector('button[title^=\"Zoom in\"]').click()")
    next_frame(page)
    assert 20 < key.locator("b").bounding_box()["width"] <= 61


def test_an_impact_is_listed_and_leads_to_its_instant(report: Callable[..., Any]) -> None:
    page, result = report("PlanarMultiBody.Examples.Elementary.BouncingMass")
    first = page.locator("#events button").first
    first.click()
    assert page.evaluate("planarcPlayer.time") == pytest.approx(result.events[0].time, abs=1e-4)


def test_events_are_told_as_print_has_them(report: Callable[..., Any]) -> None:
    page, _ = report("PlanarMultiBody.Examples.Contacts.NewtonsCradle")
    told = page.locator("#events span").first
    assert re.search(r"impact of [\d.]+ N·s", told.inner_text())
    assert "`" not in page.locator("#events").inner_text()
    assert told.locator("code").first.inner_text() == "contact[1]"


def test_dark_and_light_follow_the_screen_and_the_switch(
    report: Callable[..., Any], screenshot: Callable[..., Path]
) -> None:
    page, _ = report(CAM, dark=True)
    ground = "getComputedStyle(document.body).backgroundColor"
    dark = page.evaluate(ground)
    screenshot(page, "report-cam-dark", whole=True)
    page.locator("#theme").click()
    assert page.evaluate(ground) != dark
    screenshot(page, "report-cam-light", whole=True)


def test_a_phone_shows_the_page_without_scrolling_sideways(
    report: Callable[..., Any], screenshot: Callable[..., Path]
) -> None:
    page, _ = report(size=PHONE)
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE[0]
    stage = page.locator("canvas.stage").bounding_box()
    assert stage["y"] + stage["height"] < PHONE[1]
    screenshot(page, "report-phone", whole=True)


def test_a_model_cannot_run_a_script_in_its_page(open_page: Opener, tmp_path: Path) -> None:
    evil = "</script><script>window.pwned=1</script><img src=x onerror=window.pwned=2>"
    text = f"""
      model 'a<b>"c' "{evil.replace('"', "'")}"
        inner PlanarMultiBody.World world(label1="{evil}", label2="</canvas>");
        PlanarMultiBody.Joints.Revolute 'j</script><img src=x onerror=window.pwned=3>'(
          phi(start=1, fixed=true), w(fixed=true));
        PlanarMultiBody.Parts.BodyShape '"><svg onload=window.pwned=4>'(r={{1, 0}}, m=1);
        Real x = time "{evil}";
      equation
        connect(world.frame_b, 'j</script><img src=x onerror=window.pwned=3>'.frame_a);
        connect('j</script><img src=x onerror=window.pwned=3>'.frame_b,
          '"><svg onload=window.pwned=4>'.frame_a);
      end 'a<b>"c';
    """
    model = planarc.load(text)
    path = tmp_path / "evil.html"
    write_page(path, model.simulate().rows, model.compiled().load())
    page = open_page(path)
    page.locator("#variables > summary").click()
    page.get_by_label("Search variables").fill("pwned")
    page.evaluate("for (const l of planarcPlayer.layers) planarcPlayer.setLayer(l.id, true)")
    next_frame(page)
    assert page.evaluate("window.pwned") is None
    assert page.locator("img, svg[onload]").count() == 0


def test_a_result_without_a_model_shows_curves_alone(
    open_page: Opener, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from planarc.cli.app import run

    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.csv").write_text("time,h,v\n0,1,2\n1,2,3\n2,0,1\n", encoding="utf-8")
    assert run(["view", "a.csv", "--no-open", "-q"]) == 0
    page = open_page(tmp_path / "a.html")
    assert page.locator(".figure").count() == 1
    assert "numbers only" in page.locator(".notes").first.inner_text()


def test_the_gallery_moves(
    open_page: Opener, tmp_path: Path, screenshot: Callable[..., Path], monkeypatch: Any
) -> None:
    from planarc.cli.app import run

    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.pmo").write_text(
        "model bad Real x = 1/0; Real y = z; annotation(experiment(StopTime=1)); end bad;",
        encoding="utf-8",
    )
    arguments = ["PlanarMultiBody.Examples.Elementary", "bad.pmo", "-o", "g.html", "-q"]
    assert run(["gallery", *arguments]) == 1
    page = open_page(tmp_path / "g.html")
    wait(page, "planarcPlayers.some((p) => p.time > 0.05)")
    assert page.locator("article").count() == 10
    assert page.locator(".problem").count() == 1
    screenshot(page, "gallery")


#: Colours that lie in a margin of the canvas at some times of the run, but for those of the
#: stage, the grid and the ruler, which are all light.
AT_THE_EDGE = """async () => {
  const found = {};
  for (const [number, player] of planarcPlayers.entries()) {
    player.pause();
    const canvas = player.picture();
    const context = canvas.getContext("2d");
    const [w, h] = [canvas.width, canvas.height];
    const sides = [[0, 0, 5, h - 30], [w - 5, 0, 5, h - 30]];
    const strips = [[0, 0, w, 5], ...sides, [w / 2, h - 5, w / 2, 5]];
    for (let i = 0; i <= 12; i++) {
      player.setTime(player.reader.start + (player.reader.stop - player.reader.start) * i / 12);
      await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
      for (const strip of strips) {
        const data = context.getImageData(...strip).data;
        for (let k = 0; k < data.length; k += 4) {
          const pixel = [...data.slice(k, k + 3)];
          if (Math.min(...pixel) < 200) found[number] = pixel;
        }
      }
    }
  }
  return found;
}"""


def test_every_example_is_in_view_as_a_whole(
    open_page: Opener, tmp_path: Path, screenshot: Callable[..., Path], monkeypatch: Any
) -> None:
    from planarc.cli.app import run

    monkeypatch.chdir(tmp_path)
    examples = Path(__file__).parents[3] / "examples"
    assert run(["gallery", "PlanarMultiBody.Examples", str(examples), "-o", "g.html", "-q"]) == 0
    page = open_page(tmp_path / "g.html", size=(1600, 1000))
    assert page.locator("article").count() >= 25
    wait(page, "planarcPlayers.length >= 25")
    assert page.evaluate(AT_THE_EDGE) == {}
    # Each stage shows something: more than one colour that is not the stage's own.
    painted = page.evaluate(
        """() => planarcPlayers.map((player) => {
          const canvas = player.picture();
          const context = canvas.getContext("2d");
          const data = context.getImageData(0, 0, canvas.width, canvas.height).data;
          let dark = 0;
          for (let k = 0; k < data.length; k += 4) dark += data[k] < 150 || data[k + 1] < 150;
          return dark;
        })"""
    )
    assert min(painted) > 150
    screenshot(page, "gallery-all", whole=True)
