"""The zero functions of relations as an integrator sees them."""

from __future__ import annotations

from collections.abc import MutableSequence, Sequence
from typing import TYPE_CHECKING

from planarc.ir.kernel import Kernel

if TYPE_CHECKING:
    from planarc.core.arrays import Array, Vector


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

    def values(self, slots: Array) -> Vector:
        """What the workspace holds of the point evaluated last."""
        from planarc.core.arrays import taken

        return taken(self._kernel.w, slots)
