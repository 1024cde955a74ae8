"""Sections put together: code whose relative addresses are right.

In:   Object, and how far the table of imported addresses will lie from the code's beginning
Out:  Joined   the code with its constants, its public functions, the imported ones

Nothing here knows a file format. An imported function is called by way of a stub, which
jumps to the address that the loader writes into the table of imports:

    call sin@stub         stub:  jmp [imports + 8*i]

Addresses are all relative, so the code can lie anywhere and is never written to. Sections of one
name lie together, since archives pack them better so.

Reference: System V ABI, AMD64 supplement, section 4.4; ELF for the Arm 64-bit architecture,
           section 5.7 (relocations).
"""

from __future__ import annotations

import struct
from collections.abc import Callable

from planarc.core.data import Data
from planarc.runtime.link.objects import Object

X86_64, AARCH64 = 62, 183
#: Length of a stub.
_STUB = 16


class Joined(Data):
    code: bytes
    functions: dict[str, int]  # public ones, by their offset in the code
    imports: tuple[str, ...]  # each has 8 bytes in the table of imports


def join(found: Object, imports_at: Callable[[int], int]) -> Joined:
    """`imports_at` gives the place of the table of imports, reckoned from the code's first byte,
    for a length of the code."""
    parts, starts, length = [], {}, 0
    for i, section in sorted(enumerate(found.sections), key=lambda s: s[1].name):
        gap = -length % section.align
        parts += [bytes(gap), section.data]
        starts[i] = length + gap
        length += gap + len(section.data)
    called = {r.symbol for s in found.sections for r in s.relocations}
    outside = [i for i in sorted(called) if found.symbols[i].section is None]
    names = tuple(found.symbols[i].name for i in outside)
    gap = -length % _STUB
    stubs, length = length + gap, length + gap + _STUB * len(outside)
    code, table = bytearray(b"".join(parts) + bytes(gap)), imports_at(length)
    for k in range(len(outside)):
        code += _stub(found.processor, stubs + _STUB * k, table + 8 * k)
    homes = {i: stubs + _STUB * k for k, i in enumerate(outside)}
    for i, symbol in enumerate(found.symbols):
        if symbol.section is not None:
            homes[i] = starts[symbol.section] + symbol.value
    apply = _X86 if found.processor == X86_64 else _ARM
    for i, section in enumerate(found.sections):
        for r in section.relocations:
            apply(code, starts[i] + r.offset, r.kind, homes[r.symbol] + r.addend)
    functions = {s.name: homes[i] for i, s in enumerate(found.symbols) if s.public and i in homes}
    return Joined(bytes(code), {n: a for n, a in functions.items() if n not in names}, names)


def _stub(processor: int, at: int, slot: int) -> bytes:
    if processor == X86_64:  # jmp *slot(%rip)
        return (b"\xff\x25" + struct.pack("<i", slot - at - 6)).ljust(_STUB, b"\xcc")
    # adrp x16, slot; ldr x16, [x16, #low]; br x16
    code = bytearray(struct.pack("<IIII", 0x90000010, 0xF9400210, 0xD61F0200, 0xD503201F))
    for kind, offset in ((_ADR_PAGE, 0), (_LOAD_64, 4)):
        _ARM(code, offset, kind, slot, at)
    return bytes(code)


_PC32, _PLT32 = 2, 4  # R_X86_64_*
_ADR_PAGE, _ADD_LOW, _LOAD_8, _JUMP, _CALL = 275, 277, 278, 282, 283  # R_AARCH64_*
_PREL32, _LOAD_16, _LOAD_32, _LOAD_64, _LOAD_128 = 261, 284, 285, 286, 299
_SHIFTS = {_ADD_LOW: 0, _LOAD_8: 0, _LOAD_16: 1, _LOAD_32: 2, _LOAD_64: 3, _LOAD_128: 4}


def _X86(code: bytearray, place: int, kind: int, target: int) -> None:
    assert kind in (_PC32, _PLT32), f"relocation R_X86_64 {kind}"
    struct.pack_into("<i", code, place, target - place)


def _ARM(code: bytearray, place: int, kind: int, target: int, base: int = 0) -> None:
    """The code begins at a multiple of 4096; `base` is where in it the bytes given stand."""
    if kind == _PREL32:
        struct.pack_into("<i", code, place, target - place)
        return
    (word,) = struct.unpack_from("<I", code, place)
    if kind in (_CALL, _JUMP):
        word |= (target - place >> 2) & 0x3FFFFFF
    elif kind == _ADR_PAGE:
        pages = (target >> 12) - (place + base >> 12)
        word |= (pages & 3) << 29 | (pages >> 2 & 0x7FFFF) << 5
    else:
        assert kind in _SHIFTS, f"relocation R_AARCH64 {kind}"
        word |= (target & 0xFFF) >> _SHIFTS[kind] << 10
    struct.pack_into("<I", code, place, word)
