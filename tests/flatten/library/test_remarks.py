"""Remarks on a text are for whoever can change it."""

from __future__ import annotations

from pathlib import Path

import planarc

PARTS = """
  connector Flange Real s; flow Real f; end Flange;
  partial model Held
    Flange flange;
  equation
    assert(cardinality(flange) < 2, "one connection only");
    flange.s = 0;
  end Held;
  model Wall
    extends Held;
    Real x(unit, start=1) = 1;
  end Wall;
"""


def codes(model: planarc.Model) -> list[str]:
    return sorted({w.code for w in model.warnings})


def test_what_is_obsolete_in_a_library_is_not_told_to_its_user(tmp_path: Path) -> None:
    (tmp_path / "Walls").mkdir()
    (tmp_path / "Walls" / "package.mo").write_text(f"package Walls {PARTS} end Walls;")
    user = planarc.load("model Stand Walls.Wall wall; end Stand;", libraries=[tmp_path])
    assert codes(user) == []


def test_it_is_told_to_who_writes_it(tmp_path: Path) -> None:
    own = planarc.load(f"model Stand {PARTS} Wall wall; end Stand;")
    assert codes(own) == ["F225", "F294"]
    (tmp_path / "Walls").mkdir()
    (tmp_path / "Walls" / "package.mo").write_text(f"package Walls {PARTS} end Walls;")
    library = planarc.load("Walls.Wall", libraries=[tmp_path])
    assert codes(library) == ["F225", "F294"]
