"""`planarc fmt`: format models, keeping comments and line breaks."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated

from planarc.cli import console
from planarc.cli.exits import Exit
from planarc.cli.line import Argument, Option
from planarc.core.diagnostic import (
    Diagnostic,
    PlanarcError,
    UsageError,
    error,
    refused,
    usage_error,
)
from planarc.core.files import read_plain
from planarc.core.source import SUFFIXES, Source, model_files


def fmt(
    files: Annotated[
        list[str],
        Argument(
            metavar="FILE|FOLDER...",
            help="Files, or folders of .pmo and .mo files; `-` formats standard input.",
        ),
    ],
    check: Annotated[
        bool, Option("--check", help="Write nothing; exit with 1 when a file would change.")
    ] = False,
) -> int:
    """Format models.

    Indentation, spaces and blank lines; comments and line breaks stay as they are.
    """
    if files == ["-"]:
        return _format_stream(check)
    changed: list[Path] = []
    errors: list[Diagnostic] = []
    paths = tuple(dict.fromkeys(_paths(files)))
    for path in paths:
        try:
            if _format_file(path, check):
                changed.append(path)
        except UsageError:
            raise
        except PlanarcError as error:
            errors += error.diagnostics
    for path in changed:
        console.say(f"{'would format' if check else 'formatted'} {console.plain(str(path))}")
    console.complain(errors)
    same = len(paths) - len(changed) - len({e.span and e.span.source for e in errors})
    if same:
        console.tell(f"{same} files need no change" if same > 1 else "1 file needs no change")
    return Exit.MODEL if errors or (check and changed) else Exit.DONE


def _format_stream(check: bool) -> int:
    from planarc.catalog.format.formatter import format_source

    text = sys.stdin.read()
    formatted = format_source(Source("<stdin>", text))
    if not check:
        sys.stdout.write(formatted)
    return Exit.MODEL if check and formatted != text else Exit.DONE


def _paths(files: Sequence[str]) -> Iterator[Path]:
    for name in files:
        path = Path(name)
        if path.is_dir():
            found = (p for p in model_files(path, below=True) if p.is_file())
            for file in found:
                if not any(part.startswith(".") for part in file.relative_to(path).parts):
                    yield file
        elif not path.exists():
            raise usage_error("C101", f"there is no file `{name}`", hint="check the path")
        elif path.suffix in SUFFIXES:
            yield path
        else:
            raise usage_error(
                "C141", f"`{name}` is no model", hint="give files with the ending `.pmo` or `.mo`"
            )


def _format_file(path: Path, check: bool) -> bool:
    """Format a file, unless `check`; true when that changes it."""
    from planarc.catalog.format.formatter import format_source

    try:
        data = read_plain(path)
        text = data.decode("utf-8")
    except UnicodeDecodeError:
        hint = "convert it, then format it again"
        raise error("C142", f"`{path}` is not UTF-8 text", hint=hint) from None
    except OSError as problem:
        raise refused("C108", f"cannot read `{path}`", problem) from None
    formatted = format_source(Source(str(path), text))
    if formatted == text:
        return False
    if not check:
        from planarc.view.storage import write_text

        write_text(path, formatted)
    return True
