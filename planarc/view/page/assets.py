"""The page's scripts and styles: small modules that a page joins as it needs them.

Each script stands in a block of its own and leaves what others use in the object `planarc`;
a page that shows a mechanism takes PLAYER, one with curves PLOTS behind it.

Example: script(*PLAYER, *PLOTS, "page.js") is the whole script of a report.
"""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from string import Template

from planarc.core.digest import sha256

_HERE = Path(__file__).parent
_VENDOR = _HERE.parent / "vendor"

#: The modules of the player, in the order in which they build on each other.
PLAYER = ("base.js", "series.js", "paint.js", "labels.js", "layers.js", "stage.js", "player.js")
PLOTS = ("export.js", "phase.js", "plots.js", "runs.js", "tree.js", "card.js", "events.js")
STYLES = ("base.css", "player.css", "plots.css")


@cache
def script(*names: str) -> str:
    """The modules as one script."""
    blocks = "".join(f"{{\n{_text(_HERE / name)}}}\n" for name in names)
    return f'"use strict";\nconst planarc = {{}};\nwindow.planarc = planarc;\n{blocks}'


@cache
def styles(*names: str) -> str:
    """The style sheets, with that of the chart library before them."""
    return _text(_VENDOR / "uPlot.min.css") + "".join(_text(_HERE / name) for name in names)


@cache
def chart_script() -> str:
    """The chart library, a script of its own that stands before `script(...)`."""
    return _text(_VENDOR / "uPlot.iife.min.js")


def text(name: str) -> str:
    """A file as it is."""
    return _text(_HERE / name)


def head(title: str, scripts: Sequence[str], sheets: Sequence[str]) -> str:
    """A page up to its body; only these scripts run in it."""
    return Template(text("head.html")).substitute(
        policy=policy(*scripts), title=html.escape(title), styles=styles(*sheets)
    )


def policy(*scripts: str) -> str:
    """The hashes by which a content security policy calls these scripts."""
    return " ".join(f"'sha256-{_digest(s)}'" for s in scripts)


def embed_json(value: object) -> str:
    """The data as JSON that cannot leave its script element, nor end a line in old engines."""
    text = json.dumps(value, separators=(",", ":"), ensure_ascii=True, allow_nan=False)
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text


def _digest(text: str) -> str:
    return base64.b64encode(sha256(text.encode())).decode()


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8")
