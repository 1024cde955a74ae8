"""Reading of model files: parsed, counted, and with planarc's own classes in place of foreign code.

A reader belongs to one request. It keeps the hash of each file that it read, by which a remembered
model is known to be as its files are.
"""

from __future__ import annotations

from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

from msgspec import Struct, field

from planarc.core.cache import key
from planarc.core.diagnostic import refused, usage_error
from planarc.core.files import read_plain
from planarc.core.resources import stdlib
from planarc.core.source import Source, decode

if TYPE_CHECKING:
    from planarc.ir import syntax


class Reader(Struct):
    """Parses files, keeps them, and counts the seconds that it takes."""

    seconds: float = 0.0
    files: dict[Path, str] = field(default_factory=dict)  # path -> content hash

    def __call__(self, path: Path) -> syntax.StoredDefinition:
        from planarc.request.substitutes import substitute

        data = content_of(path)
        self.files[path.absolute()] = key(data)
        stored = self.parse(Source(shown_name(path), decode(data), path))
        return stored if path.is_relative_to(stdlib()) else substitute(stored, self)

    def parse(self, source: Source) -> syntax.StoredDefinition:
        from planarc.parse.parser import parse_text

        begin = perf_counter()
        try:
            return parse_text(source)
        finally:
            self.seconds += perf_counter() - begin


def shown_name(path: Path) -> str:
    """The name of a file in messages: planarc's own ones without where it is installed."""
    root = stdlib()
    return path.relative_to(root).as_posix() if path.is_relative_to(root) else str(path)


def content_of(path: Path) -> bytes:
    """The bytes of a model's file. Raises UsageError C101, C102, C108."""
    try:
        return read_plain(path)
    except FileNotFoundError:
        from planarc.core.mend import Meant
        from planarc.core.nearest import nearest

        near = tuple(str(path.with_name(n)) for n in nearest(path.name, _siblings(path)))
        hint = Meant(str(path), near) if near else None
        raise usage_error("C101", f"there is no file `{path}`", hint=hint) from None
    except IsADirectoryError:
        raise usage_error(
            "C102",
            f"`{path}` is a folder, not a file",
            hint=f"name a file in it, or a class with `--library {path}`",
        ) from None
    except ValueError as problem:  # a NUL in the name
        raise usage_error("C108", f"cannot read {str(path)!r}: {problem}") from None
    except OSError as problem:
        raise refused("C108", f"cannot read `{path}`", problem) from None


def _siblings(path: Path) -> list[str]:
    folder = path.parent
    return sorted(p.name for p in folder.iterdir()) if folder.is_dir() else []
