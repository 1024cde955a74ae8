"""CVODE's memory: its context, vectors, callbacks and counters, given back by `close`."""

from __future__ import annotations

import ctypes as C
from collections.abc import Callable, Sequence
from typing import Any

from planarc.solve.solvers.sundials import Sundials, Unavailable

#: The task of `CVode` that comes back after every step.
ONE_STEP = 2


class Session:
    """`memory` is None until `create`; `begun` says whether it is the present run's."""

    def __init__(self, lib: Sundials) -> None:
        self.lib = lib
        self.context, self.memory = C.c_void_p(), C.c_void_p()
        lib.SUNContext_Create(0, C.byref(self.context))
        lib.SUNContext_ClearErrHandlers(self.context)
        self._vectors: list[int] = []
        self._linear = self._matrix = None
        self._raised: BaseException | None = None
        self._of_steps = _places([C.c_long] * 4 + [C.c_int] * 2 + [C.c_double] * 4)
        self._of_systems = _places([C.c_long] * 8)
        self.begun = False

    @property
    def present(self) -> bool:
        return self.memory.value is not None

    def create(self, method: int) -> None:
        self.memory = C.c_void_p(self.lib.CVodeCreate(method, self.context))

    # Vectors

    def vectors(self, count: int, size: int) -> tuple[list[int], list[Any]]:
        """Vectors, and their numbers."""
        made = [self.lib.N_VNew_Serial(size, self.context) for _ in range(count)]
        for vector in made:
            self.lib.N_VEnableFusedOps_Serial(vector, 1)
        self._vectors += made
        return made, [self.numbers(v, size) for v in made]

    def numbers(self, vector: int, size: int) -> Any:
        """The numbers of a vector in place."""
        return (C.c_double * size).from_address(self.lib.N_VGetArrayPointer(vector))

    # Calls

    def call(self, name: str, *arguments: object) -> int:
        """A function of CVODE, by its name without `CVode`."""
        flag: int = getattr(self.lib, "CVode" + name)(self.memory, *arguments)
        return flag

    def check(self, name: str, *arguments: object) -> None:
        """Call a function that must not fail. Raises `Unavailable`."""
        flag = self.call(name, *arguments)
        if flag < 0:
            raise Unavailable(f"CVode{name} of SUNDIALS refused with {flag}")

    def guarded(self, function: Callable[..., int]) -> Callable[..., int]:
        """No exception passes through C: it is kept, and raised by `reraise`."""

        def call(*arguments: object) -> int:
            try:
                return function(*arguments)
            except BaseException as problem:
                self._raised = problem
                return -1

        return call

    def reraise(self) -> None:
        """Raise what a callback has raised."""
        if self._raised is not None:
            problem, self._raised = self._raised, None
            raise problem

    # The linear solver of the corrector

    def eliminate(self, size: int, vector: int) -> None:
        """Solve with a dense matrix."""
        self._matrix = self.lib.SUNDenseMatrix(size, size, self.context)
        self._linear = self.lib.SUNLinSol_Dense(vector, self._matrix, self.context)
        self.check("SetLinearSolver", self._linear, self._matrix)

    def multiply(self, vector: int, kept: int) -> None:
        """Solve by GMRES, with so many vectors kept."""
        self._linear = self.lib.SUNLinSol_SPGMR(vector, 0, kept, self.context)
        self.check("SetLinearSolver", self._linear, None)

    def fill(self, matrix: int, found: Any) -> None:
        """The numbers of a square matrix, which SUNDIALS keeps column by column."""
        import numpy as np

        size = len(found)
        data = self.lib.SUNDenseMatrix_Data(matrix)
        columns = (C.c_double * (size * size)).from_address(data)
        np.ctypeslib.as_array(columns).reshape(size, size)[:] = np.transpose(found)

    def free_linear_solver(self) -> None:
        self.lib.SUNLinSolFree(self._linear)
        if self._matrix is not None:
            self.lib.SUNMatDestroy(self._matrix)
        self._linear = self._matrix = None

    # What it did

    def number(self, name: str) -> int:
        """A counter: `NumSteps` and the like."""
        value = C.c_long()
        self.call(f"Get{name}", C.byref(value))
        return value.value

    def statistics(self) -> tuple[int, int, int, int]:
        """Steps, right-hand sides, Jacobians, and failures of the error test."""
        told, places = self._of_steps
        self.call("GetIntegratorStats", *places)
        solved, places = self._of_systems
        self.call("GetLinSolveStats", *places)
        jacobians, differences = solved[0].value, solved[1].value
        return told[0].value, told[1].value + differences, jacobians, told[3].value

    def last_step(self) -> float:
        """The length of the last step, in seconds; 0 before there was one."""
        step = C.c_double()
        if self.begun:
            self.call("GetLastStep", C.byref(step))
        return step.value

    def errors(self, size: int) -> Sequence[float]:
        """The error of each unknown in the last step tried, as a part of its tolerance."""
        if not self.begun:
            return ()
        own = [self.lib.N_VNew_Serial(size, self.context) for _ in range(2)]
        self.call("GetEstLocalErrors", own[0])
        self.call("GetErrWeights", own[1])
        errors, weights = (list(self.numbers(v, size)) for v in own)
        for vector in own:
            self.lib.N_VDestroy(vector)
        return [e * w for e, w in zip(errors, weights, strict=True)]

    # The end

    def close(self) -> None:
        if self.present:
            self.lib.CVodeFree(C.byref(self.memory))
            self.free_linear_solver()
            self.memory = C.c_void_p()
        for vector in self._vectors:
            self.lib.N_VDestroy(vector)
        self._vectors = []
        if self.context.value is not None:
            self.lib.SUNContext_Free(C.byref(self.context))


def _places(kinds: Sequence[Any]) -> tuple[list[Any], list[int]]:
    """Numbers that a function writes, and their addresses."""
    numbers = [kind() for kind in kinds]
    return numbers, [C.addressof(number) for number in numbers]
