"""What a compiled model is: the request, the code for back ends, and what the program declares.

    model = planarc.load("four_bar.pmo")
    model.parameters["crankBody.m"].value

It is compiled once for each back end, and can be pickled.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from planarc.api.inputs import input_names, sort_inputs
from planarc.api.variables import Names, Parameter, parameters_of
from planarc.api.variant import named_like
from planarc.compiled import Compiled
from planarc.compiler import compile_model
from planarc.core.diagnostic import Diagnostic
from planarc.core.options import Backend, RunOptions
from planarc.core.prose import counted
from planarc.ir.kernel import Kernel
from planarc.ir.program import Program
from planarc.request.request import Request
from planarc.solve.kept import Shelf
from planarc.solve.settings import resolve
from planarc.stages import to_code

if TYPE_CHECKING:
    from planarc.api.signals import Signal


class Loaded:
    """A compiled model before it runs: its names, its code, and kernels to run it with."""

    def __init__(
        self, request: Request, backend: Backend, compiled: Compiled | None = None
    ) -> None:
        self.request, self.backend = request, backend
        self._compiled = {backend: compiled or compile_model(request, backend)}
        self._shelves: dict[Backend, tuple[Compiled, Shelf]] = {}

    def __repr__(self) -> str:
        p = self.program
        states = counted(p.state_count, "state")
        return f"<Model {p.name}: {counted(p.equations_before, 'equation')}, {states}>"

    def __getstate__(self) -> dict[str, Any]:
        from planarc.ir.store import dumps

        program, lead = self.program, self.compiled().lead
        codes = {b: (c.code, c.lead and c.lead.code) for b, c in self._compiled.items()}
        leading = None if lead is None else dumps(lead.program, lead.program.table)
        return {"request": self.request, "backend": self.backend, "warnings": self.warnings,
                "program": dumps(program, program.table), "lead": leading,
                "codes": codes}  # fmt: skip

    def __setstate__(self, state: dict[str, Any]) -> None:
        from planarc.ir.store import loads

        self.request, self.backend = state["request"], state["backend"]
        program, lead = loads(state["program"]), state["lead"] and loads(state["lead"])
        self._compiled = {
            b: Compiled(program, b, code, state["warnings"], lead=lead and Compiled(lead, b, way))
            for b, (code, way) in state["codes"].items()
        }
        self._shelves = {}

    def _repr_html_(self) -> str:
        from html import escape

        p = self.program
        about = f"{p.name}: {p.description}" if p.description else p.name
        counts = f"{counted(p.equations_before, 'equation')}, {counted(p.state_count, 'state')}"
        return f"<p><b>{escape(about)}</b><br>{counts}</p>{self.parameters._repr_html_()}"

    @property
    def program(self) -> Program:
        """The equations as they are compiled: slots, blocks, candidates for states."""
        return self.compiled().program

    @property
    def name(self) -> str:
        """The full name of the class."""
        return self.program.name

    @property
    def description(self) -> str:
        """The text behind the name of the class, empty where there is none."""
        return self.program.description

    @property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """What the compiler warned of."""
        return self.compiled().warnings

    @property
    def parameters(self) -> Names[Parameter]:
        """The parameters by their names, an array's elements one by one, in SI units.

        Each has `value` (the default), `unit`, `description`, `settable`, `structural`, `kind` and
        `literals`. A name that is not there raises UnknownName.
        """
        kernel = self.compiled().load()
        kernel.parameters()
        return Names("parameter", parameters_of(self.program, kernel))

    @property
    def inputs(self) -> tuple[str, ...]:
        """The names of the inputs, which `simulate(inputs=...)` takes."""
        return input_names(self.program)

    @property
    def outputs(self) -> tuple[str, ...]:
        """The names of the outputs."""
        return self.program.outputs

    # Its code

    def compiled(self, backend: Backend | None = None) -> Compiled:
        """The code for a back end, made when it is first asked for."""
        backend = backend or self.backend
        if backend not in self._compiled:
            known = next(iter(self._compiled.values()))
            code = to_code(known.program, backend)
            lead = None if known.lead is None else Compiled.of(known.lead.program, backend)
            self._compiled[backend] = replace(known, backend=backend, code=code, lead=lead)
        return self._compiled[backend]

    def shelf(self, compiled: Compiled) -> Shelf:
        """The kernels at rest of earlier runs of this code."""
        known = self._shelves.get(compiled.backend)
        if known is None or known[0] is not compiled:
            known = self._shelves[compiled.backend] = compiled, Shelf()
        return known[1]

    def sorted_inputs(
        self, options: RunOptions, inputs: Mapping[str, Signal] | None
    ) -> tuple[RunOptions, dict[str, Signal]]:
        """Options with the values of inputs that are held in a run, and the signals of others."""
        held, signals = sort_inputs(self.program, inputs)
        return replace(options, starts={**options.starts, **held}) if held else options, signals

    def forced(self, kernel: Kernel, options: RunOptions, inputs: Mapping[str, Signal]) -> Kernel:
        """The kernel with inputs that follow signals."""
        if not inputs:
            return kernel
        from planarc.api.signals import ForcedKernel, read_corners, read_signals

        program, asked = self.program, resolve(self.program, options)
        signals = read_signals(inputs, program.inputs, asked.stop - asked.start)
        slots = [(program.slots[name], f) for name, f in signals.items()]
        own = asked.fixed_step is not None  # such steps look at functions when they were told to
        bends = read_corners(inputs, asked.grid[:0] if own else asked.grid)
        return ForcedKernel(kernel, lambda t: {k: f(t) for k, f in slots}, asked.start, bends)

    def take_name(self, of: Program, changed: Collection[str] = ()) -> None:
        """Be called as another model, of which this is a variant with other values of some
        parameters."""
        for backend, compiled in self._compiled.items():
            program = named_like(compiled.program, of, changed)
            self._compiled[backend] = replace(compiled, program=program)
