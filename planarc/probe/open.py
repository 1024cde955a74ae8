"""A program put together at its start on NumPy's back end, which is there at once.

In:   Program, its text
Out:  Opened    a kernel with parameters, start values and discrete values, nothing solved

A few points are solved, and then the kernel is thrown away: LAPACK is not imported for them.

Example: of a four-bar `open_program(program).start()` closes the loop; then the kernel's Jacobian
of its block tells how many of the conditions are independent.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from planarc.core.data import Data
from planarc.core.options import Backend, RunOptions

if TYPE_CHECKING:
    from planarc.core.arrays import Vector
    from planarc.ir.program import Program
    from planarc.solve.kernels.numpy.kernel import NumpyKernel
    from planarc.solve.start.solve import Start
    from planarc.solve.start.system import System


class Opened(Data):
    """A program put together at its start. `t` is the start time."""

    program: Program
    kernel: NumpyKernel
    t: float

    def start(self, judge: Callable[[System, Vector], None] | None = None) -> Start:
        """The kernel left at consistent start values; see `solve_start`."""
        from planarc.solve.start.solve import solve_start

        return solve_start(self.program, self.kernel, self.t, judge=judge)


def open_program(program: Program, text: str | None = None) -> Opened:
    """The program with its workspace filled. Raises PlanarcError R414 for parameters without
    value."""
    from planarc.codegen.numpy.printer import kernel_source
    from planarc.solve.kernels.numpy.kernel import NumpyKernel
    from planarc.solve.opened import open_program as open_workspace

    kernel = NumpyKernel(program, text or kernel_source(program))
    kernel.expect_few_points()
    request = open_workspace(program, kernel, RunOptions(backend=Backend.NUMPY))
    return Opened(program, kernel, request.start)
