"""Linked code in this process: in memory that is either written to or run.

In:   object files, the addresses that are known by name
Out:  the memory, and the addresses of what is public in it

    code and constants
    table of imports        filled before the memory becomes one to run

Needs:     `PLACES`.
"""

from __future__ import annotations

import ctypes
import mmap
import os
import struct
from collections.abc import Mapping, Sequence

from planarc.runtime.link.join import join
from planarc.runtime.link.objects import put_together, read_object


def place(objects: Sequence[bytes], known: Mapping[str, int]) -> tuple[mmap.mmap, dict[str, int]]:
    """What runs must not outlive the memory. Functions that are not `known` are C's."""
    joined = join(put_together([read_object(o) for o in objects]), _behind)
    table = [known.get(name) or _of_c(name) for name in joined.imports]
    gap = bytes(_behind(len(joined.code)) - len(joined.code))
    memory, start = put(joined.code + gap + struct.pack(f"<{len(table)}Q", *table))
    return memory, {name: start + at for name, at in joined.functions.items()}


def put(code: bytes) -> tuple[mmap.mmap, int]:
    """Code in memory, and where it begins."""
    memory = mmap.mmap(-1, len(code), flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    memory[:] = code
    start = ctypes.addressof(ctypes.c_char.from_buffer(memory))
    runs = mmap.PROT_READ | mmap.PROT_EXEC
    system = ctypes.CDLL(None, use_errno=True)
    if system.mprotect(ctypes.c_void_p(start), ctypes.c_size_t(len(code)), runs):
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return memory, start


def _behind(length: int) -> int:
    """Where the table begins."""
    return -(-length // 8) * 8


def _of_c(name: str) -> int:
    """The address of a function of the C library, part of which is its own file with some."""
    library = ctypes.CDLL(None)
    if not hasattr(library, name):
        library = ctypes.CDLL("libm.so.6")
    return ctypes.cast(getattr(library, name), ctypes.c_void_p).value or 0
