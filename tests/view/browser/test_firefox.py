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

from planarc.compiler import compile_model, run
from planarc.core.options import RunOptions
from planarc.export.page.page import make_page
from planarc.request.request import Request

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
