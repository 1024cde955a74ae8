"""The text of a live page: the modules of the report, with controls beside them.

Who makes the page says where its answers come from: a script that sets `planarc.source`.
"""

from __future__ import annotations

import html
from functools import cache
from string import Template

from planarc.core.data import Data
from planarc.view.page import assets


class Surroundings(Data):
    """What stands around the controls, as HTML; `data` are script elements that hold data."""

    kind: str = "live"  # classes of the body
    head: str = ""
    menu: str = ""  # buttons beside the theme's
    about: str = ""  # below everything
    footer: str = ""
    data: str = ""


@cache
def live_script(*more: str) -> str:
    """The page's script; `more` are the texts of modules that set `planarc.source`."""
    shared = assets.script(*assets.PLAYER, *assets.PLOTS, "fields.js")
    return shared + "".join(f"{{\n{text}}}\n" for text in (*more, assets.text("live.js")))


def live_text(name: str, description: str, script: str, around: Surroundings) -> str:
    """The page of a model."""
    package, _, title = name.rpartition(".")
    return Template(assets.text("live.html")).substitute(
        package=html.escape(package),
        title=html.escape(title),
        description=html.escape(description),
        kind=around.kind,
        head=around.head,
        menu=around.menu,
        about=around.about,
        footer=around.footer,
        data=around.data,
        styles=assets.styles(*assets.STYLES, "page.css", "live.css"),
        chart=assets.chart_script(),
        script=script,
    )
