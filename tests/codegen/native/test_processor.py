"""What kind of processor code belongs to."""

from __future__ import annotations

from pathlib import Path

import pytest

from planarc.codegen.native.processor import FUSING, _asked, _features, fuses, key
from planarc.runtime.link import PLACES

pytest.importorskip("llvmlite")
if not PLACES:
    pytest.skip("LLVM tells it here", allow_module_level=True)

#: Of the answers to CPUID, the bit of an instruction set: (which answer, bit).
BITS = {"sse2": (2, 26), "fma": FUSING, "avx": (1, 28), "avx2": (4, 5), "avx512f": (4, 16)}


def test_the_processor_has_what_the_system_says() -> None:
    answers = list(_asked())
    flags = Path("/proc/cpuinfo").read_text(encoding="utf-8").partition("flags")[2].split("\n")[0]
    for name, (answer, bit) in BITS.items():
        if name in flags.split():
            assert answers[answer] >> bit & 1


def test_an_emulator_that_knows_less_has_another_key(monkeypatch: pytest.MonkeyPatch) -> None:
    from planarc.codegen.native import processor

    here = key()
    answers = list(_asked())
    answers[4] &= ~(1 << 16 | 1 << 5)
    monkeypatch.setattr(processor, "_asked", lambda: answers)
    key.cache_clear()
    assert key() != here
    key.cache_clear()


def test_llvm_says_the_same_of_rounding_once(monkeypatch: pytest.MonkeyPatch) -> None:
    from planarc.codegen.native import processor

    assert fuses() == ("+fma" in _features().split(","))
    answers = list(_asked())
    answers[FUSING[0]] &= ~(1 << FUSING[1])
    monkeypatch.setattr(processor, "_asked", lambda: answers)
    assert not fuses.__wrapped__()
