"""Options of LLVM: set where they are known, and set back."""

from __future__ import annotations

import llvmlite.binding as llvm
import pytest

from planarc.codegen.native import options


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
