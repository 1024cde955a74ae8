"""A watch that notices edits of a model's files, by looking at them now and then.

Looked at are the user's files: the one that is served and the folders of `--library`, not
planarc's own. A few looks a second cost nothing, and hold on every system and network disk.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from threading import Event, Thread

from planarc.core.source import model_files
from planarc.request.request import Request

#: Seconds between two looks.
PERIOD = 0.3
#: The most files of a large library that are looked at.
_MOST = 2000


def files_of(request: Request) -> tuple[Path, ...]:
    """The files of a request that its user may edit."""
    return tuple(_files(request))[:_MOST]


def _files(request: Request) -> Iterator[Path]:
    if request.file is not None:
        yield request.file
    for root in request.libraries:
        if root.is_dir():
            yield from model_files(root, below=True)
        else:
            yield root


def stamp(request: Request) -> tuple[tuple[str, int, int], ...]:
    """Time and size of each file: a mark that differs after an edit."""
    found = []
    for path in files_of(request):
        try:
            status = path.stat()
        except OSError:  # gone for a moment while an editor writes it
            continue
        found.append((str(path), status.st_mtime_ns, status.st_size))
    return tuple(found)


class Watch:
    """Calls `changed` in a thread of its own after each edit, until `stop`."""

    def __init__(self, request: Request, changed: Callable[[], None]) -> None:
        self._request, self._changed = request, changed
        self._seen = stamp(request)
        self._end = Event()
        self._thread = Thread(target=self._look, name="planarc watch", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        self._end.set()
        self._thread.join()

    def _look(self) -> None:
        while not self._end.wait(PERIOD):
            now = stamp(self._request)
            # Nothing there: an editor is about to put the new file in the old one's place.
            if now and now != self._seen:
                self._seen = now
                self._changed()
