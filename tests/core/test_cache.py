"""The cache folder: what was stored comes back or is absent, and nothing raises."""

from __future__ import annotations

import multiprocessing
import os
import stat
import time
from pathlib import Path

import pytest

from planarc.core import cache


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "a" / "cache"
    monkeypatch.setenv("PLANARC_CACHE_DIR", str(path))
    return path


def test_what_was_stored_comes_back(folder: Path) -> None:
    key = cache.key("a")
    assert cache.load("kind", key) is None
    cache.store("kind", key, b"data")
    assert cache.load("kind", key) == b"data"
    assert cache.load("other", key) is None
    cache.store("kind", key, b"new")
    assert cache.load("kind", key) == b"new"


def test_keys_tell_their_parts_apart() -> None:
    keys = [cache.key(*parts) for parts in [("ab", "c"), ("a", "bc"), ("abc",), ("ab", "c", "")]]
    assert len(set(keys)) == 4
    assert cache.key("a", b"b") == cache.key(b"a", "b")
    assert cache.key("\ud800")


@pytest.mark.skipif(os.name != "posix", reason="permissions of POSIX")
def test_nobody_else_reads_it(folder: Path) -> None:
    folder.mkdir(parents=True)
    folder.chmod(0o755)
    cache.store("kind", "k", b"data")
    for path in (folder, folder / "kind", folder / "kind" / "k"):
        assert stat.S_IMODE(path.stat().st_mode) & 0o077 == 0


@pytest.mark.parametrize("damage", [b"", b"x", b"x" * 100])
def test_a_damaged_entry_is_absent(folder: Path, damage: bytes) -> None:
    cache.store("kind", "k", b"data")
    entry = folder / "kind" / "k"
    entry.write_bytes(damage)
    assert cache.load("kind", "k") is None
    entry.write_bytes(damage)
    cache.store("kind", "k", b"data")
    assert cache.load("kind", "k") == b"data"


def test_a_changed_byte_is_noticed(folder: Path) -> None:
    cache.store("kind", "k", b"data")
    entry = folder / "kind" / "k"
    data = bytearray(entry.read_bytes())
    data[-1] ^= 1
    entry.write_bytes(bytes(data))
    assert cache.load("kind", "k") is None


def test_the_folder_can_be_switched_off(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PLANARC_CACHE_DIR", "")
    monkeypatch.chdir(tmp_path)
    cache.store("kind", "k", b"data")
    assert cache.load("kind", "k") is None
    assert list(tmp_path.iterdir()) == []


def test_an_unusable_folder_is_only_slow(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_bytes(b"")
    monkeypatch.setenv("PLANARC_CACHE_DIR", str(tmp_path / "file"))
    cache.store("kind", "k", b"data")
    assert cache.load("kind", "k") is None


def test_the_entries_unused_for_longest_go_first(folder: Path) -> None:
    for number in range(10):
        cache.store("kind", str(number), b"x" * 1000)
        long_ago = time.time() - 1000 + number
        os.utime(folder / "kind" / str(number), (long_ago, long_ago))
    assert cache.load("kind", "0") is not None  # used now
    cache.shrink(folder, 3500)
    assert sorted(p.name for p in (folder / "kind").iterdir()) == ["0", "8", "9"]


def _store_often(folder: str, number: int) -> None:
    os.environ["PLANARC_CACHE_DIR"] = folder
    for _ in range(100):
        cache.store("kind", "k", bytes([number]) * 5000)
        data = cache.load("kind", "k")
        assert data is not None
        assert len(set(data)) == 1
        assert len(data) == 5000


def test_several_processes_never_see_half_an_entry(folder: Path) -> None:
    context = multiprocessing.get_context("spawn")
    processes = [context.Process(target=_store_often, args=(str(folder), n)) for n in range(3)]
    for process in processes:
        process.start()
    for process in processes:
        process.join()
    assert [process.exitcode for process in processes] == [0, 0, 0]
    assert [p.name for p in (folder / "kind").iterdir()] == ["k"]
