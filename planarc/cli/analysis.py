"""The common parts of the commands of analyses: the model, settings, numbers as text and JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from planarc.cli import console
from planarc.cli.arguments import choose_backend, make_request
from planarc.cli.settings import Given, read_settings, sort_settings
from planarc.core.diagnostic import Diagnostic, Severity, usage_error
from planarc.core.options import Redundant

if TYPE_CHECKING:
    from planarc.api.model import Model
    from planarc.core.options import Backend


def open_model(
    target: str,
    class_name: str | None,
    libraries: Sequence[Path] | None,
    backend: Backend | None = None,
    redundant: Redundant = Redundant.REFUSE,
) -> Model:
    """Compile the model and print its warnings."""
    from planarc.api.model import Model

    request = make_request(target, class_name, libraries, redundant)
    model = Model(request, choose_backend(backend))
    console.complain(model.warnings)
    return model


def with_settings(
    model: Model, settings: Sequence[str] | None
) -> tuple[Model, dict[str, float], dict[str, Given]]:
    """The model to run, values of its parameters, and start values.

    A structural parameter makes another model; a note says so.
    """
    import warnings

    from planarc.api.variant import Recompiled

    parameters = {p.name for p in model.program.parameter_slots}
    values, starts = sort_settings(read_settings(settings or ()), parameters)
    with warnings.catch_warnings(record=True, category=Recompiled) as said:
        warnings.simplefilter("always", Recompiled)
        chosen, settable = model.with_parameters(values)
    console.complain(Diagnostic("C116", str(w.message), severity=Severity.NOTE) for w in said)
    return chosen, settable, starts


def split_pair(option: str, item: str, example: str) -> tuple[str, str]:
    """The name and the text of `NAME=TEXT`."""
    name, sign, text = (part.strip() for part in item.partition("="))
    if not (name and sign and text):
        raise usage_error("C250", f"`{option} {item}` is no NAME=VALUE", hint=f"write `{example}`")
    return name, text


def number_or_word(text: str) -> float | str:
    """A time as a number, or a word such as `equilibrium`."""
    try:
        return float(text)
    except ValueError:
        return text


def say_json(value: Mapping[str, Any]) -> None:
    console.say(json.dumps({"ok": True, **value}))


def say_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print columns below their names: the first left-aligned, numbers right-aligned."""
    lines = [list(head), *(list(row) for row in rows)]
    widths = [max(len(line[i]) for line in lines) for i in range(len(head))]
    for line in lines:
        first = line[0].ljust(widths[0])
        rest = (cell.rjust(w) for cell, w in zip(line[1:], widths[1:], strict=True))
        console.say("  ".join((first, *rest)).rstrip())


def number(value: float) -> str:
    return f"{value + 0.0:.6g}"  # + 0.0: no -0
