"""A compiled model: a program with its code for one back end, and the code of its derivatives.

The code of derivatives is made when it is first asked for, by a solver that pays for it, by
`linearize` or by `sensitivities`: most runs never do.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from msgspec import field

from planarc.core.data import Data, without_collection
from planarc.core.diagnostic import Diagnostic
from planarc.core.options import Backend
from planarc.remembered import Remembered, recall_slopes, remember_slopes
from planarc.stages import to_code, to_lead, to_slopes

if TYPE_CHECKING:
    from collections.abc import Callable, MutableSequence

    from planarc.core.clock import Clock
    from planarc.ir.dae import Dae
    from planarc.ir.derivatives import Scope
    from planarc.ir.flat import FlatModel
    from planarc.ir.kernel import Kernel, Reacting
    from planarc.ir.program import Program


class Compiled(Data):
    """A program and its code, ready to be loaded any number of times."""

    program: Program
    backend: Backend
    code: str | bytes  # NumPy source, or a native object file
    warnings: tuple[Diagnostic, ...] = ()
    remembered: bool = False  # True when it came from the cache
    lead: Compiled | None = None  # what leads to its start, where it has a simplified form
    _slopes: dict[Scope, str | bytes | None] = field(default_factory=dict)
    beside: dict[str, Any] = field(default_factory=dict)  # what rooms above make of it once

    @classmethod
    def of(
        cls,
        program: Program,
        backend: Backend,
        clock: Clock | None = None,
        warnings: tuple[Diagnostic, ...] = (),
        lead: Compiled | None = None,
    ) -> Compiled:
        """A program with its code."""
        return cls(program, backend, to_code(program, backend, clock), warnings, lead=lead)

    @classmethod
    def recalled(cls, known: Remembered, backend: Backend) -> Compiled:
        """What an earlier process compiled."""
        lead = None if known.lead is None else cls.recalled(known.lead, backend)
        return cls(known.program, backend, known.code, known.warnings, True, lead)

    def as_remembered(self) -> Remembered:
        """What a later process needs of it."""
        lead = None if self.lead is None else self.lead.as_remembered()
        return Remembered(self.program, self.code, self.warnings, lead)

    def load(self) -> Kernel:
        """A kernel with a workspace of its own."""
        from planarc.solve.kernels import load

        lead = self.lead
        way = None if lead is None else lambda: (lead.program, lead.load())
        return load(self.program, self.code, self.slopes, way, _reactor)

    def parameters(self) -> MutableSequence[float]:
        """A workspace with the values of parameters."""
        kernel = self.load()
        kernel.parameters()
        return kernel.w

    def slopes(self, scope: Scope) -> str | bytes | None:
        """The code of derivatives; None where the model calls a function that has none."""
        if scope not in self._slopes:
            self._slopes[scope] = self._find_slopes(scope)
        return self._slopes[scope]

    def _find_slopes(self, scope: Scope) -> str | bytes | None:
        known = recall_slopes(self.program, self.code, scope)
        if known is None:
            with without_collection():
                made = to_slopes(self.program, self.backend, scope) or b""
            known = made.encode() if isinstance(made, str) else made
            remember_slopes(self.program, self.code, scope, known)
        return (known if self.backend is Backend.NATIVE else known.decode()) or None


def _reactor(program: Program, frame: Any, call: Callable[..., int]) -> Reacting:
    """What iterates a kernel's events, or makes its steps, in machine code."""
    from planarc.instance.plan import crowd_names
    from planarc.ir.kernel import Reacting

    if crowd_names(program):
        from planarc.instance.crowd.stepper import Stepper

        return Reacting(steps=Stepper(program, frame, call))
    from planarc.instance.reactor import Reactor

    return Reacting(Reactor(program, frame, call))


def find_lead(
    model: FlatModel, dae: Dae, backend: Backend, clock: Clock | None = None
) -> Compiled | None:
    """What leads to the start of a model that has simplified forms (`homotopy`)."""
    program = to_lead(model, clock) if dae.simplified else None
    return None if program is None else Compiled.of(program, backend, clock)
