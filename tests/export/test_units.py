"""Functions that models share: each known by itself, whatever else was made with it."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planarc.codegen.native.runtime import runtime_text
from planarc.compiler import compile_model
from planarc.core import processes
from planarc.export import objects
from planarc.export.emission import SYSTEMS, WASM, finished, on_system, shared_object, shared_text
from planarc.export.fmu import make_fmu
from planarc.export.pruned import FUNCTION, calls_in
from planarc.export.units import Text, Unit, constants_once, reached
from planarc.export.wishes import Wishes
from planarc.request.request import Request
from planarc.runtime.link.objects import Object, put_together, read_object
from tests.export.fmus import EXAMPLES

LINUX, ARM = "x86_64-unknown-linux-gnu", "aarch64-unknown-linux-gnu"
#: `px_a` gives what lies in a range, which spares `px_b` a branch; both load constants.
BOTH = """
@px_text_{0} = constant [4 x i8] c"one\\00"
@px_text_{1} = constant [4 x i8] c"two\\00"
declare void @px_log(ptr)
define double @px_a(double %x) nounwind {{
  call void @px_log(ptr @px_text_{1})
  %y = fmul double %x, 0.1
  ret double %y
}}
define double @px_b(double %x) nounwind {{
  call void @px_log(ptr @px_text_{0})
  %y = call double @px_a(double %x)
  %z = fadd double %y, 0.1
  ret double %z
}}
"""


@cache
def runtime(triple: str) -> tuple[Text, tuple[Unit, ...]]:
    text = runtime_text()
    found = Text(on_system(shared_text(text, calls_in(text)), triple))
    return found, tuple(found.units({}, lambda made, small: finished(made, triple, small)))


def test_no_function_and_no_constant_is_left_out() -> None:
    text = runtime_text()
    for triple in SYSTEMS:
        if triple != WASM:
            whole = read_object(shared_object(text, triple, calls_in(text)))
            _, units = runtime(triple)
            together = constants_once(put_together([u.code for u in units]))
            assert defined(together) == defined(whole)
            ours, usual = size(together, ".text"), size(whole, ".text")
            assert usual <= ours < 1.5 * usual, "the quickest way is larger, until it is packed"
            assert size(together, ".rodata") <= size(whole, ".rodata")


def defined(found: Object) -> set[str]:
    return {s.name for s in found.symbols if s.section is not None and s.public}


def size(found: Object, kind: str) -> int:
    return sum(len(s.data) for s in found.sections if s.name.startswith(kind))


def test_what_nobody_needs_is_no_part_of_a_library() -> None:
    text = runtime_text()
    calls = {f[1]: calls_in(f[0]) for f in FUNCTION.finditer(text)}
    for triple in (LINUX, ARM):
        together = put_together([u.code for u in runtime(triple)[1]])
        for public in (["pc_linear"], ["pc_start", "pc_step"], []):
            wanted, todo = set(), [*public]
            while todo:
                if (name := todo.pop()) not in wanted and name in calls:
                    wanted.add(name)
                    todo += calls[name]
            left = reached(together, public)
            full = {
                s.name
                for s in left.symbols
                if s.public and s.section is not None and left.sections[s.section].data
            }
            assert {*public} <= full <= wanted, "LLVM has put some into others"
            assert reached(left, public) == left
        everything = {s.name for s in together.symbols if s.public}
        assert size(reached(together, everything), ".text") == size(together, ".text")


@settings(max_examples=8, deadline=None)
@given(st.data())
@pytest.mark.parametrize("triple", [LINUX, ARM])
def test_code_is_the_same_whatever_was_known(triple: str, data: st.DataObject) -> None:
    text, units = runtime(triple)
    known = {u.key: u.code for u in units if data.draw(st.booleans())}
    assert tuple(text.units(known, lambda made, small: finished(made, triple, small))) == units


def test_what_is_known_is_not_made() -> None:
    text, units = runtime(LINUX)
    made: list[str] = []

    def counted(part: str, small: bool) -> bytes:
        made.append(part)
        return finished(part, LINUX, small)

    *known, last = units
    assert tuple(text.units({u.key: u.code for u in known}, counted)) == units
    assert [part.count("\ndefine ") for part in made] == [1]
    assert tuple(text.units({u.key: u.code for u in units}, counted)) == units
    assert len(made) == 1
    assert last.key in text.keys.values()


def test_what_runs_often_is_made_apart_from_what_shall_be_small() -> None:
    text, _ = runtime(LINUX)
    made: dict[bool, set[str]] = {True: set(), False: set()}

    def noted(part: str, small: bool) -> bytes:
        made[small] |= set(re.findall(r"^define [^@]*@(\w+)\(", part, re.MULTILINE))
        return finished(part, LINUX, small)

    units = tuple(text.units({}, noted))
    assert "pc_linear" in made[False] and "pc_open" in made[True]
    assert not made[False] & made[True] and made[False] | made[True] == text.keys.keys() - {""}
    quick = tuple(text.units({}, lambda part, _: finished(part, LINUX, small=True)))
    assert len(quick) == len(units) and quick != units


def keys(text: str) -> dict[str, str]:
    return Text(shared_text(text, {"px_a", "px_b"})).keys


def test_a_function_is_known_whatever_number_its_texts_have() -> None:
    assert keys(BOTH.format(0, 1)) == keys(BOTH.format(7, 5))


def test_another_text_or_head_is_another_function() -> None:
    first = keys(BOTH.format(0, 1))
    other = keys(BOTH.format(0, 1).replace('c"two', 'c"too'))
    assert (first["px_a"], first["px_b"]) != (other["px_a"], other["px_b"])
    assert first["px_b"] == other["px_b"] and first[""] != other[""]
    wide = keys(BOTH.format(0, 1).replace("define double @px_a", "define noundef double @px_a"))
    assert wide["px_b"] != first["px_b"], "a caller hangs on what it is given"


def test_equal_constants_stand_once() -> None:
    text = BOTH.format(0, 1)
    found = Text(shared_text(text, calls_in(text)))
    units = found.units({}, lambda made, small: finished(made, LINUX, small))
    apart = put_together([u.code for u in units])
    together = constants_once(apart)
    assert [size(found, ".rodata.cst8") for found in (apart, together)] == [16, 8]
    assert defined(together) == defined(apart)


def test_a_model_of_another_kind_is_the_same_where_functions_are_known(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[int] = []

    def counted(text: str, triple: str, small: bool) -> bytes:
        made.append(text.count("\ndefine "))
        return finished(text, triple, small)

    monkeypatch.setattr(objects, "finished", counted)
    monkeypatch.setattr(processes, "cores", lambda: 1)  # another one counts for itself
    counts, archives = [], []
    for folder, names in (("a", ("double_pendulum",)), ("b", ("four_bar", "double_pendulum"))):
        monkeypatch.setenv("PLANARC_CACHE_DIR", str(tmp_path / folder))
        for name in names:
            made.clear()
            data = make_fmu(compile_model(Request(EXAMPLES / f"{name}.pmo")), Wishes()).data
        counts.append(sum(made))
        archives.append(data)
    assert archives[0] == archives[1]
    assert 0 < counts[1] < 0.2 * counts[0]
