"""Functions in LLVM's text, compiled for a test."""

from __future__ import annotations

from typing import Any

import llvmlite.binding as llvm


def compiled(*texts: str) -> Any:
    """An engine that tells their addresses, as long as it is kept."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    text = "".join(("declare double @llvm.fabs.f64(double)\n", *texts))
    machine = llvm.Target.from_default_triple().create_target_machine(opt=1, jit=True)
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(text), machine)
    engine.finalize_object()
    return engine
