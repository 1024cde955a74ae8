"""The commands as typer knows them: help, completion, and what is wrong with a command line."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Sequence
from functools import wraps
from inspect import Parameter, Signature
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from planarc.cli import console, line
from planarc.cli.commands import COMMANDS, function_of
from planarc.cli.exits import Exit
from planarc.core.diagnostic import Diagnostic, UsageError
from planarc.core.version import __version__

_EVERYWHERE = (
    "With every command: --quiet (-q) leaves out summaries and warnings, --verbose (-v) tells more."
)


def answer(arguments: Sequence[str]) -> int:
    """Run a command line and give its exit code. Raises UsageError where it is wrong."""
    _refuse_spaces(arguments)
    app = make_app(_wanted(arguments), options=not _lists(arguments))
    try:
        code = app(args=arguments or ["--help"], prog_name="planarc", standalone_mode=False)
    except typer.Abort:
        raise KeyboardInterrupt from None
    except _CommandLineError as error:
        raise UsageError((_told(error),)) from None
    if code == Exit.INTERRUPTED and not isinstance(code, Exit):
        raise KeyboardInterrupt  # typer gives the bare number where Ctrl-C broke a command off
    return int(code or 0)


def _long_names(found: list[Any], written: str) -> list[Any]:
    """What a shell offers, with each option once: short names are for those who type them."""
    return [i for i in found if len(i.value) != 2 or i.value[0] != "-" or i.value == written]


class _Command(TyperCommand):
    def shell_complete(self, ctx: Any, incomplete: str) -> list[Any]:
        return _long_names(super().shell_complete(ctx, incomplete), incomplete)


class _Group(TyperGroup):
    def shell_complete(self, ctx: Any, incomplete: str) -> list[Any]:
        return _long_names(super().shell_complete(ctx, incomplete), incomplete)


def make_app(names: Iterable[str] = COMMANDS, options: bool = True) -> typer.Typer:
    """The application with these commands; without their options, which cost time, to list them."""
    app = typer.Typer(
        name="planarc",
        cls=_Group,
        help="Compile and simulate planar mechanisms.",
        rich_markup_mode=None,  # help without colours: importing rich would double its time
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback()(root)
    for name in names:
        # `\b` keeps the lines of a paragraph.
        epilog = "\n".join(["\b", "Examples:", *COMMANDS[name], "", _EVERYWHERE])
        command = function_of(name)
        shown = as_typed(command) if options else _listed
        app.command(name, cls=_Command, help=command.__doc__, epilog=epilog)(shown)
    return app


def _listed() -> None:
    """Stand for a command in a list, which only its name and its help are read for."""


def as_typed(command: Callable[..., int]) -> Callable[..., int]:
    """A command's function with the signature that typer reads."""

    @wraps(command)
    def typed(**given: Any) -> int:
        return command(**given)

    shown = []
    for p in line.parameters(command):
        kind = typer.Option if isinstance(p.said, line.Option) else typer.Argument
        told = {**p.said.told, "parser": p.said.parser and _telling(p.said.parser)}
        hint = Annotated[p.type, kind(*p.said.names, **told)]  # type: ignore[name-defined]
        default = Parameter.empty if p.default is ... else p.default
        shown.append(Parameter(p.name, Parameter.KEYWORD_ONLY, default=default, annotation=hint))
    typed.__signature__ = Signature(shown)  # type: ignore[attr-defined]
    return typed


def _telling(parser: Callable[[str], Any]) -> Callable[[str], Any]:
    """A parser whose ValueError is told in its own words."""

    def parsed(text: str) -> Any:
        try:
            return parser(text)
        except ValueError as problem:
            raise typer.BadParameter(str(problem)) from None

    return parsed


def _wanted(arguments: Sequence[str]) -> Iterable[str]:
    """The command that is asked for, or all of them where help or completion may name any."""
    first = arguments[0] if arguments else "--help"
    return (first,) if first in COMMANDS and "_PLANARC_COMPLETE" not in os.environ else COMMANDS


def _lists(arguments: Sequence[str]) -> bool:
    """Whether the commands are only listed."""
    asked = list(arguments) in ([], ["--help"], ["-h"])
    return asked and "_PLANARC_COMPLETE" not in os.environ


#: What typer raises when the command line itself cannot be understood.
_CommandLineError: type[Exception] = typer.BadParameter.__mro__[1]


def _print_version(asked: bool) -> None:
    if asked:
        console.say(f"planarc {__version__}")
        raise typer.Exit


def root(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Show the version and exit."
        ),
    ] = False,
    quiet: Annotated[
        bool, typer.Option("--quiet", "-q", help="Leave out summaries, remarks and warnings.")
    ] = False,
    verbose: Annotated[bool, typer.Option("--verbose", "-v", help="Tell more.")] = False,
) -> None:
    """Compile and simulate planar mechanisms."""


def _refuse_spaces(arguments: Sequence[str]) -> None:
    """Raise UsageError for `--set rod.m = 2`, of which the shell makes several words."""
    for at, word in enumerate(arguments):
        if word[:1] != "=" or not at:
            continue
        words = arguments[at - 1 : at + (2 if word == "=" else 1)]
        hint = f"write it in one word: `{''.join(words)}`"
        message = f"there are spaces around the `=` of `{' '.join(words)}`"
        raise UsageError((Diagnostic("C100", message, hint=hint),))


def _told(error: Exception) -> Diagnostic:
    """typer's message in our form: lower case, names in backticks, the advice as a hint."""
    text = getattr(error, "format_message", lambda: str(error))().strip()
    message, _, advice = text.partition(". Did you mean ")
    near = re.findall(r"'([^']*)'", advice)
    option = getattr(error, "option_name", None)
    if option is not None and hasattr(error, "possibilities"):
        from planarc.core.nearest import nearest, synonyms

        command = getattr(getattr(error, "ctx", None), "command", None)
        known = [o.strip("-") for p in getattr(command, "params", ()) for o in p.opts]
        said = synonyms(option.strip("-"), known) or nearest(option.strip("-"), known)
        near = [f"-{o}" if len(o) == 1 else f"--{o}" for o in said]
        message = f"no such option '{option}'"
    commands = getattr(getattr(getattr(error, "ctx", None), "command", None), "commands", ())
    if (unknown := re.fullmatch(r"No such command '(.+)'\.?", message)) and not near:
        from planarc.core.nearest import synonyms

        near = list(synonyms(unknown[1], list(commands)))
    if refused := re.search(r"'([^']*)' is not one of (.*)", message):
        from planarc.core.nearest import did_you_mean

        meant = did_you_mean(refused[1], re.findall(r"'([^']*)'", refused[2]), most=1)
        near = list(meant.names) if meant else []
    message = re.sub(r"(^|: )([A-Z])", lambda m: m[0].lower(), message.rstrip("."))
    message = re.sub(r"'([^']*)'", r"`\1`", message)
    command = getattr(getattr(error, "ctx", None), "command_path", "planarc")
    hint = f"did you mean `{near[0]}`?" if near else f"see `{command} --help`"
    return Diagnostic("C100", message, hint=_meant(message) or hint)


#: What a message says of its own kind, and what is to be written then.
_MEANT = (
    (r"unexpected extra.*\.(?:pmo|mo)\b", "a command takes one file: run it once for each"),
    (r"no such command `(.+\.(?:pmo|mo))`", r"write `planarc simulate \1`"),
    (r"`(-?\d+),(\d+)` is no", r"write `\1.\2`: decimals stand behind a point"),
    (r"`--intervals`: `([\d.e-]+)` is not", r"for a time between two rows, write `--interval \1`"),
    (r"`([\d.e-]+) ?%` is not", r"write a number, `\1`, or a hundredth of it for per cent"),
    (r"no such option `--plot`", "draw curves by `planarc plot RESULT.csv VARIABLE`"),
)


def _meant(message: str) -> str | None:
    """What to write in the place of what a message refuses."""
    for pattern, advice in _MEANT:
        if (found := re.search(pattern, message)) is not None:
            return found.expand(advice)
    return None
