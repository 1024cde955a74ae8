"""The extension in a real VS Code: text, mechanism and mistakes, as a user sees them.

The workbench is one that a browser shows, with VS Code's own extension host: `PLANARC_WORKBENCH`
names its program (code-server), and `editors/vscode/dist/planarc.vsix` is packed before
(`npm run pack`). Where one of them is missing, the tests are skipped.
"""

from __future__ import annotations

import json
import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from math import cos, sin
from pathlib import Path
from typing import Any
from urllib.request import urlopen

import pytest

ROOT = Path(__file__).parents[2]
PACKED = ROOT / "editors" / "vscode" / "dist" / "planarc.vsix"
PROGRAM = os.environ.get("PLANARC_WORKBENCH", "")
PATIENCE = 20.0

pytestmark = pytest.mark.skipif(
    not PROGRAM or not PACKED.is_file(),
    reason="no VS Code: PLANARC_WORKBENCH names no code-server, or the extension is not packed",
)


def until(what: str, condition: Callable[[], Any]) -> Any:
    """Wait for something; gives what the condition gave."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        found = condition()
        if found:
            return found
        time.sleep(0.02)
    raise AssertionError(f"it did not come: {what}")


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, Path]]:
    """A workbench with the extension in it, and the folder that it shows."""
    home = tmp_path_factory.mktemp("workbench")
    folder = home / "folder"
    (home / "data" / "User").mkdir(parents=True)
    folder.mkdir()
    settings = {
        "planarc.command": [sys.executable, "-m", "planarc"],
        "editor.autoClosingBrackets": "never",
        "editor.quickSuggestions": {"other": "off"},
        "files.autoSave": "off",
        "files.hotExit": "off",
        "security.workspace.trust.enabled": False,
        "workbench.startupEditor": "none",
        "window.confirmBeforeClose": "never",
    }
    (home / "data" / "User" / "settings.json").write_text(json.dumps(settings), "utf-8")
    places = ["--user-data-dir", str(home / "data"), "--extensions-dir", str(home / "extensions")]
    own = {**os.environ, "XDG_CONFIG_HOME": str(home / "config")}
    command = [PROGRAM, *places, "--install-extension", str(PACKED)]
    subprocess.run(command, check=True, capture_output=True, env=own, timeout=300)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    quiet = ["--auth", "none", "--disable-telemetry", "--disable-update-check"]
    command = [PROGRAM, *places, *quiet, "--bind-addr", f"127.0.0.1:{port}", str(folder)]
    with (home / "log").open("w") as log:
        served = subprocess.Popen(command, stdout=log, stderr=log, env=own)
        try:
            until("the workbench", lambda: _answers(port))
            yield f"http://127.0.0.1:{port}/?folder={folder}", folder
        finally:
            served.terminate()
            served.wait(60)


def _answers(port: int) -> bool:
    try:
        with urlopen(f"http://127.0.0.1:{port}/healthz", timeout=5):
            return True
    except OSError:
        return False


class Workbench:
    """A window with one file."""

    def __init__(self, page: Any, folder: Path) -> None:
        self.page, self.folder = page, folder

    def open(self, name: str) -> None:
        self.page.get_by_role("treeitem", name=name).first.dblclick()
        self.page.wait_for_selector(".view-lines")
        self.page.wait_for_selector(".codelens-decoration")  # the server has come

    def run(self, title: str) -> None:
        """A command of the palette, by its title."""
        self.page.keyboard.press("F1")
        self.page.wait_for_selector(".quick-input-widget input")
        self.page.keyboard.type(title)
        self.page.get_by_role("option", name=title).first.click()

    def go_to(self, line: int, column: int = 1) -> None:
        """Put the cursor on a place, counted from 1."""
        self.page.locator(".monaco-editor .view-lines").first.click()
        self.page.keyboard.press("Control+g")
        self.page.wait_for_selector(".quick-input-widget input")
        self.page.keyboard.type(f"{line}:{column}")
        self.page.keyboard.press("Enter")
        until("the place", lambda: self.place == (line, column))

    @property
    def place(self) -> tuple[int, int] | None:
        told = self.page.locator('[id="status.editor.selection"]').inner_text()
        words = told.replace(",", "").split()
        numbers = [int(w) for w in words if w.isdigit()]
        return (numbers[0], numbers[1]) if len(numbers) >= 2 else None

    @property
    def mistakes(self) -> list[str]:
        """What is underlined."""
        return [str(e) for e in self.page.locator(".squiggly-error").all()]

    def panel(self) -> Any:
        """The frame of the live page, when its mechanism moves."""

        def found() -> Any:
            for frame in self.page.frames:
                try:
                    if frame.evaluate("window.planarcPlayer && !planarcLive.busy"):
                        return frame
                except Exception:  # a frame that is just being filled
                    continue
            return None

        return until("the mechanism", found)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    api = pytest.importorskip("playwright.sync_api")
    program = os.environ.get("PLANARC_BROWSER") or shutil.which("chromium")
    with api.sync_playwright() as playwright:
        launched = playwright.chromium.launch(
            executable_path=program, args=["--no-sandbox", "--disable-gpu"]
        )
        yield launched
        launched.close()


@pytest.fixture
def workbench(
    browser: Any, address: tuple[str, Path], request: pytest.FixtureRequest
) -> Iterator[Workbench]:
    where, folder = address
    text = (ROOT / "examples" / "four_bar.pmo").read_text("utf-8")
    (folder / "four_bar.pmo").write_text(text, "utf-8")
    context = browser.new_context(viewport={"width": 1600, "height": 950})
    page = context.new_page()
    page.set_default_timeout(1000 * PATIENCE)
    page.goto(where)
    page.wait_for_selector(".monaco-workbench")
    made = Workbench(page, folder)
    made.open("four_bar.pmo")
    yield made
    named = request.config.getoption("--screenshots")
    if named:
        page.screenshot(path=Path(named) / f"workbench-{request.node.name}.png")
    made.run("File: Revert File")
    context.close()


def line_of(text: str) -> int:
    lines = (ROOT / "examples" / "four_bar.pmo").read_text("utf-8").splitlines()
    return next(i for i, line in enumerate(lines, 1) if text in line)


def test_a_mistake_is_underlined_while_typing(workbench: Workbench) -> None:
    workbench.go_to(line_of("Fixed groundD"), 3)
    workbench.page.keyboard.type("x")
    workbench.page.wait_for_selector(".squiggly-error")
    workbench.page.keyboard.press("Backspace")
    workbench.page.wait_for_selector(".squiggly-error", state="detached")


def test_a_name_says_what_it_is(workbench: Workbench) -> None:
    workbench.go_to(line_of("FixedTranslation crank"), 22)
    workbench.page.keyboard.press("Control+k")
    workbench.page.keyboard.press("Control+i")
    rod = workbench.page.locator(".monaco-hover").filter(has_text="Rigid rod without mass")
    rod.wait_for()


#: Where a component is at the start of the motion, in the panel's own pixels.
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
    at: [x, y],
  };
}"""
PICTURE = """() => new Promise((done) => requestAnimationFrame(() => setTimeout(
  () => done(planarcPlayer.picture().toDataURL())
)))"""


def show(workbench: Workbench) -> Any:
    workbench.run("planarc: Show the Mechanism Beside the Text")
    return workbench.panel()


def test_a_click_on_a_bar_goes_to_its_line(workbench: Workbench) -> None:
    frame = show(workbench)
    for bar in ("rocker", "coupler"):
        point = frame.evaluate(POINT, [f"{bar}.shape", 0.75])
        frame.locator("canvas.stage").click(position=_inside(frame, point))
        line = line_of(f"FixedTranslation {bar}")
        until(
            f"the line of the {bar}",
            lambda line=line: workbench.place is not None and workbench.place[0] == line,
        )


def _inside(frame: Any, point: dict[str, float]) -> dict[str, float]:
    """A point of the page as one of the canvas."""
    corner = frame.evaluate("planarcPlayer.picture().getBoundingClientRect().toJSON()")
    return {"x": point["x"] - corner["left"], "y": point["y"] - corner["top"]}


def at_rest(frame: Any) -> str:
    """The picture once it stays as it is: what the cursor was on before goes out a little later."""
    seen: list[str] = []

    def rests() -> bool:
        seen.append(frame.evaluate(PICTURE))
        time.sleep(0.05)
        return len(seen) > 10 and len(set(seen[-10:])) == 1

    until("a picture at rest", rests)
    return seen[-1]


def test_the_component_under_the_cursor_lights_up(workbench: Workbench) -> None:
    frame = show(workbench)
    workbench.go_to(line_of("A crank-rocker"), 5)
    frame.evaluate(POINT, ["coupler.shape", 0.0])
    plain = at_rest(frame)
    workbench.go_to(line_of("FixedTranslation coupler"), 22)
    until("the light", lambda: frame.evaluate(PICTURE) != plain)
    workbench.go_to(line_of("A crank-rocker"), 5)
    until("darkness", lambda: frame.evaluate(PICTURE) == plain)


def test_an_edit_redraws_at_once_and_an_error_keeps_the_picture(workbench: Workbench) -> None:
    frame = show(workbench)
    line = line_of("FixedTranslation crank")
    workbench.go_to(line, len("  FixedTranslation crank(r={0.4") + 1)
    before = (workbench.folder / "four_bar.pmo").read_text("utf-8")
    assert frame.evaluate(POINT, ["coupler.shape", 0.0])["at"] == pytest.approx(
        [0.4 * cos(1), 0.4 * sin(1)], abs=1e-3
    )
    workbench.page.keyboard.press("Backspace")
    begin = time.monotonic()
    workbench.page.keyboard.type("3")
    wanted = pytest.approx([0.3 * cos(1), 0.3 * sin(1)], abs=1e-3)
    until(
        "the picture of the edited text",
        lambda: frame.evaluate(POINT, ["coupler.shape", 0.0])["at"] == wanted,
    )
    seconds = time.monotonic() - begin
    print(f"from the key to the picture: {seconds:.2f} s")
    workbench.page.keyboard.type("*nowhere")
    until("the reason", lambda: "nowhere" in frame.locator("#notes").inner_text())
    assert frame.locator("#player.stale").count() == 1
    assert frame.evaluate(POINT, ["coupler.shape", 0.0])["at"] == wanted  # the last picture
    assert (workbench.folder / "four_bar.pmo").read_text("utf-8") == before  # nothing was saved
