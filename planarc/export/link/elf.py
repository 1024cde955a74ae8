"""A shared library for Linux: ELF, with what a loader reads and nothing else.

In:   Object, the functions that others may call, the libraries that have the imported ones
Out:  bytes

    headers, symbols, hash table, relocations     read
    code and constants                            read, executed
    dynamic section, table of imports             read, written by the loader

The sections of a linker's view are left out: no loader looks at them.

Reference: System V Application Binary Interface, chapter 5, "Program Loading and Dynamic
           Linking"; its supplements for AMD64 and AArch64.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

from planarc.runtime.link.join import X86_64, join
from planarc.runtime.link.objects import Object

#: Pages are at most that long on any Linux for these processors.
_PAGE = {X86_64: 0x1000}
_LARGEST_PAGE = 0x10000
#: Code begins at such an address: `join` reckons ARM's pages from it.
_CODE = 0x1000
#: The kind of relocation that asks for a symbol's address (GLOB_DAT).
_ADDRESS = {X86_64: 6}
_ADDRESS_ARM = 1025
_LOAD, _DYNAMIC, _STACK = 1, 2, 0x6474E551
_READ, _RUN, _WRITE = 4, 1, 2
_HEAD, _PROGRAM, _SYMBOL, _RELOCATION, _ENTRY = 64, 56, 24, 24, 16
_NEEDED, _HASH, _NAMES, _TABLE, _RELA, _RELASZ, _RELAENT = 1, 4, 5, 6, 7, 8, 9
_NAMES_SIZE, _SYMBOL_SIZE, _SONAME, _FLAGS = 10, 11, 14, 30
_BIND_NOW = 8


def write_library(found: Object, name: str, public: Sequence[str], needed: Sequence[str]) -> bytes:
    """The library `name`."""
    page = _PAGE.get(found.processor, _LARGEST_PAGE)
    dynamic_size = _ENTRY * (11 + len(needed))

    # Sizes first: they do not depend on addresses.
    sizing = join(found, lambda length: length)
    imports, code_length = sizing.imports, len(sizing.code)
    texts = _Names()
    names = [texts.add(n) for n in (*imports, *public)]
    libraries = [texts.add(n) for n in needed]
    own = texts.add(name)
    count = 1 + len(names)
    symbols_at = _HEAD + 5 * _PROGRAM
    hash_at = symbols_at + _SYMBOL * count
    relocations_at = _even(hash_at + 4 * (2 + 1 + count))
    names_at = relocations_at + _RELOCATION * len(imports)
    first = names_at + len(texts.data)
    code_file = -(-first // _CODE) * _CODE
    code_at = code_file + page
    data_file = -(-(code_file + code_length) // 64) * 64
    data_at = data_file + 2 * page
    imports_at = data_at + dynamic_size

    joined = join(found, lambda _: imports_at - code_at)
    symbols = bytes(_SYMBOL) + b"".join(
        struct.pack("<IBBHQQ", n, 0x12, 0, 0, 0, 0) for n in names[: len(imports)]
    )
    for text, at in zip(public, names[len(imports) :], strict=True):
        symbols += struct.pack("<IBBHQQ", at, 0x12, 0, 1, code_at + joined.functions[text], 0)
    chain = [0, *range(2, count), 0][:count]
    table = struct.pack(f"<II{1 + count}I", 1, count, min(1, count - 1), *chain)
    kind = _ADDRESS.get(found.processor, _ADDRESS_ARM)
    relocations = b"".join(
        struct.pack("<QQq", imports_at + 8 * i, (i + 1) << 32 | kind, 0)
        for i in range(len(imports))
    )
    entries = [*((_NEEDED, at) for at in libraries), (_SONAME, own), (_HASH, hash_at)]
    entries += [(_NAMES, names_at), (_TABLE, symbols_at), (_NAMES_SIZE, len(texts.data))]
    entries += [(_SYMBOL_SIZE, _SYMBOL), (_RELA, relocations_at), (_RELASZ, len(relocations))]
    entries += [(_RELAENT, _RELOCATION), (_FLAGS, _BIND_NOW), (0, 0)]
    dynamic = b"".join(struct.pack("<QQ", *e) for e in entries)
    assert len(dynamic) == dynamic_size
    data_size = dynamic_size + 8 * len(imports)
    programs = (
        (_LOAD, _READ, 0, 0, first, page),
        (_LOAD, _READ | _RUN, code_file, code_at, code_length, page),
        (_LOAD, _READ | _WRITE, data_file, data_at, data_size, page),
        (_DYNAMIC, _READ | _WRITE, data_file, data_at, dynamic_size, 8),
        (_STACK, _READ | _WRITE, 0, 0, 0, 16),
    )
    head = b"\x7fELF\x02\x01\x01".ljust(16, b"\0")
    head += struct.pack("<HHIQQQIHHHHHH", 3, found.processor, 1, 0, _HEAD, 0, 0, _HEAD, _PROGRAM,
                        len(programs), 64, 0, 0)  # fmt: skip
    for kind, flags, offset, address, size, align in programs:
        head += struct.pack("<IIQQQQQQ", kind, flags, offset, address, address, size, size, align)
    pieces = [(symbols_at, symbols), (hash_at, table), (relocations_at, relocations)]
    pieces += [(names_at, texts.data), (code_file, joined.code), (data_file, dynamic)]
    out = bytearray(head)
    for at, piece in pieces:
        out += bytes(at - len(out)) + piece
    return bytes(out) + bytes(8 * len(imports))


class _Names:
    """A table of texts, each ended by a zero."""

    def __init__(self) -> None:
        self.data = b"\0"

    def add(self, text: str) -> int:
        at = len(self.data)
        self.data += text.encode() + b"\0"
        return at


def _even(at: int) -> int:
    return -(-at // 8) * 8
