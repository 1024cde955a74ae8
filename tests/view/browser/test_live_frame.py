"""The live page in the panel of an editor: clicks come out, the editor's cursor lights up parts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread
from typing import Any

import pytest

from planarc.live.server import LiveServer
from planarc.request.request import Request
from tests.view.browser.conftest import settle, until

ROOT = Path(__file__).parents[3]
#: An editor's panel: it greets the page, and keeps what it is told.
PANEL = """<!doctype html><title>editor</title>
<iframe style="width: 900px; height: 700px"></iframe>
<script>
  const told = [];
  const frame = document.querySelector("iframe");
  addEventListener("message", (event) => {
    if (event.source === frame.contentWindow) told.push([event.origin, event.data]);
  });
  function light(component, to = new URL(frame.src).origin) {
    frame.contentWindow.postMessage({ type: "planarc/lit", component, dark: true }, to);
  }
</script>"""
#: Where a component is, in the page's own pixels, at the start of the motion.
POINT = """([component, along]) => {
  planarcPlayer.pause();
  planarcPlayer.setTime(0);
  const { x, y, angle, length } = planarcPlayer.pose(component);
  const { view } = planarcPlayer;
  const box = planarcPlayer.picture().getBoundingClientRect();
  const [wx, wy] = [x + along * length * Math.cos(angle), y + along * length * Math.sin(angle)];
  return {
    x: box.left + box.width / 2 + (wx - view.x) * view.scale,
    y: box.top + box.height / 2 - (wy - view.y) * view.scale,
  };
}"""
#: The next picture is drawn.
DRAWN = "() => new Promise((done) => requestAnimationFrame(() => setTimeout(done)))"
#: The frame counts what it hears, after the page itself has heard it.
HEARD = "() => { window.heard = 0; addEventListener('message', () => { heard += 1; }); }"


@pytest.fixture
def served(tmp_path: Path, serve: Callable[..., LiveServer]) -> Callable[[bool], LiveServer]:
    file = tmp_path / "four_bar.pmo"
    file.write_text((ROOT / "examples" / "four_bar.pmo").read_text("utf-8"), "utf-8")
    return lambda framed: serve(Request(file), framed=framed)


class Editor(BaseHTTPRequestHandler):
    def do_GET(self) -> None:
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.end_headers()
        self.wfile.write(PANEL.encode())

    def log_message(self, *told: Any) -> None:
        pass


@pytest.fixture
def editor() -> Iterator[str]:
    """The address of an editor of this machine, which runs in a browser."""
    with ThreadingHTTPServer(("127.0.0.1", 0), Editor) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://localhost:{server.server_port}/"
        server.shutdown()


@pytest.fixture
def panel(open_page: Callable[..., Any], editor: str) -> Callable[..., tuple[Any, Any]]:
    """The panel with a frame of an address in it: the page around it, and the frame."""

    def open_panel(address: str, around: Path | str = editor) -> tuple[Any, Any]:
        page = open_page(around, (1000, 800))
        page.evaluate(
            """(address) => new Promise((done) => {
              frame.addEventListener("load", done, { once: true });
              frame.src = address;
            })""",
            address,
        )
        frame = page.frames[1]
        frame.evaluate(HEARD)
        return page, frame

    return open_panel


def tell(page: Any, frame: Any, message: str) -> None:
    """The panel says something, and the frame, which is another process, has drawn it."""
    heard = frame.evaluate("heard")
    page.evaluate(message)
    until(frame, f"heard === {heard + 1}")
    frame.evaluate(DRAWN)


def click(page: Any, frame: Any, component: str, along: float, off: float = 0.0) -> None:
    point = frame.evaluate(POINT, [component, along])
    box = page.locator("iframe").bounding_box()
    page.mouse.click(box["x"] + 2 + point["x"], box["y"] + 2 + point["y"] + off)


def test_a_click_on_a_bar_is_told_to_the_editor(
    panel: Callable[..., Any], served: Callable[..., LiveServer], screenshot: Callable[..., Path]
) -> None:
    live = served(True)
    page, frame = panel(live.address)
    settle(frame)
    click(page, frame, "coupler.shape", 0.25)
    assert page.evaluate("told") == []  # an editor that has said nothing hears nothing
    tell(page, frame, "light('')")
    click(page, frame, "coupler.shape", 0.25)
    click(page, frame, "rocker.shape", 0.75)
    click(page, frame, "coupler.shape", 0.25, off=-150.0)  # nothing is there
    until(page, "told.length === 2")
    origin = f"http://127.0.0.1:{live.port}"
    picked = [{"type": "planarc/picked", "component": n} for n in ("coupler", "rocker")]
    assert page.evaluate("told") == [[origin, p] for p in picked]
    screenshot(page, "live-panel")


def test_a_picture_that_is_moved_is_not_clicked(
    panel: Callable[..., Any], served: Callable[..., LiveServer]
) -> None:
    page, frame = panel(served(True).address)
    settle(frame)
    tell(page, frame, "light('')")
    point = frame.evaluate(POINT, ["coupler.shape", 0.25])
    page.mouse.move(point["x"] + 10, point["y"] + 10)
    page.mouse.down()
    page.mouse.move(point["x"] + 40, point["y"] + 10, steps=4)
    page.mouse.up()
    frame.evaluate(DRAWN)
    frame.wait_for_selector("#reset:not([hidden])")  # it was dragged
    settle(frame)  # and runs from there
    assert page.evaluate("told") == []


def test_the_component_under_the_cursor_is_lit_up(
    panel: Callable[..., Any], served: Callable[..., LiveServer], screenshot: Callable[..., Path]
) -> None:
    page, frame = panel(served(True).address)
    settle(frame)
    frame.evaluate(POINT, ["coupler.shape", 0.0])
    tell(page, frame, "light('')")
    plain = pixels(frame)
    assert frame.evaluate("document.documentElement.dataset.theme") == "dark"  # as the editor
    tell(page, frame, "light('coupler')")
    lit = pixels(frame)
    assert lit != plain
    screenshot(page, "live-panel-lit")
    tell(page, frame, "light('coup')")  # part of a name is no component
    assert pixels(frame) == plain
    for name in ("coupler.shape", "coupler.frame_b"):  # of what is not drawn, what it is in
        tell(page, frame, f"light('{name}')")
        assert pixels(frame) == lit
    for nonsense in ("{ type: 'planarc/lit', component: 7 }", "null"):
        tell(page, frame, f"frame.contentWindow.postMessage({nonsense}, '*')")
    assert pixels(frame) == lit


def pixels(frame: Any) -> str:
    return str(frame.evaluate("planarcPlayer.picture().toDataURL()"))


def test_a_page_of_a_browser_stands_in_no_frame(
    panel: Callable[..., Any], served: Callable[..., LiveServer], watch: Any
) -> None:
    watch.allowed = ["403", "frame"]
    _page, frame = panel(served(False).address)
    assert frame.evaluate("typeof planarcPlayer") == "undefined"
    assert "FourBar" not in frame.content()


def test_a_page_that_is_no_editor_frames_nothing(
    panel: Callable[..., Any], served: Callable[..., LiveServer], watch: Any, tmp_path: Path
) -> None:
    """Even one that knows the whole address."""
    watch.allowed = ["frame-ancestors"]
    other = tmp_path / "other.html"
    other.write_text(PANEL, "utf-8")
    _page, frame = panel(served(True).address, other)
    assert frame.evaluate("typeof planarcPlayer") == "undefined"
    assert "FourBar" not in frame.content()
    assert [c for c in watch.complaints if "frame-ancestors" in c]
