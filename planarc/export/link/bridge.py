"""Ways from code that calls as Linux does to functions that are called as Windows does.

In:   text of LLVM; later the objects made of it, the last one with the ways that they need
Out:  the text, whose functions call each other as on Linux; objects that call by these ways

On x86-64 Windows passes arguments in other registers than Linux and macOS. Code inside a library is
the same everywhere, and called as on Linux; the functions of the interface and the host's are not.
What Windows' own library has is reached by

    way_sin:  (called as on Linux)  call sin  (as on Windows);  return

Names of files are UTF-8 inside; Windows itself has them in UTF-16 (`_wfopen`), and reads others in
an alphabet that may lack their letters.

Reference: System V ABI, AMD64 supplement, section 3.2; Microsoft, x64 calling convention;
           F. Yergeau, RFC 3629 (UTF-8); P. Hoffman, F. Yergeau, RFC 2781 (UTF-16).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager

from msgspec.structs import replace

from planarc.codegen.native.assembly import INT, POINTER, Code, Value
from planarc.codegen.native.formulas import declarations
from planarc.runtime.link.objects import Object

_INSIDE = "x86_64_sysvcc"
_WAY = "way_"
#: The functions of a system's library that code inside calls: what they give and take.
_CALLED = {name: ("double", g) for name, g in re.findall(r"@(\w+)\((.*?)\)", declarations())} | {
    "calloc": ("ptr", "i64, i64"),
    "free": ("void", "ptr"),
    "sincos": ("void", "double, ptr, ptr"),
    "fopen": ("ptr", "ptr, ptr"),
    "fread": ("i64", "ptr, i64, i64, ptr"),
    "fclose": ("i32", "ptr"),
}
#: Functions inside, those of the library, and addresses of functions inside: the host's functions,
#: which are called by their addresses, too, give nothing.
_NAMES = rf"\w+ @(?:p[cx]_\w+|{'|'.join(_CALLED)})\(|i32 %\w+\("
_TO_MARK = re.compile(rf"\b(define|declare|call) ({_NAMES})")


def called_inside(text: str) -> str:
    """The text, whose functions are called as on Linux."""
    return _TO_MARK.sub(rf"\1 {_INSIDE} \2", text)


def ways(objects: Iterable[Object]) -> str:
    """The ways that objects need, as text."""
    needed = {s.name for found in objects for s in found.symbols if s.section is None}
    declared = (f"declare {result} @{name}({given})\n" for name, (result, given) in _CALLED.items())
    lines = (line for name in sorted(needed & _CALLED.keys()) for line in _way(name))
    return "".join((*declared, *lines))


def _way(name: str) -> Iterator[str]:
    if name == "fopen":
        yield _OPENING + _open().replace("define ", f"define {_INSIDE} ")
        return
    result, types = _CALLED[name]
    given = [f"{t} %a{i}" for i, t in enumerate(types.split(", "))]
    yield f"define {_INSIDE} {result} @{_WAY}{name}({', '.join(given)}) nounwind noredzone {{\n"
    if name == "sincos":  # which Windows does not have
        for i, part in enumerate(("sin", "cos"), 1):
            yield f"  %r{i} = call double @{part}(double %a0)\n  store double %r{i}, ptr %a{i}\n"
    else:
        to = "" if result == "void" else "%r = "
        yield f"  {to}call {result} @{name}({', '.join(given)})\n"
    yield f"  ret {result}{'' if result == 'void' else ' %r'}\n}}\n"


_OPENING = """
declare ptr @_wfopen(ptr, ptr)
@way_mode = constant [3 x i16] [i16 114, i16 98, i16 0]
"""


def _open() -> str:
    """A file opened to be read."""
    c = Code(f"{_WAY}fopen", POINTER, ((POINTER, "name"), (POINTER, "mode")))
    name, _ = c.arguments
    at, to, point = (c.variable(0, INT) for _ in range(3))

    def byte() -> Value:
        place = c.emit(POINTER, f"getelementptr i8, ptr {name.text}, i64 {at.get().text}")
        return c.emit(INT, f"zext i8 {c.emit('i8', f'load i8, ptr {place.text}').text} to i64")

    def masked(value: Value, bits: int) -> Value:
        return c.emit(INT, f"and i64 {value.text}, {bits}")

    def write(value: Value) -> None:
        place = c.emit(POINTER, f"getelementptr i16, ptr {wide.text}, i64 {to.get().text}")
        low = c.emit("i16", f"trunc i64 {value.text} to i16")
        c.line(f"store i16 {low.text}, ptr {place.text}")
        to.set(to.get() + 1)

    with _while(c, lambda: ~byte().equals(0)):
        at.set(at.get() + 1)
    wide = c.call(POINTER, "calloc", at.get() + 1, c.constant(2, INT))
    with c.when(c.emit("i1", f"icmp eq ptr {wide.text}, null"), leaves=True):
        c.give(wide)
    at.set(c.constant(0, INT))
    with _while(c, lambda: ~byte().equals(0)):
        first = byte()
        point.set(first)
        for least, bits in ((0xC0, 0x1F), (0xE0, 0x0F), (0xF0, 0x07)):
            with c.when(first >= least):
                point.set(masked(first, bits))
        at.set(at.get() + 1)
        with _while(c, lambda: masked(byte(), 0xC0).equals(0x80)):
            point.set(point.get() * 64 + masked(byte(), 0x3F))
            at.set(at.get() + 1)
        with c.when(point.get() >= 0x10000):
            write((point.get() - 0x10000) / 1024 + 0xD800)
            point.set(masked(point.get(), 0x3FF) + 0xDC00)
        write(point.get())
    file = c.call(POINTER, "_wfopen", wide, Value(c, POINTER, "@way_mode"))
    c.run("free", wide)
    c.give(file)
    return c.text()


@contextmanager
def _while(c: Code, holds: Callable[[], Value]) -> Iterator[None]:
    again, inside, behind = c.label(), c.label(), c.label()
    c.enter(again)
    c.branch(holds(), inside, behind)
    c.begin(inside)
    yield
    c.jump(again)
    c.begin(behind)


def by_ways(objects: Sequence[Object]) -> list[Object]:
    """The objects, where calls go by the ways that the last one has."""
    *inside, last = objects
    there = {s.name for s in last.symbols if s.section is not None}

    def led(found: Object) -> Object:
        symbols = (
            replace(s, name=_WAY + s.name) if s.section is None and _WAY + s.name in there else s
            for s in found.symbols
        )
        return replace(found, symbols=tuple(symbols))

    return [*map(led, inside), last]
