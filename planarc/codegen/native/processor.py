"""The processor that code is made for, and what tells its kind.

Apart from `machine`, because whoever looks for code that was made before needs `key` and
none of the printers. Where planarc places code itself, neither does it need LLVM, whose import
is a tenth of a short run.
"""

from __future__ import annotations

from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

from planarc.runtime.link import PLACES

#: Lines of Linux about a processor that say what it can run, and of which kind it is.
_TELLING: Final = ("vendor_id", "cpu family", "model", "stepping", "flags")


@cache
def key() -> str:
    """The dependences of object code besides the model: processor, system, version of LLVM."""
    if PLACES:
        with suppress(OSError):
            return f"{_kind()} {_state_of_llvm()}"
    return " ".join(_as_llvm_says())


def _kind() -> str:
    """The first processor, as the system knows it."""
    first, _, _ = Path("/proc/cpuinfo").read_text("utf-8", "replace").partition("\n\n")
    return "\n".join(line for line in first.splitlines() if line.startswith(_TELLING))


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
