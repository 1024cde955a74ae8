"""LLVM text to object code for this machine.

The object code holds no absolute address, so it may be kept on disk for machines of
the same kind (`key`). The modules of a program are in it, the runtime, its own, and two more
where it has events, each behind its length (8 bytes).

Measured on a four-bar: LLVM's whole pipeline takes 220 ms for the runtime and 17 ms for
the model; registers instead of stack places, tidied branches and rotated loops 37 ms
and 10 ms, for the same speed. The model's text has no common subexpressions left and
gets no passes at all, and is made in LLVM's quickest way, but for its registers: 11 ms instead
of 27 for a four-bar, and runs up to a tenth slower. With values in memory that takes 7 ms, and
runs up to two thirds slower; for a chain of 80 rods it takes 30 ms instead of 180.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

from planarc.codegen.native.options import IN_MEMORY, QUICK, Option, are_known, options
from planarc.codegen.native.printer import ir, slopes_ir
from planarc.codegen.native.processor import fuses, key, target_machine
from planarc.codegen.native.waves import waves_text
from planarc.core import cache as store
from planarc.core.data import Data
from planarc.runtime.link import PLACES

if TYPE_CHECKING:
    from planarc.ir.derivatives import Scope
    from planarc.ir.program import Program

#: Lines of LLVM above which a program's values are kept in memory.
LARGEST_IN_REGISTERS = 3000
_TIDIED = ("sroa", "simplify_cfg", "instruction_combine", "loop_rotate", "simplify_cfg")


class Events(Data):
    """The texts of a program's events: one that all of this kind share, and its own. `often`: what
    is shared takes most of a run."""

    kind: str
    shared: Callable[[], str]
    own: str
    often: bool = False


def compile_object(program: Program, events: Events | None = None) -> bytes:
    """The program's object code, with that of its events."""
    own = _own(ir(program, alone=("pc_linear_top", *("pc_waves",) * fuses())))
    return _joined(_runtime(), own, *(() if events is None else _events(events)))


def compile_slopes(program: Program, scope: Scope) -> bytes | None:
    """The object code of derivatives, to be added to the program's own; None where the
    program calls a function that has none."""
    from planarc.codegen.slopes import derive_slopes

    slopes = derive_slopes(program, scope)
    return None if slopes is None else _joined(_passing(), _own(slopes_ir(program, slopes, scope)))


def _joined(*objects: bytes) -> bytes:
    return b"".join(len(code).to_bytes(8, "little") + code for code in objects)


def _own(text: str) -> bytes:
    """A model whose values or comments alone were changed has the text that it had."""
    quick = QUICK if text.count("\n") <= LARGEST_IN_REGISTERS else (IN_MEMORY,)

    def make() -> bytes:
        # Without its options the quickest way keeps values in memory.
        return _compiled(text, 1 if quick is QUICK and not are_known() else 0, quick=quick)

    return _kept((text,), make)


def _events(events: Events) -> Iterator[bytes]:
    """The object that models with events of this kind share, made in LLVM's quickest way where what
    runs is the model's, mostly. And the model's own."""
    write, way = events.shared, (1, _TIDIED) if events.often else (0, ("sroa",))
    yield _kept(("events", events.kind), lambda: _compiled(write(), *way))
    yield _own(events.own)


@cache
def _runtime() -> bytes:
    """The runtime's object code; it is the same for all models."""

    def make() -> bytes:
        from planarc.codegen.native.runtime import runtime_text

        text = runtime_text() + (waves_text() if fuses() else "")
        return _compiled(text, 1, _TIDIED)

    return _kept(("runtime",), make)


@cache
def _passing() -> bytes:
    """The functions that pass derivatives on, likewise."""
    from planarc.codegen.native.passing import passing_text

    return _kept(("passing",), lambda: _compiled(passing_text(), 1, _TIDIED))


def _kept(what: tuple[str, ...], make: Callable[[], bytes]) -> bytes:
    """Object code that was made before, or is made now. Of planarc's own text it is enough
    to know the name: the cache's keys hold the state of planarc's files."""
    name = store.key("object", key(), *what)
    known = store.load("native", name)
    if known is None:
        known = make()
        store.store("native", name, known)
    return known


def _compiled(
    text: str, level: int, passes: Sequence[str] = (), quick: Sequence[Option] = (IN_MEMORY,)
) -> bytes:
    machine = target_machine(level)
    with options(*(() if level else quick)):
        return emit_object(text, machine, ("pc_", "px_") if PLACES else (), passes)


def emit_object(
    text: str, machine: Any, hidden: tuple[str, ...], passes: Sequence[str] = ()
) -> bytes:
    """The text's object code, after passes of LLVM."""
    return bytes(machine.emit_object(optimised(text, machine, hidden, passes)))


def optimised(
    text: str,
    machine: Any,
    hidden: tuple[str, ...],
    passes: Sequence[str] = (),
    called: Container[str] | None = None,
) -> Any:
    """The text's module, after passes of LLVM. Names that begin in a `hidden` way are known to what
    is linked with it alone, which needs no table to find them; where it is told which of them are
    `called` from there, the others may go."""
    import llvmlite.binding as llvm

    module = llvm.parse_assembly(text)
    module.triple, module.data_layout = machine.triple, str(machine.target_data)
    for each in (*module.functions, *module.global_variables):
        if each.name.startswith(hidden) and each.linkage.name == "external":
            if called is None or each.name in called or each.is_declaration:
                each.visibility = "hidden"
            else:
                each.linkage = "internal"
    module.verify()
    if passes:
        builder = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options())
        manager = llvm.create_new_module_pass_manager()
        for name in passes:
            getattr(manager, f"add_{name}_pass")()
        manager.run(module, builder)
    return module
