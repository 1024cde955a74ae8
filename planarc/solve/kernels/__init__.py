"""Loaded programs: what `codegen` printed, made callable (`planarc.ir.program.Kernel`)."""

from __future__ import annotations

from planarc.ir.program import Kernel, Program


def load(program: Program, code: str | bytes) -> Kernel:
    """A kernel with a workspace of its own, from NumPy source text or native object code.

    Loading the same code again is cheap: compiled text and linked objects are kept.
    """
    if isinstance(code, str):
        from planarc.solve.kernels.numpy_kernel import NumpyKernel

        return NumpyKernel(program, code)
    from planarc.solve.kernels.native_kernel import NativeKernel

    return NativeKernel(program, code)
