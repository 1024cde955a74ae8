"""A page that runs its model itself, in Firefox: by its own protocol, Marionette."""

from __future__ import annotations

import itertools
import json
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import planarc
from planarc.compiler import compile_model, run
from planarc.core.options import RunOptions
from planarc.export.page.page import make_page
from planarc.request.request import Request
from tests.view.browser.test_own_page_tells import BALL

ROOT = Path(__file__).parents[3]
FIREFOX = shutil.which("firefox") or shutil.which("firefox-esr")

#: Moves a slider to a value, waits for the run, and tells what the page says and shows.
MOVE = """
const [name, value, done] = arguments;
(async () => {
  const rest = () => new Promise((ready) => setTimeout(ready, 10));
  while (!window.planarcPlayer || planarcLive.busy) await rest();
  const slider = document.querySelector(`.field[data-name="${name}"] input.slide`);
  slider.value = value;
  slider.dispatchEvent(new Event("input", { bubbles: true }));
  while (planarcLive.busy) await rest();
  planarcPlayer.pause();
  planarcPlayer.setTime(1);
  const { x, y, angle } = planarcPlayer.pose("rocker");
  done({ state: document.getElementById("state").textContent, x, y, angle });
})();
"""


#: Drags a point of a component by an angle around the origin; tells the start value that followed.
DRAG = """
const [name, component, u, turn, done] = arguments;
(async () => {
  const rest = (ms = 10) => new Promise((ready) => setTimeout(ready, ms));
  while (!window.planarcPlayer || planarcLive.busy) await rest();
  const canvas = planarcPlayer.picture();
  canvas.setPointerCapture = () => {}; // there is no real pointer
  planarcPlayer.pause();
  planarcPlayer.setTime(0);
  await rest(100);
  const { angle } = planarcPlayer.pose(component);
  const put = (kind, phi) => {
    const box = canvas.getBoundingClientRect();
    const { view } = planarcPlayer;
    canvas.dispatchEvent(new PointerEvent(kind, {
      pointerId: 7, bubbles: true, buttons: 1,
      clientX: box.left + box.width / 2 + (u * Math.cos(phi) - view.x) * view.scale,
      clientY: box.top + box.height / 2 - (u * Math.sin(phi) - view.y) * view.scale,
    }));
  };
  put("pointerdown", angle);
  for (let i = 1; i <= 5; i++) {
    put("pointermove", angle + (turn * i) / 5);
    await rest();
  }
  put("pointerup", angle + turn);
  while (planarcLive.busy) await rest();
  planarcPlayer.pause();
  planarcPlayer.setTime(0);
  done({
    before: angle, after: planarcPlayer.pose(component).angle,
    value: planarcLive.fields.values().starts[name],
    peaks: document.querySelectorAll("#peaks tr").length,
  });
})();
"""
#: What the page lists of events, and its marks.
EVENTS = """
const [done] = arguments;
(async () => {
  const rest = () => new Promise((ready) => setTimeout(ready, 10));
  while (!window.planarcPlayer || planarcLive.busy) await rest();
  const texts = [...document.querySelectorAll("#events li span")].map((line) => line.textContent);
  done({ texts, marks: document.querySelectorAll(".marks i").length });
})();
"""


class Firefox:
    """Messages are [0, number, command, arguments], and their length before them."""

    def __init__(self, port: int) -> None:
        end = time.monotonic() + 240
        while True:
            try:
                self._socket = socket.create_connection(("127.0.0.1", port))
                break
            except OSError:
                if time.monotonic() > end:
                    raise
                time.sleep(0.1)
        self._rest, self._count = b"", itertools.count(1)
        self._receive()
        self.ask("WebDriver:NewSession")
        self.ask("WebDriver:SetTimeouts", script=240_000)

    def ask(self, command: str, **arguments: Any) -> Any:
        data = json.dumps([0, next(self._count), command, arguments]).encode()
        self._socket.sendall(b"%d:%s" % (len(data), data))
        _, _, problem, answer = self._receive()
        assert problem is None, problem
        return answer

    def _receive(self) -> Any:
        while b":" not in self._rest:
            self._rest += self._socket.recv(1 << 16)
        size, _, rest = self._rest.partition(b":")
        while len(rest) < int(size):
            rest += self._socket.recv(1 << 16)
        self._rest = rest[int(size) :]
        return json.loads(rest[: int(size)])

    def close(self) -> None:
        self._socket.close()


@pytest.fixture
def firefox(tmp_path: Path) -> Iterator[Firefox]:
    if FIREFOX is None:
        pytest.skip("there is no firefox here")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    profile = tmp_path / "profile"
    profile.mkdir()
    (profile / "user.js").write_text(f'user_pref("marionette.port", {port});\n')
    command = [FIREFOX, "--headless", "--marionette", "--no-remote", "--profile", str(profile)]
    program = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        browser = Firefox(port)
        yield browser
        browser.close()
    finally:
        program.terminate()
        program.wait()


def test_events_are_told_and_a_part_is_dragged(firefox: Firefox, tmp_path: Path) -> None:
    ball = planarc.load(BALL)
    told = ball.simulate().rows.events
    path = ball.export_page(tmp_path / "ball.html")
    firefox.ask("WebDriver:Navigate", url=path.as_uri())
    found = firefox.ask("WebDriver:ExecuteAsyncScript", script=EVENTS, args=[])["value"]
    assert found["texts"] == [", ".join(e.causes) for e in told]
    assert found["marks"] == len(told)
    bars = planarc.load(str(ROOT / "examples" / "four_bar.pmo"))
    path = bars.export_page(tmp_path / "bars.html")
    firefox.ask("WebDriver:Navigate", url=path.as_uri())
    given = ["revA.phi", "crank", 0.3, 0.4]
    found = firefox.ask("WebDriver:ExecuteAsyncScript", script=DRAG, args=given)["value"]
    assert found["after"] == pytest.approx(found["before"] + 0.4, abs=1e-3)
    assert found["value"] == pytest.approx(found["after"], abs=1e-4)
    assert found["peaks"] > 1


def test_a_slider_runs_the_model_again(firefox: Firefox, tmp_path: Path) -> None:
    compiled = compile_model(Request(ROOT / "examples" / "four_bar.pmo"))
    path = tmp_path / "FourBar.html"
    path.write_text(make_page(compiled, run(compiled, RunOptions())).text, "utf-8")
    firefox.ask("WebDriver:Navigate", url=path.as_uri())
    slow = firefox.ask("WebDriver:ExecuteAsyncScript", script=MOVE, args=["crank.r[1]", 0.3])
    found = slow["value"]
    assert found["state"].startswith("simulated in")
    options = RunOptions(stop=1.0, tolerance=1e-10, values={"crank.r[1]": 0.3})
    wanted = run(compiled, options)["revD.phi"][-1]
    assert (found["x"], found["y"]) == pytest.approx((1.0, 0.0))
    assert found["angle"] == pytest.approx(float(wanted), abs=1e-6)
