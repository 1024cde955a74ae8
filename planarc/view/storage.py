"""Files that are there whole or not at all.

The text goes to a new file beside the old one, which it then replaces: a full disk or a
power cut leaves the old file as it was.
"""

from __future__ import annotations

import io
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from planarc.core.diagnostic import Diagnostic, UsageError, usage_error
from planarc.core.nearest import MOST, did_you_mean
from planarc.core.prose import either, ticked
from planarc.ir.program import Column, Program


class CannotWrite(UsageError):
    """A file could not be written: no folder, no permission, or a full disk."""


def with_ending(path: Path, *endings: str) -> Path:
    """The path with the first of the endings, unless it has one of them.

    Raises UsageError (V506) for the ending of another kind of file, so that no page is called
    `.pdf`; `run.2` is a name without one.
    """
    ending = path.suffix.lower()
    if ending in endings:
        return path
    if not path.name:
        raise CannotWrite(Diagnostic("V501", f"cannot write `{path}`: it is a folder", hint=_hint))
    if ending[1:2].isalpha():
        raise usage_error(
            "V506",
            f"`{path.name}` has the ending of another kind of file",
            hint=f"name it `{path.with_suffix(endings[0]).name}`",
        )
    return path.with_name(path.name + endings[0])


def known_ending(path: Path, endings: Sequence[str], code: str, lacks: str) -> str:
    """The ending of a name in small letters. Raises UsageError where it is none of these."""
    ending = path.suffix.lower()
    if ending not in endings:
        known = either(endings) if len(endings) < 3 else f"one of {ticked(endings)}"
        raise usage_error(code, f"`{path.name}` has no ending {lacks}", hint=f"use {known}")
    return ending


@contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """A file to write bytes to; it stands at `path` when the block ends without error.

    Raises `UsageError` V501 where the system refuses.
    """
    try:
        if "\0" in str(path):
            raise OSError("no name holds a null byte")
        target = Path(os.path.realpath(path))
        if target.exists() and not target.is_file():
            # A device or a pipe (`/dev/stdout`) is written to, never replaced.
            with target.open("wb") as file:
                yield file
            return
        new = target.with_name(f".{target.name[:_LONGEST]}.{os.getpid()}.new")
        try:
            with new.open("wb") as file:
                yield file
            new.replace(target)
        except BaseException:
            with suppress(OSError):
                new.unlink()
            raise
    except OSError as problem:
        raise CannotWrite(
            Diagnostic("V501", f"cannot write `{path}`: {_reason(path, problem)}", hint=_hint)
        ) from None


def write_bytes(path: Path, data: bytes) -> None:
    """Raises `UsageError` V501 where the system refuses."""
    with replacing(path) as file:
        file.write(data)


def write_text(path: Path, text: str) -> None:
    """Write a whole file, as `replacing` does."""
    with replacing(path) as file:
        file.write(text.encode())


def write_folder(folder: Path, texts: Mapping[str, str]) -> None:
    """Write files into a folder, which is made where there is none."""
    try:
        folder.mkdir(exist_ok=True)
    except OSError as problem:
        told = "it is a file" if isinstance(problem, FileExistsError) else _reason(folder, problem)
        raise CannotWrite(
            Diagnostic("V501", f"cannot write `{folder}`: {told}", hint=_hint)
        ) from None
    for name, text in texts.items():
        write_text(folder / name, text)


def write_rows(path: Path, head: Iterable[object], rows: Iterable[Iterable[object]]) -> None:
    """Write comma-separated values below their names, with numbers of full precision."""
    import csv

    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(head)
    writer.writerows(rows)
    write_text(path, text.getvalue())


#: Characters of a name that the new file beside it has, too: systems bound names by bytes.
_LONGEST = 50

_hint = "give another place to write to"


def _reason(path: Path, problem: OSError) -> str:
    if isinstance(problem, FileNotFoundError):
        folder = Path(os.path.realpath(path)).parent
        if not folder.is_dir():
            return f"there is no folder `{folder.name}`"
    if isinstance(problem, IsADirectoryError):
        return "it is a folder"
    return (problem.strerror or str(problem)).lower()


def shown(program: Program, only: re.Pattern[str] | None = None) -> tuple[Column, ...]:
    """The columns that a user knows of, or only those whose names match somewhere.

    Names made by planarc itself begin with `$`.
    """
    return tuple(
        c
        for c in program.columns
        if not c.name.startswith("$") and (only is None or only.search(c.name))
    )


def refuse_no_match(program: Program, only: re.Pattern[str] | None) -> None:
    """Refuse, with UsageError V505, a regular expression that matches no name."""
    if only is not None and not shown(program, only):
        raise no_match("variable", only, (c.name for c in shown(program)))


def no_match(kind: str, only: re.Pattern[str], names: Iterable[str] = ()) -> UsageError:
    """The refusal of a regular expression that matches none of the names of a kind."""
    names = list(names)
    hint = "look at the names in a result, and put a backslash before `[` or `(`"
    small = re.compile(only.pattern, only.flags | re.IGNORECASE)
    plain = only.pattern.replace("\\", "").strip("^$")
    if meant := [n for n in names if small.search(n)]:
        hint = f"did you mean {either(meant[:MOST])}? Capitals count"
    elif "," in plain and all(n.strip() in names for n in plain.split(",")):
        hint = f"give one regular expression: `{'|'.join(map(str.strip, plain.split(',')))}`"
    elif meant := [n for n in names if plain in n]:
        hint = f"for {either(meant[:MOST])}, write `{re.escape(meant[0])}`"
    elif (near := did_you_mean(plain, names)) is not None:
        hint = str(near)
    return usage_error("V505", f"no {kind} matches `{only.pattern}`", hint=hint)
