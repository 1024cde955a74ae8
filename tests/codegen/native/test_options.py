"""Options of LLVM: set where they are known, and set back."""

from __future__ import annotations

from collections.abc import Sequence

import llvmlite.binding as llvm
import pytest

from planarc.codegen.native import machine, options


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    found: list[str] = []
    monkeypatch.setattr(llvm, "set_option", lambda name, option: found.append(option))
    return found


def test_options_are_set_only_where_llvm_is_known_to_have_them(
    monkeypatch: pytest.MonkeyPatch, told: list[str]
) -> None:
    """An LLVM without one of them would end the process."""
    for major in (*options._TRIED, options._TRIED.stop):
        told.clear()
        monkeypatch.setattr(llvm, "llvm_version_info", (major, 0, 0))
        with options.options(("disable-lsr", 1, 0)):
            pass
        assert bool(told) is (major in options._TRIED)


def test_they_are_set_back_also_where_code_cannot_be_made(
    monkeypatch: pytest.MonkeyPatch, told: list[str]
) -> None:
    monkeypatch.setattr(llvm, "llvm_version_info", (options._TRIED.start, 0, 0))
    with pytest.raises(RuntimeError), options.options(("a", 1, 0), ("b", "one", "other")):
        assert told == ["-a=1", "-b=one"]
        raise RuntimeError
    assert told[2:] == ["-a=0", "-b=other"]
    with options.options(options.IN_MEMORY):  # the next one is not held up
        pass


@pytest.mark.parametrize("known", (True, False))
def test_small_programs_run_from_registers(known: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """An LLVM that is not asked for them keeps to them at its next level only."""
    made: list[tuple[int, bool]] = []

    def compiled(text: str, level: int, *, quick: Sequence[options.Option] = ()) -> bytes:
        made.append((level, options.IN_REGISTERS in quick))
        return b""

    monkeypatch.setattr(machine, "_compiled", compiled)
    monkeypatch.setattr(machine, "_kept", lambda what, make: make())
    major = options._TRIED.stop - known
    monkeypatch.setattr(llvm, "llvm_version_info", (major, 0, 0))
    for lines in (10, machine.LARGEST_IN_REGISTERS + 1):
        machine._own("\n" * lines)
    assert made == [(0 if known else 1, True), (0, False)]
