"""Code inside a library for Windows, which calls as on Linux, and what it calls there."""

from __future__ import annotations

import ctypes
import platform

import pytest

from planarc.export.emission import emitted
from planarc.export.link.bridge import by_ways, called_inside, ways
from planarc.runtime.link import PLACES
from planarc.runtime.link.join import join
from planarc.runtime.link.memory import put
from planarc.runtime.link.objects import put_together, read_object

LINUX, WINDOWS = "x86_64-unknown-linux-gnu", "x86_64-pc-windows-msvc-elf"
INSIDE = """
declare double @atan2(double, double)
declare void @sincos(double, ptr, ptr)
define double @pc_f(double %x, double %y) {
  %s = alloca double
  %c = alloca double
  %a = call double @atan2(double %x, double %y)
  call void @sincos(double %a, ptr %s, ptr %c)
  %b = load double, ptr %s
  %d = load double, ptr %c
  %e = fadd double %b, %d
  %g = fsub double %e, %x
  ret double %g
}
"""
#: Functions of a library of Windows, with results that tell their arguments apart.
OUTSIDE = """
define double @atan2(double %a, double %b) {
  %c = fmul double %b, 100.0
  %d = fadd double %a, %c
  ret double %d
}
define double @sin(double %a) {
  %b = fmul double %a, 1000.0
  ret double %b
}
define double @cos(double %a) {
  ret double %a
}
"""


@pytest.mark.skipif(not PLACES or platform.machine() != "x86_64", reason="another processor")
def test_what_is_called_gets_its_arguments_and_gives_its_result() -> None:
    inside = read_object(emitted(INSIDE, LINUX))
    way = ways([inside])
    objects = by_ways([inside, read_object(emitted(way, WINDOWS))])
    outside = read_object(emitted(OUTSIDE, WINDOWS))
    joined = join(put_together([*objects, outside]), lambda length: length)
    assert joined.imports == ()
    memory, start = put(joined.code)
    f = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double, ctypes.c_double)(
        start + joined.functions["pc_f"]
    )
    assert f(3.0, 2.0) == 1001 * 203.0 - 3.0
    del memory  # not before


def test_functions_inside_are_marked_and_no_others() -> None:
    text = (
        "declare double @pow(double, double)\n"
        "declare double @llvm.fabs.f64(double)\n"
        "define i32 @fmi3DoStep(ptr %m) {\n"
        "  call void %v1(i32 3)\n"
        "  %v2 = call i32 %v3(ptr %m)\n"
        "  %v4 = call i32 @px_step(ptr %m)\n"
    )
    marked = called_inside(text).splitlines()
    assert [i for i, line in enumerate(marked) if "x86_64_sysvcc" in line] == [0, 4, 5]
    assert marked[5] == "  %v4 = call x86_64_sysvcc i32 @px_step(ptr %m)"


OPENING = """
declare ptr @fopen(ptr, ptr)
define ptr @pc_opened(ptr %name) {
  %a = call ptr @fopen(ptr %name, ptr null)
  ret ptr %a
}
"""
#: Windows' functions; there is memory at one place.
SYSTEM = """
define ptr @calloc(i64 %count, i64 %size) {{
  ret ptr inttoptr (i64 {room} to ptr)
}}
define void @free(ptr %a) {{
  ret void
}}
define ptr @_wfopen(ptr %name, ptr %mode) {{
  %a = load i16, ptr %mode
  %b = zext i16 %a to i64
  %c = getelementptr i8, ptr %name, i64 %b
  ret ptr %c
}}
"""


@pytest.mark.skipif(not PLACES or platform.machine() != "x86_64", reason="another processor")
@pytest.mark.parametrize("name", ("C:/a b", "\xe4", "\u20ac/\U0001f600.bin", "x" * 3000))
def test_names_of_files_are_told_windows_in_its_letters(name: str) -> None:
    inside = read_object(emitted(OPENING, LINUX))
    objects = by_ways([inside, read_object(emitted(ways([inside]), WINDOWS))])
    room = (ctypes.c_uint16 * 4096)()
    address = ctypes.addressof(room)
    outside = read_object(emitted(SYSTEM.format(room=address), WINDOWS))
    joined = join(put_together([*objects, outside]), lambda length: length)
    memory, start = put(joined.code)
    opened = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_char_p)(
        start + joined.functions["pc_opened"]
    )
    assert opened(name.encode()) == address + ord("r")
    assert bytes(room).decode("utf-16-le").rstrip("\0") == name
    del memory  # not before
