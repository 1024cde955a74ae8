"""An object file of LLVM, read: ELF, 64 bits, little end first.

In:   bytes
Out:  Object   sections with their bytes and relocations, symbols

Read is what LLVM writes for code without addresses: sections of code and of constants.
Sections about lines and stacks are left out: compiled code throws nothing.

Reference: System V Application Binary Interface, chapter 4, "Object Files".
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence

from msgspec.structs import replace

from planarc.core.data import Data

_ALLOCATED, _WRITABLE = 2, 1  # flags of a section
_SYMBOLS, _RELOCATIONS, _EMPTY = 2, 4, 8  # kinds of sections


class Relocation(Data, array_like=True):
    """A place, the symbol whose address it wants, in which form (`kind`, of the processor)."""

    offset: int
    kind: int
    symbol: int
    addend: int


class Section(Data, array_like=True):
    name: str
    data: bytes
    align: int
    relocations: tuple[Relocation, ...]


class Symbol(Data, array_like=True):
    """`section` is an index in `Object.sections`, or None of what another library has."""

    name: str
    section: int | None
    value: int
    public: bool


class Object(Data, array_like=True):
    processor: int
    sections: tuple[Section, ...]
    symbols: tuple[Symbol, ...]


def read_object(data: bytes) -> Object:
    """The object file's contents."""
    assert data[:6] == b"\x7fELF\x02\x01", "no ELF object of 64 bits"
    processor = struct.unpack_from("<H", data, 18)[0]
    (table,) = struct.unpack_from("<Q", data, 40)
    size, count, names_at = struct.unpack_from("<HHH", data, 58)
    heads = [struct.unpack_from("<IIQQQQIIQQ", data, table + size * i) for i in range(count)]
    names = _body(data, heads[names_at])
    kept = [
        i
        for i, h in enumerate(heads)
        if h[2] & _ALLOCATED and h[5] and not _text(names, h[0]).startswith((".eh_frame", ".note"))
    ]
    place = {i: k for k, i in enumerate(kept)}
    relocations: dict[int, list[Relocation]] = {}
    symbols: list[Symbol] = []
    for head in heads:
        if head[1] == _SYMBOLS:
            symbols.extend(_symbols(data, head, heads, place))
        elif head[1] == _RELOCATIONS and head[7] in place:
            relocations.setdefault(head[7], []).extend(_relocations(_body(data, head)))
    sections = []
    for i in kept:
        name, head = _text(names, heads[i][0]), heads[i]
        assert not head[2] & _WRITABLE and head[1] != _EMPTY, f"{name} would be written to"
        found = tuple(relocations.get(i, ()))
        sections.append(Section(name, _body(data, head), head[8], found))
    return Object(processor, tuple(sections), tuple(symbols))


def _body(data: bytes, head: tuple[int, ...]) -> bytes:
    return data[head[4] : head[4] + head[5]]


def _text(names: bytes, at: int) -> str:
    return names[at : names.index(0, at)].decode()


def _symbols(
    data: bytes, head: tuple[int, ...], heads: list[tuple[int, ...]], place: dict[int, int]
) -> Iterator[Symbol]:
    names = _body(data, heads[head[6]])
    for name, info, _, home, value, _ in struct.iter_unpack("<IBBHQQ", _body(data, head)):
        yield Symbol(_text(names, name), place.get(home), value, info >> 4 == 1)


def _relocations(body: bytes) -> Iterator[Relocation]:
    for offset, info, addend in struct.iter_unpack("<QQq", body):
        yield Relocation(offset, info & 0xFFFFFFFF, info >> 32, addend)


def put_together(objects: Sequence[Object]) -> Object:
    """Several objects as one: what one lacks, another has."""
    sections: list[Section] = []
    symbols: list[Symbol] = []
    for found in objects:
        first, number = len(sections), len(symbols)
        for s in found.sections:
            moved = (replace(r, symbol=r.symbol + number) for r in s.relocations)
            sections.append(replace(s, relocations=tuple(moved)))
        for symbol in found.symbols:
            home = symbol.section
            symbols.append(replace(symbol, section=None if home is None else home + first))
    known = {s.name: s for s in symbols if s.public and s.section is not None}
    return Object(
        objects[0].processor, tuple(sections), tuple(known.get(s.name, s) if s.public else s
                                                     for s in symbols)
    )  # fmt: skip
