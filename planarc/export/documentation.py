"""What people read in an FMU: a page about the model, and the model's own text.

In:   Compiled, Interface
Out:  files of the archive by their paths

    documentation/index.html     the mechanism at its start, inputs, outputs, parameters
    extra/planarc/NAME.pmo       the file that the model stands in

A model that is not drawn, or that cannot be run, has no picture.

Reference: FMI 3.0.2, section 2.5.1 (structure of the archive).
"""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from pathlib import PurePath
from typing import TYPE_CHECKING

from planarc.core.diagnostic import PlanarcError
from planarc.core.options import RunOptions
from planarc.core.source import NOWHERE
from planarc.instance.block import OTHER
from planarc.instance.plan import crowd_names

if TYPE_CHECKING:
    from planarc.compiled import Compiled
    from planarc.export.fmi.variables import Interface, Seen

#: Why there is no model exchange.
_STEPPED = (
    "<p>Bodies of the crowd meet in steps of one length, at whose ends velocities jump; the "
    "parameter <code>_step</code> says how long they are. An integrator of another tool cannot do "
    "that: this FMU is for co-simulation alone.</p>"
)
_WIDTH = 640  # pixels of the picture
_STYLE = (
    "body{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem}"
    "table{border-collapse:collapse}td,th{text-align:left;padding:.2rem .8rem .2rem 0}"
    "td:nth-child(2){font-variant-numeric:tabular-nums}svg{max-width:100%;height:auto}"
)


def documents(compiled: Compiled, shown: Interface) -> dict[str, bytes]:
    """Page and text; a model that is no file but a text has that."""
    page = _page(compiled, shown)
    found = {"documentation/index.html": page.encode()}
    source = compiled.program.span.source if compiled.program.span is not NOWHERE else None
    if source is not None and source.text:
        name = PurePath(source.path or "model.pmo").name
        found[f"extra/planarc/{name}"] = source.text.encode()
    return found


def _page(compiled: Compiled, shown: Interface) -> str:
    program = compiled.program
    tables = (
        ("Inputs", "input", "start"),
        ("Outputs", "output", "start"),
        ("Parameters", "parameter", "value"),
    )
    parts = [
        f"<h1>{escape(program.name)}</h1>",
        f"<p>{escape(program.description)}</p>" if program.description else "",
        _picture(compiled),
        *(_table(title, (v for v in shown.variables if v.causality == cause), head)
          for title, cause, head in tables),
        "<p>Start values that may be set, by any name of theirs: "
        + (", ".join(f"<code>{escape(name)}</code>" for name in _starts(shown)) or "none")
        + ".</p>",
        "<p>A loop of the mechanism is put together as it was at export, also where other "
        "parameters and start values are set before the end of the initialization.</p>",
        _STEPPED if crowd_names(program) else "",
    ]  # fmt: skip
    head = f'<meta charset="utf-8"><title>{escape(program.name)}</title><style>{_STYLE}</style>'
    return f"<!doctype html><html lang=en>{head}{''.join(parts)}</html>\n"


def _starts(shown: Interface) -> Iterable[str]:
    """A name of each value that has a start."""
    found: dict[int, str] = {}
    for v in shown.variables:
        if v.initial == "exact" and v.causality != "parameter":
            found.setdefault(v.reference % OTHER // 8, v.name)
    return found.values()


def _table(title: str, variables: Iterable[Seen], head: str) -> str:
    rows = [
        f"<tr><td><code>{escape(v.name)}</code><td>{'' if v.start is None else f'{v.start:g}'}"
        f"<td>{escape(v.unit)}<td>{escape(_meaning(v))}"
        for v in variables
    ]
    if not rows:
        return ""
    top = "<tr><th>Name<th>" + head.capitalize() + "<th>Unit<th>Description"
    return f"<h2>{title}</h2><table>{top}{''.join(rows)}</table>"


def _meaning(v: Seen) -> str:
    """The description, with the names of a type's values."""
    if v.type is None:
        return v.description
    told = ", ".join(f"{k} {name}" for k, name in enumerate(v.type.literals, 1))
    return f"{v.description} ({told})".strip()


def _picture(compiled: Compiled) -> str:
    """The mechanism at its start, as SVG."""
    from planarc.solve.simulate import simulate
    from planarc.view.picture.camera import fit_camera
    from planarc.view.picture.motion import still
    from planarc.view.picture.svg import render_svg
    from planarc.view.scene import make_scene

    program = compiled.program
    start = program.experiment.start
    try:
        step = 1e-3 if crowd_names(program) else None
        options = RunOptions(stop=start, intervals=1, fixed_step=step, backend=compiled.backend)
        scene = make_scene(simulate(program, compiled.load(), options))
        if scene.box is None:
            return ""
        motion = still(scene, start)
    except PlanarcError:
        return ""
    return render_svg(motion, fit_camera(scene.box, _WIDTH), program.name, False)
