"""Many mechanisms on one page, each moving on a small stage of its own.

In:   cards    a scene each, or the reason why there is none
Out:  the page as text, made like a report: one file, no network, no texts that become markup
"""

from __future__ import annotations

import html
from collections.abc import Sequence
from string import Template
from typing import Any

from planarc.core.arrays import spread
from planarc.core.data import Data
from planarc.view.page import assets
from planarc.view.page.data import scene_data
from planarc.view.scene import Scene

#: Rows of a card's motion.
ROWS = 160


class Card(Data):
    """A mechanism of the gallery: `facts` on one line, `report` its file relative to the page."""

    title: str
    description: str
    facts: str = ""
    scene: Scene | None = None
    problem: str = ""
    report: str = ""


def render_gallery(title: str, cards: Sequence[Card]) -> str:
    script = assets.script(*assets.PLAYER, "gallery.js")
    scenes = [None if card.scene is None else _scene(card.scene) for card in cards]
    return Template(assets.text("gallery.html")).substitute(
        head=assets.head(title, (script,), ("base.css", "player.css", "gallery.css")),
        title=html.escape(title),
        cards="".join(_card(i, card) for i, card in enumerate(cards)),
        data=assets.embed_json(scenes),
        script=script,
    )


def _scene(scene: Scene) -> dict[str, Any]:
    return scene_data(scene, spread(len(scene.time), ROWS))


def _card(number: int, card: Card) -> str:
    name = html.escape(card.title)
    if card.report:
        name = f'<a href="{html.escape(card.report, quote=True)}">{name}</a>'
    stage = f'<div class="small" data-scene="{number}"></div>' if card.scene is not None else ""
    problem = f'<p class="problem">{html.escape(card.problem)}</p>' if card.problem else ""
    return (
        f'<article class="card">{stage}{problem}<h2>{name}</h2>'
        f"<p>{html.escape(card.description)}</p>"
        f'<p class="faint">{html.escape(card.facts)}</p></article>'
    )
