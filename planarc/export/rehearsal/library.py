"""An exported model as machine code for this processor, linked into this process.

In:   Compiled
Out:  Library   its instances, each with a workspace of its own

    model_new, model_set, model_begin, model_go, model_message    as a C program calls them
    model_place(m) -> workspace      where its values stand
    model_at(m, t, tolerance)        another start time, and the tolerance of its steps
    model_blame(m) -> text           the instant, and what could not be solved last
    model_free(m)

Before and behind each event an instance calls Python by

    model_event(time, behind, w, crossing, fired, samples)

as a page is called (`export.page.entries`), from which thread ever: an instance is known by its
workspace.

Needs:     llvmlite
Raises:    PlanarcError C300 for what cannot be exported, and what a start may raise.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final, Protocol

import numpy as np
from msgspec.structs import replace

from planarc.codegen.native.assembly import POINTER, REAL
from planarc.codegen.native.machine import emit_object
from planarc.codegen.native.newton import open_frame
from planarc.codegen.native.processor import key, target_machine
from planarc.core import cache as store
from planarc.export.c.entries import functions
from planarc.export.heard import tell_events
from planarc.export.image import take_image
from planarc.export.module import write_whole
from planarc.export.refusal import refuse
from planarc.export.wishes import tolerance_of
from planarc.instance.block import constant, whole
from planarc.instance.plan import Own, Stale, is_eventful
from planarc.instance.said import MARK
from planarc.ir.derivatives import Scope
from planarc.ir.frame import Frame, Number
from planarc.runtime.link import PLACES
from planarc.solve.kernels.native.engine import CALLED
from planarc.solve.kernels.native.linkers import LlvmLinker, OwnLinker

if TYPE_CHECKING:
    from planarc.compiled import Compiled
    from planarc.core.arrays import Vector
    from planarc.export.fmi.entries import Entries

_REAL, _POINTER, _FLAG = ctypes.c_double, ctypes.c_void_p, ctypes.c_int
_SIGNATURES: Final[dict[str, tuple[Any, ...]]] = {
    "model_new": (_POINTER,),
    "model_set": (_FLAG, _POINTER, _FLAG, _REAL),
    "model_at": (_FLAG, _POINTER, _REAL, _REAL),
    "model_begin": (_FLAG, _POINTER),
    "model_go": (_FLAG, _POINTER, _REAL),
    "model_message": (ctypes.c_char_p, _POINTER, _FLAG),
    "model_blame": (ctypes.c_char_p, _POINTER),
    "model_place": (_POINTER, _POINTER),
    "model_free": (_FLAG, _POINTER),
}
#: LLVM's level, as the kernel's functions have it, and its passes over them.
_LEVEL = 1
_PASSES = ("sroa", "instruction_combine")


class Listener(Protocol):
    """What is told of the events of an instance."""

    def __call__(
        self, time: float, behind: bool, crossing: list[int], fired: list[int]
    ) -> None: ...


#: The listeners of instances that run, by the addresses of their workspaces.
_LISTENERS: Final[dict[int, Callable[[float, bool, int, int], None]]] = {}


def _event(time: float, behind: int, w: int, crossing: int, fired: int, samples: int) -> None:
    listener = _LISTENERS.get(w)
    if listener is not None:
        listener(time, bool(behind), crossing, fired)


_TOLD: Final = ctypes.CFUNCTYPE(None, _REAL, _FLAG, *[_POINTER] * 4)(_event)


class Library:
    """The functions of a model; `held` are pairs (slot, slot of the value that it is held at)."""

    def __init__(self, compiled: Compiled, stiff: bool) -> None:
        from planarc.codegen.slopes import derive_slopes

        program = compiled.program
        refuse(program, stiff)
        image = replace(take_image(compiled), stiff=stiff)
        slopes = derive_slopes(program, Scope.ALL, ()) if stiff else None
        written = write_whole(
            program, image, _entries(is_eventful(program)), "", tolerance_of(program), slopes, stiff
        )
        called, told = (ctypes.cast(f, _POINTER).value or 0 for f in (CALLED, _TOLD))
        known = {"pc_external": called, "model_event": told}
        self._linker = (OwnLinker if PLACES else LlvmLinker)(known)
        self._linker.add(*map(_object, written.texts))
        self.functions = {
            name: ctypes.CFUNCTYPE(*signature)(self._linker.address(name))
            for name, signature in _SIGNATURES.items()
        }
        self.program, self.held = program, image.held

    @contextmanager
    def instance(self) -> Iterator[Instance]:
        """One as it was exported. Raises MemoryError."""
        block = self.functions["model_new"]()
        if not block:
            raise MemoryError
        instance = Instance(self, block)
        try:
            yield instance
        finally:
            _LISTENERS.pop(instance.place, None)
            self.functions["model_free"](block)


class Instance:
    """An instance. `w` is its workspace."""

    def __init__(self, library: Library, block: int) -> None:
        self._library, self._block = library, block
        self._f = library.functions
        self._raised: BaseException | None = None
        self.place = self._f["model_place"](block)
        self.w = _numbers(self.place, library.program.size)
        words = _numbers(block, len(Frame)).view(np.int64)
        count = library.program.state_count
        self._states = _numbers(int(words[Frame.NUMBERS]), Number.FIRST_STATE + count).view(
            np.int64
        )[Number.FIRST_STATE :]

    @property
    def states(self) -> tuple[int, ...]:
        """The slots of the present states."""
        return tuple(self._states.tolist())

    def listen(self, listener: Listener) -> None:
        """Tell it of events: the numbers of the relations and samplers that switch."""
        program = self._library.program
        counts = len(program.relations), len(program.samplers)

        def heard(time: float, behind: bool, *flags: int) -> None:
            try:
                crossing, fired = (
                    np.flatnonzero(_numbers(at, n).view(np.int64)).tolist()
                    for at, n in zip(flags, counts, strict=True)
                )
                listener(time, behind, crossing, fired)
            except BaseException as problem:  # Ctrl-C, too: nothing goes up through machine code
                self._raised = problem

        _LISTENERS[self.place] = heard

    def step_by(self, length: float) -> None:
        """The steps of a crowd."""
        program = self._library.program
        behind = program.size + 2 * program.state_count + len(program.relations)
        done = self.set(behind + 1, length)
        assert done, "the length of steps stands behind what is seen of relations"

    def set(self, slot: int, value: float) -> bool:
        """Whether such a value can be set."""
        done: bool = self._f["model_set"](self._block, slot, value) == 0
        return done

    def begin(self, t: float, tolerance: float) -> int:
        """0, or what stands in the way of a start. What a listener raised is raised here."""
        self._f["model_at"](self._block, t, tolerance)
        flag: int = self._f["model_begin"](self._block)
        self._reraise()
        return flag

    def go(self, t: float) -> int:
        """0 at the time `t`; else what ended the run: see `export.c.entries`. What a listener
        raised on the way is raised here."""
        flag: int = self._f["model_go"](self._block, t)
        self._reraise()
        return flag

    def _reraise(self) -> None:
        if (raised := self._raised) is not None:
            self._raised = None
            raise raised

    def message(self, number: int) -> str:
        """The text of an ending."""
        text: bytes = self._f["model_message"](self._block, number)
        return text.decode()

    def blame(self) -> str:
        """The instant, and what could not be solved last."""
        text: bytes = self._f["model_blame"](self._block)
        return text.decode()


def _entries(eventful: bool) -> Entries:
    e = functions()
    if eventful:
        tell_events(e, "model_event")
    with e.plain("model_place", "ptr m", POINTER) as (c, (m,)):
        c.give(open_frame(m)[0])
    with e.plain("model_free", "ptr m") as (c, (m,)):
        c.run("free", m)
        c.give(0)
    with e.plain("model_blame", "ptr m", POINTER) as (c, (m,)):
        c.give(c.call(POINTER, "px_fill", m, constant(c, e.string(f"at t = {MARK}t6 s: {MARK}w0"))))
    with e.plain("model_at", "ptr m, double t, double tolerance") as (c, (m, t, tolerance)):
        w = open_frame(m)[0]
        m.store(tolerance, Own.TOLERANCE)
        with c.when(~w.load(REAL).equals(t)):
            w.store(t)
            m.store(whole(c, Stale.START), Own.STALE)
        c.give(0)
    return e


def _object(text: str) -> bytes:
    """Code that was made before, or is made now."""
    name = store.key("rehearsed", key(), text)
    known = store.load("native", name)
    if known is None:
        known = emit_object(text, target_machine(_LEVEL), ("pc_", "px_") if PLACES else (), _PASSES)
        store.store("native", name, known)
    return known


def _numbers(at: int, count: int) -> Vector:
    """Numbers in the memory of an instance, in place."""
    if not count:
        return np.empty(0)
    return np.ctypeslib.as_array(ctypes.cast(at, ctypes.POINTER(_REAL)), (count,))
