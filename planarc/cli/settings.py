"""`--set NAME=VALUE`: parameters, and start values as `x.start`."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from planarc.core.diagnostic import Diagnostic, UsageError

_WORDS = {"true": 1.0, "false": 0.0}
_START = ".start"


@dataclass(frozen=True, slots=True)
class Setting:
    name: str
    value: float


def read_settings(items: Sequence[str]) -> tuple[Setting, ...]:
    """The settings of the command line, the last of a name winning."""
    found = {s.name: s for s in map(_read, items)}
    return tuple(found.values())


def sort_settings(
    settings: Sequence[Setting], parameters: Collection[str]
) -> tuple[dict[str, float], dict[str, float]]:
    """Values of parameters, and start values of variables.

    A parameter may itself be called `start`, as in `ramp.start`; then it is meant.
    """
    values, starts = {}, {}
    for setting in settings:
        if setting.name.endswith(_START) and setting.name not in parameters:
            starts[setting.name.removesuffix(_START)] = setting.value
        else:
            values[setting.name] = setting.value
    return values, starts


def _read(item: str) -> Setting:
    name, sign, text = (part.strip() for part in item.partition("="))
    if not (name and sign and text):
        raise UsageError(
            Diagnostic("C110", f"`--set {item}` is no NAME=VALUE", hint="write `--set rod.L=0.5`")
        )
    return Setting(name, _WORDS[text] if text in _WORDS else _number(name, text))


def _number(name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise UsageError(
            Diagnostic(
                "C111",
                f"the value `{text}` of `{name}` is no number",
                hint="give a number, `true` or `false`",
            )
        ) from None
