"""The files of a run's results, decided before it starts.

Named files are replaced. The default ones, `<Class>.csv` and `<Class>.html` in the
working directory, are replaced only when planarc wrote what is there now: a file of
the user that happens to have that name is never lost.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Severity, UsageError, refused, usage_error
from planarc.core.prose import either

TABLES = (".csv", ".mat")
PAGES = (".html", ".htm")

#: The beginnings of planarc's own files, within their first few lines.
_OWN = {
    ".csv": r'\A"time(?: \[s\])?"[,\r\n]',
    ".html": r'<meta name="generator" content="planarc\b',
}
_HEAD = 4096  # characters in which the mark must stand


class Destinations(Data):
    """The files to write, None for none."""

    output: Path | None
    report: Path | None


def destinations(
    model: str,
    output: Path | None,
    report: Path | None,
    no_output: bool,
    no_report: bool,
) -> Destinations:
    """The files that a run of `model` will write; UsageError when one cannot be written."""
    stem = file_stem(model)
    return Destinations(
        None if no_output else _destination(output, f"{stem}.csv", TABLES, "--output"),
        None if no_report else _destination(report, f"{stem}.html", PAGES, "--report"),
    )


def replaced(model: str, path: Path | None) -> Iterator[Diagnostic]:
    """The warning that the default file holds the results of a class of another package, whose
    name ends alike."""
    from planarc.view.table.origin import read_beside

    if path != Path(f"{file_stem(model)}.csv") or not path.is_file():
        return
    origin, _ = read_beside(path)
    if origin is not None and origin.model not in ("", model):
        message = f"`{path}` held the results of `{origin.model}`, which those of `{model}` replace"
        hint = f"write `--output {model}.csv` to keep both"
        yield Diagnostic("C124", message, None, Severity.WARNING, hint=hint)


def table_destination(named: Path) -> Path:
    """The table to write for `--output`."""
    return _destination(named, "", TABLES, "--output")


def csv_destination(named: Path) -> Path:
    """The table to write for `--output` where it is no result of a run."""
    return _destination(named, "", TABLES[:1], "--output")


def report_destination(named: Path) -> Path:
    """The page to write for `--report`."""
    return _destination(named, "", PAGES, "--report")


def page_destination(name: str, named: Path | None) -> Path:
    """The page to write for `--output`, or the default one of something called `name`."""
    return _destination(named, f"{file_stem(name)}.html", PAGES, "--output", optional=False)


def file_stem(model: str) -> str:
    """The last part of a class name, safe as a file name."""
    last = re.findall(r"'(?:[^'\\]|\\.)*'|[^.]+", model)[-1]
    return re.sub(r"[^\w-]", "_", last.strip("'")) or "model"


def _destination(
    named: Path | None,
    default: str,
    suffixes: tuple[str, ...],
    option: str,
    optional: bool = True,
) -> Path:
    path = Path(default) if named is None else named
    if path.suffix.lower() not in suffixes:
        raise usage_error(
            "C121",
            f"`{option} {path}` has no ending that planarc writes",
            hint=f"use {either(suffixes)}",
        )
    check_writable(path, option)
    if named is None and path.exists() and not _is_own(path):
        without = f", or use `--no{option[1:]}`" if optional else ""
        raise usage_error(
            "C122",
            f"`{path}` exists and was not written by planarc",
            hint=f"move it away, or name another file with `{option}`{without}",
        )
    return path


def check_writable(path: Path, option: str) -> None:
    """UsageError unless a file can be written at `path`."""
    try:
        path.lstat()
    except (FileNotFoundError, NotADirectoryError):
        pass
    except (OSError, ValueError) as problem:
        raise refused("C123", f"cannot write `{path}`", problem, f"change `{option}`") from None
    if path.is_dir():
        raise usage_error(
            "C123", f"cannot write `{path}`: it is a folder", hint=f"give `{option}` a file"
        )
    if not path.parent.is_dir():
        raise usage_error(
            "C123",
            f"cannot write `{path}`: there is no folder `{path.parent}`",
            hint="create the folder first",
        )
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise usage_error(
            "C123", f"cannot write `{path}`: permission denied", hint=f"change `{option}`"
        )


def _is_own(path: Path) -> bool:
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            head = file.read(_HEAD)
    except OSError:
        return False
    return not head or bool(re.search(_OWN[path.suffix], head))


def save(path: Path, write: Callable[[Path], object]) -> None:
    """Call `write` with the path; what cannot be written there goes to the system's folder for
    temporary files. Raises UsageError V501, which says where it is."""
    from planarc.view.storage import CannotWrite

    try:
        write(path)
    except CannotWrite as problem:
        other = _elsewhere(path, write)
        if other is None:
            raise
        first = replace(problem.diagnostics[0], hint=f"what was computed is in `{other}`")
        raise CannotWrite(first) from None


def _elsewhere(path: Path, write: Callable[[Path], object]) -> Path | None:
    with suppress(OSError):
        import tempfile

        folder = Path(tempfile.mkdtemp(prefix="planarc-"))
        try:
            write(folder / path.name)
        except UsageError:
            folder.rmdir()
        else:
            return folder / path.name
    return None
