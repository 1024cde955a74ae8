"""Results saved in spite of a full disk: what cannot be written where it was asked for goes to
the system's folder for temporary files."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from msgspec.structs import replace

from planarc.core.diagnostic import UsageError


def save(path: Path, write: Callable[[Path], object]) -> None:
    """Call `write` with the path. Raises UsageError V501, which says where else it is."""
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
        folder = Path(tempfile.mkdtemp(prefix="planarc-"))
        try:
            write(folder / path.name)
        except UsageError:
            folder.rmdir()
        else:
            return folder / path.name
    return None
