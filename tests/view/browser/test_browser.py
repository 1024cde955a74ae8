"""The watch over the browser itself: a page that misbehaves is noticed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

BAD = {
    "console": "<script>console.error('this is wrong')</script>",
    "exception": "<script>nothing.here()</script>",
    "request": "<img src='http://elsewhere.example/a.png'>",
}


@pytest.mark.parametrize("kind", BAD)
def test_a_page_that_misbehaves_is_noticed(
    kind: str, open_page: Callable[..., Any], watch: Any, tmp_path: Path
) -> None:
    file = tmp_path / "bad.html"
    file.write_text(f"<!doctype html><title>bad</title>{BAD[kind]}", encoding="utf-8")
    open_page(file)
    assert [c for c in watch.unexpected() if c.startswith(kind)]
    watch.allowed = [""]  # all of it


def test_a_page_that_does_nothing_is_fine(
    open_page: Callable[..., Any], watch: Any, tmp_path: Path, screenshot: Callable[..., Path]
) -> None:
    file = tmp_path / "good.html"
    file.write_text("<!doctype html><title>good</title><p>all is well", encoding="utf-8")
    page = open_page(file)
    assert page.title() == "good"
    assert watch.addresses == [file.as_uri()]
    assert screenshot(page, "browser").stat().st_size > 1000
