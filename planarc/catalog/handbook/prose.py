"""A library's own HTML, made harmless.

In:   str   the `info` text of a Documentation annotation, written by anyone
Out:  str   the same with known elements and no attribute but the target of a link

Scripts, styles, forms and pictures are left out with what they hold; an unknown
element is left out and its text stays. All elements are closed where they began.

Example:

    <html><p onclick="f()">See <a href="modelica://A.B">B</a></p><script>g()</script></html>

    <p>See <a href="#A.B">B</a></p>
"""

from __future__ import annotations

import html
import re
from collections import Counter
from collections.abc import Container
from html.parser import HTMLParser

_KEPT = frozenset(
    re.findall(
        r"\w+",
        """p b i em strong code pre tt ul ol li dl dt dd table tr td th thead tbody caption
        h1 h2 h3 h4 h5 h6 sub sup blockquote a u small var kbd samp""",
    )
)
_EMPTY = frozenset(("br", "hr"))
_DROPPED = frozenset(("script", "style", "iframe", "object", "embed", "form", "svg", "template"))
_LIBRARY = "modelica://"


def clean(text: str, known: Container[str]) -> str:
    """Harmless HTML. Links to classes in `known` lead to their sections."""
    cleaner = _Cleaner(known)
    # Marked sections are no HTML, and Python's parser breaks off at those that it does not know.
    cleaner.feed(text.replace("<![", "<! ["))
    cleaner.close()
    return cleaner.result()


class _Cleaner(HTMLParser):
    def __init__(self, known: Container[str]) -> None:
        super().__init__(convert_charrefs=True)
        self._known = known
        self._out: list[str] = []
        self._open: list[str] = []
        self._depth: Counter[str] = Counter()  # of each tag in `_open`
        self._dropping = 0

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag in _DROPPED:
            self._dropping += 1
        elif self._dropping:
            return
        elif tag in _EMPTY:
            self._out.append(f"<{tag}>")
        elif tag in _KEPT:
            self._open.append(tag)
            self._depth[tag] += 1
            self._out.append(f"<{tag}{self._target(tag, dict(attrs))}>")

    def handle_endtag(self, tag: str) -> None:
        if tag in _DROPPED:
            self._dropping = max(self._dropping - 1, 0)
        elif not self._dropping and self._depth[tag]:
            while True:
                closed = self._open.pop()
                self._depth[closed] -= 1
                self._out.append(f"</{closed}>")
                if closed == tag:
                    break

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in _DROPPED:
            self.handle_starttag(tag, attrs)
            self.handle_endtag(tag)

    def handle_data(self, data: str) -> None:
        if not self._dropping:
            self._out.append(html.escape(data))

    def _target(self, tag: str, attributes: dict[str, str | None]) -> str:
        target = (attributes.get("href") or "").strip() if tag == "a" else ""
        if target.lower().startswith(_LIBRARY):
            name = target[len(_LIBRARY) :]
            return f' href="#{html.escape(name)}"' if name in self._known else ""
        if target.startswith(("https://", "http://")):
            return f' href="{html.escape(target)}" rel="noreferrer"'
        return ""

    def result(self) -> str:
        return "".join(self._out) + "".join(f"</{tag}>" for tag in reversed(self._open))
