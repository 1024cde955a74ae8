"""Matrices in files: what a library's functions for tables and matrices read.

    .mat    a variable of MATLAB's file, up to version 7, or a field `s.curve` of one
    .csv    the whole file, behind its head lines
    else    a text that begins with `#1` and holds matrices one after the other:

        #1
        double curve(3, 2)   # a comment
        0  0
        1  2.5
        2  4

Numbers of a text stand row by row, with spaces, commas, semicolons or line breaks between them;
what stands behind a `#` is a comment.

Raises ValueError with the reason, where there is no such matrix.
"""

from __future__ import annotations

import re
from functools import lru_cache
from pathlib import Path

_HEAD = re.compile(r"(?:double|float)\s+([\w.]+)\s*\(\s*(\d+)\s*,\s*(\d+)\s*\)")

#: The name of no file, in the libraries that read tables.
NO_NAME = "NoName"

Rows = list[list[float]]


def sizes(file: str, name: str) -> tuple[list[int]]:
    """Numbers of rows and columns."""
    return (_sizes(_matrix(file, name)),)


def matrix(file: str, name: str, rows: int, columns: int, verbose: bool) -> tuple[Rows]:
    """A matrix of a size that was asked for before."""
    return (_fitting(_matrix(file, name), rows, columns, name),)


def table_sizes(file: str, name: str, delimiter: str, head: int) -> tuple[list[int]]:
    """Numbers of rows and columns of a table."""
    return (_sizes(_matrix(file, name, delimiter, head)),)


def table(file: str, name: str, delimiter: str, head: int, rows: int, columns: int) -> tuple[Rows]:
    """A table of a size that was asked for before."""
    return (_fitting(_matrix(file, name, delimiter, head), rows, columns, name),)


def _sizes(found: Rows) -> list[int]:
    return [len(found), len(found[0]) if found else 0]


def _fitting(found: Rows, rows: int, columns: int, name: str) -> Rows:
    if _sizes(found) != [rows, columns]:
        raise ValueError(f"`{name}` is no matrix of {rows} rows and {columns} columns")
    return found


def _matrix(file: str, name: str, delimiter: str = ",", head: int = 0) -> Rows:
    path = Path(file)
    if file == NO_NAME:
        raise ValueError("no file is named: give `fileName`")
    try:
        stamp = path.stat()
    except OSError:
        raise ValueError(f"there is no file `{file}`") from None
    return _read(path, (stamp.st_size, stamp.st_mtime_ns), name, delimiter, head)


@lru_cache(maxsize=16)
def _read(path: Path, stamp: tuple[int, int], name: str, delimiter: str, head: int) -> Rows:
    """`stamp` tells a file that was written anew."""
    try:
        if path.suffix.lower() == ".mat":
            return _of_matlab(path, name)
        text = path.read_text(encoding="utf-8-sig", errors="replace")
    except OSError as problem:
        raise ValueError(f"`{path}` cannot be read: {problem.strerror or problem}") from None
    if path.suffix.lower() == ".csv":
        return _of_lines(path, text, delimiter, head)
    return _of_text(path, text, name)


def _of_matlab(path: Path, name: str) -> Rows:
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    first, *fields = name.split(".")
    try:
        found = loadmat(path, variable_names=[first]).get(first)
    except NotImplementedError:
        raise ValueError(f"`{path}` is of MATLAB's version 7.3: save it with `-v7`") from None
    except (MatReadError, ValueError, TypeError, EOFError) as problem:
        raise ValueError(f"`{path}` is no file of MATLAB: {problem}") from None
    for inner in fields:
        known = getattr(getattr(found, "dtype", None), "names", None) or ()
        found = found[inner][0, 0] if found is not None and inner in known else None
    if found is None:
        raise _missing(path, name)
    if getattr(found, "ndim", 0) != 2 or found.dtype.kind not in "fiub":
        raise ValueError(f"`{name}` in `{path}` is no matrix of numbers")
    return [[float(x) for x in row] for row in found]


def _of_lines(path: Path, text: str, delimiter: str, head: int) -> Rows:
    rows = []
    for number, line in enumerate(text.splitlines(), start=1):
        if number > head and line.strip():
            rows.append(_numbers(line.split(delimiter), path, number))
            if len(rows[-1]) != len(rows[0]):
                message = f"line {number} of `{path}` has {len(rows[-1])} numbers"
                raise ValueError(f"{message}, the first has {len(rows[0])}")
    return rows


def _of_text(path: Path, text: str, name: str) -> Rows:
    lines = [line.partition("#")[0].strip() for line in text.splitlines()]
    if not text.startswith("#1"):
        raise ValueError(f"`{path}` does not begin with `#1`, as a text with tables does")
    for begin, line in enumerate(lines):
        head = _HEAD.match(line)
        if head is None or head[1] != name:
            continue
        rows, columns = int(head[2]), int(head[3])
        numbers = _numbers(re.split(r"[\s,;]+", line[head.end() :].strip()), path, begin + 1)
        for number, more in enumerate(lines[begin + 1 :], start=begin + 2):
            if len(numbers) >= rows * columns or _HEAD.match(more):
                break
            numbers += _numbers(re.split(r"[\s,;]+", more), path, number)
        if len(numbers) < rows * columns:
            message = f"`{name}` in `{path}` has {len(numbers)} numbers"
            raise ValueError(f"{message}, and not {rows}*{columns}")
        return [numbers[i * columns : (i + 1) * columns] for i in range(rows)]
    raise _missing(path, name)


def _numbers(words: list[str], path: Path, line: int) -> list[float]:
    found = []
    for word in words:
        if not word.strip():
            continue
        try:
            found.append(float(word))
        except ValueError:
            message = f"`{word.strip()}` in line {line} of `{path}` is no number"
            raise ValueError(message) from None
    return found


def _missing(path: Path, name: str) -> ValueError:
    return ValueError(f"there is no `{name}` in `{path}`")
