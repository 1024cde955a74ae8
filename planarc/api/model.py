"""A compiled model, as a user holds it in Python.

    model = planarc.load("four_bar.pmo")
    model.parameters["crankBody.m"].value
    result = model.simulate(stop_time=10, parameters={"crankBody.m": 2})

It is compiled once; runs with other parameters and start values use the same code, and
each has a workspace of its own, so that several threads may share one model. No result
is ever kept.

The file is long because it is one class: the signatures and docstrings of all that a user may
ask.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from planarc.api.result import Result, RunStopped
from planarc.api.values import Value, by_name, finite, parameter_values, run_options, start_values
from planarc.api.variables import Names, Parameter, Variable, parameters_of, variables_of
from planarc.api.variant import named_like, texts_of, variant_of
from planarc.compiled import Compiled
from planarc.compiler import compile_model, run
from planarc.core.diagnostic import Diagnostic, PlanarcError, Severity, usage_error
from planarc.core.options import Backend, Redundant, RunOptions, Solver, fastest_backend
from planarc.core.prose import be, both, counted
from planarc.core.unknown import refuse_unknown, telling_keywords, unknown_name
from planarc.ir.kernel import Kernel
from planarc.ir.program import Program
from planarc.request.request import Request, names_class
from planarc.stages import to_code

if TYPE_CHECKING:
    from planarc.api.analysis.assemble import Assembly
    from planarc.api.analysis.drive import Driven
    from planarc.api.analysis.equilibrium import Equilibrium
    from planarc.api.analysis.linearize import Linearization
    from planarc.api.analysis.rhs import Rhs
    from planarc.api.analysis.sensitivity import Sensitivities
    from planarc.api.analysis.starting import Place
    from planarc.api.analysis.stepper import Stepper
    from planarc.api.signals import Signal

_TEXT = re.compile(r"[\n;]")
#: Endings of files that planarc writes, and that hold no model.
_RESULTS = (".csv", ".mat", ".html")


class Recompiled(UserWarning):
    """A structural parameter was changed, so the model was compiled again."""


def recompiled(names: Collection[str]) -> str:
    """The remark that some parameters are structural."""
    return f"{both(names)} {be(len(names))} structural: the model is compiled again"


@telling_keywords
def load(
    source: str | Path,
    class_name: str | None = None,
    *,
    libraries: Sequence[str | Path] = (),
    backend: str | None = None,
    redundant: str | Redundant = Redundant.REFUSE,
) -> Model:
    """A model from a file, a class of a library (`PlanarMultiBody.Examples...`), or a text.

    `class_name` names the class in a file or text that holds several; `libraries` are folders to
    look in first; `backend` is `native` or `numpy` (by default native where llvmlite is installed).
    `redundant="accept"`: joints may hold the same motion more than once, as a third parallel bar
    does; of their forces, in N and N.m at all frames of all joints, those of least squares are
    taken.

    Raises UsageError (C206) where nothing of the kind is there, and PlanarcError with all
    diagnostics when the model is wrong.
    """
    if not isinstance(class_name, str | None):
        raise usage_error("C202", f"the name of a class is a text, not {class_name!r}")
    given = (libraries,) if isinstance(libraries, str | Path) else libraries
    if not isinstance(given, Iterable) or not all(isinstance(p, str | Path) for p in given):
        raise usage_error("C202", f"`libraries` takes folders, not {libraries!r}")
    folders = tuple(Path(p) for p in given)
    if isinstance(source, Path):
        request = Request(source, class_name, folders)
    elif not isinstance(source, str):
        raise usage_error(
            "C206", f"a model is a file, a class or a text, not {type(source).__name__}"
        )
    elif not source.strip():
        raise usage_error("C206", "a model is a file, a class or a text, not nothing")
    elif _TEXT.search(source):
        request = Request(None, class_name, folders, text=source)
    elif class_name is None and names_class(source):
        request = Request(None, source, folders)
    else:
        request = Request(Path(source), class_name, folders)
    if request.file is not None and request.file.suffix.lower() in _RESULTS:
        raise usage_error(
            "C206",
            f"`{request.file}` is a result, not a model",
            hint=f"`planarc view {request.file}` shows it; load the model that made it",
        )
    return Model(replace(request, redundant=_treatment(redundant)), _backend(backend))


class Model:
    """A compiled model, as `planarc.load` gives it.

        model = planarc.load("four_bar.pmo")
        model.parameters["crankBody.m"].value
        result = model.simulate(10, parameters={"crankBody.m": 2}, start={"revA.phi": "45deg"})

    It is compiled once. Runs with other parameters and start values use the same code, and each
    has a workspace of its own, so that several threads may share one model. It can be pickled.
    `simulate` runs it; `equilibrium`, `assemble`, `linearize`, `drive` and `sensitivities` analyse
    it. A notebook shows its parameters.
    """

    def __init__(
        self, request: Request, backend: Backend, compiled: Compiled | None = None
    ) -> None:
        self.request, self.backend = request, backend
        self._compiled = {backend: compiled or compile_model(request, backend)}
        self._variants: dict[tuple[tuple[str, float], ...], Model] = {}
        self._variables: dict[str, Variable] | None = None
        self._driven: dict[tuple[object, ...], tuple[Compiled, dict[str, str]]] = {}
        self._otherwise: Model | None = None  # redundant joints treated in the other way

    def __repr__(self) -> str:
        p = self.program
        return f"<Model {p.name}: {p.equations_before} equations, {p.state_count} states>"

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
        self._variants, self._variables, self._driven, self._otherwise = {}, None, {}, None

    # What it has

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
    def variables(self) -> Names[Variable]:
        """All variables that are no parameters, in SI units.

        Each has `start` (None where it follows from others), `value` (at the start of a run with
        default values), `unit`, `description` and `kind`.
        """
        if self._variables is None:
            self._variables = self._find_variables()
        return Names("variable", self._variables)

    @property
    def states(self) -> Names[Variable]:
        """The variables that may be states: which of them are is chosen while running."""
        known = self.variables
        shown = (c.display for c in self.program.candidates)
        return Names("state", {n: known[n] for n in shown if n in known})

    @property
    def inputs(self) -> tuple[str, ...]:
        """The names of the inputs, which `simulate(inputs=...)` takes."""
        return self.program.inputs

    @property
    def outputs(self) -> tuple[str, ...]:
        """The names of the outputs."""
        return self.program.outputs

    def _find_variables(self) -> dict[str, Variable]:
        from planarc.api.analysis.point import open_point

        try:
            kernel, started = open_point(self, RunOptions(backend=self.backend)).kernel, True
        except PlanarcError:
            kernel, started = self.compiled().load(), False
            kernel.parameters()
        return variables_of(self.program, kernel, started)

    # Runs

    @telling_keywords
    def simulate(
        self,
        stop_time: float | None = None,
        *,
        start_time: float | None = None,
        tolerance: float | None = None,
        intervals: int | None = None,
        interval: float | None = None,
        parameters: Mapping[str, Value] | None = None,
        start: Mapping[str, Value] | None = None,
        start_from: Place | None = None,
        inputs: Mapping[str, Signal] | None = None,
        solver: str | Solver = Solver.AUTO,
        fixed_step: float | None = None,
        backend: str | Backend | None = None,
        redundant: str | Redundant | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Result:
        """Run the model; what is not given is as the model's experiment annotation says.

        Times are in s; `tolerance` is the relative error of a step. The result has a row at every
        `interval` (s), or `intervals` + 1 of them, and two at each event. `parameters` and `start`
        set values by name (SI units; an array takes a sequence). `start_from` takes all others from
        `"equilibrium"`, `"assembly 2"` (as `assemble` lists them, from 1), or the last row of a
        Result or of a file. `inputs` are numbers, functions of time or tables; what the model needs
        of their derivatives follows, or is given as `der(u)`.
        `solver` is one of `auto`, `cvode-bdf`, `cvode-adams`, `lsoda`, `scipy-bdf` and, with a
        `fixed_step` (s), `euler` and `rk4`. `redundant`: see `planarc.load`; by default as the
        model was loaded. `progress` is called with the time that is reached.

        Raises UnknownName for a name that is not there, UsageError for a wrong request,
        PlanarcError where there is no start, RunStopped (with the `result` so far) where the run
        fails. Warns Recompiled where a parameter is structural.
        """
        if progress is not None and not callable(progress):
            raise usage_error(
                "C202", f"`progress` takes a function of time, not `{progress!r:.40}`"
            )
        times = start_time, stop_time, tolerance, intervals
        model, options = self.asked(parameters, start, *times)
        options = replace(
            options,
            backend=self.backend if backend is None else _backend(backend),
            interval=None if interval is None else finite("interval", interval, "s"),
            solver=_choice(Solver, "solver", solver),
            fixed_step=None if fixed_step is None else finite("fixed_step", fixed_step, "s"),
            redundant=None if redundant is None else _treatment(redundant),
        )
        if start_from is not None:
            from planarc.api.analysis.starting import starts_from

            options = replace(options, starts=starts_from(model, options, start_from, inputs))
        return model.run(options, inputs, progress)

    @telling_keywords
    def stepper(
        self,
        step: float = 0.01,
        *,
        stop_time: float | None = None,
        start_time: float | None = None,
        tolerance: float | None = None,
        parameters: Mapping[str, Value] | None = None,
        start: Mapping[str, Value] | None = None,
        start_from: Place | None = None,
        solver: str | Solver = Solver.AUTO,
        fixed_step: float | None = None,
        backend: str | Backend | None = None,
    ) -> Stepper:
        """A run that goes on step by step: set inputs, step, read. For controllers and learning.

        `step` is its length in s; the integrator takes as many steps within it as the tolerance
        asks for, and events happen at their instants. It ends at `stop_time`, by default as the
        model's experiment says. All else is as for `simulate`.

        Raises what `simulate` raises where there is no start, UsageError C216 for a wrong `step`.
        """
        from planarc.api.analysis.stepper import open_stepper

        model, options = self.asked(parameters, start, start_time, stop_time, tolerance, None)
        options = replace(
            options,
            intervals=1,
            backend=self.backend if backend is None else _backend(backend),
            solver=_choice(Solver, "solver", solver),
            fixed_step=None if fixed_step is None else finite("fixed_step", fixed_step, "s"),
        )
        if start_from is not None:
            from planarc.api.analysis.starting import starts_from

            options = replace(options, starts=starts_from(model, options, start_from))
        return open_stepper(model, options, step)

    def asked(
        self,
        parameters: Mapping[str, Value] | None,
        start: Mapping[str, Value] | None,
        *times: float | None,
    ) -> tuple[Model, RunOptions]:
        """The model to run, and its options; `times` are start, stop, tolerance, intervals."""
        model, settable = self.with_parameters(parameters)
        starts = start_values(model.program, start)
        given = times or (None, None, None, None)
        return model, run_options(self.backend, *given, values=settable, starts=starts)

    def run(
        self,
        options: RunOptions,
        inputs: Mapping[str, Signal] | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Result:
        """Run the model, as `simulate` does, with options that were checked already."""
        if not isinstance(options, RunOptions):
            hint = "`simulate(stop_time=...)` runs the model"
            raise usage_error("C202", f"`run` takes RunOptions, not `{options!r:.40}`", hint=hint)
        if options.redundant not in (None, self.request.redundant):
            return self._with_redundant(options.redundant).run(options, inputs, progress)
        compiled = self.compiled(options.backend)
        kernel = self.forced(compiled.load(), options, inputs)
        rows = run(compiled, options, progress=progress, kernel=kernel)
        result = Result(rows, compiled, self.request)
        ended = result.ended
        if ended is not None and ended.severity is Severity.ERROR:
            raise RunStopped(ended, result)
        return result

    def _with_redundant(self, choice: Redundant) -> Model:
        if self._otherwise is None:
            self._otherwise = Model(replace(self.request, redundant=choice), self.backend)
            self._otherwise.take_name(self.program)
        return self._otherwise

    def forced(
        self, kernel: Kernel, options: RunOptions, inputs: Mapping[str, Signal] | None
    ) -> Kernel:
        """The kernel with inputs that follow what is given."""
        if not inputs:
            return kernel
        from planarc.api.signals import ForcedKernel, read_signals

        program, inputs = self.program, by_name(inputs)
        refuse_unknown("input", inputs, program.inputs)
        begin = program.experiment.start if options.start is None else options.start
        stop = program.experiment.stop if options.stop is None else options.stop
        signals = read_signals(inputs, program.inputs, stop - begin)
        slots = [(program.slots[name], f) for name, f in signals.items()]
        return ForcedKernel(kernel, lambda t: {k: f(t) for k, f in slots}, begin)

    def compiled(self, backend: Backend | None = None) -> Compiled:
        """The code for a back end, made when it is first asked for."""
        backend = backend or self.backend
        if backend not in self._compiled:
            known = next(iter(self._compiled.values()))
            code = to_code(known.program, backend)
            lead = None if known.lead is None else Compiled.of(known.lead.program, backend)
            self._compiled[backend] = replace(known, backend=backend, code=code, lead=lead)
        return self._compiled[backend]

    def with_parameters(
        self, parameters: Mapping[str, Value] | None
    ) -> tuple[Model, dict[str, float]]:
        """The model to run, and values to set. Structural ones make another model."""
        values = parameter_values(self.program, parameters)
        structural = {p.name: p for p in self.program.parameter_slots if p.structural}
        changed = {n: v for n, v in values.items() if n in structural}
        if not changed:
            return self, values
        kernel = self.compiled().load()
        kernel.parameters()
        changed = {n: v for n, v in changed.items() if kernel.w[structural[n].slot] != v}
        rest = {n: v for n, v in values.items() if n not in structural}
        if not changed:
            return self, rest
        key = tuple(sorted(changed.items()))
        if key not in self._variants:
            texts = texts_of(self.request, self.program, changed, self.backend)
            warnings.warn(recompiled(changed), Recompiled, stacklevel=4)
            self._variants[key] = self.variant(texts)
        return self._variants[key], rest

    def variant(self, values: Mapping[str, str], declarations: str = "") -> Model:
        """This model with some values as Modelica text, compiled anew."""
        model = Model(variant_of(self.request, values, declarations), self.backend)
        model.take_name(self.program)
        return model

    def take_name(self, of: Program) -> None:
        """Be called as another model, of which this is a variant."""
        for backend, compiled in self._compiled.items():
            self._compiled[backend] = replace(compiled, program=named_like(compiled.program, of))

    # Analyses

    @telling_keywords
    def rhs(
        self,
        *,
        parameters: Mapping[str, Value] | None = None,
        start: Mapping[str, Value] | None = None,
        start_time: float | None = None,
    ) -> Rhs:
        """The equations as a function: `f(t, x, u)` gives the derivatives of `f.states`.

        `f.x0` are the states at the start; `f.jacobian` gives df/dx and df/du, `f.outputs` other
        variables. For integrators, optimisers and observers of other packages; events are theirs to
        find (`f.settle`). Raises PlanarcError where there is no start, R474 of a model with delays.
        """
        from planarc.api.analysis.rhs import Rhs

        model, options = self.asked(parameters, start, start_time, None, None, None)
        return Rhs(model, options)

    @telling_keywords
    def linearize(
        self,
        at: float | str | Mapping[str, Value] | None = None,
        *,
        parameters: Mapping[str, Value] | None = None,
        start: Mapping[str, Value] | None = None,
        inputs: Mapping[str, Signal] | None = None,
        outputs: Sequence[str] | None = None,
    ) -> Linearization:
        """The linear model at a point: the start (default), a time, or given start values.

        `at="equilibrium"` looks for the nearest stable equilibrium first. With n states, m inputs
        and p `outputs` the matrices A, B, C and D have the shapes (n, n), (n, m), (p, n), (p, m).
        Raises PlanarcError where there is no start there, R474 for a model with delays.
        """
        from planarc.api.analysis.linearize import linearize

        return linearize(*self.asked(parameters, start), at, inputs, outputs)

    @telling_keywords
    def equilibrium(
        self,
        *,
        parameters: Mapping[str, Value] | None = None,
        start: Mapping[str, Value] | None = None,
        inputs: Mapping[str, Signal] | None = None,
    ) -> Equilibrium:
        """A state of rest near the start: stable, where there is a way down to one.

        Raises PlanarcError (R471) where none is found.
        """
        from planarc.api.analysis.equilibrium import find_equilibrium

        return find_equilibrium(*self.asked(parameters, start), inputs)

    @telling_keywords
    def assemble(
        self,
        *,
        parameters: Mapping[str, Value] | None = None,
        start: Mapping[str, Value] | None = None,
        tries: int = 200,
    ) -> tuple[Assembly, ...]:
        """All ways to put the mechanism together that many guesses find, the nearest first.

        What is fixed at the start stays. The guesses are the same each time. Raises PlanarcError
        (R472) where there is no way.
        """
        from planarc.api.analysis.assemble import assemble

        return assemble(*self.asked(parameters, start), tries)

    @telling_keywords
    def drive(
        self,
        motion: str | Mapping[str, Signal | str],
        signal: Signal | str | None = None,
        *,
        stop_time: float | None = None,
        start_time: float | None = None,
        tolerance: float | None = None,
        intervals: int | None = None,
        parameters: Mapping[str, Value] | None = None,
        start: Mapping[str, Value] | None = None,
    ) -> Driven:
        """Inverse dynamics: the effort that a motion of joint coordinates needs.

        `model.drive("crank.phi", f)`: `f` is a function of time, a table, three functions
        (position, velocity, acceleration), or a text in Modelica such as `"sin(2*time)"`. Several
        coordinates come as a mapping. The effort is in N.m for an angle, in N for a length.

        Raises UnknownName for a coordinate that is not there, UsageError for a motion that is not
        known at some time (C212) or that cannot be read (C246).
        """
        from planarc.api.analysis.drive import drive

        motions = dict(motion) if isinstance(motion, Mapping) else {motion: signal}
        options = run_options(self.backend, start_time, stop_time, tolerance, intervals)
        return drive(self, motions, options, parameters, start)

    def driven(
        self,
        coordinates: Sequence[str],
        efforts: Mapping[str, str],
        texts: Sequence[str | None],
    ) -> tuple[Compiled, dict[str, str]]:
        """The model with driven joints, compiled when it is first asked for."""
        from planarc.api.analysis.drive import compile_driven

        key = (tuple(coordinates), tuple(texts))
        if key not in self._driven:
            self._driven[key] = compile_driven(self, coordinates, efforts, texts)
        return self._driven[key]

    @telling_keywords
    def sensitivities(
        self,
        parameters: Sequence[str],
        *,
        stop_time: float | None = None,
        start_time: float | None = None,
        tolerance: float | None = None,
        intervals: int | None = None,
        values: Mapping[str, Value] | None = None,
        start: Mapping[str, Value] | None = None,
    ) -> Sensitivities:
        """Derivatives of all variables with respect to some parameters, over time.

        `values` are other values of parameters, around which the derivatives are taken. The
        equations of the sensitivities are integrated beside the motion, as exactly as that.

        Raises UnknownName, UsageError (C244, C253), and PlanarcError (R473) where a sensitivity
        cannot be followed, as through an event whose instant depends on the parameter.
        """
        from planarc.api.analysis.sensitivity import sensitivities

        times = start_time, stop_time, tolerance, intervals
        model, options = self.asked(values, start, *times)
        return sensitivities(model, parameters, options)


def _treatment(redundant: str | Redundant) -> Redundant:
    choice: Redundant = _choice(Redundant, "treatment of redundant joints", redundant)
    return choice


def _choice(kind: Any, name: str, value: Any) -> Any:
    try:
        return kind(value)
    except ValueError:
        raise unknown_name(name, str(value), [k.value for k in kind]) from None


def _backend(value: str | Backend | None) -> Backend:
    best = fastest_backend()
    chosen: Backend = best if value is None else _choice(Backend, "back end", value)
    if chosen is Backend.NATIVE and best is not chosen:
        raise usage_error("C207", "the native back end needs `llvmlite`, which is not installed")
    return chosen
