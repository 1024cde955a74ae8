"""Which files are watched, and that an edit is noticed once."""

from __future__ import annotations

import time
from pathlib import Path

from planarc.live.watch import PERIOD, Watch, files_of
from planarc.request.request import Request


def test_the_file_and_the_users_libraries_are_watched(tmp_path: Path) -> None:
    file = tmp_path / "a.pmo"
    library = tmp_path / "Lib"
    (library / "Inner").mkdir(parents=True)
    found = [library / "package.mo", library / "Inner" / "package.mo", library / "Inner" / "B.mo"]
    for path in (file, *found, library / "notes.txt"):
        path.write_text("", "utf-8")
    watched = files_of(Request(file, None, (library,)))
    assert watched[0] == file
    assert set(watched[1:]) == set(found)
    assert files_of(Request(None, "PlanarMultiBody.World")) == ()


def test_an_edit_is_noticed_once(tmp_path: Path) -> None:
    file = tmp_path / "a.pmo"
    file.write_text("one", "utf-8")
    noticed: list[str] = []
    watch = Watch(Request(file), lambda: noticed.append(file.read_text("utf-8")))
    try:
        # As editors do: a new file takes the place of the old one.
        new = tmp_path / "a.new"
        new.write_text("other", "utf-8")
        new.replace(file)
        until = time.monotonic() + 300
        while not noticed and time.monotonic() < until:
            time.sleep(0.02)
        time.sleep(3 * PERIOD)
        assert noticed == ["other"]
    finally:
        watch.stop()
