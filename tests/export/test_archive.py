"""Archives, as Python's own reader sees them."""

from __future__ import annotations

import io
import zipfile

from planarc.export.archive import write_archive

FILES = {
    "a.txt": b"",
    "deep/b.bin": bytes(range(256)) * 300,
    "ä.txt": "grün".encode(),
}


def test_an_archive_holds_the_files_in_their_order() -> None:
    with zipfile.ZipFile(io.BytesIO(write_archive(FILES))) as read:
        assert read.testzip() is None
        assert {name: read.read(name) for name in read.namelist()} == FILES
        assert read.namelist() == [*FILES]
        for told in read.infolist():
            assert told.date_time == (1980, 1, 1, 0, 0, 0)
            assert told.external_attr >> 16 == 0o100644


def test_the_same_files_give_the_same_bytes_packed() -> None:
    data = write_archive(FILES)
    assert data == write_archive(dict(FILES))
    assert len(data) < 2_000
