"""`--set NAME=VALUE`: parameters, and start values as `x.start`.

A value is a number, one with a unit (`45deg`, `20cm`), `true`, `false`, the name of an enumeration
literal, or several in braces for an array: `--set rod.r={0.5,0}`.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, TypeAlias

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Severity, usage_error

if TYPE_CHECKING:
    from planarc.compiled import Compiled
    from planarc.core.options import RunOptions
    from planarc.request.request import Request

_WORDS = {"true": True, "false": False}
_START = ".start"
_LITERAL = r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*"

#: A number, a text that is a literal's name or a number with a unit, or a list of them.
Given: TypeAlias = "float | str | list[Given]"


class Setting(Data):
    name: str
    value: Given


def read_settings(items: Sequence[str]) -> tuple[Setting, ...]:
    """The settings of the command line, the last of a name winning."""
    found = {s.name: s for s in map(_read, items)}
    return tuple(found.values())


def sort_settings(
    settings: Sequence[Setting], parameters: Collection[str]
) -> tuple[dict[str, Given], dict[str, Given]]:
    """Values of parameters, and start values of variables.

    A parameter may itself be called `start`, as in `ramp.start`; then it is meant.
    """
    values: dict[str, Given] = {}
    starts: dict[str, Given] = {}
    for setting in settings:
        if setting.name.endswith(_START) and setting.name not in parameters:
            starts[setting.name.removesuffix(_START)] = setting.value
        else:
            values[setting.name] = setting.value
    return values, starts


def apply_settings(
    settings: Sequence[Setting], request: Request, compiled: Compiled, options: RunOptions
) -> tuple[Request, Compiled, RunOptions, tuple[Diagnostic, ...]]:
    """Apply all settings; a structural parameter, or one that a formula gives, makes another model,
    and a note says so."""
    from planarc.solve.settings import compiles_again

    program = compiled.program
    parameters = {p.name: p for p in program.parameter_slots}
    given, begun = sort_settings(settings, parameters)
    values = {n: v for n, v in given.items() if isinstance(v, float)}
    starts = {n: v for n, v in begun.items() if isinstance(v, float)}
    if len(values) < len(given) or len(starts) < len(begun):
        from planarc.api.values import parameter_values, start_values

        values |= parameter_values(program, {n: given[n] for n in given.keys() - values.keys()})
        starts |= start_values(program, {n: begun[n] for n in begun.keys() - starts.keys()})
    structural = {
        n: v
        for n, v in values.items()
        if n in parameters and compiles_again(program, parameters[n])
    }
    plain = {n: v for n, v in values.items() if n not in structural}
    options = replace(options, values=plain, starts=starts)
    if not structural:
        return request, compiled, options, ()
    from planarc.api.variant import compile_like, texts_of, variant_of, why_again

    changed = variant_of(request, texts_of(request, program, structural, options.backend))
    again = compile_like(changed, options.backend, program, structural)
    note = Diagnostic(
        "C116",
        f"{why_again(program, structural)}: the model was compiled again",
        severity=Severity.NOTE,
    )
    return changed, again, options, (note,)


def read_values(name: str, text: str) -> list[Given]:
    """Values with commas between them, as a study takes them."""
    return [_value(name, part) for part in _parts(text)]


def _read(item: str) -> Setting:
    name, sign, text = (part.strip() for part in item.partition("="))
    if not (name and sign and text):
        hint = f"write `--set {name or 'rod.L'}=0.5`"
        raise usage_error("C110", f"`--set {item}` is no NAME=VALUE", hint=hint)
    return Setting(name, _value(name, text))


def _value(name: str, text: str) -> Given:
    if text in _WORDS:
        return _WORDS[text]
    if text.startswith("{") and text.endswith("}"):
        return [_value(name, part) for part in _parts(text[1:-1])]
    try:
        return float(text)
    except ValueError:
        from planarc.core.quantity import split

        if re.fullmatch(_LITERAL, text) or split(text) is not None:
            return text
        if text.startswith("{"):  # a shell has taken it apart
            raise usage_error(
                "C111",
                f"the value `{text}` of `{name}` has no closing brace",
                hint=f"put it in quotes, as in '{name}={{0.5,0}}': a shell reads braces itself",
            ) from None
        raise usage_error(
            "C111",
            f"the value `{text}` of `{name}` is no number",
            hint=_number_hint(name, text),
        ) from None


def _number_hint(name: str, text: str) -> str:
    if re.search(r",\s*[\w.\[\]]+=", text):
        words = f"--set {name}={text.replace(',', ' --set ', 1)}"
        return f"write each behind its own `--set`: `{words}`"
    if re.fullmatch(r"[-+\d]+,\d+", text):
        return f"write `{text.replace(',', '.')}`: decimals stand behind a point"
    if ".." in text:
        return "write a range as FROM:TO:HOW_MANY, such as 1:2:5"
    return (
        "give a number, one with a unit such as 20cm, `true`, `false`, the name of an enumeration "
        "literal, or numbers in braces such as {0.5,0}"
    )


def _parts(text: str) -> list[str]:
    """The texts between commas outside of inner braces."""
    parts, depth = [""], 0
    for sign in text:
        depth += (sign == "{") - (sign == "}")
        if sign == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += sign
    return [part.strip() for part in parts]
