"""The live page as text: the modules of the report with controls beside them."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from msgspec.structs import replace

from planarc.view.page import assets
from planarc.view.page.live import Surroundings, live_script, live_text

_HERE = Path(__file__).parent


#: The panels of editors that may show a framed page: of a desktop, in a browser, or by a tunnel.
#: A page's token is known to its editor alone.
_EDITORS = (
    "vscode-webview: vscode-file: https://*.vscode-cdn.net "
    "http://127.0.0.1:* http://localhost:* https://127.0.0.1:* https://localhost:*"
)


#: What is kept as a file: its address, its ending, what it is called.
_MENU = """\
<details id="keep" class="keep">
      <summary title="Keep" aria-label="Keep"></summary>
      <div class="menu">
        <button type="button" data-file="report" data-ending="html">Report (.html)</button>
        <button type="button" data-file="csv" data-ending="csv">Table (.csv)</button>
        <button type="button" data-file="svg" data-ending="svg">This picture (.svg)</button>
      </div>
    </details>
"""
_AROUND = Surroundings(
    head='<link rel="icon" href="data:,">\n',
    menu=_MENU,
    footer="Served by planarc on this machine only. The page follows the file when it is edited.",
)


def live_page(name: str, description: str, framed: bool = False) -> tuple[str, str]:
    """The page, and the content security policy that it is to be sent with."""
    script = _script()
    around = replace(_AROUND, kind="live framed") if framed else _AROUND
    policy = (
        f"default-src 'none'; script-src {assets.policy(assets.chart_script(), script)}; "
        "style-src 'unsafe-inline'; connect-src 'self'; img-src data: blob:; "
        "base-uri 'none'; form-action 'none'; "
        f"frame-ancestors {_EDITORS if framed else repr('none')}"
    )
    return live_text(name, description, script, around), policy


def _script() -> str:
    return live_script(*(_text(n) for n in ("frame.js", "drag.js", "served.js")))


@cache
def _text(name: str) -> str:
    return (_HERE / name).read_text(encoding="utf-8")
