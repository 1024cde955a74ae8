"""The table of commands, and what becomes of an error: a message and an exit code.

0    done                        70   a mistake of planarc's own
1    the model is wrong          130  stopped by Ctrl-C
2    the request is wrong        141  the reader of the output went away
3    the run failed part-way
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from planarc.cli import console
from planarc.cli.exits import Exit, exit_code
from planarc.cli.outcome import Outcome
from planarc.cli.streams import CannotPrint, silence
from planarc.core.diagnostic import Diagnostic, PlanarcError, Severity, mistake

#: The commands with the examples of their help, in its order. Each is a function in a file of its
#: name, and imported when it is asked for: all of them together would take half of a check's time.
COMMANDS = {
    name: examples
    for block in Path(__file__).with_name("examples.txt").read_text("utf-8").split("\n\n")
    for name, *examples in [block.splitlines()]
}
_EVERYWHERE = (
    "With every command: --quiet (-q) leaves out summaries and warnings, --verbose (-v) tells more."
)
#: The functions that cannot be called as their commands, since Python calls its own things so; the
#: file of one is called like its function.
_RENAMED = {"compile": "compile_model", "list": "list_classes", "import": "import_outline"}
_FILES = {"import": "import_outline"}


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
        command = getattr(
            import_module(f"planarc.cli.{_FILES.get(name, name)}"), _RENAMED.get(name, name)
        )
        shown = command if options else _listed
        app.command(name, cls=_Command, help=command.__doc__, epilog=epilog)(shown)
    return app


def _listed() -> None:
    """Stand for a command in a list, which only its name and its help are read for."""


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
        from importlib.metadata import version

        console.say(f"planarc {version('planarc')}")
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


def run(arguments: Sequence[str]) -> int:
    """Run one command line; gives its exit code and never raises."""
    arguments, volume = _take_volume(arguments)
    console.prepare(volume)
    try:
        code = _answer(arguments, "--json" in arguments)
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        silence(sys.stdout)
        return Exit.BROKEN_PIPE
    except CannotPrint as problem:
        silence(sys.stdout)
        return _fail((Diagnostic("C123", f"cannot print: {problem}"),), Exit.USAGE, False)


def _answer(arguments: Sequence[str], as_json: bool) -> int:
    """The exit code. Raises BrokenPipeError, CannotPrint."""
    try:
        app = make_app(_wanted(arguments), options=not _lists(arguments))
        code = app(args=arguments or ["--help"], prog_name="planarc", standalone_mode=False)
        _tell_of_the_cache()
        sys.stdout.flush()
        if code == Exit.INTERRUPTED and not isinstance(code, Exit):
            raise KeyboardInterrupt  # typer gives the bare number where Ctrl-C broke a command off
        return int(code or 0)
    except PlanarcError as error:
        return _fail(error.diagnostics, exit_code(error), as_json)
    except _CommandLineError as error:
        return _fail((_usage(error),), Exit.USAGE, as_json)
    except (BrokenPipeError, CannotPrint):
        raise
    except (KeyboardInterrupt, typer.Abort):
        return _fail((_INTERRUPTED,), Exit.INTERRUPTED, as_json)
    except Exception as error:
        if os.environ.get("PLANARC_DEBUG"):
            raise
        if isinstance(error, OSError) and error.filename is not None:  # a name that is too long
            reason = (error.strerror or str(error)).lower()
            found = Diagnostic("C108", f"cannot use `{error.filename}`: {reason}")
            return _fail((found,), Exit.USAGE, as_json)
        return _fail((mistake(error),), Exit.BUG, as_json)


_VOLUMES = {
    "-q": console.Volume.QUIET,
    "--quiet": console.Volume.QUIET,
    "-v": console.Volume.VERBOSE,
    "--verbose": console.Volume.VERBOSE,
}


def _take_volume(arguments: Sequence[str]) -> tuple[list[str], console.Volume]:
    """The arguments without `--quiet` and `--verbose`, which may stand anywhere before `--`."""
    own = list(arguments)
    end = own.index("--") if "--" in own else len(own)
    volumes = [_VOLUMES[a] for a in own[:end] if a in _VOLUMES]
    rest = [a for a in own[:end] if a not in _VOLUMES] + own[end:]
    return rest, volumes[-1] if volumes else console.Volume.NORMAL


def _tell_of_the_cache() -> None:
    """Say why nothing is kept, where a command asked for what is kept."""
    cache = sys.modules.get("planarc.core.cache")
    reason = cache.refusal() if cache else ""
    if reason:
        said = f"nothing is kept between runs: {reason}"
        hint = "let PLANARC_CACHE_DIR name another folder"
        console.complain((Diagnostic("C131", said, severity=Severity.WARNING, hint=hint),))


_INTERRUPTED = Diagnostic("C130", "interrupted")


def _fail(diagnostics: tuple[Diagnostic, ...], code: Exit, as_json: bool) -> int:
    if as_json:
        console.say(Outcome(ok=False, diagnostics=diagnostics).as_json())
    else:
        console.complain(diagnostics)
    return code


def _usage(error: Exception) -> Diagnostic:
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
    message = re.sub(r"(^|: )([A-Z])", lambda m: m[0].lower(), message.rstrip("."))
    message = re.sub(r"'([^']*)'", r"`\1`", message)
    command = getattr(getattr(error, "ctx", None), "command_path", "planarc")
    hint = f"did you mean `{near[0]}`?" if near else f"see `{command} --help`"
    return Diagnostic("C100", message, hint=hint)
