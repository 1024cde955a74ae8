"""The pages of the commands, made from what their `--help` says, so that nothing is said twice."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from typer.main import get_command

from planarc.cli.advice import make_app
from planarc.cli.commands import COMMANDS
from planarc_docs.written import code, fence, prose, table


def command_pages() -> Iterator[tuple[str, str]]:
    """Names and texts of the pages."""
    known: dict[str, Any] = get_command(make_app()).commands  # type: ignore[attr-defined]
    for name in COMMANDS:
        yield name, _page(name, known[name])


def _page(name: str, command: Any) -> str:
    context = command.context_class(command, info_name=f"planarc {name}")
    usage = command.get_usage(context).removeprefix("Usage: ")
    params = list(command.get_params(context))
    arguments = [p for p in params if p.param_type_name == "argument"]
    options = [p for p in params if p.param_type_name == "option"]
    parts = [f"# planarc {name}\n", *_paragraphs(command.help), fence("text", usage)]
    if arguments:
        rows = [(code(_variable(p)), prose(p.help or "")) for p in arguments]
        parts += ["## Arguments\n", table(("argument", "meaning"), rows)]
    rows3 = [(_names(p), prose(p.help or ""), _default(p, context)) for p in options]
    parts += ["## Options\n", table(("option", "meaning", "default"), rows3)]
    examples = "\n".join(f"$ {line.strip()}" for line in COMMANDS[name])
    return "\n".join([*parts, "## Examples\n", fence("console", examples)])


def _paragraphs(text: str) -> Iterator[str]:
    for paragraph in text.split("\n\n"):
        yield prose(paragraph) + "\n"


def _variable(argument: Any) -> str:
    return str(argument.metavar or argument.name.upper()).strip("[]{}")


def _names(option: Any) -> str:
    """All spellings of an option, and what it takes."""
    spelt = ", ".join((*option.opts, *option.secondary_opts))
    if option.is_flag:
        return code(spelt)
    choices = getattr(option.type, "choices", None)
    takes = option.metavar or ("|".join(choices) if choices else option.type.name.upper())
    return f"{code(spelt)} {code(takes)}"


def _default(option: Any, context: Any) -> str:
    value = option.get_default(context)
    if value is None or value is False or value == () or value == [] or callable(value):
        return ""
    return code(str(getattr(value, "value", value)))
