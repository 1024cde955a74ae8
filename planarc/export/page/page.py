"""A page that runs its model itself: one file, without a server and without a network.

In:   Compiled, Result of a run of it
Out:  Page   its text

    fields     inputs; parameters and start values, as `planarc serve` shows them, but for what
               would compile the model again
    module     the model as WebAssembly; `engine.js` runs it
    drawing    what is shown, with the steps that make it from the rows of a run (`record.js`)

Raises:    PlanarcError C300 for what cannot be exported.
"""

from __future__ import annotations

import base64
import html
import json
import zlib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec import to_builtins
from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic
from planarc.export.page.drawing import Drawing, draw
from planarc.export.page.held import held_inputs
from planarc.export.page.module import make_module
from planarc.export.page.told import told_of
from planarc.instance.ends import CROWDED
from planarc.instance.plan import is_eventful, is_settable
from planarc.instance.settling import ENDLESS
from planarc.view.page import assets
from planarc.view.page.controls import Field, Group, groups_of, inputs_of
from planarc.view.page.data import ROWS
from planarc.view.page.live import Surroundings, live_script, live_text
from planarc.view.page.typeset import typeset

if TYPE_CHECKING:
    from planarc.compiled import Compiled
    from planarc.ir.program import Program
    from planarc.ir.result import Result

_HERE = Path(__file__).parent
#: The modules of the page, in the order in which they build on each other.
SCRIPTS = ("engine.js", "record.js", "told.js", "pull.js", "own.js")
#: Only what stands in the page runs, and nothing is asked of anyone.
_POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; img-src data: blob:; "
    "script-src {hashes} 'wasm-unsafe-eval'; base-uri 'none'; form-action 'none'"
)
_SAID = {
    "start": "no start is found with these values: a loop does not close, or the way there from "
    "the values of the file is too far",
    "step": "the equations have no solution there, or the motion is too quick for the page's "
    "method; `planarc simulate` may tell more",
    str(-ENDLESS): "the events there do not come to rest",
    str(-CROWDED): "events follow each other without end there: the model chatters",
    "refused": "this value follows from others",
}


_FOOTER = "Made by planarc. This page holds the model itself and asks nothing of the network."
_DRAG = " Drag a part to let it start elsewhere, with Shift to change its length."
_CARD = '<section class="card"><h2>{}</h2>{}</section>'


class Page(Data):
    """The text, and how many values can be set in it."""

    text: str
    fields: int


def make_page(compiled: Compiled, result: Result, stiff: bool = False) -> Page:
    """The page of a model; `result` is its run with the values of the file. With `stiff` it takes
    implicit steps."""
    program = compiled.program
    module, drawing = make_module(compiled, stiff), draw(result)
    groups = tuple(_groups(compiled, result, module.starts))
    script = live_script(*map(_text, SCRIPTS))
    policy = _POLICY.format(hashes=assets.policy(assets.chart_script(), script))
    data = {
        "places": dict(_places(program, groups)),
        "pulled": list(_pulled(program, groups)),
        "rows": min(len(result.time), ROWS),
        "model": {
            "name": program.name,
            "description": program.description,
            "start": program.experiment.start,
            "stop": program.experiment.stop,
            "groups": to_builtins(groups),
            "choices": [],
            "warnings": [["warning", _line(w)] for w in compiled.warnings],
        },
        "told": {
            **_SAID,
            "notes": [["remark", n] for n in drawing.notes],
            **told_of(program, module.late),
        },
    }
    around = Surroundings(
        head=f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n',
        menu='<button id="link" type="button" class="link" '
        'title="The address of this page with these values">copy link</button>\n    ',
        about=_about(program, drawing),
        footer=_FOOTER + _DRAG if data["pulled"] else _FOOTER,
        data=f'<script type="application/json" id="data">{assets.embed_json(data)}</script>\n'
        f'<script type="text/plain" id="model">{_packed(drawing, module.code)}</script>',
    )
    text = live_text(program.name, program.description, script, around)
    return Page(text, sum(len(g.fields) for g in groups))


def _packed(drawing: Drawing, code: bytes) -> str:
    """The drawing and the module, compressed: `own.js` unpacks them."""
    names = ("data", "steps", "holes", "slots")
    parts = {n: getattr(drawing, n) for n in names}
    told = json.dumps(parts, separators=(",", ":"), allow_nan=False).encode()
    whole = len(told).to_bytes(4, "little") + told + code
    return base64.b64encode(zlib.compress(whole, 9)).decode()


def _groups(compiled: Compiled, result: Result, starts: frozenset[int]) -> Iterator[Group]:
    """The fields that a run takes: inputs, no structural ones, and of start values those that are
    held."""
    program = compiled.program
    driven = inputs_of(program, result, [d.name for d in held_inputs(program)])
    if driven:
        yield Group("Inputs", "held during the run", driven)
    free = {p.name for p in program.parameter_slots if is_settable(p)}
    held = {c.display for c in program.candidates if c.slot in starts}
    for group in groups_of(program, compiled.parameters()):
        own = tuple(f for f in group.fields if f.name in (held if f.start else free))
        if own:
            yield replace(group, fields=own)


def _places(program: Program, groups: tuple[Group, ...]) -> Iterator[tuple[str, tuple[int, int]]]:
    """Where the value of a field stands in the workspace, and with which sign."""
    known = {c.name: c for c in program.columns}
    slots = {p.name: p.slot for p in program.parameter_slots}
    slots |= {name: program.slots[name] for name in program.inputs}
    slots |= {d.name: d.slot for d in held_inputs(program)}

    def place(f: Field) -> tuple[int, int]:
        return (known[f.name].slot, known[f.name].sign) if f.start else (slots[f.name], 1)

    for group in groups:
        for f in group.fields:
            yield _key(f), place(f)


def _pulled(program: Program, groups: tuple[Group, ...]) -> Iterator[str]:
    """The fields that may follow a part that is dragged: inputs, and start values of positions."""
    heights = [b.height for b in program.blocks]
    positions = {c.display for c in program.candidates if heights[c.block] == max(heights)}
    for group in groups:
        for f in group.fields:
            if f.name in (positions if f.start else program.inputs):
                yield _key(f)


def _key(f: Field) -> str:
    """The name of a field in the page."""
    return f"{f.name}.start" if f.start else f.name


def _about(program: Program, drawing: Drawing) -> str:
    """Cards below the rest; those of peaks and events are filled by each run."""
    cards = [
        _facts(drawing) if drawing.facts else "",
        _CARD.format(
            "Peak and RMS", '<div class="wide" tabindex="0"><table id="peaks"></table></div>'
        )
        if drawing.data["peaks"]
        else "",
        _CARD.format("Events", '<ol id="events"></ol>') if is_eventful(program) else "",
    ]
    inside = "".join(cards)
    told = "About the mechanism and the run"
    return f'<aside class="about" aria-label="{told}">{inside}</aside>\n' if inside else ""


def _facts(drawing: Drawing) -> str:
    rows = "".join(
        f"<dt>{html.escape(label)}</dt><dd>{html.escape(typeset(text))}</dd>"
        for label, text in drawing.facts
    )
    return _CARD.format("Mechanism, as the file says", f"<dl>{rows}</dl>")


def _line(d: Diagnostic) -> str:
    return f"{d.message}\n{d.hint}" if d.hint else d.message


@cache
def _text(name: str) -> str:
    return (_HERE / name).read_text(encoding="utf-8")
