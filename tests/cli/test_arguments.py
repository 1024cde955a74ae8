"""What the arguments mean: a file or a class, a parameter or a start value."""

from __future__ import annotations

from pathlib import Path

import pytest

from planarc.cli.arguments import make_request, names_file
from planarc.cli.settings import Setting, read_settings, sort_settings
from planarc.core.diagnostic import UsageError


@pytest.mark.parametrize("text", ["a.pmo", "A.mo", "dir/a", "./a", "four-bar", "a b.pmo"])
def test_these_are_files(text: str) -> None:
    assert names_file(text)


@pytest.mark.parametrize("text", ["Pendulum", "PlanarMultiBody.Parts.Body", ".A.B", "A.'b c'"])
def test_these_are_classes(text: str) -> None:
    assert not names_file(text)


def test_a_file_without_ending_is_a_file_when_it_is_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert not names_file("Pendulum")
    Path("Pendulum").write_text("", "utf-8")
    assert names_file("Pendulum")


def test_a_class_needs_no_second_class() -> None:
    with pytest.raises(UsageError):
        make_request("A.B", "C")


def test_the_last_setting_of_a_name_wins() -> None:
    assert read_settings(["a=1", "b = 2e-3", "a=true"]) == (
        Setting("a", 1.0),
        Setting("b", 0.002),
    )


def test_a_value_is_a_number_a_literal_or_an_array_of_them() -> None:
    found = read_settings(["a=Mode.fast", "r={0.5, -1}", "T={{1,2},{3,4}}", "b={true}"])
    assert [s.value for s in found] == ["Mode.fast", [0.5, -1.0], [[1.0, 2.0], [3.0, 4.0]], [1.0]]


@pytest.mark.parametrize("item", ["a", "=1", "a=", "a=1;b=2", "a=1+1", "a={1,2+1}"])
def test_a_setting_is_a_name_and_a_value(item: str) -> None:
    with pytest.raises(UsageError):
        read_settings([item])


def test_start_values_are_told_from_parameters_called_start() -> None:
    settings = read_settings(["x.start=1", "ramp.start=2", "k=3"])
    assert sort_settings(settings, {"ramp.start", "k"}) == (
        {"ramp.start": 2.0, "k": 3.0},
        {"x": 1.0},
    )
