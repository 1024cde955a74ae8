"""Object code linked into this process, by planarc itself (`planarc.runtime.link`) or by LLVM.

Both own the memory of the code, and find addresses by name. LLVM takes a tenth of a short run
to be imported, and is where planarc does not place code itself.
"""

from __future__ import annotations

import ctypes
import mmap
import sys

# Beneath the module `threading`, whose import is 0.6 ms of a run.
from _thread import allocate_lock

from planarc.runtime import elementary
from planarc.runtime.link.memory import place


class OwnLinker:
    """What is added finds by its name what was there before. Of equal names that was added last
    counts: equal code may be of models whose derivatives differ. Runs in threads may add the same
    at a time: memory that was placed twice would be lost to whom it was placed for first."""

    def __init__(self, known: dict[str, int]) -> None:
        self._lock = allocate_lock()
        self._addresses = dict(known)
        self._placed: dict[tuple[bytes, ...], tuple[mmap.mmap, dict[str, int]]] = {}

    def add(self, *objects: bytes) -> None:
        with self._lock:
            if objects not in self._placed:
                self._placed[objects] = place(objects, self._addresses)
            _, found = self._placed[objects]
            self._addresses |= found

    def address(self, name: str) -> int:
        return self._addresses[name]


class LlvmLinker:
    """The same by LLVM's runtime linker."""

    def __init__(self, known: dict[str, int]) -> None:
        import llvmlite.binding as llvm

        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
        target = llvm.Target.from_triple(llvm.get_process_triple())
        machine = target.create_target_machine(codemodel="jitdefault", jit=True)
        empty = llvm.parse_assembly("")
        empty.triple = llvm.get_process_triple()
        self._engine = llvm.create_mcjit_compiler(empty, machine)
        for name, address in (known | _c_library()).items():
            llvm.add_symbol(name, address)
        self._known: set[bytes] = set()
        self._lock = allocate_lock()

    def add(self, *objects: bytes) -> None:
        import llvmlite.binding as llvm

        with self._lock:
            for data in objects:
                if data not in self._known:
                    self._known.add(data)
                    self._engine.add_object_file(llvm.ObjectFileRef.from_data(data))
            self._engine.finalize_object()

    def address(self, name: str) -> int:
        return int(self._engine.get_global_value_address(name))


def _c_library() -> dict[str, int]:
    """The addresses of C's functions where LLVM does not find them: on Windows."""
    if sys.platform != "win32":
        return {}
    library = ctypes.CDLL("ucrtbase")
    named = (row.in_native for row in elementary.TABLE.values())
    names = (
        *(n for n in named if n and not n.startswith("llvm.")),
        "pow",
        "floor",
        "ceil",
        "trunc",
        "calloc",
        "free",
    )
    return {n: ctypes.cast(getattr(library, n), ctypes.c_void_p).value or 0 for n in names}
