"""What a page tells of a run that it has made itself: its end, its warnings, its events.

In:   Program
Out:  texts with marks for what only the run knows: `told.js` puts it there

    ends        what a run may end with (`export.endings`)
    warnings    the assertions that only warn
    events      the relations that switch, and the touches, in words
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from planarc.core.diagnostic import Diagnostic
from planarc.core.render import render_all
from planarc.export.endings import NOW, THEN, ends, ends_of, marked
from planarc.ir.dae import Assertion, Message
from planarc.ir.expr import Op, postorder
from planarc.ir.program import Program
from planarc.runtime import texts
from planarc.solve.contact.messages import between
from planarc.solve.contact.touches import Points
from planarc.solve.messages.assertion import assertion_diagnostic
from planarc.view.page.typeset import typeset

#: Where a message names the instant, which only the page knows.
_MARKED = "t = @ s"


def warnings(program: Program) -> list[Assertion]:
    return [a for a in program.assertions if a.warning]


def told_of(program: Program, late: Sequence[str] = ()) -> dict[str, Any]:
    """All of it for `json`; `late` is why a run may end at a delay."""
    return {
        "ends": [
            {**_text(d), "forms": _forms(message), "severity": d.severity.value}
            for d, message in zip(ends_of(program, names=False), ends(program), strict=True)
        ]
        + [
            {"message": text, "hint": "", "text": "", "forms": [], "severity": "error"}
            for text in late
        ],
        "warnings": [
            {**_text(assertion_diagnostic(program, THEN, a, marked(a.message))),
             "forms": _forms(a.message)}
            for a in warnings(program)
        ],
        "texts": dict(_texts(program)),
        "relations": [[typeset(r.text), r.component] for r in program.relations],
        "samplers": len(program.samplers),
        "touches": list(_touches(program)),
    }  # fmt: skip


def touch_slots(program: Program) -> list[tuple[int, ...]]:
    """Where it stands whether a touch is closed, which way it slides, and its last impulse."""
    return [tuple(t.slots[n] for n in ("held", "way", "impulse")) for t in Points(program).all]


def _touches(program: Program) -> Iterator[list[Any]]:
    points = Points(program)
    for i, (touch, slots) in enumerate(zip(points.all, touch_slots(program), strict=True)):
        yield [between(points, i), touch.name, *slots]


def _text(d: Diagnostic) -> dict[str, str]:
    """A diagnostic with a mark for its instant."""
    message = d.message.replace(NOW, _MARKED, 1)
    return {"message": message, "hint": d.hint or "", "text": render_all((d,))}


def _forms(message: Message) -> list[str]:
    """How each value is written."""
    return [p[1] for p in message.parts if not isinstance(p, str)]


def _texts(program: Program) -> Iterator[tuple[str, str]]:
    """The texts that a message may choose among, by the numbers that stand for them."""
    messages = (*ends(program), *(a.message for a in warnings(program)))
    chosen = [p[0] for m in messages for p in m.parts if not isinstance(p, str) and p[1] == '"']
    for e in postorder(chosen):
        if e.op is Op.CONST:
            yield str(int(e.data)), texts.text_of(e.data)
