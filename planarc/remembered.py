"""Compiled and checked models, remembered on disk from one process to the next.

The entry of a model is found by the request alone (file name, text, class, roots), and counts
only while every file that it was made from has the content that it had then, and whatever was
looked for, found or not, would be found the same.
"""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import TYPE_CHECKING, Any

from planarc.core import cache, plain
from planarc.core.data import Data
from planarc.core.files import read_plain
from planarc.core.looked import same
from planarc.core.options import Backend
from planarc.request.request import Request, Target, roots_of

if TYPE_CHECKING:
    from planarc.core.diagnostic import Diagnostic
    from planarc.ir.derivatives import Scope
    from planarc.ir.mechanism import Mechanism, Mobility
    from planarc.ir.program import Program

KINDS = _MODELS, _CHECKS, _SLOPES = "models", "checks", "slopes"


class Remembered(Data):
    """What a model was compiled to. `code` is that of one back end."""

    program: Program
    code: str | bytes
    warnings: tuple[Diagnostic, ...]
    lead: Remembered | None = None  # what leads to its start


class Checked(Data):
    """What a check told of a model that is right."""

    name: str
    equations_before: int
    equations_after: int
    states: int
    warnings: tuple[Diagnostic, ...]
    mechanism: Mechanism | None = None
    mobility: Mobility | None = None  # where it was asked for
    started: bool = False  # a start was asked for, and found


def recall_check(request: Request) -> Checked | None:
    """What a check of this request told before, None when that is not known any more."""
    found = _recall(_CHECKS, _key(request))
    return found[0] if found else None


def remember_check(request: Request, target: Target, checked: Checked) -> None:
    """Keep what was told, with the content of the files that it came from."""
    _remember(_CHECKS, _key(request), target, (checked,))


def recall(request: Request, backend: Backend) -> Remembered | None:
    """What this request was compiled to before, None when that is not known any more."""
    found = _recall(_MODELS, _key(request, backend.value, *_machine(backend)))
    try:
        return _loaded(*found) if found else None
    except Exception:  # an entry that cannot be read is no entry
        return None


def identity(request: Request, backend: Backend) -> str | None:
    """A text that only this model has as it was compiled; None where that is not known any more."""
    found = _recall(_MODELS, _key(request, backend.value, *_machine(backend)))
    return None if found is None else cache.key(*found[:2])


def _loaded(
    program: bytes, code: str | bytes, warnings: tuple[Diagnostic, ...], *lead: Any
) -> Remembered:
    from planarc.ir.store import loads

    return Remembered(loads(program), code, warnings, _loaded(*lead) if lead else None)


def remember(request: Request, backend: Backend, target: Target, made: Remembered) -> None:
    """Keep what was compiled, with the content of the files that it came from."""
    key = _key(request, backend.value, *_machine(backend))
    _remember(_MODELS, key, target, _entry(made))


def _entry(made: Remembered) -> tuple[Any, ...]:
    from planarc.ir.store import dumps

    lead = () if made.lead is None else _entry(made.lead)
    return dumps(made.program, made.program.table), made.code, made.warnings, *lead


def recall_slopes(program: Program, code: str | bytes, scope: Scope) -> bytes | None:
    """The code of derivatives that was made of this code before; empty where there is none."""
    return cache.load(_SLOPES, _slopes_key(program, code, scope))


def remember_slopes(program: Program, code: str | bytes, scope: Scope, made: bytes) -> None:
    """Keep the code of derivatives; empty bytes say that there is none."""
    cache.store(_SLOPES, _slopes_key(program, code, scope), made)


def _slopes_key(program: Program, code: str | bytes, scope: Scope) -> str:
    # Equal code may be of programs that differ in what may be asked of it.
    asked = (
        [(c.slot, c.derivative) for c in program.candidates],
        [p.slot for p in program.parameter_slots if p.settable],
        [program.slots[name] for name in program.inputs],
    )
    return cache.key(_SLOPES, scope.value, code, repr(asked))


def _recall(kind: str, key: str) -> tuple[Any, ...] | None:
    """An entry whose files are as they were."""
    stored = cache.load(kind, key)
    if stored is None:
        return None
    try:
        files, findings, *entry = plain.loads(stored)
        # The user's own file is the first, and what changes most.
        valid = all(_unchanged(Path(p), k) for p, k in files) and same(findings)
        return tuple(entry) if valid else None
    except Exception:  # an entry that cannot be read is no entry
        return None


def _remember(kind: str, key: str, target: Target, entry: tuple[Any, ...]) -> None:
    if target.library.looked.open_questions:
        return
    files = [(str(p), k) for p, k in target.reader.files.items()]
    found = target.library.looked.findings()
    cache.store(kind, key, pickle.dumps((files, found, *entry), pickle.HIGHEST_PROTOCOL))


def _key(request: Request, *more: str) -> str:
    roots = roots_of(request)
    file = str(request.file.absolute()) if request.file else ""
    return cache.key(
        str(request.file or ""),
        file,
        request.text or "",
        request.class_name or "",
        request.units.value,
        request.redundant.value,
        repr(request.inputs),
        repr(request.placed),
        *(str(r) for r in roots),
        *(str(r.absolute()) for r in roots),
        *more,
    )


def _machine(backend: Backend) -> tuple[str, ...]:
    """Native code belongs to one kind of processor and one version of its compiler."""
    if backend is not Backend.NATIVE:
        return ()
    from planarc.codegen.native.processor import key

    return (key(),)


def _unchanged(path: Path, key: str) -> bool:
    try:
        return cache.key(read_plain(path)) == key
    except OSError:
        return False
