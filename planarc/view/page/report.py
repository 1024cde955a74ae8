"""The page of a run: text, styles, scripts and data in one file that needs no network.

A model's texts are data: in HTML they are escaped, in the script's JSON `<`, `>` and `&` are
written as escapes, and a content security policy lets only the scripts of this page run, known
by their hashes.
"""

from __future__ import annotations

import html
import re
from collections.abc import Sequence
from pathlib import Path
from string import Template

from planarc.core.diagnostic import Diagnostic, Severity, UsageError
from planarc.core.prose import counted
from planarc.ir.insight import Insight, Peak
from planarc.ir.result import Result
from planarc.view.page import assets
from planarc.view.page.data import choose_rows, curve_data, room_beside, scene_data
from planarc.view.page.figures import choose_figures
from planarc.view.page.runs import Shown, run_data
from planarc.view.page.typeset import number, typeset, unit
from planarc.view.scene import Scene
from planarc.view.storage import write_text

#: The most events that the page lists.
EVENTS = 1000
#: The most rows of the table of peaks.
PEAKS = 60

Rows = Sequence[tuple[str, str]]


def write_report(
    path: Path,
    result: Result,
    scene: Scene,
    summary: Rows = (),
    curves: Sequence[str] | None = None,
    insight: Insight | None = None,
    notes: Sequence[str] = (),
    label: str = "",
    others: Sequence[Shown] = (),
) -> None:
    """Write the page of a run to `path`.

    `summary` is shown as labels with texts; `curves` names the variables to plot, None chooses
    them; `notes` stand at the top; `others` are laid beside the run, which is then called
    `label`. Raises UsageError where the file cannot be written or a name is unknown.
    """
    unknown = [name for name in curves or () if name not in result]
    if unknown:
        raise UsageError(Diagnostic("V102", f"the result has no variable `{unknown[0]}`"))
    chosen = None if curves is None else tuple(curves)
    page = render_page(result, scene, summary, chosen, insight, notes, label, others)
    write_text(path, page)


def render_page(
    result: Result,
    scene: Scene,
    summary: Rows = (),
    curves: tuple[str, ...] | None = None,
    insight: Insight | None = None,
    notes: Sequence[str] = (),
    label: str = "",
    others: Sequence[Shown] = (),
) -> str:
    """The page as text."""
    program = result.program
    figures = choose_figures(result, curves, insight)
    share = 1 + len(others)
    rows = choose_rows(result, figures, 4 * len(scene.items), share)
    events = [(e.time, typeset(", ".join(e.causes))) for e in result.events[:EVENTS]]
    series, layers = ((), ()) if insight is None else (insight.series, insight.layers)
    motion = scene_data(scene, rows, sorted({t for t, _ in events}), layers)
    data = {
        "name": program.name.rpartition(".")[2],
        "scene": motion,
        "curves": curve_data(result, figures, rows, series, room_beside(motion) // share),
        "events": events,
        "label": label,
        "runs": run_data(others, figures, share),
    }
    chart = assets.chart_script()
    script = assets.script(*assets.PLAYER, *assets.PLOTS, "page.js")
    left_out = data["curves"]["left_out"]  # type: ignore[index]
    remarks = [("remark", n) for n in (*notes, *scene.notes)]
    told = [*_notes(result, len(rows), left_out), *remarks]
    cards = [
        _card("Mechanism", _list(insight.facts)) if insight is not None and insight.facts else "",
        _card("Run", _list(summary)) if summary else "",
        _peaks([Shown(label, result, scene, insight), *others]),
        _card("Events", _events(len(result.events))) if result.events else "",
    ]
    return Template(assets.text("page.html")).substitute(
        head=assets.head(program.name, (chart, script), (*assets.STYLES, "page.css")),
        package=html.escape(program.name.rpartition(".")[0]),
        title=html.escape(program.name.rpartition(".")[2]),
        description=html.escape(program.description),
        notes="".join(f'<p class="{kind}">{_prose(text)}</p>' for kind, text in told),
        cards="".join(cards),
        open="" if any(f.on for f in figures) else " open",
        data=assets.embed_json(data),
        chart=chart,
        script=script,
    )


def _prose(text: str) -> str:
    """A message as HTML: it begins with a capital, and names stand in `code`."""
    escaped = html.escape(typeset(text[:1].upper() + text[1:]))
    return re.sub(r"`([^`\n]*)`", r"<code>\1</code>", escaped)


def _card(title: str, inside: str) -> str:
    return f'<section class="card"><h2>{html.escape(title)}</h2>{inside}</section>'


def _list(rows: Rows) -> str:
    entries = (f"<dt>{html.escape(label)}</dt><dd>{_breaking(text)}</dd>" for label, text in rows)
    return f"<dl>{''.join(entries)}</dl>"


def _breaking(text: str) -> str:
    """A text whose long names break at their dots."""
    return re.sub(r"(?<=\w\w\.)(?=[A-Za-z])", "<wbr>", html.escape(typeset(text)))


def _peaks(runs: Sequence[Shown]) -> str:
    """The largest values of drives and joints, runs side by side."""
    told = [{p.name: p for p in r.insight.peaks} if r.insight else {} for r in runs]
    names = dict.fromkeys(name for peaks in told for name in peaks)
    if not names:
        return ""
    heads = '<th scope="col">peak</th><th scope="col">at s</th><th scope="col">RMS</th>'
    above = "".join(f'<th scope="col" colspan="3">{html.escape(r.label)}</th>' for r in runs)
    lines = [f"<tr><td></td>{above}<td></td></tr>"] if len(runs) > 1 else []
    lines.append(f"<tr><td></td>{heads * len(runs)}<td></td></tr>")
    for name in list(names)[:PEAKS]:
        own = [peaks.get(name) for peaks in told]
        kind = next(unit(p.unit) for p in own if p is not None)
        cells = f"{''.join(map(_peak, own))}<td>{kind}</td>"
        lines.append(f'<tr><th scope="row">{html.escape(name)}</th>{cells}</tr>')
    return _card(
        "Peak and RMS", f'<div class="wide" tabindex="0"><table>{"".join(lines)}</table></div>'
    )


def _peak(peak: Peak | None) -> str:
    if peak is None:
        return "<td></td>" * 3
    return (
        f"<td>{number(peak.value)}</td><td>{number(peak.time, 3)}</td><td>{number(peak.rms)}</td>"
    )


def _events(count: int) -> str:
    more = f'<p class="faint">The first {EVENTS} of {count}.</p>' if count > EVENTS else ""
    return f'<ol id="events"></ol>{more}'


def _notes(result: Result, shown: int, left_out: int) -> list[tuple[str, str]]:
    """Kind and text of what a reader must know before looking."""
    notes = []
    if result.ended is not None:
        kind = "error" if result.ended.severity is Severity.ERROR else "remark"
        notes.append((kind, f"The run ended at t = {result.time[-1]:g} s: {result.ended.message}"))
    notes += [("warning", _told(warning)) for warning in result.warnings]
    if shown < len(result.time):
        text = (
            f"Shown are {shown} of {len(result.time)} rows; of each stretch of time the lowest "
            "and highest values of the first curves are kept. The result file holds all rows."
        )
        notes.append(("remark", text))
    if left_out:
        text = (
            f"{counted(left_out, 'variable')} had no room on this page; the result file holds all."
        )
        notes.append(("remark", text))
    return notes


def _told(warning: Diagnostic) -> str:
    return f"{warning.message}\n{warning.hint}" if warning.hint else warning.message
