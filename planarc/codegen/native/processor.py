"""The processor that code is made for, and what tells its kind.

Apart from `machine`, because whoever looks for code that was made before needs `key` and
none of the printers. Where planarc places code itself, neither does it need LLVM, whose import
is a tenth of a short run.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

from planarc.runtime.link import PLACES
from planarc.runtime.link.memory import put

#: Lines of Linux about a processor that say what it can run, and of which kind it is.
_TELLING: Final = ("vendor_id", "cpu family", "model", "stepping", "flags")
#: Of the answers to CPUID, the bit that tells of rounding a*b + c once: which answer, which bit.
FUSING: Final = 1, 12
#: void f(leaf, part, registers): the instruction CPUID, its answer eax, ebx, ecx, edx in memory.
_CPUID: Final = bytes.fromhex(
    "53 49 89 d0 89 f8 89 f1 0f a2"  # push rbx; mov r8, rdx; mov eax, edi; mov ecx, esi; cpuid
    "41 89 00 41 89 58 04 41 89 48 08 41 89 50 0c"  # mov [r8], eax; ...
    "5b c3"  # pop rbx; ret
)


@cache
def key() -> str:
    """The dependences of object code besides the model: processor, system, version of LLVM."""
    if PLACES:
        with suppress(OSError):
            return f"{_kind()} {_state_of_llvm()}"
    return " ".join(_as_llvm_says())


@cache
def fuses() -> bool:
    """Whether this processor rounds a*b + c once; others need a function for that."""
    if PLACES:
        with suppress(OSError):
            knows = any("fma" in line.split() for line in _told() if line.startswith("flags"))
            answer, bit = FUSING
            return knows and bool([*_asked()][answer] >> bit & 1)
    import llvmlite.binding as llvm

    arm = llvm.get_process_triple().startswith(("aarch64", "arm64"))  # all of which do
    return arm or "+fma" in _features().split(",")


def _kind() -> str:
    """The first processor as the system knows it, and what this process may use of it: emulators
    such as Valgrind's know fewer instructions."""
    return "\n".join((*_told(), *map(str, _asked())))


def _told() -> list[str]:
    first, _, _ = Path("/proc/cpuinfo").read_text("utf-8", "replace").partition("\n\n")
    return [line for line in first.splitlines() if line.startswith(_TELLING)]


def _asked() -> Iterator[int]:
    """What the processor answers about its instructions."""
    memory, start = put(_CPUID)
    ask = ctypes.CFUNCTYPE(None, ctypes.c_uint32, ctypes.c_uint32, ctypes.c_void_p)(start)
    registers = (ctypes.c_uint32 * 4)()
    for leaf, part in ((1, 0), (7, 0), (7, 1), (0x80000001, 0)):
        ask(leaf, part, ctypes.addressof(registers))
        found = registers[:]
        yield from (found[0], *found[2:]) if leaf == 1 else found  # there ebx numbers the core
    del memory  # not before


def _state_of_llvm() -> str:
    """Changes with the installed LLVM."""
    found = find_spec("llvmlite")
    places = found.submodule_search_locations if found else None
    library = Path(*places or (), "binding", "libllvmlite.so").stat()
    return f"{library.st_size} {library.st_mtime_ns}"


def _as_llvm_says() -> tuple[str, ...]:
    import llvmlite
    import llvmlite.binding as llvm

    version = ".".join(map(str, llvm.llvm_version_info))
    processor = llvm.get_process_triple(), llvm.get_host_cpu_name(), _features()
    return (*processor, version, llvmlite.__version__)


@cache
def target_machine(level: int) -> Any:
    """The machine that makes code for this processor, at one of LLVM's levels of optimisation."""
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target = llvm.Target.from_triple(llvm.get_process_triple())
    return target.create_target_machine(
        cpu=llvm.get_host_cpu_name(),
        features=_features(),
        opt=level,
        reloc="pic" if PLACES else "default",
        codemodel="small" if PLACES else "jitdefault",
        jit=not PLACES,
    )


def _features() -> str:
    import llvmlite.binding as llvm

    features: str = llvm.get_host_cpu_features().flatten()
    return features
