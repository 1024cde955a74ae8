"""Object code, linked into this process."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Mapping
from functools import cached_property
from types import MappingProxyType
from typing import Any, Final

from planarc.runtime import external
from planarc.runtime.link import PLACES
from planarc.solve.kernels.native.linkers import LlvmLinker, OwnLinker

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
        "pc_seek": (*[_POINTER] * 5, ctypes.c_int64),
        "pc_motions": (*[_POINTER] * 4, _REAL),
        "pc_begin": (_POINTER,) * 5,
    }
)


def _external(function: int, output: int, count: int, arguments: Any) -> float:
    """A function of `planarc.runtime.external`, as native code calls it."""
    try:
        return external.number(_EXTERNALS[function], output, tuple(arguments[:count]))
    except Exception:  # nothing may go up through machine code
        return math.nan


_EXTERNALS: Final = tuple(external.INDEX)
#: Its address serves all engines, so it lives as long as the process.
CALLED: Final = ctypes.CFUNCTYPE(_REAL, *[ctypes.c_int64] * 3, ctypes.POINTER(_REAL))(_external)


def parts_of(code: bytes) -> list[bytes]:
    """The objects of object code, each behind its length."""
    found, at = [], 0
    while at < len(code):
        end = at + 8 + int.from_bytes(code[at : at + 8], "little")
        found.append(code[at + 8 : end])
        at = end
    return found


class Engine:
    """Owns the memory of the functions: it must outlive every address taken from it."""

    def __init__(self, code: bytes) -> None:
        called = ctypes.cast(CALLED, _POINTER).value or 0
        self._linker = (OwnLinker if PLACES else LlvmLinker)({"pc_external": called})
        runtime, own, *self._events = parts_of(code)
        self._linker.add(runtime, own)
        self.functions = {name: self._function(name) for name in _SIGNATURES}

    def add(self, code: bytes) -> None:
        """Link all parts, what is the same for all models once."""
        self._linker.add(*parts_of(code))

    @cached_property
    def react(self) -> Callable[..., int] | None:
        """`px_react`, where the code iterates events."""
        if not self._events:
            return None
        self._linker.add(*self._events)
        return ctypes.CFUNCTYPE(ctypes.c_int, _POINTER, ctypes.c_int64)(self.address("px_react"))

    def address(self, name: str) -> int:
        """The address of a function or a constant."""
        return self._linker.address(name)

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
