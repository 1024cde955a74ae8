"""The live page as text: the modules of the report with controls beside them."""

from __future__ import annotations

import html
from functools import cache
from pathlib import Path
from string import Template

from planarc.view.page import assets

_HERE = Path(__file__).parent


def live_page(name: str, description: str) -> tuple[str, str]:
    """The page, and the content security policy that it is to be sent with."""
    chart, script = assets.chart_script(), _script()
    text = Template(_text("page.html")).substitute(
        name=html.escape(name),
        description=html.escape(description),
        styles=assets.styles(*assets.STYLES, "page.css") + _text("live.css"),
        chart=chart,
        script=script,
    )
    policy = (
        f"default-src 'none'; script-src {assets.policy(chart, script)}; "
        "style-src 'unsafe-inline'; connect-src 'self'; img-src data: blob:; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )
    return text, policy


@cache
def _script() -> str:
    shared = assets.script(*assets.PLAYER, *assets.PLOTS)
    return shared + "".join(f"{{\n{_text(n)}}}\n" for n in ("fields.js", "live.js"))


@cache
def _text(name: str) -> str:
    return (_HERE / name).read_text(encoding="utf-8")
