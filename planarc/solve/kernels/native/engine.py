"""Object code, linked into this process."""

from __future__ import annotations

import ctypes
import math
import sys
from collections.abc import Callable, Mapping
from functools import cached_property
from types import MappingProxyType
from typing import Any, Final

from planarc.runtime import elementary, external

_REAL, _POINTER = ctypes.c_double, ctypes.c_void_p
_FRAME_AND_TIME = (_POINTER, _REAL)

#: The functions that Python calls, with their arguments; all give an int.
_SIGNATURES: Final[Mapping[str, tuple[Any, ...]]] = MappingProxyType(
    {
        "pc_parameters": _FRAME_AND_TIME,
        "pc_discrete": _FRAME_AND_TIME,
        "pc_accept": _FRAME_AND_TIME,
        "pc_outputs": (*_FRAME_AND_TIME, _POINTER),
        "pc_rhs": (*_FRAME_AND_TIME, _POINTER, _POINTER),
        "pc_roots": (*_FRAME_AND_TIME, _POINTER, _POINTER),
        "pc_evaluate": (_POINTER, ctypes.c_int64, _POINTER),
        "pc_differences": (_POINTER, _POINTER, _POINTER),
    }
)


def _external(function: int, output: int, count: int, arguments: Any) -> float:
    """A function of `planarc.runtime.external`, as native code calls it."""
    try:
        return external.number(_EXTERNALS[function], output, arguments[:count])
    except Exception:  # nothing may go up through machine code
        return math.nan


_EXTERNALS: Final = tuple(external.INDEX)
#: Its address serves all engines, so it lives as long as the process.
_CALLED: Final = ctypes.CFUNCTYPE(_REAL, *[ctypes.c_int64] * 3, ctypes.POINTER(_REAL))(_external)


class Engine:
    """Owns the memory of the functions: it must outlive every address taken from it."""

    def __init__(self, code: bytes) -> None:
        import llvmlite.binding as llvm

        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
        target = llvm.Target.from_triple(llvm.get_process_triple())
        machine = target.create_target_machine(codemodel="jitdefault", jit=True)
        empty = llvm.parse_assembly("")
        empty.triple = llvm.get_process_triple()
        self._engine = llvm.create_mcjit_compiler(empty, machine)
        if sys.platform == "win32":
            _name_library(llvm)
        llvm.add_symbol("pc_external", ctypes.cast(_CALLED, _POINTER).value)
        self._known: set[bytes] = set()
        self._addresses: dict[str, int] = {}
        self.add(code)
        self.functions = {name: self._function(name) for name in _SIGNATURES}

    def add(self, code: bytes) -> None:
        """Link both parts, what is the same for all models once."""
        import llvmlite.binding as llvm

        split = 8 + int.from_bytes(code[:8], "little")
        for part in (code[8:split], code[split:]):
            if part not in self._known:
                self._known.add(part)
                self._engine.add_object_file(llvm.ObjectFileRef.from_data(part))
        self._engine.finalize_object()

    def address(self, name: str) -> int:
        found = self._addresses.get(name)
        if not found:
            found = self._addresses[name] = int(self._engine.get_function_address(name))
        return found

    def value(self, name: str) -> int:
        """The address of a constant."""
        return int(self._engine.get_global_value_address(name))

    def passing(self) -> tuple[Callable[..., int], ...]:
        """`pc_ranges`, `pc_pass` and `pc_gather`, once code of derivatives was added."""
        shapes: dict[str, tuple[Any, ...]] = {
            "pc_ranges": (None, _POINTER),
            "pc_pass": (ctypes.c_int, _POINTER, _REAL),
            "pc_gather": (ctypes.c_int, _POINTER, _POINTER, ctypes.c_int64, _POINTER),
        }
        return tuple(ctypes.CFUNCTYPE(*shape)(self.address(name)) for name, shape in shapes.items())

    @cached_property
    def sweep(self) -> Callable[..., int]:
        """`pc_sweep`."""
        shape = ctypes.CFUNCTYPE(
            ctypes.c_int, *[_POINTER] * 7, ctypes.c_int64, ctypes.c_int64, _REAL
        )
        return shape(self.address("pc_sweep"))

    def _function(self, name: str) -> Callable[..., int]:
        made = ctypes.CFUNCTYPE(ctypes.c_int, *_SIGNATURES[name])
        return made(self.address(name))


def _name_library(llvm: Any) -> None:
    """Tell LLVM where the C library's functions are: on Windows it does not find them."""
    c_library = ctypes.CDLL("ucrtbase")
    named = (row.in_native for row in elementary.TABLE.values())
    library = (name for name in named if name and not name.startswith("llvm."))
    for name in (*library, "pow", "floor", "ceil", "trunc"):
        llvm.add_symbol(name, ctypes.cast(getattr(c_library, name), _POINTER).value)
