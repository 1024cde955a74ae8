"""The live page as text: the modules of the report with controls beside them."""

from __future__ import annotations

import html
from functools import cache
from pathlib import Path
from string import Template

from planarc.view.page import assets

_HERE = Path(__file__).parent


#: The panels of editors that may show a framed page: of a desktop, in a browser, or by a tunnel.
#: A page's token is known to its editor alone.
_EDITORS = (
    "vscode-webview: vscode-file: https://*.vscode-cdn.net "
    "http://127.0.0.1:* http://localhost:* https://127.0.0.1:* https://localhost:*"
)


def live_page(name: str, description: str, framed: bool = False) -> tuple[str, str]:
    """The page, and the content security policy that it is to be sent with."""
    chart, script = assets.chart_script(), _script()
    package, _, title = name.rpartition(".")
    text = Template(_text("page.html")).substitute(
        package=html.escape(package),
        title=html.escape(title),
        description=html.escape(description),
        kind="live framed" if framed else "live",
        styles=assets.styles(*assets.STYLES, "page.css") + _text("live.css"),
        chart=chart,
        script=script,
    )
    around = _EDITORS if framed else "'none'"
    policy = (
        f"default-src 'none'; script-src {assets.policy(chart, script)}; "
        "style-src 'unsafe-inline'; connect-src 'self'; img-src data: blob:; "
        "base-uri 'none'; form-action 'none'; "
        f"frame-ancestors {around}"
    )
    return text, policy


@cache
def _script() -> str:
    shared = assets.script(*assets.PLAYER, *assets.PLOTS)
    return shared + "".join(
        f"{{\n{_text(n)}}}\n" for n in ("fields.js", "frame.js", "drag.js", "live.js")
    )


@cache
def _text(name: str) -> str:
    return (_HERE / name).read_text(encoding="utf-8")
