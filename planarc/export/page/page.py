"""A page that runs its model itself: one file, without a server and without a network.

In:   Compiled, Result of a run of it
Out:  Page   its text

    fields     parameters and start values, as `planarc serve` shows them, but for what would
               compile the model again
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
from typing import TYPE_CHECKING, Any

from msgspec import to_builtins
from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic
from planarc.core.render import render_all
from planarc.export.actions import endings, errors, message_text
from planarc.export.fits import misfits
from planarc.export.page.drawing import Drawing, draw
from planarc.export.page.module import make_module
from planarc.export.plan import is_settable
from planarc.export.touches import jams
from planarc.ir.dae import Assertion, Reinit, SetDiscrete, Terminate
from planarc.solve.messages.event import assertion_diagnostic, no_value, terminated
from planarc.view.page import assets
from planarc.view.page.controls import Field, Group, groups_of
from planarc.view.page.data import ROWS
from planarc.view.page.live import Surroundings, live_script, live_text
from planarc.view.page.typeset import typeset

if TYPE_CHECKING:
    from planarc.compiled import Compiled
    from planarc.ir.program import Program
    from planarc.ir.result import Result

_HERE = Path(__file__).parent
#: Only what stands in the page runs, and nothing is asked of anyone.
_POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; img-src data: blob:; "
    "script-src {hashes} 'wasm-unsafe-eval'; base-uri 'none'; form-action 'none'"
)
#: An assertion's message names the instant, which only the page knows.
_NOW = "t = 0 s"
#: The place of a number in a message.
_MARK = "\x01"
_START = (
    "no start is found with these values: a loop does not close, or the way there from the "
    "values of the file is too far"
)
_STEP = (
    "the equations have no solution there, or the motion is too quick for the page's method; "
    "`planarc simulate` may tell more"
)


class Page(Data):
    """The text, and how many values can be set in it."""

    text: str
    fields: int


def make_page(compiled: Compiled, result: Result) -> Page:
    """The page of a model; `result` is its run with the values of the file."""
    program = compiled.program
    module, drawing = make_module(compiled), draw(result)
    groups = tuple(_groups(compiled, module.starts))
    script = live_script(*(_text(n) for n in ("engine.js", "record.js", "own.js")))
    policy = _POLICY.format(hashes=assets.policy(assets.chart_script(), script))
    data = {
        "places": dict(_places(program, groups)),
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
        "told": _told(program, drawing),
    }
    around = Surroundings(
        head=f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n',
        menu='<button id="link" type="button" class="link" '
        'title="The address of this page with these values">copy link</button>\n    ',
        about=_about(drawing),
        footer="Made by planarc. This page holds the model itself and asks nothing of the network.",
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


def _groups(compiled: Compiled, starts: frozenset[int]) -> Iterator[Group]:
    """The fields that a run takes: no structural ones, and of start values those that are held."""
    program = compiled.program
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

    def place(f: Field) -> tuple[int, int]:
        return (known[f.name].slot, known[f.name].sign) if f.start else (slots[f.name], 1)

    for group in groups:
        for f in group.fields:
            yield (f"{f.name}.start" if f.start else f.name), place(f)


def _told(program: Program, drawing: Drawing) -> dict[str, Any]:
    """What the page says where a run cannot go on."""
    return {
        "notes": [["remark", note] for note in drawing.notes],
        "start": _START,
        "step": _STEP,
        "refused": "this value follows from others",
        "assertions": [
            {
                "message": d.message.replace(_NOW, "t = @ s", 1),
                "text": render_all((d,)),
                "severity": d.severity.value,
            }
            for d in ends_of(program)
        ],
    }


def ends_of(program: Program) -> Iterator[Diagnostic]:
    """What a run tells that ends at time 0, in the order of the numbers of endings."""
    for i, action in enumerate(endings(program)):
        if isinstance(action, Assertion):
            # the page knows no numbers of those that stand in a `when`
            text = _message if i < len(errors(program)) else _dotted
            yield assertion_diagnostic(program, 0.0, action, text(action))
        elif isinstance(action, Terminate):
            yield terminated(0.0, action, message_text(action.message))
        else:
            assert isinstance(action, SetDiscrete | Reinit)
            name = action.name if isinstance(action, SetDiscrete) else repr(action.symbol)
            yield no_value(program, 0.0, name, action)
    yield from jams(program)
    yield from misfits(program)


def _dotted(assertion: Assertion) -> str:
    return message_text(assertion.message)


def _message(assertion: Assertion) -> str:
    """The message of an assertion: a mark for each number that the page knows, else dots."""
    marked = (
        p if isinstance(p, str) else "..." if p[1] else _MARK for p in assertion.message.parts
    )
    return "".join(marked)


def _about(drawing: Drawing) -> str:
    if not drawing.facts:
        return ""
    rows = "".join(
        f"<dt>{html.escape(label)}</dt><dd>{html.escape(typeset(text))}</dd>"
        for label, text in drawing.facts
    )
    return (
        '<aside class="about" aria-label="About the mechanism"><section class="card">'
        f"<h2>Mechanism, as the file says</h2><dl>{rows}</dl></section></aside>\n"
    )


def _line(d: Diagnostic) -> str:
    return f"{d.message}\n{d.hint}" if d.hint else d.message


@cache
def _text(name: str) -> str:
    return (_HERE / name).read_text(encoding="utf-8")
