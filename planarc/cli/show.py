"""`planarc show`: what a class is made of, in the terminal."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from planarc.cli import console
from planarc.cli.arguments import AsJson, ClassName, Libraries, Target, make_request
from planarc.core.diagnostic import PlanarcError, usage_error
from planarc.core.prose import counted

if TYPE_CHECKING:
    from planarc.api.model import Model
    from planarc.catalog.handbook.pages import ClassPage
    from planarc.flatten.library.library import Entry, Library
    from planarc.view.page.controls import Field

_HEAD = ("name", "value", "unit", "description")
_WIDEST = 40  # characters of a value


def show(
    target: Target,
    class_name: ClassName = None,
    library: Libraries = None,
    as_json: AsJson = False,
) -> int:
    """Show what a class is made of, with units and defaults.

    Parameters, connectors, components and variables, with their descriptions. Of a model that runs,
    also all that --set takes: the parameters and start values of its components.
    """
    entry, classes = _entry(target, class_name, library)
    from planarc.catalog.handbook.gather import page_of
    from planarc.request.request import is_example

    page = page_of(classes, entry)
    model = _compiled(target, entry.full_name, library) if is_example(entry) else None
    if as_json:
        console.say(json.dumps({"ok": True, **_as_json(page, model)}))
    else:
        console.say("\n".join(_lines(page, model)))
    return 0


def _entry(
    target: str, class_name: str | None, library: list[Path] | None
) -> tuple[Entry, Library]:
    """The class that is meant: any one, not only what can be simulated."""
    from planarc.request.request import open_library, open_target

    request = make_request(target, class_name, library)
    classes, _, declared = open_library(request)
    if request.class_name is None and len(declared) == 1:
        name = declared[0]
    elif request.class_name is not None and classes.entry(request.class_name) is not None:
        name = request.class_name
    else:
        name = open_target(request).class_name
    found = classes.entry(name)
    if found is None:
        raise usage_error("C103", f"there is no class `{name}`")
    return found, classes


def _compiled(target: str, name: str, library: list[Path] | None) -> Model | None:
    """The model with its values; one that is wrong is shown as far as its text tells."""
    from planarc.api.model import Model
    from planarc.core.options import fastest_backend

    try:
        return Model(make_request(target, name, library), fastest_backend())
    except PlanarcError as problem:
        console.complain(problem.diagnostics)
        return None


def _lines(page: ClassPage, model: Model | None) -> Iterator[str]:
    said = f' "{page.comment}"' if page.comment else ""
    yield f"{page.kind} {page.name}{said}"
    if page.bases:
        yield f"extends {', '.join(base.text for base in page.bases)}"
    if model is not None:
        p = model.program
        yield f"{counted(p.equations_before, 'equation')}, {counted(p.state_count, 'state')}"
    for label, text in page.head:
        if label != "Check":
            yield from _labelled(label, text)
    for heading, rows in page.tables:
        told = heading.lower() if heading == "Values" else heading
        values = [(r.name, _short(r.value), r.unit, r.comment) for r in rows]
        if heading in ("Components", "Connectors"):
            values = [(r.name, r.type.text, "", r.comment) for r in rows]
        yield from _table(told[0].upper() + told[1:], values)
    if page.children:
        yield from ("", "Classes", *(f"  {name}" for name in page.children))
    found = list(_settable(model))
    for title, fields in found:
        yield from _table(title, [_row(f) for f in fields])
    if found:
        yield from ("", "numbers without unit count in SI units; others have theirs: 45deg, 20cm")


def _labelled(label: str, text: str) -> Iterator[str]:
    first, *more = text.split("\n")
    yield f"{label + ':':8}{first}"
    yield from (" " * 8 + line for line in more)


def _table(title: str, rows: Sequence[tuple[str, ...]]) -> Iterator[str]:
    """A heading, and below it columns without a head."""
    if not rows:
        return
    yield from ("", title)
    widths = [max(len(row[i]) for row in rows) for i in range(3)]
    for row in rows:
        cells = (cell.ljust(w) for cell, w in zip(row, widths, strict=False))
        words = "  ".join(cell for cell, w in zip(cells, widths, strict=True) if w)
        yield f"  {words}  {console.plain(row[3])}".rstrip()


def _short(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= _WIDEST else f"{line[: _WIDEST - 3]}..."


def _settable(model: Model | None) -> Iterator[tuple[str, Sequence[Field]]]:
    """What `--set` takes, by components; what only the picture needs is left out."""
    if model is None:
        return
    from planarc.view.page.controls import REST, groups_of

    for group in groups_of(model.program, model.compiled().parameters()):
        if group.title != REST:
            title = f"{group.title} ({group.description})" if group.description else group.title
            yield f"--set: {title or 'of the model itself'}", group.fields


def _row(field: Field) -> tuple[str, str, str, str]:
    name = f"{field.name}.start" if field.start else field.name
    value: object = f"{field.value * field.factor + 0.0:.6g}"
    if field.kind == "Boolean":
        value = "true" if field.value else "false"
    elif field.literals:
        value = field.literals[int(field.value) - 1]
    return name, str(value), field.unit, field.description


def _as_json(page: ClassPage, model: Model | None) -> dict[str, Any]:
    tables = {
        heading.lower(): [
            {"name": r.name, "type": r.type.target or r.type.text, "value": r.value,
             "unit": r.unit, "description": r.comment,
             "from": None if r.origin is None else r.origin.target}
            for r in rows
        ]
        for heading, rows in page.tables
    }  # fmt: skip
    settable = [
        {"name": f"{f.name}.start" if f.start else f.name, "value": f.value,
         "shown": f.value * f.factor, "unit": f.unit, "description": f.description}
        for _, fields in _settable(model)
        for f in fields
    ]  # fmt: skip
    counts = model and {"equations": model.program.equations_before,
                        "states": model.program.state_count}  # fmt: skip
    return {
        "class": page.name, "kind": page.kind, "description": page.comment,
        "extends": [base.target for base in page.bases], "classes": list(page.children),
        **tables, "settable": settable, "counts": counts,
    }  # fmt: skip
