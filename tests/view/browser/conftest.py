"""A real browser for the pages: nothing may complain, and nothing may leave the machine.

`open_page(place)` opens a file or an address of this machine and gives the page (of
playwright). When the test ends, it fails where the page wrote an error to its console, threw an
exception, or asked for anything but files and this machine. `screenshot(page, name)` keeps a
picture: see `--screenshots` in `tests/conftest.py`.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

from planarc.core.options import Backend
from planarc.live.server import LiveServer
from planarc.live.session import Session
from planarc.request.request import Request

#: Where Debian and others put it. playwright's own download is not used.
NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")

#: As quiet a browser as can be had; every name but the machine's own leads nowhere.
FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE localhost, EXCLUDE 127.0.0.1",
)

DESKTOP = (1280, 800)
PHONE = (390, 844)

#: Where on the screen a point of a component is, `u` (m) along its x axis.
PLACE = """([u, component]) => {
  const { x, y, angle } = planarcPlayer.pose(component);
  const canvas = planarcPlayer.picture().getBoundingClientRect();
  const { view } = planarcPlayer;
  return {
    x: canvas.left + canvas.width / 2 + (x + u * Math.cos(angle) - view.x) * view.scale,
    y: canvas.top + canvas.height / 2 - (y + u * Math.sin(angle) - view.y) * view.scale,
  };
}"""


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """One chromium for all tests of a process; skips, and says why, where none can be had."""
    api = pytest.importorskip("playwright.sync_api", reason="no browser: playwright is missing")
    named = os.environ.get("PLANARC_BROWSER")
    program = named or next(filter(None, map(shutil.which, NAMES)), None)
    if program is None:
        pytest.skip(f"no browser: none of {', '.join(NAMES)} is installed")
    with api.sync_playwright() as playwright:
        launched = playwright.chromium.launch(executable_path=program, args=[*FLAGS])
        yield launched
        launched.close()


class Watch:
    """What a page may not do; `allowed` are parts of messages that a test expects."""

    def __init__(self) -> None:
        self.allowed: list[str] = []
        self.complaints: list[str] = []
        self.addresses: list[str] = []

    def follow(self, page: Any) -> None:
        page.on("console", self._console)
        page.on("pageerror", lambda error: self.complaints.append(f"exception: {error}"))
        page.on("request", lambda request: self._request(request.url))

    def _console(self, message: Any) -> None:
        if message.type == "error":
            self.complaints.append(f"console: {message.text}")

    def _request(self, address: str) -> None:
        self.addresses.append(address)
        parts = urlsplit(address)
        local = parts.hostname in ("127.0.0.1", "localhost", "::1")
        if parts.scheme not in ("file", "data", "blob", "about") and not local:
            self.complaints.append(f"request: {address}")

    def unexpected(self) -> list[str]:
        return [c for c in self.complaints if not any(a in c for a in self.allowed)]


@pytest.fixture
def watch() -> Watch:
    """What the pages of this test did; `watch.allowed` takes what the test expects of them."""
    return Watch()


@pytest.fixture
def open_page(browser: Any, watch: Watch) -> Iterator[Callable[..., Any]]:
    """`open_page(path or address, size=DESKTOP, dark=False)`; PHONE makes a phone with touch."""
    contexts = []

    def open_one(place: Path | str, size: tuple[int, int] = DESKTOP, dark: bool = False) -> Any:
        phone = size == PHONE
        context = browser.new_context(
            viewport={"width": size[0], "height": size[1]},
            color_scheme="dark" if dark else "light",
            device_scale_factor=2 if phone else 1,
            has_touch=phone,
            is_mobile=phone,
        )
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(300_000)  # for busy machines; nobody waits where all is well
        watch.follow(page)
        page.goto(place.absolute().as_uri() if isinstance(place, Path) else place)
        return page

    yield open_one
    for context in contexts:
        context.close()
    assert not watch.unexpected()


@pytest.fixture
def screenshot(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Callable[..., Path]:
    """`screenshot(page, "report-dark")` keeps a picture of what the window shows.

    `whole=True` takes the page to its end.
    """
    named = request.config.getoption("--screenshots") or os.environ.get("PLANARC_SCREENSHOTS")
    folder = Path(named) if named else tmp_path_factory.getbasetemp() / "screenshots"

    def keep(page: Any, name: str, whole: bool = False) -> Path:
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{name}.png"
        page.screenshot(path=path, full_page=whole)
        return path

    return keep


@pytest.fixture
def serve() -> Iterator[Callable[..., LiveServer]]:
    """`serve(request, backend=NATIVE, framed=False)` answers a live page until the test ends."""
    servers = []

    def start(
        request: Request, backend: Backend = Backend.NATIVE, framed: bool = False
    ) -> LiveServer:
        live = LiveServer(Session(request, backend), request, framed=framed)
        live.start()
        servers.append(live)
        return live

    yield start
    for live in servers:
        live.stop()


def until(page: Any, condition: str) -> None:
    """Wait for a condition; playwright's own waiting is against the page's security policy."""
    page.evaluate(
        f"""async () => {{
          const end = performance.now() + 300000;
          while (!({condition})) {{
            if (performance.now() > end) throw new Error("it did not come");
            await new Promise((done) => setTimeout(done, 10));
          }}
        }}"""
    )


def settle(page: Any) -> None:
    """Until the last order is answered and drawn."""
    until(page, "window.planarcPlayer && !planarcLive.busy")
    page.evaluate("new Promise((done) => requestAnimationFrame(() => setTimeout(done)))")
