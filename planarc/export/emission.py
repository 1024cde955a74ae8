"""Machine code of an exported model's texts that is small, for each system.

What counts is what an archive makes of the code: it packs best where instructions stay in the order
in which they are written, and where a value is not moved between places. That are options of LLVM,
which a whole process has; they are set back behind each object.

What models share is made in LLVM's quickest way, but for its registers: that takes a third of the
time, and runs hardly slower, as the time of a run goes into the model's own code.

Needs:     llvmlite
Promises:  the same text gives the same bytes.
"""

from __future__ import annotations

import re
from collections.abc import Sequence, Set
from typing import Any

from planarc.codegen.native.assembly import SELDOM
from planarc.codegen.native.machine import emit_object, optimised
from planarc.codegen.native.options import QUICK, options
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
_DEFINED = re.compile(rf"^define [^\n]*@{LARGER}\(.*?^}}\n", re.MULTILINE | re.DOTALL)


class System(Data):
    """The least processor, what it shall do without, marks of all functions, and the system as on
    which functions of a library call each other, where that is another one."""

    cpu: str = ""
    features: str = ""
    marks: str = ""
    inside: str = ""


_LINUX, _WINDOWS = "x86_64-unknown-linux-gnu", "x86_64-pc-windows-msvc-elf"
WASM = "wasm32-unknown-unknown"
_MARK = "noredzone"
#: By LLVM's names, each for all systems that call functions in the same way. macOS 11 runs on
#: nothing older than Penryn (2008), which has SSE4.1. Windows keeps nothing below the stack. On ARM
#: macOS has x18 for itself, and x29 for its chain of frames. LLVM moves nothing that is finished
#: where it is told of Cyclone.
SYSTEMS = {
    _LINUX: System("penryn", marks=_MARK),
    _WINDOWS: System("penryn", marks=_MARK, inside=_LINUX),
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
#: The same of the quickest way, which gives out registers in the order of the text.
_QUICK = (*QUICK, ("regalloc-enable-priority-advisor", "dummy", "default"))
#: What names of planarc's own functions begin with.
_OURS = ("pc_", "px_")


def emitted(text: str, triple: str, passes: Sequence[str] = ()) -> bytes:
    """The object of a text, after passes of LLVM."""
    with options(*(() if triple == WASM else _OPTIONS)):
        return emit_object(_marked(text, triple), _machine(triple), _OURS, passes)


def finished(text: str, triple: str, small: bool) -> bytes:
    """The object of a text that LLVM has left as it is (`shared_text`)."""
    with options(*(_QUICK if small else _OPTIONS)):
        return emit_object(text, _machine(triple, 0 if small else 1), ())


def shared_object(text: str, triple: str, called: Set[str]) -> bytes:
    """The object of a text that many models share, and of which others call these."""
    machine = _machine(triple)
    module = optimised(_marked(text, triple), machine, _OURS, _PASSES, called)
    with options(*(() if triple == WASM else _OPTIONS)):
        return bytes(machine.emit_object(module))


def shared_text(text: str, called: Set[str]) -> str:
    """Such a text as LLVM leaves it, for all systems: what functions are made of (`units`)."""
    return str(optimised(_marked(text, _LINUX), _machine(_LINUX), _OURS, _PASSES, called))


def on_system(text: str, triple: str) -> str:
    """Such a text for one of them."""
    if triple.startswith("x86"):
        return text
    return _DEFINED.sub("", _with_maximum(text.replace(_MARK, SYSTEMS[triple].marks)))


def _machine(triple: str, level: int = 1) -> Any:
    import llvmlite.binding as llvm

    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    system = SYSTEMS[triple]
    return llvm.Target.from_triple(triple).create_target_machine(
        cpu=system.cpu,
        features=system.features,
        opt=level,
        reloc="static" if triple == WASM else "pic",  # its constants have addresses of their own
        codemodel="small",
    )


def _marked(text: str, triple: str) -> str:
    text = _INSTANCE.sub(rf"\1 {_TIGHT}nounwind", text.replace(SELDOM, _SMALL))
    text = text.replace(' nounwind "', f' nounwind {SYSTEMS[triple].marks} "')
    return text if triple.startswith("x86") else _with_maximum(text)


def _with_maximum(text: str) -> str:
    return text.replace(f"call double @{LARGER}(", f"call double @{_MAXIMUM}(")
