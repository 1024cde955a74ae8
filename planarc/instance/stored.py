"""Numbers of a large model, which stand in a file once instead of in the library of each platform.

    resources/numbers.bin    a seal, the first content of an instance, and its tables, packed

    px_bring(block, resources) -> flag   reads them into the block; 1 where that is not their file
    px_file(resources) -> text           the file's path, in memory of its own

FMI 3.0 tells the folder by its path, FMI 2.0 by a URI (`file:///C:/a%20b`). Words stand as in the
memory of all platforms: the lowest byte first.

Reference: FMI 3.0.2, section 2.3.1, `resourcePath`; FMI 2.0.5, section 2.1.5,
           `fmuResourceLocation`; RFC 8089, "The 'file' URI Scheme".
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import reduce

from planarc.codegen.native.assembly import FLAG, INT, POINTER, Code, Value, Variable, function
from planarc.instance.block import (
    BYTE,
    constant,
    is_null,
    load_narrow,
    plan,
    store_narrow,
    whole,
)
from planarc.instance.plan import Own, Table
from planarc.instance.text import text_constant

FILE = "numbers.bin"
_UNREAD = (
    f"resources/{FILE} of this FMU cannot be read: unpack the whole archive, and tell its folder "
    "`resources` when an instance is made"
)
_NEEDED = """
declare ptr @fopen(ptr, ptr)
declare i64 @fread(ptr, i64, i64, ptr)
declare i32 @fclose(ptr)
"""


def stored_functions(by_uri: bool, plain: Callable[[str], str]) -> tuple[str, ...]:
    """`plain` makes a text one that a logger shows as it is."""
    texts = (text_constant("px_reading", "rb"), text_constant("px_unread", plain(_UNREAD)))
    return (_NEEDED, *texts, _bring(), _file(by_uri))


def stored_bytes(words: Sequence[int]) -> bytes:
    """The words as they stand in the file."""
    return struct.pack(f"<{len(words)}q", *words)


@function("i32 px_bring(ptr m, ptr resources)", seldom=True)
def _bring(c: Code, m: Value, resources: Value) -> None:
    with c.when(is_null(c, resources), leaves=True):
        c.give(1)
    path = c.call(POINTER, "px_file", resources)
    with c.when(is_null(c, path), leaves=True):
        c.give(1)
    file = c.call(POINTER, "fopen", path, constant(c, "px_reading"))
    c.run("free", path)
    with c.when(is_null(c, file), leaves=True):
        c.give(1)
    first, count = m.load(POINTER, Own.STORED), plan(c, Table.STORED)
    read = c.call(INT, "fread", first, whole(c, 8), count, file)
    c.call(FLAG, "fclose", file)
    sealed = first.load(INT).equals(constant(c, "px_seal").load(INT))
    with c.when(read.equals(count) & sealed, leaves=True):
        c.give(0)
    c.give(1)


@function("ptr px_file(ptr resources)", seldom=True)
def _file(c: Code, resources: Value, by_uri: bool) -> None:
    """The folder, a slash where it ends with none, and the file's name."""
    length, at, to = (c.variable(0, INT) for _ in range(3))

    def letter(place: Value) -> Value:
        return load_narrow(c, BYTE, resources, place)

    def write(code: Value | int) -> None:
        value = whole(c, code) if isinstance(code, int) else code
        store_narrow(c, BYTE, path, value, to.get())
        to.set(to.get() + 1)

    with _until_end(c, letter, length):
        pass
    path = c.call(POINTER, "calloc", length.get() / 8 + 4, whole(c, 8))
    with c.when(is_null(c, path), leaves=True):
        c.give(path)
    if by_uri:
        _skip_scheme(c, letter, at, length.get())
    with _until_end(c, letter, at) as found:
        code = c.variable(found, INT)
        if by_uri:
            with c.when(found.equals(ord("%")) & (at.get() + 2 < length.get())):
                high, low = (_digit(c, letter(at.get() + i)) for i in (1, 2))
                code.set(high * 16 + low)
                at.set(at.get() + 2)
        write(code.get())
    last = load_narrow(c, BYTE, path, to.get() - 1)
    with c.when((to.get() > 0) & ~last.equals(ord("/"))):
        write(ord("/"))
    for name_letter in FILE.encode():
        write(name_letter)
    c.give(path)


@contextmanager
def _until_end(c: Code, letter: Callable[[Value], Value], at: Variable) -> Iterator[Value]:
    """What stands inside for each letter from there to the end of the text."""
    again, inside, behind = c.label(), c.label(), c.label()
    c.enter(again)
    found = letter(at.get())
    c.branch(found.equals(0), behind, inside)
    c.begin(inside)
    yield found
    at.set(at.get() + 1)
    c.jump(again)
    c.begin(behind)


def _skip_scheme(c: Code, letter: Callable[[Value], Value], at: Variable, length: Value) -> None:
    """`file:`, two slashes without a host, and the slash before a drive."""

    def skip(count: int, *letters: tuple[int, str]) -> None:
        there = at.get() + count < length
        with c.when(there):
            same = [letter(at.get() + i).equals(ord(x)) for i, x in letters]
            with c.when(reduce(Value.__and__, same)):
                at.set(at.get() + count)

    skip(5, (0, "f"), (4, ":"))
    skip(2, (0, "/"), (1, "/"))
    skip(1, (0, "/"), (2, ":"))


def _digit(c: Code, code: Value) -> Value:
    """The value of a hexadecimal digit; of letters, small or large, the low bits are 1 to 6."""
    low = code - code / 16 * 16
    return c.select(code > ord("9"), low + 9, low)
