"""Writes the page: text, styles, scripts and data in one file that needs no network.

A model's texts are data: in HTML they are escaped, in the script's JSON `<`, `>` and `&` are
written as escapes, and a content security policy lets only the scripts of this page run, known
by their hashes.
"""

from __future__ import annotations

import base64
import hashlib
import html
import json
from collections.abc import Sequence
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING

from planarc.core.diagnostic import Diagnostic, UsageError
from planarc.view.report.curves import choose_curves
from planarc.view.report.data import page_data

if TYPE_CHECKING:
    from planarc.ir.result import Result
    from planarc.view.scene import Scene

_HERE = Path(__file__).parent
_VENDOR = _HERE.parent / "vendor"
_SCRIPTS = ("draw.js", "player.js", "plots.js", "page.js")


def write_report(
    path: Path,
    result: Result,
    scene: Scene,
    summary: Sequence[tuple[str, str]] = (),
    curves: Sequence[str] | None = None,
) -> None:
    """Write the page of a run to `path`.

    `summary` is shown as a table of label and text; `curves` names the variables to plot,
    None chooses them. Raises UsageError where the file cannot be written or a name is unknown.
    """
    unknown = [name for name in curves or () if name not in result]
    if unknown:
        raise UsageError(Diagnostic("V102", f"the result has no variable `{unknown[0]}`"))
    text = render_page(result, scene, summary, None if curves is None else tuple(curves))
    try:
        path.write_text(text, encoding="utf-8", newline="\n")
    except OSError as reason:
        message = f"cannot write the report `{path}`: {reason.strerror or reason}"
        raise UsageError(Diagnostic("V101", message)) from None


def render_page(
    result: Result,
    scene: Scene,
    summary: Sequence[tuple[str, str]] = (),
    curves: tuple[str, ...] | None = None,
) -> str:
    """The page as text."""
    program = result.program
    data = page_data(result, scene, choose_curves(result, curves))
    chart = (_VENDOR / "uPlot.iife.min.js").read_text(encoding="utf-8")
    script = "\n".join((_HERE / name).read_text(encoding="utf-8") for name in _SCRIPTS)
    notes = [*_notes(result, len(data["time"])), *scene.notes]
    return Template((_HERE / "page.html").read_text(encoding="utf-8")).substitute(
        policy=f"'sha256-{_digest(chart)}' 'sha256-{_digest(script)}'",
        name=html.escape(program.name),
        description=html.escape(program.description),
        styles=(_VENDOR / "uPlot.min.css").read_text(encoding="utf-8")
        + (_HERE / "page.css").read_text(encoding="utf-8"),
        summary="".join(
            f"<tr><th>{html.escape(label)}</th><td>{html.escape(value)}</td></tr>"
            for label, value in summary
        ),
        notes="".join(f"<p>{html.escape(note)}</p>" for note in notes),
        data=embed_json(data),
        chart=chart,
        script=script,
    )


def embed_json(value: object) -> str:
    """JSON that cannot leave its script element, nor end a line in old engines."""
    text = json.dumps(value, separators=(",", ":"), ensure_ascii=True, allow_nan=False)
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text


def _digest(script: str) -> str:
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()


def _notes(result: Result, shown: int) -> list[str]:
    notes = []
    if result.ended is not None:
        notes.append(f"The run ended at t = {result.time[-1]:g} s: {result.ended.message}")
    if shown < len(result.time):
        notes.append(
            f"Shown are {shown} of {len(result.time)} rows; of each stretch of time the lowest "
            "and highest values are kept. The result file holds all rows."
        )
    return notes
