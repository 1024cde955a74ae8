"""The cache folder: what was stored comes back or is absent, and nothing raises."""

from __future__ import annotations

import multiprocessing
import os
import stat
import time
from pathlib import Path

import pytest
from platformdirs import user_cache_dir

from planarc.core import cache

KEY = "0" * 40
POSIX = pytest.mark.skipif(os.name != "posix", reason="permissions of POSIX")


@pytest.fixture
def named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder that PLANARC_CACHE_DIR names."""
    path = tmp_path / "a" / "cache"
    monkeypatch.setenv("PLANARC_CACHE_DIR", str(path))
    return path


@pytest.fixture
def folder(named: Path) -> Path:
    """The folder of planarc's own in it."""
    return named / "planarc"


def open_again() -> None:
    """Look at the folder as another process would."""
    cache._opened.cache_clear()


@pytest.mark.parametrize("asked", [None, "", "/var/mine", "/var/mine/", "caches", "~/caches"])
def test_the_users_folder_is_that_of_other_programs(
    asked: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    if asked is None:
        monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    else:
        monkeypatch.setenv("XDG_CACHE_HOME", asked)
    assert cache.users_folder() == Path(user_cache_dir("planarc", appauthor=False))


def test_what_was_stored_comes_back(folder: Path) -> None:
    key = cache.key("a")
    assert cache.load("models", key) is None
    cache.store("models", key, b"data")
    assert cache.load("models", key) == b"data"
    assert cache.load("checks", key) is None
    cache.store("models", key, b"new")
    assert cache.load("models", key) == b"new"


def test_keys_tell_their_parts_apart() -> None:
    keys = [cache.key(*parts) for parts in [("ab", "c"), ("a", "bc"), ("abc",), ("ab", "c", "")]]
    assert len(set(keys)) == 4
    assert cache.key("a", b"b") == cache.key(b"a", "b")
    assert cache.key("\ud800")


@POSIX
def test_nobody_else_reads_it(folder: Path) -> None:
    cache.store("models", KEY, b"data")
    for path in (folder, folder / "models", folder / "models" / KEY, folder / "secret"):
        assert stat.S_IMODE(path.stat().st_mode) & 0o077 == 0


@pytest.mark.parametrize("damage", [b"", b"x", b"x" * 100])
def test_a_damaged_entry_is_absent(folder: Path, damage: bytes) -> None:
    cache.store("models", KEY, b"data")
    entry = folder / "models" / KEY
    entry.write_bytes(damage)
    assert cache.load("models", KEY) is None
    entry.write_bytes(damage)
    cache.store("models", KEY, b"data")
    assert cache.load("models", KEY) == b"data"


def test_a_changed_byte_is_noticed(folder: Path) -> None:
    cache.store("models", KEY, b"data")
    entry = folder / "models" / KEY
    data = bytearray(entry.read_bytes())
    data[-1] ^= 1
    entry.write_bytes(bytes(data))
    assert cache.load("models", KEY) is None


def test_the_folder_can_be_switched_off(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PLANARC_CACHE_DIR", "")
    monkeypatch.chdir(tmp_path)
    cache.store("models", KEY, b"data")
    assert cache.load("models", KEY) is None
    assert list(tmp_path.iterdir()) == []


def test_an_unusable_folder_is_only_slow(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_bytes(b"")
    monkeypatch.setenv("PLANARC_CACHE_DIR", str(tmp_path / "file"))
    cache.store("models", KEY, b"data")
    assert cache.load("models", KEY) is None


def test_the_entries_unused_for_longest_go_first(folder: Path) -> None:
    keys = [cache.key(str(number)) for number in range(10)]
    for number, key in enumerate(keys):
        cache.store("models", key, b"x" * 1000)
        long_ago = time.time() - 1000 + number
        os.utime(folder / "models" / key, (long_ago, long_ago))
    assert cache.load("models", keys[0]) is not None  # used now
    cache.shrink(folder, 3500)
    assert {p.name for p in (folder / "models").iterdir()} == {keys[0], *keys[8:]}


def _store_often(folder: str, number: int) -> None:
    os.environ["PLANARC_CACHE_DIR"] = folder
    for _ in range(100):
        cache.store("models", KEY, bytes([number]) * 5000)
        data = cache.load("models", KEY)
        assert data is not None
        assert len(set(data)) == 1
        assert len(data) == 5000


def test_several_processes_never_see_half_an_entry(folder: Path) -> None:
    context = multiprocessing.get_context("spawn")
    processes = [
        context.Process(target=_store_often, args=(str(folder.parent), n)) for n in range(3)
    ]
    for process in processes:
        process.start()
    for process in processes:
        process.join()
    assert [process.exitcode for process in processes] == [0, 0, 0]
    assert [p.name for p in (folder / "models").iterdir()] == [KEY]


# What is not ours --------------------------------------------------------------------------


@POSIX
def test_what_lies_beside_it_stays_as_it_is(named: Path, folder: Path) -> None:
    others = [named / "results" / KEY, named / "models" / KEY, named / "notes"]
    for path in others:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"x" * 1000)
    named.chmod(0o755)
    cache.store("models", KEY, b"data")
    (folder / "models" / "mine").write_bytes(b"x")  # not called as an entry is
    (folder / "more").mkdir()
    (folder / "more" / KEY).write_bytes(b"x")
    cache.shrink(folder, 0)
    assert cache.clear(folder) == 0
    assert all(path.read_bytes() == b"x" * 1000 for path in others)
    assert (folder / "models" / "mine").exists()
    assert (folder / "more" / KEY).exists()
    assert not (folder / "models" / KEY).exists()
    assert stat.S_IMODE(named.stat().st_mode) == 0o755


@pytest.mark.parametrize("inside", ["readme", "models/mine", "models/deeper/file"])
def test_a_folder_of_another_program_is_refused(folder: Path, inside: str) -> None:
    (folder / inside).parent.mkdir(parents=True)
    (folder / inside).write_bytes(b"data")
    before = sorted(folder.rglob("*"))
    cache.store("models", KEY, b"data")
    assert cache.load("models", KEY) is None
    assert cache.folder() is None
    assert cache.refusal() == f"`{folder}` holds files that planarc did not write"
    assert sorted(folder.rglob("*")) == before


def test_a_mark_of_another_program_is_refused(folder: Path) -> None:
    folder.mkdir(parents=True)
    (folder / "CACHEDIR.TAG").write_text("Signature: 8a477f597d28d172789f06886806bc55\n", "utf-8")
    assert cache.folder() is None
    assert "another program" in cache.refusal()


def test_a_folder_filled_before_there_was_a_mark_is_taken_over(folder: Path) -> None:
    (folder / "models").mkdir(parents=True)
    (folder / "models" / KEY).write_bytes(b"x" * 100)
    assert cache.load("models", KEY) is None
    cache.store("models", KEY, b"data")
    assert cache.load("models", KEY) == b"data"


@POSIX
@pytest.mark.parametrize("mode", [0o770, 0o707, 0o777])
def test_a_folder_in_which_others_may_write_is_refused(folder: Path, mode: int) -> None:
    cache.store("models", KEY, b"data")
    folder.chmod(mode)
    open_again()
    assert cache.load("models", KEY) is None
    assert "others may write" in cache.refusal()
    assert stat.S_IMODE(folder.stat().st_mode) == mode


@POSIX
@pytest.mark.parametrize("place", ["models", f"models/{KEY}"])
def test_what_others_may_have_written_is_not_read(folder: Path, place: str) -> None:
    cache.store("models", KEY, b"data")
    (folder / place).chmod(0o777)
    assert cache.load("models", KEY) is None
    if place == "models":
        cache.store("models", KEY, b"new")
    (folder / place).chmod(0o700)
    assert cache.load("models", KEY) == b"data"


def test_an_entry_counts_in_its_place_only(folder: Path) -> None:
    other = "1" * 40
    cache.store("models", KEY, b"data")
    data = (folder / "models" / KEY).read_bytes()
    cache.store("models", other, b"other")
    cache.store("native", KEY, b"other")
    for path in (folder / "models" / other, folder / "native" / KEY):
        path.write_bytes(data)
        assert cache.load(path.parent.name, path.name) is None


def test_an_entry_of_another_cache_is_not_read(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Who knows the code of an entry, but not the secret, cannot plant one."""
    cache.store("native", KEY, b"mine")
    monkeypatch.setenv("PLANARC_CACHE_DIR", str(tmp_path / "b"))
    cache.store("native", KEY, b"planted")
    planted = (tmp_path / "b" / "planarc" / "native" / KEY).read_bytes()
    monkeypatch.setenv("PLANARC_CACHE_DIR", str(folder.parent))
    (folder / "native" / KEY).write_bytes(planted)
    assert cache.load("native", KEY) is None


@POSIX
def test_a_secret_that_others_could_read_is_drawn_anew(folder: Path) -> None:
    cache.store("native", KEY, b"data")
    before = (folder / "secret").read_bytes()
    (folder / "secret").chmod(0o644)
    open_again()
    assert cache.load("native", KEY) is None
    assert (folder / "secret").read_bytes() != before
    assert stat.S_IMODE((folder / "secret").stat().st_mode) == 0o600


@POSIX
def test_links_are_not_followed(folder: Path, tmp_path: Path) -> None:
    cache.store("models", KEY, b"data")
    entry = folder / "models" / KEY
    (tmp_path / "elsewhere").write_bytes(entry.read_bytes())
    entry.unlink()
    entry.symlink_to(tmp_path / "elsewhere")
    assert cache.load("models", KEY) is None
    assert cache.entries(folder) == {}
    cache.clear(folder)
    assert (tmp_path / "elsewhere").exists()


@POSIX
def test_a_pipe_in_the_place_of_an_entry_is_not_waited_for(folder: Path) -> None:
    cache.store("models", KEY, b"data")
    (folder / "models" / KEY).unlink()
    os.mkfifo(folder / "models" / KEY, 0o600)
    assert cache.load("models", KEY) is None
