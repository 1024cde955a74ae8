"""The cache folder: what was computed once and can be computed again.

In it are files `<kind>/<key>`, a secret of the user's, and a mark by which planarc knows the
folder for its own. Some entries are loaded as code. So nothing is read that another user could
have written: folder, kind and entry belong to the user and nobody else may write them, and an
entry begins with a code of its content, its place and the secret (Krawczyk, Bellare and Canetti,
RFC 2104; here BLAKE2 with a key, RFC 7693). A damaged or planted entry counts as absent.

An entry is written under another name and renamed, so that several processes never see half of
one. A folder that is not planarc's own is left as it is; `refusal` says why. Nothing here
raises: a cache that cannot be used is only slow.
"""

from __future__ import annotations

import os
import re
import stat
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from zlib import crc32

from planarc.core.data import Data
from planarc.core.digest import blake2b
from planarc.core.version import __version__

#: Bytes that all entries may take; the entries unused for longest go first.
MAX_BYTES = 256 * 1024 * 1024
#: The kinds of entries, and their names, until they are whole and then. Nothing else in the
#: folder is planarc's.
KINDS = ("checks", "grammar", "models", "native", "pages", "slopes", "syntax")
_FORMER = "bytecode"  # a kind that there was before there was a mark
_NAME = r"\.new-[0-9a-f]{16}|[0-9a-f]{40}"
#: The mark also tells programs that save files to leave the folder out
#: (Cache Directory Tagging Specification 0.6).
_MARK = "CACHEDIR.TAG"
_MARKED = b"Signature: 8a477f597d28d172789f06886806bc55\n# Made by planarc.\n"
_SECRET, _SECRET_BYTES = "secret", 32
#: Stores between two looks at the size, as a share of all keys: 1 in 100.
_LOOK_SHARE = 100
_CODE_BYTES = 16


class Opened(Data):
    """The folder, where it can be used, and the user's secret; or why not."""

    root: Path | None = None
    secret: bytes = b""
    refusal: str = ""


def folder() -> Path | None:
    """The cache folder, made if need be; None when there is none that is ours alone.

    It is called `planarc`, in the folder that `PLANARC_CACHE_DIR` names or in that of the
    user; where the name is empty, the cache is off.
    """
    return _opened(os.environ.get("PLANARC_CACHE_DIR")).root


def refusal() -> str:
    """Why the folder that was asked for cannot be used; empty where it can, or is off."""
    asked = _opened.cache_info().currsize > 0
    return _opened(os.environ.get("PLANARC_CACHE_DIR")).refusal if asked else ""


def key(*parts: str | bytes) -> str:
    """A key for what these texts, this planarc and this Python give."""
    digest = blake2b(digest_size=20)
    for part in (*_versions(), *parts):
        data = part.encode("utf-8", "surrogatepass") if isinstance(part, str) else part
        digest.update(len(data).to_bytes(8, "little"))
        digest.update(data)
    return digest.hexdigest()


def load(kind: str, key: str) -> bytes | None:
    """The bytes stored under a key, None if there are none or they are not ours."""
    opened = _opened(os.environ.get("PLANARC_CACHE_DIR"))
    if opened.root is None or not _is_ours(kept := opened.root / kind, stat.S_ISDIR):
        return None
    path = kept / key
    data = _read_own(path)
    if data is None:
        return None
    content = data[_CODE_BYTES:]
    if data[:_CODE_BYTES] != _code(opened.secret, kind, key, content):
        with suppress(OSError):
            path.unlink()
        return None
    with suppress(OSError):
        os.utime(path)  # used now: among the last to go
    return content


def store(kind: str, key: str, data: bytes) -> None:
    """Keep bytes under a key, if that is possible."""
    opened = _opened(os.environ.get("PLANARC_CACHE_DIR"))
    if opened.root is None:
        return
    assert kind in KINDS
    target = opened.root / kind / key
    try:
        target.parent.mkdir(mode=0o700, exist_ok=True)
        if not _is_ours(target.parent, stat.S_ISDIR):
            return
        _write(target, _code(opened.secret, kind, key, data) + data)
    except OSError:
        return
    if len(data) > MAX_BYTES // 64 or crc32(key.encode()) % _LOOK_SHARE == 0:
        shrink(opened.root, MAX_BYTES)


def entries(root: Path) -> dict[str, tuple[int, int]]:
    """The number of entries of each kind, and the bytes that they take."""
    found: dict[str, tuple[int, int]] = {}
    for kind, _, state in _stored(root):
        number, total = found.get(kind, (0, 0))
        found[kind] = number + 1, total + state.st_size
    return found


def clear(root: Path) -> int:
    """Remove all entries; how many could not be removed."""
    shrink(root, -1)
    return sum(number for number, _ in entries(root).values())


def shrink(root: Path, limit: int) -> None:
    """Remove the entries that were unused for longest until the rest fits."""
    entries = [(state.st_mtime, state.st_size, path) for _, path, state in _stored(root)]
    total = sum(size for _, size, _ in entries)
    for _, size, path in sorted(entries):
        if total <= limit:
            break
        with suppress(OSError):
            Path(path).unlink()
            total -= size


def _stored(root: Path) -> Iterator[tuple[str, str, os.stat_result]]:
    """The files that planarc wrote: their kinds, paths and states."""
    for kind in KINDS:
        if _is_ours(root / kind, stat.S_ISDIR):
            with os.scandir(root / kind) as found:  # thousands of files: paths would take longer
                for file in found:
                    with suppress(OSError):
                        state = file.stat(follow_symlinks=False)
                        if _is_written(file) and stat.S_ISREG(state.st_mode):
                            yield kind, file.path, state


def _is_written(path: Path | os.DirEntry[str]) -> bool:
    return re.fullmatch(_NAME, path.name) is not None


# Opening the folder -----------------------------------------------------------------------


@cache
def _opened(named: str | None) -> Opened:
    if named == "":
        return Opened()
    try:
        root = users_folder() if named is None else Path(named) / "planarc"
        root.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        with suppress(FileExistsError):
            root.mkdir(mode=0o700)
        root = root.resolve()
        reason = _reason_against(root)
        if reason:
            return Opened(refusal=f"`{root}` {reason}")
        return Opened(root, _secret(root))
    except (OSError, ValueError, RuntimeError):
        return Opened()


def users_folder() -> Path:
    """The folder for planarc in that of the user's caches. Of Linux it is known (XDG Base Directory
    Specification 0.8) without `platformdirs`, which takes a twentieth of a short command to be
    imported."""
    if sys.platform == "linux" and "ANDROID_DATA" not in os.environ:
        asked = Path(os.environ.get("XDG_CACHE_HOME", ""))
        return (asked if asked.is_absolute() else Path.home() / ".cache") / "planarc"
    from platformdirs import user_cache_dir

    return Path(user_cache_dir("planarc", appauthor=False))


def _reason_against(root: Path) -> str:
    """Why a folder is not to be used; empty where it is marked, or is marked now."""
    if not root.is_dir():
        return "is no folder"
    if not _is_ours(root, stat.S_ISDIR):
        return "belongs to another user, or others may write into it"
    mark = _read_own(root / _MARK)
    if mark == _MARKED:
        return ""
    if mark is not None and mark.startswith(_MARKED.splitlines()[0]):
        return "is marked by another program"
    if not _looks_like_ours(root):
        return "holds files that planarc did not write"
    _write(root / _MARK, _MARKED)
    return ""


def _looks_like_ours(root: Path) -> bool:
    """True for an empty folder, and for one that was filled before there was a mark."""
    inside = [path for path in root.iterdir() if not _is_written(path)]
    return all(
        path.name == _SECRET
        or (path.name in (*KINDS, _FORMER) and all(map(_is_written, path.iterdir())))
        for path in inside
        if path.name != _MARK
    )


def _secret(root: Path) -> bytes:
    """The user's secret, drawn where there is none; the first of several processes draws it."""
    path = root / _SECRET
    for _ in range(3):
        known = _read_own(path, private=True)
        if known is not None and len(known) == _SECRET_BYTES:
            return known
        if known is not None:
            path.unlink(missing_ok=True)
        _draw(path)
    raise OSError(f"{path} cannot be kept")


def _draw(path: Path) -> None:
    drawn = _write_beside(path, os.urandom(_SECRET_BYTES))
    try:
        path.hardlink_to(drawn)  # of several processes one succeeds
    except FileExistsError:
        if _read_own(path, private=True) is None:  # others may read or write it
            path.unlink(missing_ok=True)
    except OSError:  # a file system without such links
        drawn.replace(path)
    finally:
        drawn.unlink(missing_ok=True)


# Files of ours alone ----------------------------------------------------------------------


def _is_ours(path: Path, kind: Callable[[int], bool]) -> bool:
    """True for a thing of this kind that only the user may write; no link is followed."""
    try:
        state = path.lstat()
    except OSError:
        return False
    return kind(state.st_mode) and _only_we_write(state)


def _only_we_write(state: os.stat_result, private: bool = False) -> bool:
    if not hasattr(os, "getuid"):
        return True
    others = 0o077 if private else 0o022
    return state.st_uid == os.getuid() and not state.st_mode & others


def _read_own(path: Path, private: bool = False) -> bytes | None:
    """The content of a plain file that only the user may write, and read if it is private."""
    try:
        number = os.open(path, os.O_RDONLY | _NO_LINK | _NO_WAIT)
    except (OSError, ValueError):
        return None
    with os.fdopen(number, "rb") as file:
        state = os.fstat(number)
        if not stat.S_ISREG(state.st_mode) or not _only_we_write(state, private):
            return None
        return file.read()


def _write(target: Path, data: bytes) -> None:
    """Write a file whole or not at all."""
    written = _write_beside(target, data)
    try:
        written.replace(target)
    except BaseException:
        written.unlink(missing_ok=True)
        raise


def _write_beside(target: Path, data: bytes) -> Path:
    written = target.with_name(f".new-{os.urandom(8).hex()}")
    written.touch(mode=0o600, exist_ok=False)
    try:
        written.write_bytes(data)
    except BaseException:
        written.unlink(missing_ok=True)
        raise
    return written


#: Flags of POSIX: a link is not followed, and a named pipe not waited for.
_NO_LINK = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
_NO_WAIT = getattr(os, "O_NONBLOCK", 0)


def _code(secret: bytes, kind: str, key: str, content: bytes) -> bytes:
    """The code that only this user's planarc can put in front of an entry."""
    digest = blake2b(f"{kind}/{key}\n".encode(), digest_size=_CODE_BYTES, key=secret)
    digest.update(content)
    return digest.digest()


# What keys hold ---------------------------------------------------------------------------


@cache
def _versions() -> tuple[str, ...]:
    """The versions on which every entry depends: planarc, by the state of its files, and Python."""
    try:
        planarc = _state_of(Path(__file__).resolve().parent.parent)
    except OSError:  # not installed as files
        planarc = __version__
    return (planarc, sys.version, sys.platform)


def _state_of(package: Path) -> str:
    """Changes with any module below a folder."""
    stamp = blake2b(digest_size=16)
    folders = [os.fspath(package)]
    while folders:
        with os.scandir(folders.pop()) as entries:
            for entry in sorted(entries, key=lambda entry: entry.name):
                if entry.is_dir():
                    folders += [entry.path] if entry.name != "__pycache__" else []
                elif entry.name.endswith(".py"):
                    state = entry.stat()
                    line = f"{entry.name} {state.st_size} {state.st_mtime_ns}\n"
                    stamp.update(line.encode("utf-8", "surrogateescape"))
    return stamp.hexdigest()
