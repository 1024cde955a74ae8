"""The zero functions of relations as an integrator sees them."""

from __future__ import annotations

from collections.abc import MutableSequence, Sequence

from planarc.ir.kernel import Kernel


class Zeros:
    """The kernel's zero functions, each moved by its shift: what is nothing but noise lies on its
    side of zero then, and is no crossing (`Crossings.shifts`). No shifts: as they are."""

    def __init__(self, kernel: Kernel) -> None:
        self._kernel = kernel
        self.shifts: Sequence[float] = ()

    def roots(self, t: float, y: Sequence[float], g: MutableSequence[float]) -> int:
        """The kernel's flag; `g` are the zero functions there."""
        flag = self._kernel.roots(t, y, g)
        for i, shift in enumerate(self.shifts):
            g[i] += shift
        return flag
