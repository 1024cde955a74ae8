"""A shared library for Windows: PE32+, a DLL.

In:   Object, the functions that others may call, the library that has the imported ones
Out:  bytes

    .text    code and constants
    .rdata   imported addresses, what is imported and exported
    .reloc   nothing to relocate: said, so that the library may lie anywhere

The object is ELF with Windows' calling convention; no table tells how to unwind its frames,
since nothing is thrown through them.

Reference: Microsoft, PE Format, sections "Optional Header", "The .edata Section",
           "The .idata Section" and "The .reloc Section".
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

from planarc.runtime.link.join import AARCH64, X86_64, join
from planarc.runtime.link.objects import Object

_PAGE, _BLOCK, _HEADERS = 0x1000, 0x200, 0x400
_BASE = 0x180000000
_MACHINE = {X86_64: 0x8664, AARCH64: 0xAA64}
#: executable image, large addresses, DLL
_KIND = 0x2 | 0x20 | 0x2000
#: high entropy, any base, no code in data
_RULES = 0x20 | 0x40 | 0x100
_CODE, _DATA = 0x60000020, 0x40000040  # read and run; read
_DISCARDED = 0x42000040


def write_library(found: Object, name: str, public: Sequence[str], needed: str) -> bytes:
    """The DLL `name`."""
    joined = join(found, lambda length: _pages(length))
    code_at = _PAGE
    data_at = code_at + _pages(len(joined.code))
    imports = joined.imports
    table = 8 * (len(imports) + 1)

    out = bytearray(2 * table + 40)  # addresses, the same as names, directory
    directory = data_at + 2 * table
    for i, text in enumerate(imports):
        hint = data_at + len(out)
        out += b"\0\0" + text.encode() + b"\0"
        out += bytes(len(out) % 2)
        for at in (8 * i, table + 8 * i):
            struct.pack_into("<Q", out, at, hint)
    library = data_at + len(out)
    out += needed.encode() + b"\0"
    struct.pack_into("<IIIII", out, 2 * table, data_at + table, 0, 0, library, data_at)

    out += bytes(-len(out) % 8)
    names = sorted(public, key=str.encode)
    exports, count = len(out), len(names)
    functions = exports + 40
    texts, ordinals = functions + 4 * count, functions + 8 * count
    out += bytes(40 + 10 * count)
    for i, text in enumerate(names):
        struct.pack_into("<I", out, functions + 4 * i, code_at + joined.functions[text])
        struct.pack_into("<I", out, texts + 4 * i, data_at + len(out))
        struct.pack_into("<H", out, ordinals + 2 * i, i)
        out += text.encode() + b"\0"
    own = data_at + len(out)
    out += name.encode() + b"\0"
    places = (data_at + functions, data_at + texts, data_at + ordinals)
    struct.pack_into("<IIHHIIIIIII", out, exports, 0, 0, 0, 0, own, 1, count, count, *places)
    exports_size = len(out) - exports

    relocations = struct.pack("<IIHH", code_at, 12, 0, 0)
    relocations_at = data_at + _pages(len(out))
    directories = [(0, 0)] * 16
    directories[0] = (data_at + exports, exports_size)
    directories[1] = (directory, 40)
    directories[5] = (relocations_at, len(relocations))
    directories[12] = (data_at, table)
    sections = (
        (b".text", code_at, joined.code, _CODE),
        (b".rdata", data_at, bytes(out), _DATA),
        (b".reloc", relocations_at, relocations, _DISCARDED),
    )
    return _file(found.processor, sections, directories)


def _file(
    processor: int,
    sections: Sequence[tuple[bytes, int, bytes, int]],
    directories: Sequence[tuple[int, int]],
) -> bytes:
    end = sections[-1][1] + _PAGE
    optional = struct.pack(
        "<HBBIIIII", 0x20B, 14, 0, _blocks(len(sections[0][2])),
        sum(_blocks(len(s[2])) for s in sections[1:]), 0, 0, sections[0][1],
    )  # fmt: skip
    optional += struct.pack("<QIIHHHHHHIIIIHH", _BASE, _PAGE, _BLOCK, 6, 0, 0, 0, 6, 0, 0, end,
                            _HEADERS, 0, 2, _RULES)  # fmt: skip
    optional += struct.pack("<QQQQII", 0x100000, 0x1000, 0x100000, 0x1000, 0, len(directories))
    optional += b"".join(struct.pack("<II", *d) for d in directories)
    head = b"MZ".ljust(60, b"\0") + struct.pack("<I", 64) + b"PE\0\0"
    head += struct.pack("<HHIIIHH", _MACHINE[processor], len(sections), 0, 0, 0, len(optional),
                        _KIND)  # fmt: skip
    head += optional
    at, bodies = _HEADERS, b""
    for name, address, body, flags in sections:
        size = _blocks(len(body))
        head += name.ljust(8, b"\0")
        head += struct.pack("<IIIIIIHHI", len(body), address, size, at, 0, 0, 0, 0, flags)
        bodies += body.ljust(size, b"\0")
        at += size
    return head.ljust(_HEADERS, b"\0") + bodies


def _pages(length: int) -> int:
    return -(-length // _PAGE) * _PAGE


def _blocks(length: int) -> int:
    return -(-length // _BLOCK) * _BLOCK
