"""A shared library for macOS: Mach-O, with a signature of its own making.

In:   Object, the functions that others may call, the library that has the imported ones
Out:  bytes

    __TEXT       headers, code and constants
    __DATA       imported addresses
    __LINKEDIT   what is bound and exported, symbols, signature

ARM's macOS runs nothing unsigned; an ad-hoc signature names nobody and holds the hashes of all
pages. On x86-64 nothing asks for one, and hashes do not pack. The object is ELF with Apple's
calling convention; symbols get Apple's underscore here.

Reference: Apple, headers mach-o/loader.h and mach-o/nlist.h, OS X ABI Mach-O File Format
           Reference; Security framework, CSCommon.h and cs_blobs.h.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from hashlib import sha256

from planarc.runtime.link.join import AARCH64, X86_64, join
from planarc.runtime.link.objects import Object

_PAGE, _HASHED = 0x4000, 0x1000
#: type and subtype of the processor
_PROCESSOR = {X86_64: (0x01000007, 3), AARCH64: (0x0100000C, 0)}
#: no undefined symbols, for the dynamic linker, names with their libraries, exports no other
_FLAGS = 0x1 | 0x4 | 0x80 | 0x100000
_SEGMENT, _SYMTAB, _DYSYMTAB, _LOAD, _ID, _UUID = 0x19, 0x2, 0xB, 0xC, 0xD, 0x1B
_SIGNATURE, _DYLD_INFO, _BUILD = 0x1D, 0x80000022, 0x32
_READ, _WRITE, _RUN = 1, 2, 4
#: macOS 11 is the first that runs on ARM.
_OLDEST = 11 << 16
#: What the library of the system calls otherwise than that of Linux, which objects are made for.
_NAMES = {"sincos": "__sincos"}


def write_library(found: Object, name: str, public: Sequence[str], needed: str) -> bytes:
    """The library `name`."""
    install = f"@rpath/{name}"
    signs = found.processor == AARCH64
    commands_size = (
        72 + 80 + 72 + 80 + 72 + 48 + 24 + 80 + 24 + 24 + _path(install) + _path(needed)
    ) + 16 * signs
    code_at = -(-(32 + commands_size) // _HASHED) * _HASHED
    sizing = join(found, lambda length: length)
    data_at = _pages(code_at + len(sizing.code))
    joined = join(found, lambda _: data_at - code_at)
    imports = [_NAMES.get(name, name) for name in joined.imports]
    data_size = 8 * len(imports)
    edit_at = data_at + _pages(data_size)

    functions = {f"_{n}": code_at + joined.functions[n] for n in public}
    edit = bytearray()

    def put(data: bytes, align: int = 8) -> int:
        edit.extend(bytes(-len(edit) % align))
        edit.extend(data)
        return edit_at + len(edit) - len(data)

    binding, exported = _even(_bound(imports)), _even(_exported(functions))
    bound_at, exported_at = put(binding), put(exported)
    texts, symbols = b"\0", b""
    for text, at in sorted(functions.items()):
        symbols += struct.pack("<IBBHQ", len(texts), 0x0F, 1, 0, at)
        texts += text.encode() + b"\0"
    for text in imports:
        symbols += struct.pack("<IBBHQ", len(texts), 0x01, 0, 1 << 8, 0)
        texts += f"_{text}".encode() + b"\0"
    symbols_at = put(symbols)
    numbers = range(len(public), len(public) + len(imports))
    indirect_at = put(struct.pack(f"<{len(numbers)}I", *numbers))
    texts_at = put(texts := _even(texts))
    edit.extend(bytes(-len(edit) % 16 * signs))
    signed_at = edit_at + len(edit)
    signature_size = _signature_size(name, signed_at) if signs else 0
    edit_size = len(edit) + signature_size

    text_size = data_at
    commands = [
        _segment("__TEXT", 0, text_size, 0, text_size, _READ | _RUN,
                 [("__text", code_at, len(joined.code), 12, 0x80000400, 0)]),
        _segment("__DATA", data_at, _pages(data_size), data_at, _pages(data_size), _READ | _WRITE,
                 [("__got", data_at, data_size, 3, 0x6, 0)]),
        _segment("__LINKEDIT", edit_at, _pages(edit_size), edit_at, edit_size, _READ, []),
        _library(_ID, install),
        struct.pack("<12I", _DYLD_INFO, 48, 0, 0, bound_at, len(binding), 0, 0, 0, 0,
                    exported_at, len(exported)),
        struct.pack("<6I", _SYMTAB, 24, symbols_at, len(public) + len(imports), texts_at,
                    len(texts)),
        struct.pack("<20I", _DYSYMTAB, 80, 0, 0, 0, len(public), len(public), len(imports), 0, 0,
                    0, 0, 0, 0, indirect_at, len(imports), 0, 0, 0, 0),
        struct.pack("<II", _UUID, 24) + sha256(joined.code).digest()[:16],
        struct.pack("<6I", _BUILD, 24, 1, _OLDEST, _OLDEST, 0),
        _library(_LOAD, needed),
    ]  # fmt: skip
    if signs:
        commands.append(struct.pack("<4I", _SIGNATURE, 16, signed_at, signature_size))
    size = sum(map(len, commands))
    assert size == commands_size, (size, commands_size)
    processor = _PROCESSOR[found.processor]
    head = struct.pack("<8I", 0xFEEDFACF, *processor, 6, len(commands), size, _FLAGS, 0)
    whole = head + b"".join(commands)
    whole = whole.ljust(code_at, b"\0") + joined.code
    whole = whole.ljust(edit_at, b"\0") + bytes(edit)
    return whole + _signature(name, whole, text_size, signature_size) if signs else whole


def _segment(
    name: str,
    address: int,
    length: int,
    offset: int,
    size: int,
    rights: int,
    sections: Sequence[tuple[str, int, int, int, int, int]],
) -> bytes:
    out = struct.pack("<II16sQQQQIIII", _SEGMENT, 72 + 80 * len(sections), name.encode(), address,
                      length, offset, size, rights, rights, len(sections), 0)  # fmt: skip
    for own, at, count, align, flags, first in sections:
        out += struct.pack("<16s16sQQIIIIIIII", own.encode(), name.encode(), at, count, at, align,
                           0, 0, flags, first, 0, 0)  # fmt: skip
    return out


def _path(text: str) -> int:
    return -(-(24 + len(text.encode()) + 1) // 8) * 8


def _library(command: int, text: str) -> bytes:
    size = _path(text)
    head = struct.pack("<6I", command, size, 24, 0, 0x10000, 0x10000)
    return (head + text.encode()).ljust(size, b"\0")


def _leb(value: int) -> bytes:
    """A whole number, seven bits a byte, the lowest first."""
    out = b""
    while value > 0x7F:
        out += bytes([value & 0x7F | 0x80])
        value >>= 7
    return out + bytes([value])


def _bound(imports: Sequence[str]) -> bytes:
    """Opcodes for the dynamic linker: each address of the second segment, from library 1."""
    out = b"\x11\x51"
    for i, name in enumerate(imports):
        out += b"\x40" + f"_{name}".encode() + b"\0\x71" + _leb(8 * i) + b"\x90"
    return out + b"\0"


def _exported(functions: dict[str, int]) -> bytes:
    """A tree of names with one level. The linker takes the first branch that fits, so the longer
    of two names that begin alike stands first."""
    names = sorted(functions, key=lambda n: (-len(n), n))
    assert len(names) < 256
    leaves = []
    for name in names:
        told = b"\0" + _leb(functions[name])
        leaves.append(_leb(len(told)) + told + b"\0")
    root_size, root = 0, b""
    while True:
        at, root = root_size, b"\0" + bytes([len(names)])
        for name, leaf in zip(names, leaves, strict=True):
            root += name.encode() + b"\0" + _leb(at)
            at += len(leaf)
        if len(root) == root_size:
            return root + b"".join(leaves)
        root_size = len(root)


def _signature_size(name: str, limit: int) -> int:
    hashes = -(-limit // _HASHED)
    return 20 + 88 + len(name.encode()) + 1 + 32 * hashes


def _signature(name: str, signed: bytes, text_size: int, size: int) -> bytes:
    """One blob, the directory of the code: a hash for each page of what stands before it."""
    ident = name.encode() + b"\0"
    pages = range(0, len(signed), _HASHED)
    hashes = b"".join(sha256(signed[i : i + _HASHED]).digest() for i in pages)
    first = 88 + len(ident)
    directory = struct.pack(">IIIIIIIII", 0xFADE0C02, size - 20, 0x20400, 0x20002, first, 88, 0,
                            len(pages), len(signed))  # fmt: skip
    directory += struct.pack(">BBBBIIIIQQQQ", 32, 2, 0, 12, 0, 0, 0, 0, 0, 0, text_size, 0)
    directory += ident + hashes
    return struct.pack(">IIIII", 0xFADE0CC0, size, 1, 0, 20) + directory


def _even(data: bytes) -> bytes:
    return data + bytes(-len(data) % 8)


def _pages(length: int) -> int:
    return -(-length // _PAGE) * _PAGE
