"""The site builds without a warning, its links hold, and it has a place for everything."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urldefrag

import planarc
from planarc.catalog.explanations import Code
from planarc.catalog.handbook.gather import gather
from planarc.cli.arguments import open_classes
from planarc.cli.commands import COMMANDS
from planarc_docs.library import LIBRARIES, has_own_page

ROOT = Path(__file__).parents[2]
#: Hosts that a page may name: of the specification, the papers, and the theme's own line.
HOSTS = {"specification.modelica.org", "doi.org", "github.com", "www.sphinx-doc.org"}


class _Page(HTMLParser):
    """The links and the anchors of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors = {""}
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {k: v or "" for k, v in attrs}
        self.anchors.add(given.get("id", ""))
        if tag in ("a", "img") and (target := given.get("href") or given.get("src")):
            self.links.append(target)


def test_the_site_builds_and_is_whole(tmp_path: Path) -> None:
    """One test, so that the site is built once."""
    command = [sys.executable, "-m", "sphinx", "-W", "-n", "--keep-going", "-q", "docs"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    told = subprocess.run(
        [*command, str(tmp_path)], cwd=ROOT, env=environment, capture_output=True, text=True
    )
    assert told.returncode == 0, told.stderr
    texts = {p: p.read_text("utf-8") for p in tmp_path.rglob("*.html")}
    pages = {p: _Page(text) for p, text in texts.items()}
    links_hold(pages)
    everything_has_a_place(tmp_path, pages)
    for path, text in texts.items():
        assert str(ROOT) not in text, path


def links_hold(pages: dict[Path, _Page]) -> None:
    for path, page in pages.items():
        for link in page.links:
            target, anchor = urldefrag(link)
            host = re.match(r"\w+://([^/]+)", target)
            if host is not None:
                assert host[1] in HOSTS, f"{path.name}: {link}"
                continue
            file = (path.parent / unquote(target)).resolve() if target else path
            assert file.exists(), f"{path.name}: {link}"
            if file in pages:
                assert unquote(anchor) in pages[file].anchors, f"{path.name}: {link}"


def everything_has_a_place(site: Path, pages: dict[Path, _Page]) -> None:
    anchors = set().union(*(page.anchors for page in pages.values()))
    assert {f"planarc.{name}" for name in planarc.__all__} <= anchors
    assert {code.name.lower() for code in Code} <= anchors
    assert {p.stem for p in (site / "commands").glob("*.html")} == COMMANDS.keys()
    for library in LIBRARIES:
        assert (site / "library" / f"{library}.html").exists()
    for page in gather(*open_classes(LIBRARIES[0], None)):
        path = site / "library" / f"{page.name}.html"
        if has_own_page(page) and path in pages and ".Examples." not in page.name:
            moving = [link for link in pages[path].links if "/motion-" in link]
            assert moving, f"{page.name} has no picture"
