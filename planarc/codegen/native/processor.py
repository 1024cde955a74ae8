"""The processor that code is made for, as LLVM knows it.

Apart from `machine`, because whoever looks for code that was made before needs `key` and
none of the printers.
"""

from __future__ import annotations

from functools import cache
from typing import Any


@cache
def key() -> str:
    """The dependences of object code besides the model: processor, system, version of LLVM."""
    import llvmlite
    import llvmlite.binding as llvm

    version = ".".join(map(str, llvm.llvm_version_info))
    parts = (llvm.get_process_triple(), llvm.get_host_cpu_name(), _features(), version)
    return " ".join((*parts, llvmlite.__version__))


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
        reloc="default",
        codemodel="jitdefault",
        jit=True,
    )


def _features() -> str:
    import llvmlite.binding as llvm

    features: str = llvm.get_host_cpu_features().flatten()
    return features
