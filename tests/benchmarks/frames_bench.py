"""How long a page takes to draw a frame, all its layers on: 60 frames/s leave 16 ms to each.

    python tests/benchmarks/frames_bench.py [MODEL ...]

Script is CPU time of the page's own script, whole is that with layout and paint, both the median
of so many frames that are drawn one after the other; a chromium without a window draws them.
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from typing import Any

ROOT = Path(__file__).parents[2]
LIBRARY = "PlanarMultiBody.Examples"
#: The examples with the most parts, the most curves and the longest paths.
MODELS = (
    f"{LIBRARY}.Contacts.NewtonsCradle",
    f"{LIBRARY}.Loops.AndrewsSqueezer",
    f"{LIBRARY}.Systems.Excavator",
    str(ROOT / "examples" / "walking_leg.pmo"),
)
FRAMES = 200
NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")

LAYERS = """() => document.querySelectorAll(".player .chip[aria-pressed=false]")
  .forEach((chip) => chip.click())"""
DRAW = """(part) => new Promise((done) => {
  const { min, max } = document.querySelector("input.time");
  planarcPlayer.setTime(Number(min) + part * (max - min));
  requestAnimationFrame(() => setTimeout(done));
})"""


def frames(page: Any) -> Iterator[tuple[float, float]]:
    """Milliseconds of script and of the whole page, a frame each."""
    page.evaluate(LAYERS)
    session = page.context.new_cdp_session(page)
    session.send("Performance.enable", {"timeDomain": "threadTicks"})

    def spent() -> tuple[float, float]:
        told = {m["name"]: m["value"] for m in session.send("Performance.getMetrics")["metrics"]}
        return told["ScriptDuration"], told["TaskDuration"]

    for i in range(FRAMES):
        before = spent()
        page.evaluate(DRAW, i / FRAMES)
        after = spent()
        yield 1e3 * (after[0] - before[0]), 1e3 * (after[1] - before[1])


def main(models: list[str]) -> None:
    from playwright.sync_api import sync_playwright

    from planarc.cli.app import run

    program = os.environ.get("PLANARC_BROWSER") or next(filter(None, map(shutil.which, NAMES)))
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        print(f"{'a frame of':46} {'script':>9} {'whole':>9}")
        for i, model in enumerate(models):
            path = Path(folder) / f"{i}.html"
            output = ["-o", str(path.with_suffix(".csv"))]
            if run(["-q", "simulate", model, "--report", str(path), *output]):
                sys.exit(1)
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            page.goto(path.as_uri())
            script, whole = map(median, zip(*frames(page), strict=True))
            name = Path(model).stem if model.endswith(".pmo") else model
            print(f"{name:46} {script:6.2f} ms {whole:6.2f} ms")
        browser.close()


if __name__ == "__main__":
    main(sys.argv[1:] or list(MODELS))
