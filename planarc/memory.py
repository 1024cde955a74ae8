"""Compiled models, remembered on disk from one process to the next.

An entry is found by the request alone (file name, text, class, roots), and counts
only while every file that it was made from still has the content it had then.
"""

from __future__ import annotations

import pickle
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from planarc.core import cache
from planarc.core.options import Backend
from planarc.request import Reader, Request, roots_of

if TYPE_CHECKING:
    from planarc.core.diagnostic import Diagnostic
    from planarc.ir.program import Program

_KIND = "models"


@dataclass(frozen=True, slots=True)
class Remembered:
    """What a model was compiled to. `code` is that of one back end."""

    program: Program
    code: str | bytes
    warnings: tuple[Diagnostic, ...]


def recall(request: Request, backend: Backend) -> Remembered | None:
    """What this request was compiled to before, None when that is not known any more."""
    from planarc.ir.store import loads

    stored = cache.load(_KIND, _key(request, backend))
    if stored is None:
        return None
    try:
        files, program, code, warnings = pickle.loads(stored)
        if not all(_unchanged(Path(p), k) for p, k in files):
            return None
        return Remembered(loads(program), code, warnings)
    except Exception:  # an entry that cannot be read is no entry
        return None


def remember(request: Request, backend: Backend, reader: Reader, made: Remembered) -> None:
    """Keep what was compiled, with the content of the files that it came from."""
    from planarc.ir.store import dumps

    files = [(str(p), k) for p, k in sorted(reader.files.items())]
    program = dumps(made.program, made.program.table)
    entry = (files, program, made.code, made.warnings)
    cache.store(_KIND, _key(request, backend), pickle.dumps(entry, pickle.HIGHEST_PROTOCOL))


def _key(request: Request, backend: Backend) -> str:
    roots = roots_of(request)
    listed = (f"{r.absolute()} {sorted(p.name for p in r.iterdir())}" for r in roots if r.is_dir())
    file = str(request.file.absolute()) if request.file else ""
    return cache.key(
        backend.value,
        str(request.file or ""),
        file,
        request.text or "",
        request.class_name or "",
        request.units.value,
        *(str(r) for r in roots),
        *listed,
        *_machine(backend),
    )


def _machine(backend: Backend) -> tuple[str, ...]:
    """Native code belongs to one kind of processor and one version of its compiler."""
    if backend is not Backend.NATIVE:
        return ()
    from planarc.codegen.native.machine import key

    return (key(),)


def _unchanged(path: Path, key: str) -> bool:
    try:
        return cache.key(path.read_bytes()) == key
    except OSError:
        return False
