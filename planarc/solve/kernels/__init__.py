"""Loaded programs: what `codegen` printed, made callable (`planarc.ir.kernel.Kernel`)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from planarc.ir.kernel import Kernel, Lead, ReactorMaker
from planarc.ir.program import Program

if TYPE_CHECKING:
    from planarc.ir.derivatives import Scope


def load(
    program: Program,
    code: str | bytes,
    slopes: Callable[[Scope], str | bytes | None] | None = None,
    lead: Lead | None = None,
    reactor: ReactorMaker | None = None,
) -> Kernel:
    """A kernel with a workspace of its own, from NumPy source text or native object code.

    Loading the same code again is cheap: compiled text and linked objects are kept. `slopes`
    gives the code of derivatives when it is asked for; without it the kernel has none.
    `lead` loads the program that leads to a start; `reactor` makes what iterates events in machine
    code.
    """
    if isinstance(code, str):
        from planarc.solve.kernels.numpy.kernel import NumpyKernel

        return NumpyKernel(program, code, slopes, lead)
    from planarc.solve.kernels.native.kernel import NativeKernel

    return NativeKernel(program, code, slopes, lead, reactor)
