"""A kernel's functions as CVODE calls them, where they are not machine code."""

from __future__ import annotations

import ctypes as C
from collections.abc import Callable, Sequence
from typing import Any

from planarc.ir.kernel import Formulas, Kernel
from planarc.ir.newton import DIFFERENCE
from planarc.runtime.differences import one_sided
from planarc.solve.solvers.session import Session
from planarc.solve.solvers.zeros import Zeros

_RHS = C.CFUNCTYPE(C.c_int, C.c_double, C.c_void_p, C.c_void_p, C.c_void_p)
_JACOBIAN = C.CFUNCTYPE(C.c_int, C.c_double, *(C.c_void_p,) * 7)
_ROOTS = C.CFUNCTYPE(C.c_int, C.c_double, *(C.c_void_p,) * 3)


class Callbacks:
    """`flag` is the kernel's of the last right-hand side, `zeros` are its last zero functions;
    `absolute` are the tolerances; a point that `is_far` is refused, for a shorter step."""

    def __init__(
        self,
        session: Session,
        kernel: Kernel,
        size: int,
        absolute: Any,
        is_far: Callable[[], bool],
    ) -> None:
        self._session, self._kernel, self._is_far = session, kernel, is_far
        self._absolute = absolute
        self._numbers = _viewer(session, size)
        self.flag = 0
        self.zeros: Sequence[float] = ()

    def rhs(self) -> Any:
        kernel, numbers = self._kernel, self._numbers

        def rhs(t: float, y: int, ydot: int, _: object) -> int:
            flag = kernel.rhs(t, numbers(y), numbers(ydot))
            if flag == 0 and self._is_far():
                flag = 1
            self.flag = flag
            return abs(flag)  # positive: CVODE tries a shorter step, up to what has no value

        return _RHS(self._session.guarded(rhs))

    def roots(self, zeros: Zeros, relations: int) -> Any:
        numbers, values = self._numbers, C.c_double * relations

        def roots(t: float, y: int, g: int, _: object) -> int:
            found: Any = values.from_address(g)
            flag = zeros.roots(t, numbers(y), found)
            self.zeros = found[:]
            return flag

        return _ROOTS(self._session.guarded(roots))

    def jacobian(self, formulas: Formulas) -> Any:
        """The Jacobian from formulas, or by differences where a function has no derivative, or a
        mode is singular."""

        def jacobian(t: float, y: int, f: int, matrix: int, *_: object) -> int:
            states = list(self._numbers(y))
            found = formulas.state_jacobian(t, states)
            if found is None:
                found = _differences(self._kernel, t, states, list(self._absolute))
            if found is None:
                return 1
            self._session.fill(matrix, found)
            return 0

        return _JACOBIAN(self._session.guarded(jacobian))


def _viewer(session: Session, size: int) -> Callable[[int], Any]:
    """The numbers of a vector in place, looked up once for each."""
    pointer = session.lib.N_VGetArrayPointer
    seen: dict[int, Any] = {}

    def numbers(vector: int) -> Any:
        address = pointer(vector)
        if address not in seen:
            seen[address] = (C.c_double * size).from_address(address)
        return seen[address]

    return numbers


def _differences(kernel: Kernel, t: float, y: list[float], absolute: Sequence[float]) -> Any:
    """The Jacobian by forward differences, a row for each derivative; None where there is none."""

    def rhs(at: Any) -> list[float] | None:
        there = [0.0] * len(y)
        return there if kernel.rhs(t, at.tolist(), there) == 0 else None

    steps = [DIFFERENCE * max(abs(v), 1e3 * a) for v, a in zip(y, absolute, strict=True)]
    return one_sided(rhs, y, steps)
