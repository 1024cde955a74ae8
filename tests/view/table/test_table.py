"""Tables are read back as they were written, by planarc and by others."""

from __future__ import annotations

import csv
import os
import re
import struct
import sys
from pathlib import Path

import numpy as np
import pytest

from planarc.core.diagnostic import UsageError
from planarc.ir.dae import Kind
from planarc.ir.expr import Exprs
from planarc.ir.program import Column, Program
from planarc.ir.result import Result, Statistics
from planarc.view.table.files import read_table, write_table

ROWS = 7


@pytest.fixture
def result() -> Result:
    columns = (
        Column("rev.phi", 0, 1, Kind.REAL, unit="rad", description="Angle", display_unit="deg"),
        Column("rev.b.phi", 0, 1, Kind.REAL),
        Column("opposite", 0, -1, Kind.REAL),
        Column("a[1,2]", 1, 1, Kind.REAL, unit="m"),
        Column('odd "name"', 1, 1, Kind.REAL, description="Länge"),
        Column("on", 2, 1, Kind.BOOLEAN),
        Column("$when[1]", 2, 1, Kind.BOOLEAN),
        Column("L", 3, 1, Kind.REAL, unit="m", constant=True),
        Column("minusL", 3, -1, Kind.REAL, constant=True),
    )
    program = Program(
        "M", Exprs(), 4, {}, columns, (), (), (), (), (), (), (), (), (), (), (), (), (), (), (),
        (), (),
    )  # fmt: skip
    time = np.array([0.0, 0.1, 0.2, 0.2, 0.3, 1e-300, 1.0])
    data = np.column_stack([np.sin(time * 1e3) / 3, np.full(ROWS, 0.1), np.arange(ROWS) % 2])
    return Result(program, time, data, {0: 0, 1: 1, 2: 2}, {3: 2.5}, Statistics("none", "numpy"))


@pytest.mark.parametrize("suffix", [".csv", ".mat"])
def test_every_number_comes_back_exactly(result: Result, tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"r{suffix}"
    write_table(path, result)
    table = read_table(path)
    assert np.array_equal(table["time"], result.time)
    expected = [
        c.name
        for c in result.program.columns
        if (suffix == ".mat" or not c.constant) and c.name[0] != "$"
    ]
    assert list(table.columns) == expected
    for name in expected:
        assert np.array_equal(table[name], result[name]), name


def test_csv_follows_rfc_4180(result: Result, tmp_path: Path) -> None:
    write_table(tmp_path / "r.csv", result)
    data = (tmp_path / "r.csv").read_bytes()
    assert data.count(b"\r\n") == data.count(b"\n") == ROWS + 1
    with (tmp_path / "r.csv").open(newline="") as file:
        rows = list(csv.reader(file, strict=True))
    assert rows[0][4:6] == ["a[1,2]", 'odd "name"']
    assert [r[6] for r in rows[1:]] == ["0", "1", "0", "1", "0", "1", "0"]


def test_mat_is_what_matlab_reads(result: Result, tmp_path: Path) -> None:
    from scipy.io import loadmat

    write_table(tmp_path / "r.mat", result)
    read = loadmat(tmp_path / "r.mat", chars_as_strings=False)
    assert "".join(read["Aclass"][3]).strip() == "binTrans"
    assert read["dataInfo"][:, 0].tolist() == [0, 1, 0, -1]
    assert read["data_2"].shape == (4, ROWS)  # time and three slots: nothing stored twice
    assert read["data_1"].tolist() == [[0.0, 1.0], [2.5, 2.5]]
    # `opposite` is the negative of what `rev.phi` is.
    assert read["dataInfo"][:2, 3].tolist() == [2, -2]
    assert "".join(read["description"][:, 1]).strip() == "Angle [rad|deg]"


def test_mat_is_what_dymat_reads(result: Result, tmp_path: Path) -> None:
    dymat = pytest.importorskip("DyMat")
    write_table(tmp_path / "r.mat", result)
    file = dymat.DyMatFile(str(tmp_path / "r.mat"))
    for name in ("rev.phi", "rev.b.phi", "opposite", "a[1,2]", "on"):
        assert np.array_equal(file.data(name), result[name]), name
        assert np.array_equal(file.abscissa(name)[0], result.time)
    assert file.data("L").tolist() == [2.5, 2.5]
    assert file.data("minusL").tolist() == [-2.5, -2.5]
    assert file.description("rev.phi") == "Angle [rad|deg]"
    # Stored once: the others share the column of the first.
    assert dict(file.sharedData("rev.phi")) == {"rev.b.phi": 1, "opposite": -1}


def test_units_come_back_from_csv_on_request(result: Result, tmp_path: Path) -> None:
    write_table(tmp_path / "r.csv", result, units=True)
    head = (tmp_path / "r.csv").read_text("utf-8").splitlines()[0]
    assert head.startswith('"time [s]","rev.phi [rad]","rev.b.phi",')
    table = read_table(tmp_path / "r.csv")
    assert table.units == {"rev.phi": "rad", "a[1,2]": "m"}
    assert np.array_equal(table["rev.phi"], result["rev.phi"])
    write_table(tmp_path / "r.csv", result)
    assert read_table(tmp_path / "r.csv").units == {"rev.phi": "rad", "a[1,2]": "m"}
    (tmp_path / "r.csv-metadata.json").unlink()  # which tells them without that
    assert read_table(tmp_path / "r.csv").units == {}


@pytest.mark.parametrize("suffix", [".csv", ".mat"])
def test_a_pattern_chooses_variables_and_parameters(
    result: Result, tmp_path: Path, suffix: str
) -> None:
    path = tmp_path / f"r{suffix}"
    write_table(path, result, re.compile("phi$|L"))
    table = read_table(path)
    assert list(table.columns) == ["rev.phi", "rev.b.phi", "L", "minusL"]
    assert np.array_equal(table["minusL"], np.full(ROWS, -2.5))
    with pytest.raises(UsageError, match="no variable matches `nothing`"):
        write_table(path, result, re.compile("nothing"))


def test_columns_of_a_mat_are_made_when_they_are_asked_for(result: Result, tmp_path: Path) -> None:
    write_table(tmp_path / "r.mat", result)
    columns = read_table(tmp_path / "r.mat").columns
    assert columns["L"] is not columns["L"]
    columns["rev.phi"][0] = 99  # a copy: the file and later readers do not see it
    assert columns["rev.phi"][0] == result["rev.phi"][0]
    with pytest.raises(KeyError):
        columns["nothing"]


def test_a_csv_of_others_may_have_quotes_blanks_and_empty_lines(tmp_path: Path) -> None:
    text = '\ufefftime, x ,"y"\n0, 1,"2"\n\n1,nan,-inf\n'
    (tmp_path / "o.csv").write_text(text, "utf-8")
    table = read_table(tmp_path / "o.csv")
    assert table["time"].tolist() == [0, 1]
    assert table["y"].tolist() == [2, -np.inf]
    assert table["x"][0] == 1 and np.isnan(table["x"][1])


def test_units_come_back_from_mat(result: Result, tmp_path: Path) -> None:
    write_table(tmp_path / "r.mat", result)
    units = read_table(tmp_path / "r.mat").units
    assert units["rev.phi"] == "rad"
    assert units["a[1,2]"] == "m"
    assert "on" not in units


def test_reads_the_other_orientation(tmp_path: Path) -> None:
    def matrix(name: str, kind: int, values: np.ndarray) -> bytes:
        title = name.encode() + b"\0"
        head = struct.pack("<5i", kind, *values.shape, 0, len(title))
        return head + title + values.tobytes(order="F")

    def texts(*lines: str) -> np.ndarray:
        width = max(map(len, lines))
        return np.array([list(line.ljust(width).encode()) for line in lines], dtype=np.uint8)

    info = np.array([[0, 1, 0, -1], [2, -2, 0, -1]], dtype="<i4")
    data = np.array([[0.0, 5.0], [1.0, 6.0]], dtype="<f4")
    (tmp_path / "n.mat").write_bytes(
        matrix("Aclass", 51, texts("Atrajectory", "1.1", " ", "binNormal"))
        + matrix("name", 51, texts("time", "x"))
        + matrix("dataInfo", 20, info)
        + matrix("data_2", 10, data)
    )
    table = read_table(tmp_path / "n.mat")
    assert table["x"].tolist() == [-5.0, -6.0]


def test_a_result_without_rows_is_written(result: Result, tmp_path: Path) -> None:
    empty = Result(
        result.program, result.time[:0], result.data[:0], result.stored, result.constants,
        result.statistics,
    )  # fmt: skip
    for suffix in (".csv", ".mat"):
        write_table(tmp_path / f"e{suffix}", empty)
        assert len(read_table(tmp_path / f"e{suffix}")["time"]) == 0


@pytest.mark.parametrize("title", ["time", "Time", "TIME [s]"])
def test_the_first_column_may_be_spelt_as_other_tools_do(tmp_path: Path, title: str) -> None:
    (tmp_path / "other.csv").write_text(f'"{title}","x"\n0,1\n2,3\n', encoding="utf-8")
    table = read_table(tmp_path / "other.csv")
    assert table["time"].tolist() == [0, 2]
    assert table["x"].tolist() == [1, 3]


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "first column is not `time`"),
        (b"time,x\r\n0,1\r\n1\r\n", "line 3 has 1 fields, not 2"),
        (b"time,x\r\n0,one\r\n", "line 2 holds a field that is no number"),
        (b"\xff\xfe\x00", "not UTF-8"),
    ],
)
def test_a_bad_csv_says_where(tmp_path: Path, data: bytes, reason: str) -> None:
    (tmp_path / "bad.csv").write_bytes(data)
    with pytest.raises(UsageError, match=reason):
        read_table(tmp_path / "bad.csv")


def test_a_cut_mat_is_noticed(result: Result, tmp_path: Path) -> None:
    write_table(tmp_path / "r.mat", result)
    data = (tmp_path / "r.mat").read_bytes()
    for size in (10, 100, len(data) - 1):
        (tmp_path / "cut.mat").write_bytes(data[:size])
        with pytest.raises(UsageError, match="V504"):
            read_table(tmp_path / "cut.mat")


def test_a_csv_that_another_program_is_still_writing_is_told(
    result: Result, tmp_path: Path
) -> None:
    path = tmp_path / "a.csv"
    write_table(path, result)
    whole = path.read_bytes()
    path.write_bytes(whole[:-3])
    with pytest.raises(UsageError) as caught:
        read_table(path)
    assert "ends early" in str(caught.value.diagnostics[0].hint)
    path.write_bytes(whole + b"1\n")
    with pytest.raises(UsageError) as caught:
        read_table(path)
    assert caught.value.diagnostics[0].hint is None


def test_refusals_name_the_reason(result: Result, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="there is no folder `nowhere`"):
        write_table(tmp_path / "nowhere" / "r.csv", result)
    with pytest.raises(UsageError, match="no ending"):
        write_table(tmp_path / "r.txt", result)
    with pytest.raises(UsageError, match="cannot read"):
        read_table(tmp_path / "missing.csv")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is full")
def test_a_full_disk_is_told(result: Result, tmp_path: Path) -> None:
    link = tmp_path / "r.csv"
    link.symlink_to("/dev/full")
    with pytest.raises(UsageError, match="no space left"):
        write_table(link, result)


def test_a_failure_leaves_the_old_file(
    result: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "r.csv"
    write_table(path, result)
    before = path.read_bytes()

    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("planarc.view.table.csv._text", fail)
    with pytest.raises(UsageError, match="no space left"):
        write_table(path, result)
    assert path.read_bytes() == before
    assert {p.name for p in tmp_path.iterdir()} == {"r.csv", "r.csv-metadata.json"}


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX permissions")
def test_files_have_ordinary_permissions(result: Result, tmp_path: Path) -> None:
    mask = os.umask(0o022)
    try:
        write_table(tmp_path / "r.mat", result)
    finally:
        os.umask(mask)
    assert (tmp_path / "r.mat").stat().st_mode & 0o777 == 0o644


@pytest.mark.parametrize(
    ("content", "line"),
    [
        (b'"time","x"\r0,1\r1,2\r', 1),
        (b'"time","x"\n0,1\r1,2\n', 2),
        (b'"time","x"\n0,1\n1,"' + b"1" * 200_000 + b'"\n', 3),
    ],
)
def test_rows_that_no_line_feed_ends_are_refused(content: bytes, line: int, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(content)
    with pytest.raises(UsageError, match=f"V504.*line {line}: "):
        read_table(path)
