"""Components in motion: which model shows which, and what a page holds of it."""

from __future__ import annotations

import base64
import json
import re
import zlib
from itertools import pairwise
from pathlib import Path

import pytest

from planarc.catalog.handbook import motion
from planarc.catalog.handbook.code import colored
from planarc.catalog.handbook.gather import gather
from planarc.catalog.handbook.motion import motions_of
from planarc.catalog.handbook.page import render_handbook
from planarc.catalog.handbook.shown import MODELS, find, models_that_show
from planarc.cli.app import run
from planarc.request.request import Request, open_library

LIBRARY = """package Mine
  import PlanarMultiBody.{Parts, Joints, World};
  model Bar "Swings"
    extends Parts.BodyShape(r={1, 0}, r_CM={0.5, 0}, m=1, I=0.1);
  end Bar;
  model Lonely "In no example"
    extends Parts.Body(m=1, I=1);
  end Lonely;
  package Examples
    model Swing "A bar that swings <b>"
      inner World world;
      Joints.Revolute hinge;
      Mine.Bar bar;
    equation
      connect(world.frame_b, hinge.frame_a);
      connect(hinge.frame_b, bar.frame_a);
      annotation(experiment(StopTime=1));
    end Swing;
    model Broken "Has no world to stand on"
      Mine.Lonely lonely(m=nothing);
      annotation(experiment(StopTime=1));
    end Broken;
  end Examples;
end Mine;
"""


def packed_in(page: str, kind: str = "pictures") -> list[str]:
    found = re.search(rf'class="{kind}">(.*?)</template>', page)
    assert found
    texts: list[str] = json.loads(zlib.decompress(base64.b64decode(found[1]))) if found[1] else []
    return texts


def test_every_component_of_the_library_has_a_model_that_shows_it() -> None:
    library, _, _ = open_library(Request())
    pages = gather(library, ["PlanarMultiBody"])
    models = models_that_show(library, pages)
    assert {s.model for s in models if s.is_file} == {file.name for file in MODELS.glob("*.pmo")}
    unseen = [p.name for p in pages if p.kind in ("model", "block") and not find(p.name, models)]
    assert unseen == []


def test_a_users_components_are_shown_by_the_users_examples(tmp_path: Path) -> None:
    file = tmp_path / "Mine.mo"
    file.write_text(LIBRARY)
    request = Request(file)
    library, _, names = open_library(request)
    pages = gather(library, names)
    motions = motions_of(library, pages, request)
    assert {n: s.name for n, (s, _) in motions.shown.items()} == {
        "Mine.Bar": "Mine.Examples.Swing",
        "Mine.Examples.Swing": "Mine.Examples.Swing",
    }
    page = render_handbook("Mine", pages, motions)
    assert packed_in(page) == [picture.decode() for picture in motions.pictures]
    assert "animateTransform" in packed_in(page)[0]
    assert page.count('data-motion="0"') == 2
    assert "A bar that swings &lt;b&gt;</figcaption>" in page


def test_one_class_alone_is_shown_by_the_examples_of_its_library() -> None:
    library, _, _ = open_library(Request())
    pages = gather(library, ["PlanarMultiBody.Joints.CurveCurveJoint"])
    motions = motions_of(library, pages, Request())
    (shows, number) = motions.shown["PlanarMultiBody.Joints.CurveCurveJoint"]
    assert (shows.name.startswith("PlanarMultiBody.Examples."), number) == (True, 0)
    assert len(motions.pictures) == 1


def test_a_picture_is_drawn_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PLANARC_CACHE_DIR", str(tmp_path))
    library, _, _ = open_library(Request())
    pages = gather(library, ["PlanarMultiBody.Joints.Revolute"])
    first = motions_of(library, pages, Request())
    monkeypatch.setattr(motion, "_draw", lambda request: pytest.fail("it is drawn again"))
    assert motions_of(library, pages, Request()) == first


def test_source_texts_are_packed_under_the_numbers_of_their_classes(tmp_path: Path) -> None:
    file = tmp_path / "Mine.mo"
    file.write_text(LIBRARY)
    library, _, names = open_library(Request(file))
    pages = gather(library, names)
    page = render_handbook("Mine", pages)
    texts = packed_in(page, "sources")
    found = re.findall(r'<section id="([^"]*)"|data-source="(\d+)"', page)
    assert {a: texts[int(n)] for (a, _), (_, n) in pairwise(found) if a and n} == {
        p.name: colored(p.source) for p in pages if p.source
    }
    assert "A bar that swings &lt;b&gt;" in "".join(texts)


def test_without_motion_nothing_runs(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(motion, "motions_of", lambda *asked: pytest.fail("it runs examples"))
    path = tmp_path / "page.html"
    command = ["-q", "doc", "PlanarMultiBody.Joints.Revolute", "-o", str(path), "--no-motion"]
    assert run(command) == 0
    assert packed_in(path.read_text("utf-8")) == []


def test_the_handbook_of_the_library_is_light() -> None:
    library, _, _ = open_library(Request())
    pages = gather(library, ["PlanarMultiBody"])
    page = render_handbook("PlanarMultiBody", pages, motions_of(library, pages, Request()))
    assert len(packed_in(page)) > 30
    assert len(page.encode()) <= 1_400_000
