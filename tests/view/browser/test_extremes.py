"""On a page micrometres and kilometres look as metres do."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import planarc

MODEL = """model M
  inner PlanarMultiBody.World world(g=9.81*size);
  PlanarMultiBody.Joints.Revolute pin(phi(start=-0.5));
  PlanarMultiBody.Parts.BodyShape rod(r={size, 0}, r_CM={size/2, 0}, m=1, I=0.1*size^2);
  constant Real size=%s;
equation
  connect(world.frame_b, pin.frame_a);
  connect(pin.frame_b, rod.frame_a);
  annotation(experiment(StopTime=1));
end M;
"""

#: Pixels that differ from the ground, below the buttons and above the scale.
INK = """() => {
  const canvas = document.querySelector("canvas.stage");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height - 34);
  const ground = data.slice(0, 3).join();
  let count = 0;
  for (let i = 0; i < data.length; i += 4) count += data.slice(i, i + 3).join() !== ground;
  return count;
}"""
FRAME = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("extremes")
    found = {}
    for name, size in {"m": "1", "um": "1e-6", "km": "1e3"}.items():
        (folder / f"{name}.pmo").write_text(MODEL % size)
        found[name] = (
            planarc.load(folder / f"{name}.pmo").simulate().report(folder / f"{name}.html")
        )
    return found


def test_what_is_drawn_does_not_depend_on_the_scale(
    pages: dict[str, Path], open_page: Callable[..., Any], screenshot: Callable[..., Path]
) -> None:
    ink = {}
    for name, path in pages.items():
        page = open_page(path)
        page.evaluate("planarcPlayer.setTime(0.6)")
        for layer in ("Paths", "Velocities"):
            page.get_by_role("button", name=layer, exact=True).first.click()
        page.evaluate(FRAME)
        ink[name] = page.evaluate(INK)
        screenshot(page, f"extreme-{name}")
    assert ink["um"] == pytest.approx(ink["m"], rel=0.02)
    assert ink["km"] == pytest.approx(ink["m"], rel=0.02)


def test_lengths_are_said_as_people_say_them(
    pages: dict[str, Path], open_page: Callable[..., Any]
) -> None:
    page = open_page(pages["m"])
    said = page.evaluate("[2e3, 0.5, 0.05, 2e-3, 2e-4, 1e-6, 5e-7].map(planarc.length)")
    assert said == ["2 km", "50 cm", "5 cm", "2 mm", "200 µm", "1 µm", "500 nm"]
