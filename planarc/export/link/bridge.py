"""Ways from code that calls as Linux does to functions that are called as Windows does.

In:   text of LLVM; later the objects made of it, the last one with the ways that they need
Out:  the text, whose functions call each other as on Linux; objects that call by these ways

On x86-64 Windows passes arguments in other registers than Linux and macOS. Code inside a library is
the same everywhere, and called as on Linux; the functions of the interface and the host's are not.
What Windows' own library has is reached by

    way_sin:  (called as on Linux)  call sin  (as on Windows);  return

Reference: System V ABI, AMD64 supplement, section 3.2; Microsoft, x64 calling convention.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

from msgspec.structs import replace

from planarc.codegen.native.formulas import declarations
from planarc.runtime.link.objects import Object

_INSIDE = "x86_64_sysvcc"
_WAY = "way_"
#: The functions of a system's library that code inside calls: what they give and take.
_CALLED = {name: ("double", g) for name, g in re.findall(r"@(\w+)\((.*?)\)", declarations())} | {
    "calloc": ("ptr", "i64, i64"),
    "free": ("void", "ptr"),
    "sincos": ("void", "double, ptr, ptr"),
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
