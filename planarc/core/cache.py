"""The cache folder: what was computed once and can be computed again.

Entries are files `<kind>/<key>` below one folder of the user, which nobody else
may read, since some entries are loaded as code. An entry is written under
another name and renamed, so that several processes never see half of one; it
begins with a checksum, so that a damaged one counts as absent. Nothing here
raises: a cache that cannot be used is only slow.
"""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from functools import cache
from hashlib import blake2b
from pathlib import Path
from zlib import crc32

#: Bytes that all entries may take; the entries unused for longest go first.
MAX_BYTES = 256 * 1024 * 1024
#: Stores between two looks at the size, as a share of all keys: 1 in 100.
_LOOK_SHARE = 100
_CHECKSUM = 16  # bytes


def folder() -> Path | None:
    """The cache folder, made if need be; None when there is none that is ours alone.

    `PLANARC_CACHE_DIR` names another one; empty, it switches the cache off.
    """
    named = os.environ.get("PLANARC_CACHE_DIR")
    return None if named == "" else _private_folder(named)


def key(*parts: str | bytes) -> str:
    """A key for what these texts, this planarc and this Python give."""
    digest = blake2b(digest_size=20)
    for part in (*_versions(), *parts):
        data = part.encode("utf-8", "surrogatepass") if isinstance(part, str) else part
        digest.update(len(data).to_bytes(8, "little"))
        digest.update(data)
    return digest.hexdigest()


def load(kind: str, key: str) -> bytes | None:
    """The bytes stored under a key, None if there are none or they are damaged."""
    root = folder()
    if root is None:
        return None
    path = root / kind / key
    try:
        data = path.read_bytes()
    except OSError:
        return None
    content = data[_CHECKSUM:]
    if data[:_CHECKSUM] != _checksum(content):
        with suppress(OSError):
            path.unlink()
        return None
    with suppress(OSError):
        os.utime(path)  # used now: among the last to go
    return content


def store(kind: str, key: str, data: bytes) -> None:
    """Keep bytes under a key, if that is possible."""
    root = folder()
    if root is None:
        return
    target = root / kind / key
    try:
        target.parent.mkdir(mode=0o700, exist_ok=True)
        written = target.with_name(f".new-{os.urandom(8).hex()}")
        written.touch(mode=0o600, exist_ok=False)
        try:
            with written.open("wb") as file:
                file.write(_checksum(data))
                file.write(data)
            written.replace(target)
        except BaseException:
            written.unlink(missing_ok=True)
            raise
    except OSError:
        return
    if len(data) > MAX_BYTES // 64 or crc32(key.encode()) % _LOOK_SHARE == 0:
        shrink(root, MAX_BYTES)


def entries(root: Path) -> dict[str, tuple[int, int]]:
    """How many entries there are of each kind, and how many bytes they take."""
    found: dict[str, tuple[int, int]] = {}
    for path in sorted(root.glob("*/*")):
        with suppress(OSError):
            size = path.stat().st_size
            number, total = found.get(path.parent.name, (0, 0))
            found[path.parent.name] = number + 1, total + size
    return found


def clear(root: Path) -> int:
    """Remove all entries; how many could not be removed."""
    shrink(root, -1)
    return sum(number for number, _ in entries(root).values())


def shrink(root: Path, limit: int) -> None:
    """Remove the entries that were unused for longest until the rest fits."""
    entries: list[tuple[float, int, Path]] = []
    for path in root.glob("*/*"):
        with suppress(OSError):
            state = path.stat()
            entries.append((state.st_mtime, state.st_size, path))
    total = sum(size for _, size, _ in entries)
    for _, size, path in sorted(entries):
        if total <= limit:
            break
        with suppress(OSError):
            path.unlink()
            total -= size


@cache
def _private_folder(named: str | None) -> Path | None:
    try:
        if named is None:
            from platformdirs import user_cache_dir

            named = user_cache_dir("planarc", appauthor=False)
        root = Path(named)
        root.mkdir(mode=0o700, parents=True, exist_ok=True)
        if hasattr(os, "getuid"):
            state = root.stat()
            if state.st_uid != os.getuid():
                return None
            if state.st_mode & 0o077:
                root.chmod(0o700)
    except (OSError, ValueError, RuntimeError):
        return None
    return root


@cache
def _versions() -> tuple[str, ...]:
    """What every entry depends on: planarc, by the state of its files, and Python."""
    try:
        planarc = _state_of(Path(__file__).resolve().parent.parent)
    except OSError:  # not installed as files
        from importlib.metadata import version

        planarc = version("planarc")
    return (planarc, sys.version, sys.platform)


def _state_of(package: Path) -> str:
    """Changes with any module below a folder."""
    stamp = blake2b(digest_size=16)
    folders = [os.fspath(package)]
    while folders:
        with os.scandir(folders.pop()) as entries:
            for entry in sorted(entries, key=lambda entry: entry.name):
                if entry.is_dir():
                    folders.append(entry.path)
                elif entry.name.endswith(".py"):
                    state = entry.stat()
                    line = f"{entry.name} {state.st_size} {state.st_mtime_ns}\n"
                    stamp.update(line.encode("utf-8", "surrogateescape"))
    return stamp.hexdigest()


def _checksum(data: bytes) -> bytes:
    return blake2b(data, digest_size=_CHECKSUM).digest()
