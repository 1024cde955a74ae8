"""What becomes of a command line, and of an error: a message and an exit code.

0    done                        70   a mistake of planarc's own
1    the model is wrong          130  stopped by Ctrl-C
2    the request is wrong        141  the reader of the output went away
3    the run failed part-way
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from planarc.cli import console, line
from planarc.cli.commands import COMMANDS, function_of
from planarc.cli.exits import Exit, exit_code
from planarc.cli.outcome import Outcome
from planarc.cli.streams import CannotPrint, silence
from planarc.core.diagnostic import Diagnostic, PlanarcError, Severity, mistake


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
        code = _called(arguments)
        _tell_of_the_cache()
        sys.stdout.flush()
        return int(code or 0)
    except PlanarcError as error:
        return _fail(error.diagnostics, exit_code(error), as_json)
    except (BrokenPipeError, CannotPrint):
        raise
    except KeyboardInterrupt:
        return _fail((_INTERRUPTED,), Exit.INTERRUPTED, as_json)
    except Exception as error:
        if os.environ.get("PLANARC_DEBUG"):
            raise
        if isinstance(error, OSError) and error.filename is not None:  # a name that is too long
            reason = (error.strerror or str(error)).lower()
            found = Diagnostic("C108", f"cannot use `{error.filename}`: {reason}")
            return _fail((found,), Exit.USAGE, as_json)
        return _fail((mistake(error),), Exit.BUG, as_json)


def _called(arguments: Sequence[str]) -> int | None:
    """What a command gives. Raises UsageError of a line that is wrong."""
    name = arguments[0] if arguments else ""
    if name in COMMANDS and "_PLANARC_COMPLETE" not in os.environ:
        command = function_of(name)
        given = line.read(command, arguments[1:])
        if given is not None:
            return command(**given)
    from planarc.cli import advice

    return advice.answer(arguments)


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
