"""Machine code of an exported model's texts that is small, for each system.

What counts is what an archive makes of the code: it packs best where instructions stay in the order
in which they are written, and where a value is not moved between places. That are options of LLVM,
which a whole process has; they are set back behind each object.

Needs:     llvmlite
Promises:  the same text gives the same bytes.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence, Set
from contextlib import contextmanager
from threading import Lock
from typing import Any

from planarc.codegen.native.assembly import SELDOM
from planarc.codegen.native.machine import emit_object, optimised
from planarc.core.data import Data
from planarc.instance.block import LARGER

#: What an instance does is marked, and what passes derivatives on: the time of a run goes into the
#: rest of the kernel. Code that LLVM would put into functions of its own packs better as it is.
_TIGHT = 'minsize optsize "nooutline" '
_INSTANCE = re.compile(
    r"^(define [^@]*@(?:px_\w+|pc_(?:eliminate|pass|ranges|rows|differences))\([^)]*\))"
    r" nounwind",
    re.MULTILINE,
)
#: What marks a seldom function in a library, which shall be small, and has no tables of addresses.
_SMALL = f'noinline {_TIGHT}"no-jump-tables"="true" '
#: What other processors have an instruction for.
_MAXIMUM = "llvm.maximum.f64"


class System(Data):
    """The least processor, what it shall do without, marks of all functions, and the system as on
    which functions of a library call each other, where that is another one."""

    cpu: str = ""
    features: str = ""
    marks: str = ""
    inside: str = ""


_LINUX, _WINDOWS = "x86_64-unknown-linux-gnu", "x86_64-pc-windows-msvc-elf"
WASM = "wasm32-unknown-unknown"
#: By LLVM's names, each for all systems that call functions in the same way. macOS 11 runs on
#: nothing older than Penryn (2008), which has SSE4.1. Windows keeps nothing below the stack. On ARM
#: macOS has x18 for itself, and x29 for its chain of frames. LLVM moves nothing that is finished
#: where it is told of Cyclone.
SYSTEMS = {
    _LINUX: System("penryn", marks="noredzone"),
    _WINDOWS: System("penryn", marks="noredzone", inside=_LINUX),
    "aarch64-unknown-linux-gnu": System(
        "", "+reserve-x18", '"tune-cpu"="cyclone" "frame-pointer"="non-leaf"'
    ),
    WASM: System(),
}
#: Passes of LLVM over code that all models share; they take out, too, what a model has no use for.
#: Branches stay as they are written: what chooses between numbers without them is longer.
_PASSES = (
    *("sroa", "ipsccp", "dead_arg_elimination"),
    *("global_dead_code_eliminate", "instruction_combine"),
)
#: The same over a model's own: its formulas have no more to be found, its loops have counters.
OWN_PASSES = ("sroa", "loop_rotate")
#: Options of LLVM, their values here, and those that they have by themselves: nothing is scheduled,
#: nothing is moved out of loops or into branches, and values are not split to stay in registers.
_OPTIONS = (
    ("enable-misched", 0, 1),
    ("disable-machine-licm", 1, 0),
    ("disable-machine-sink", 1, 0),
    ("disable-lsr", 1, 0),
    ("disable-block-placement", 1, 0),
    ("grow-region-complexity-budget", 0, 10000),
)
#: What names of planarc's own functions begin with.
_OURS = ("pc_", "px_")
#: Versions of LLVM that are known to have these: one without ends the process.
_TRIED = range(20, 23)
_LOCK = Lock()


def emitted(text: str, triple: str, passes: Sequence[str] = ()) -> bytes:
    """The object of a text, after passes of LLVM."""
    with _thrifty(triple != WASM):
        return emit_object(_marked(text, triple), _machine(triple), _OURS, passes)


def finished(text: str, triple: str) -> bytes:
    """The object of a text that LLVM has left as it is."""
    with _thrifty(triple != WASM):
        return emit_object(text, _machine(triple), ())


def shared_object(text: str, triple: str, called: Set[str]) -> bytes:
    """The object of a text that many models share, and of which others call these."""
    machine = _machine(triple)
    with _thrifty(triple != WASM):
        return bytes(machine.emit_object(_shared(text, triple, called, machine)))


def shared_text(text: str, triple: str, called: Set[str]) -> str:
    """Such a text as LLVM leaves it: what functions are made of (`units`)."""
    return str(_shared(text, triple, called, _machine(triple)))


def _shared(text: str, triple: str, called: Set[str], machine: Any) -> Any:
    return optimised(_marked(text, triple), machine, _OURS, _PASSES, called)


def _machine(triple: str) -> Any:
    import llvmlite.binding as llvm

    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    system = SYSTEMS[triple]
    return llvm.Target.from_triple(triple).create_target_machine(
        cpu=system.cpu,
        features=system.features,
        opt=1,
        reloc="static" if triple == WASM else "pic",  # its constants have addresses of their own
        codemodel="small",
    )


def _marked(text: str, triple: str) -> str:
    text = _INSTANCE.sub(rf"\1 {_TIGHT}nounwind", text.replace(SELDOM, _SMALL))
    text = text.replace(' nounwind "', f' nounwind {SYSTEMS[triple].marks} "')
    if not triple.startswith("x86"):
        text = text.replace(f"call double @{LARGER}(", f"call double @{_MAXIMUM}(")
    return text


@contextmanager
def _thrifty(wanted: bool) -> Iterator[None]:
    """Code made here is small, where that is wanted."""
    import llvmlite.binding as llvm

    options = _OPTIONS if wanted and llvm.llvm_version_info[0] in _TRIED else ()
    with _LOCK:
        for name, here, _ in options:
            llvm.set_option("", f"-{name}={here}")
        try:
            yield
        finally:
            for name, _, usual in options:
                llvm.set_option("", f"-{name}={usual}")
