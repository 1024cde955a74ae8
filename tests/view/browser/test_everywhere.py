"""Every page in windows of three widths, light and dark, on paper, and by axe-core's rules.

axe-core says what keeps people from using a page by keys, by a screen reader, or with weak
eyes; what it calls serious or critical is a mistake.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from planarc.cli.app import run
from planarc.core.options import Backend
from planarc.live.server import LiveServer
from planarc.live.session import Session
from planarc.request.request import Request

EXAMPLES = Path(__file__).parents[3] / "examples"
VENDOR = Path(__file__).parent / "vendor"
WINDOWS = {"wide": (1920, 1080), "desktop": (1280, 800), "phone": (390, 844)}
PAGES = ("report", "runs", "handbook", "gallery", "live")

RULES = """async () => {
  const found = await axe.run(document, { resultTypes: ["violations"] });
  return found.violations
    .filter((v) => ["serious", "critical"].includes(v.impact))
    .map((v) => `${v.id}: ${v.nodes[0].html.slice(0, 200)}`);
}"""

#: Boxes of a page on paper, in the order of the page.
BOXES = """() => [...document.querySelectorAll(".player, .figure, .about .card")].map((e) => {
  const { left, top, right, bottom } = e.getBoundingClientRect();
  return { left, top, right, bottom, whole: getComputedStyle(e).breakInside };
})"""


@pytest.fixture(scope="module")
def places(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Path | str]]:
    folder = tmp_path_factory.mktemp("everywhere")
    files = {name: folder / f"{name}.html" for name in PAGES if name != "live"}
    four_bar = str(EXAMPLES / "four_bar.pmo")
    for name, length in (("a", 0.4), ("b", 0.3)):
        more = ["--no-report"] if name == "b" else ["--report", str(files["report"])]
        out = ["-o", str(folder / f"{name}.csv"), *more]
        assert run(["-q", "simulate", four_bar, "--set", f"crank.r={{{length},0}}", *out]) == 0
    both = [str(folder / "a.csv"), str(folder / "b.csv")]
    assert run(["-q", "view", *both, "--no-open", "-o", str(files["runs"])]) == 0
    assert run(["-q", "doc", "PlanarMultiBody.Joints", "-o", str(files["handbook"])]) == 0
    assert run(["-q", "gallery", str(EXAMPLES / "pendulum.pmo"), "-o", str(files["gallery"])]) == 0
    request = Request(EXAMPLES / "four_bar.pmo")
    live = LiveServer(Session(request, Backend.NATIVE), request)
    live.start()
    yield {**files, "live": live.address}
    live.stop()


@pytest.fixture
def show(places: dict[str, Path | str], open_page: Callable[..., Any]) -> Callable[..., Any]:
    def show(name: str, window: str = "desktop", dark: bool = False) -> Any:
        page = open_page(places[name], WINDOWS[window], dark)
        if name == "live":
            page.evaluate(
                """async () => {
                  while (!window.planarcPlayer || planarcLive.busy)
                    await new Promise((done) => setTimeout(done, 10));
                }"""
            )
        if name == "handbook":
            page.evaluate("location.hash = 'PlanarMultiBody.Joints.Revolute'")
        page.evaluate("new Promise((done) => requestAnimationFrame(() => setTimeout(done)))")
        return page

    return show


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("window", WINDOWS)
@pytest.mark.parametrize("name", PAGES)
def test_no_page_scrolls_sideways(
    name: str, window: str, dark: bool, show: Callable[..., Any], screenshot: Callable[..., Path]
) -> None:
    page = show(name, window, dark)
    assert page.evaluate("document.documentElement.scrollWidth") <= WINDOWS[window][0]
    screenshot(page, f"{name}-{window}-{'dark' if dark else 'light'}")


@pytest.mark.parametrize(("window", "dark"), [("desktop", False), ("phone", True)])
@pytest.mark.parametrize("name", PAGES)
def test_axe_finds_nothing_serious(
    name: str, window: str, dark: bool, show: Callable[..., Any]
) -> None:
    page = show(name, window, dark)
    page.evaluate((VENDOR / "axe.min.js").read_text("utf-8"))
    assert page.evaluate(RULES) == []


def test_axe_is_the_published_file() -> None:
    told = re.search(r"`axe.min.js`.*`([0-9a-f]{64})`", (VENDOR / "README.md").read_text("utf-8"))
    assert told
    assert hashlib.sha256((VENDOR / "axe.min.js").read_bytes()).hexdigest() == told[1]


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("name", ["report", "runs"])
def test_on_paper_nothing_is_cut_and_nothing_overlaps(
    name: str, dark: bool, show: Callable[..., Any]
) -> None:
    page = show(name, dark=dark)
    page.emulate_media(media="print")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    boxes = page.evaluate(BOXES)
    assert len(boxes) > 3
    assert all(box["whole"] == "avoid" for box in boxes)
    for above, below in pairwise(boxes):
        assert below["top"] >= above["bottom"] - 1
    assert page.evaluate("document.documentElement.dataset.theme") == "light"
    assert page.pdf(format="A4").startswith(b"%PDF")
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert page.evaluate("document.documentElement.dataset.theme") == ("dark" if dark else "light")


def test_the_handbook_finds_classes_and_opens_its_tree_there(show: Callable[..., Any]) -> None:
    page = show("handbook")
    current = page.locator("nav a[aria-current]")
    assert current.inner_text() == "Revolute"
    assert current.is_visible()
    assert page.locator("section:target h1").inner_text() == "Revolute"
    page.fill("nav input", "slide prismatic")
    assert page.locator(".found a").all_inner_texts() == ["Prismatic", "PrismaticWithFriction"]
    page.press("nav input", "Enter")
    page.evaluate("new Promise((done) => setTimeout(done))")
    assert page.locator("section:target h1").inner_text() == "Prismatic"
    page.press("nav input", "Escape")
    assert page.locator("nav a[aria-current]").inner_text() == "Prismatic"


def test_the_handbook_moves_the_class_that_is_shown(show: Callable[..., Any]) -> None:
    page = show("handbook")
    picture = page.locator("section:target figure svg")
    picture.wait_for()
    turned = "svg => [...svg.querySelectorAll('g')].map((g) => g.getCTM().b).join()"
    before = picture.evaluate(turned)
    page.wait_for_timeout(200)
    assert picture.evaluate(turned) != before
    page.click("section:target figure button")
    assert picture.evaluate("svg => svg.animationsPaused()")
    page.evaluate("location.hash = 'PlanarMultiBody.Joints.Prismatic'")
    page.locator("section:target figure svg").wait_for()
    assert page.locator("figure svg:visible").count() == 1


def test_the_handbook_writes_the_source_text_of_the_class_that_is_shown(
    show: Callable[..., Any],
) -> None:
    page = show("handbook")
    for name in ("Revolute", "Prismatic"):
        page.evaluate(f"location.hash = 'PlanarMultiBody.Joints.{name}'")
        text = page.locator("section:target .source pre")
        text.locator("b").first.wait_for(state="attached")
        assert text.text_content().startswith(f"model {name} ")


def test_a_link_into_the_handbook_opens_a_class_whole(
    places: dict[str, Path | str], open_page: Callable[..., Any]
) -> None:
    page = open_page(f"{Path(places['handbook']).as_uri()}#PlanarMultiBody.Joints.Revolute")
    page.locator("section:target .source pre b").first.wait_for(state="attached")
    page.locator("section:target figure svg").wait_for()
