"""Both ways into the process: the same functions, whoever puts the code there."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier
from time import sleep
from typing import Any

import pytest

import planarc
from planarc.runtime.link import PLACES
from planarc.solve.kernels.native import engine, kernel, linkers
from planarc.solve.kernels.native.linkers import LlvmLinker, OwnLinker

pytest.importorskip("llvmlite")
if not PLACES:
    pytest.skip("code is placed by LLVM here", allow_module_level=True)

from planarc.codegen.native.machine import emit_object
from planarc.codegen.native.processor import target_machine

FOUR_BAR = Path(__file__).parents[4] / "examples" / "four_bar.pmo"


def test_llvm_places_what_planarc_places(monkeypatch: pytest.MonkeyPatch) -> None:
    model = planarc.load(FOUR_BAR)
    own = model.simulate(1.0)
    kernel._engine.cache_clear()
    monkeypatch.setattr(engine, "PLACES", False)
    by_llvm = model.simulate(1.0)
    kernel._engine.cache_clear()
    assert all((own[name] == by_llvm[name]).all() for name in own)


def function(value: str) -> bytes:
    """`pc_f`, which gives a value."""
    text = (
        f"declare double @cos(double)\ndefine double @pc_g(double %x) {{\nret double {value} }}\n"
    )
    text += "define double @pc_f(double %x) {\n%a = call double @cos(double %x)\n"
    text += "%b = call double @pc_g(double %a)\nret double %b }\n"
    return emit_object(text, target_machine(0), ("pc_",))


@pytest.mark.parametrize("linker", [OwnLinker, LlvmLinker])
def test_calls_within_and_out_of_what_was_added(linker: type) -> None:
    import ctypes

    linked = linker({})
    linked.add(function("%x"))
    f = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(linked.address("pc_f"))
    assert f(0.0) == 1.0


def test_of_equal_names_what_was_added_last() -> None:
    import ctypes

    linked, one, two = OwnLinker({}), function("1.0"), function("2.0")
    for code, value in ((one, 1.0), (two, 2.0), (one, 1.0)):
        linked.add(code)
        f = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(linked.address("pc_f"))
        assert f(0.0) == value


def test_memory_is_written_or_run_never_both() -> None:
    linked = OwnLinker({})
    linked.add(function("%x"))
    at = linked.address("pc_f")
    for line in Path("/proc/self/maps").read_text(encoding="utf-8").splitlines():
        first, last = (int(a, 16) for a in line.split()[0].split("-"))
        if first <= at < last:
            assert line.split()[1] == "r-xp"
            break
    else:
        pytest.fail("the code is nowhere")


def test_threads_that_add_the_same_share_its_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """What was placed twice would be freed for the one that was first."""
    both, placed = Barrier(2), list[tuple[bytes, ...]]()

    def place(objects: tuple[bytes, ...], known: dict[str, int]) -> Any:
        placed.append(objects)
        sleep(0.05)
        return object(), {"f": len(placed)}

    monkeypatch.setattr(linkers, "place", place)
    linker = OwnLinker({})

    def add(_: int) -> int:
        both.wait()
        linker.add(b"code")
        return linker.address("f")

    with ThreadPoolExecutor(2) as pool:
        assert list(pool.map(add, range(2))) == [1, 1]
    assert placed == [(b"code",)]


def test_llvm_places_what_iterates_events(monkeypatch: pytest.MonkeyPatch) -> None:
    model = planarc.load(FOUR_BAR.with_stem("geneva_drive"))
    own = model.simulate(2.0)
    kernel._engine.cache_clear()
    monkeypatch.setattr(engine, "PLACES", False)
    by_llvm = planarc.load(FOUR_BAR.with_stem("geneva_drive")).simulate(2.0)
    kernel._engine.cache_clear()
    assert len(own.events) > 2
    assert by_llvm.rows.events == own.rows.events
