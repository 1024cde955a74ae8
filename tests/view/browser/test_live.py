"""The live page in a real browser: what is moved is run and drawn, errors stand at their field."""

from __future__ import annotations

import re
from collections.abc import Callable
from math import cos, sin
from pathlib import Path
from typing import Any

import pytest

import planarc
from planarc.request.request import Request
from tests.view.browser.conftest import settle, until

ROOT = Path(__file__).parents[3]
CAM = "PlanarMultiBody.Examples.CurveCurveJoint.CamFollower"
DESKTOP, TABLET, PHONE = (1400, 860), (1000, 800), (390, 844)

#: Where a component is drawn at a time (s).
POSE = """async ([component, time]) => {
  planarcPlayer.pause();
  planarcPlayer.setTime(time);
  return planarcPlayer.pose(component);
}"""


@pytest.fixture
def four_bar(tmp_path: Path) -> Request:
    """A copy, which may be edited."""
    file = tmp_path / "four_bar.pmo"
    file.write_text((ROOT / "examples" / "four_bar.pmo").read_text("utf-8"), "utf-8")
    return Request(file)


def field(page: Any, name: str) -> Any:
    """The row of a field, its groups opened."""
    row = page.locator(f'.field[data-name="{name}"]')
    row.evaluate(
        """(row) => {
          let box = row.closest("details");
          for (; box; box = box.parentElement.closest("details")) box.open = true;
        }"""
    )
    return row


def slide(page: Any, name: str, value: float) -> None:
    """Move a slider as a finger does: many small steps."""
    slider = field(page, name).locator("input.slide")
    slider.evaluate(
        """(s, end) => {
          const begin = Number(s.value);
          for (let i = 1; i <= 10; i++) {
            s.value = begin + (end - begin) * i / 10;
            s.dispatchEvent(new Event("input", { bubbles: true }));
          }
        }""",
        value,
    )
    settle(page)


def test_a_slider_moves_the_mechanism_to_where_a_run_says(
    open_page: Callable[..., Any],
    serve: Callable[..., Any],
    four_bar: Request,
    screenshot: Callable[..., Path],
) -> None:
    page = open_page(serve(four_bar).address, DESKTOP)
    settle(page)
    before = page.evaluate("planarcPlayer.reader.time.length")
    slide(page, "crank.r[1]", 0.3)
    assert field(page, "crank.r[1]").locator("input[id]").input_value() == "0.3"
    result = planarc.load(str(four_bar.file)).simulate(parameters={"crank.r[1]": 0.3})
    assert before > 100
    for time in (0.0, 0.5, 2.2):
        pose = page.evaluate(POSE, ["coupler.shape", time])
        angle = float(result.at("revA.phi", time))
        assert (pose["x"], pose["y"]) == pytest.approx(
            (0.3 * cos(angle), 0.3 * sin(angle)), abs=2e-3
        )
    delays = page.evaluate("planarcLive.delays")
    assert delays
    screenshot(page, "live-four-bar")


def test_a_slider_changes_the_curve(
    open_page: Callable[..., Any], serve: Callable[..., Any], four_bar: Request
) -> None:
    page = open_page(serve(four_bar).address, DESKTOP)
    settle(page)
    shown = """() => {
      const panel = document.querySelector('#plots canvas');
      return panel.toDataURL();
    }"""
    legend = page.locator("#plots").inner_text()
    assert "revA.phi" in legend
    first = page.evaluate(shown)
    slide(page, "couplerBody.m", 4.5)
    assert page.evaluate(shown) != first
    page.locator("#reset").click()
    settle(page)
    assert page.locator(".field.changed").count() == 0
    page.evaluate("planarcPlayer.pause()")
    assert page.evaluate(shown) == first


def test_start_values_are_moved_in_degrees(
    open_page: Callable[..., Any], serve: Callable[..., Any], four_bar: Request
) -> None:
    page = open_page(serve(four_bar).address, DESKTOP)
    settle(page)
    number = field(page, "revA.phi.start").locator("input[id]")
    number.fill("30")
    settle(page)
    pose = page.evaluate(POSE, ["crank.shape", 0.0])
    assert pose["angle"] == pytest.approx(0.5235988, abs=1e-5)


def test_errors_stand_beside_the_field(
    open_page: Callable[..., Any],
    serve: Callable[..., Any],
    four_bar: Request,
    screenshot: Callable[..., Path],
) -> None:
    page = open_page(serve(four_bar).address, DESKTOP)
    settle(page)
    row = field(page, "crankBody.m")
    row.locator("input[id]").fill("-2")
    assert row.locator(".error").inner_text() == "at least 0 kg"
    assert page.locator("#state").inner_text() == "m: at least 0 kg"
    row.locator("input[id]").fill("heavy")
    assert row.locator(".error").inner_text() == "not a number"
    row.locator("input[id]").fill("2,5")
    settle(page)
    assert row.locator(".error").is_hidden()
    # A rod so long that the loop cannot be closed: the run says so, beside the rod.
    rod = field(page, "coupler.r[1]")
    rod.locator("input[id]").fill("9")
    settle(page)
    assert rod.locator(".error").is_visible()
    assert "cannot be assembled" in page.locator("#state").inner_text()
    screenshot(page, "live-error")
    rod.locator("button.again").click()
    settle(page)
    assert rod.locator(".error").is_hidden()
    assert page.locator("#state").inner_text().startswith("simulated in ")


def test_an_error_fits_a_phone(
    open_page: Callable[..., Any], serve: Callable[..., Any], four_bar: Request
) -> None:
    page = open_page(serve(four_bar).address, PHONE)
    settle(page)
    field(page, "coupler.r[1]").locator("input[id]").fill("9")
    settle(page)
    assert "cannot be assembled" in page.locator("#state").inner_text()
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE[0]


def test_replaceable_curves_are_menus(
    open_page: Callable[..., Any], serve: Callable[..., Any], screenshot: Callable[..., Path]
) -> None:
    """The paper's figure 5: another curve is chosen, and its own parameters appear."""
    page = open_page(serve(Request(None, CAM)).address, DESKTOP)
    settle(page)
    screenshot(page, "live-cam")
    menu = field(page, "=contact.curve1").locator("select")
    menu.select_option(label="Circle")
    settle(page)
    assert "compiled again in" in page.locator("#notes").inner_text()
    assert page.locator('.field[data-name="contact.curve1.a"]').count() == 0
    slide(page, "contact.curve1.R", 0.3)
    assert page.locator("#state").inner_text().startswith("simulated in ")
    screenshot(page, "live-cam-circle")
    # A circle about its own centre does not lift: the follower stays at the height R.
    for time in (0.0, 1.0, 3.0):
        assert page.evaluate(POSE, ["follower.centre", time])["y"] == pytest.approx(0.3, abs=1e-5)


def test_structural_values_compile_again_and_say_so(
    open_page: Callable[..., Any], serve: Callable[..., Any], four_bar: Request
) -> None:
    page = open_page(serve(four_bar).address, DESKTOP)
    settle(page)
    field(page, "revA.w.start").locator("input[id]").fill("0")
    settle(page)
    field(page, "world.gravityType").locator("select").select_option(label="NoGravity")
    settle(page)
    assert "world.gravityType is structural: compiled again" in page.locator("#notes").inner_text()
    # From rest and without gravity nothing moves.
    poses = [page.evaluate(POSE, ["crank.shape", t])["angle"] for t in (0.0, 2.0)]
    assert poses == pytest.approx([1.0, 1.0], abs=1e-6)


def test_an_edited_file_is_followed(
    open_page: Callable[..., Any],
    serve: Callable[..., Any],
    four_bar: Request,
    screenshot: Callable[..., Path],
) -> None:
    page = open_page(serve(four_bar).address, DESKTOP)
    settle(page)
    assert four_bar.file is not None
    text = four_bar.file.read_text("utf-8")
    four_bar.file.write_text(
        text.replace("FixedTranslation crank(r={0.4, 0})", "FixedTranslation crank(r={0.35, 0})"),
        "utf-8",
    )
    number = field(page, "crank.r[1]").locator("input[id]")
    until(page, "document.querySelector('.field[data-name=\"crank.r[1]\"] input').value === '0.35'")
    settle(page)
    four_bar.file.write_text(text.replace("connect(revA", "conect(revA", 1), "utf-8")
    page.wait_for_selector("#notes pre")
    assert "four_bar.pmo" in page.locator("#notes pre").first.inner_text()
    # However long its lines are, the message does not widen the page.
    assert page.evaluate("document.documentElement.scrollWidth") <= DESKTOP[0]
    screenshot(page, "live-broken-file")
    four_bar.file.write_text(text, "utf-8")
    until(page, "!document.querySelector('#notes pre')")
    settle(page)
    assert number.input_value() == "0.4"


def test_before_a_long_run_the_start_of_the_edited_model_is_shown(
    open_page: Callable[..., Any], serve: Callable[..., Any], four_bar: Request
) -> None:
    assert four_bar.file is not None
    text = four_bar.file.read_text("utf-8")
    page = open_page(serve(four_bar).address, DESKTOP)
    settle(page)
    # However fast this machine is: the page believes that a run took a second.
    page.evaluate(
        """() => {
          const before = window.fetch;
          window.orders = [];
          window.fetch = async (url, given) => {
            const order = JSON.parse(given.body);
            const response = await before(url, given);
            const answer = await response.json();
            const { scene } = answer;
            window.orders.push([order.still, planarcPlayer.time, planarc.times(scene.time).length]);
            return { ok: true, json: async () => ({ ...answer, seconds: 1.0 }) };
          };
        }"""
    )
    page.evaluate("planarcPlayer.pause(); planarcPlayer.setTime(1.25)")
    slide(page, "crank.r[1]", 0.38)
    page.evaluate("window.orders.length = 0")
    four_bar.file.write_text(text.replace("coupler(r={0.9", "coupler(r={0.92"), "utf-8")
    until(page, "window.orders.length === 2")
    settle(page)
    (still, _, rows), (whole, shown, all_rows) = page.evaluate("window.orders")
    assert (still, rows, whole, shown) == (True, 1, False, 0.0)
    assert all_rows > 100
    assert page.evaluate("planarcPlayer.time") == pytest.approx(1.25)


def test_what_is_on_the_page_can_be_kept(
    open_page: Callable[..., Any], serve: Callable[..., Any], four_bar: Request, tmp_path: Path
) -> None:
    page = open_page(serve(four_bar).address, DESKTOP)
    settle(page)
    slide(page, "crank.r[1]", 0.3)
    for ending, begin in (("svg", "<svg"), ("csv", '"time [s]"'), ("html", "<!doctype html>")):
        page.locator("#keep summary").click()
        with page.expect_download() as download:
            page.locator(f'#keep button[data-ending="{ending}"]').click()
        path = tmp_path / f"kept.{ending}"
        download.value.save_as(path)
        assert download.value.suggested_filename == f"FourBar.{ending}"
        assert path.read_text("utf-8").startswith(begin)
    # The kept report is a page of its own, of the run with the moved slider.
    report = open_page(tmp_path / "kept.html")
    until(report, "window.planarcPlayer")
    pose = report.evaluate(POSE, ["coupler.shape", 0.0])
    assert pose["x"] == pytest.approx(0.3 * cos(1.0), abs=1e-5)


def test_wrong_tokens_see_nothing(
    open_page: Callable[..., Any], serve: Callable[..., Any], four_bar: Request, watch: Any
) -> None:
    live = serve(four_bar)
    watch.allowed = ["403"]
    page = open_page(f"http://127.0.0.1:{live.port}/{'x' * len(live.token)}/")
    assert "wrong token" in page.locator("body").inner_text()
    assert "FourBar" not in page.content()


def test_another_sites_page_is_refused(
    browser: Any, serve: Callable[..., Any], four_bar: Request
) -> None:
    """Even one that somehow knows the whole address gets nothing, in all ways a page can ask."""
    live = serve(four_bar)
    other = browser.new_context()
    page = other.new_page()
    page.route(
        "http://localhost/evil.html",
        lambda route: route.fulfill(
            body="<!doctype html><title>evil</title>", content_type="text/html"
        ),
    )
    page.goto("http://localhost/evil.html")
    tried = page.evaluate(
        """async (address) => {
          const kind = { "Content-Type": "application/json" };
          const ways = {
            simple: ["run", { method: "POST", body: "{}" }],
            json: ["run", { method: "POST", headers: kind, body: "{}" }],
            read: ["", {}],
            blind: ["run", { method: "POST", mode: "no-cors", body: "{}" }],
          };
          const found = {};
          for (const [name, [place, options]] of Object.entries(ways)) {
            try {
              found[name] = await (await fetch(address + place, options)).text();
            } catch (problem) {
              found[name] = "refused";
            }
          }
          return found;
        }""",
        live.address,
    )
    assert tried == dict.fromkeys(("simple", "json", "read", "blind"), "refused")
    frame = page.evaluate(
        """(address) => new Promise((done) => {
          const frame = document.createElement("iframe");
          frame.onload = () => {
            try {
              done(frame.contentDocument ? frame.contentDocument.body.innerText : "closed");
            } catch {
              done("closed");
            }
          };
          frame.src = address;
          document.body.append(frame);
        })""",
        live.address,
    )
    assert frame == "closed"
    other.close()


def test_the_end_of_the_server_is_told(
    open_page: Callable[..., Any], serve: Callable[..., Any], four_bar: Request
) -> None:
    live = serve(four_bar)
    page = open_page(live.address, DESKTOP)
    settle(page)
    live.stop()
    page.wait_for_selector("#notes .error")
    assert "does not answer any more" in page.locator("#notes").inner_text()


@pytest.mark.parametrize(
    ("name", "size", "dark"),
    [
        ("dark", DESKTOP, True),
        ("tablet", TABLET, False),
        ("phone", PHONE, False),
        ("phone-dark", PHONE, True),
    ],
)
def test_the_page_fits_every_screen(
    name: str,
    size: tuple[int, int],
    dark: bool,
    open_page: Callable[..., Any],
    serve: Callable[..., Any],
    four_bar: Request,
    screenshot: Callable[..., Path],
) -> None:
    page = open_page(serve(four_bar).address, size, dark)
    settle(page)
    assert page.evaluate("document.documentElement.scrollWidth") <= size[0]
    color = page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert (sum(int(n) for n in re.findall(r"\d+", color)) < 300) is dark
    screenshot(page, f"live-{name}")
    if size == PHONE:
        page.mouse.wheel(0, 700)
        until(page, "window.scrollY > 100")
        # The mechanism stays in sight while the sliders are moved.
        box = page.locator("#player canvas").bounding_box()
        assert box["y"] >= 0
        assert box["y"] + box["height"] < size[1] * 0.6
        screenshot(page, f"live-{name}-fields")


def test_a_run_is_kept_beside_what_comes(
    open_page: Callable[..., Any], serve: Callable[..., Any], four_bar: Request
) -> None:
    page = open_page(serve(four_bar).address, DESKTOP)
    settle(page)
    assert page.locator("#runs").is_hidden()
    page.click("#hold")
    slide(page, "crank.r[1]", 0.3)
    assert page.locator("#runs .chip").all_inner_texts() == [
        "crank.r[1] = 0.3 m",
        "as the file says",
    ]
    assert " | " in page.locator(".legend b").first.inner_text()
    page.locator("#runs .remove").click()
    assert page.locator("#runs").is_hidden()
