"""A compiled model, as a user holds it in Python: runs, variants, analyses.

What it has before a run stands in `loaded`. No result is ever kept. The file is long because each
public name says shapes, units, errors and an example.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from planarc.api.choices import integrated, treatment_of
from planarc.api.loaded import Loaded
from planarc.api.result import Result, RunStopped
from planarc.api.values import (
    Value,
    finite,
    parameter_values,
    run_options,
    slots_of,
    start_values,
)
from planarc.api.variables import Names, Variable, variables_of
from planarc.api.variant import Recompiled, texts_of, variant_of, why_again
from planarc.compiled import Compiled
from planarc.compiler import run
from planarc.core.diagnostic import PlanarcError, Severity, usage_error
from planarc.core.options import Backend, Contacts, Redundant, RunOptions, Solver
from planarc.core.unknown import telling_keywords, unknown_attribute
from planarc.request.request import Request
from planarc.solve.settings import compiles_again, differs

if TYPE_CHECKING:
    import re
    from os import PathLike
    from pathlib import Path

    from planarc.api.analysis.assemble import Assembly
    from planarc.api.analysis.drive import Driven
    from planarc.api.analysis.equilibrium import Equilibrium
    from planarc.api.analysis.linearize import Linearization
    from planarc.api.analysis.rhs import Rhs
    from planarc.api.analysis.sensitivity import Sensitivities
    from planarc.api.analysis.starting import Place
    from planarc.api.analysis.stepper import Stepper
    from planarc.api.signals import Signal
    from planarc.ir.result import Result as Rows


class Model(Loaded):
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
        super().__init__(request, backend, compiled)
        self._begin()

    def __setstate__(self, state: dict[str, Any]) -> None:
        super().__setstate__(state)
        self._begin()

    def _begin(self) -> None:
        """Nothing is made of it yet."""
        self._variants: dict[tuple[tuple[str, float], ...], Model] = {}
        self._variables: dict[str, Variable] | None = None
        #: With driven joints, by these and their motions as text: see `analysis.drive`.
        self.driven: dict[tuple[object, ...], tuple[Compiled, dict[str, str]]] = {}
        self._otherwise: Model | None = None  # redundant joints treated in the other way
        self._placed: Model | None = None

    if not TYPE_CHECKING:  # whoever checks types is told of wrong names by their checker

        def __getattr__(self, name: str) -> Any:
            """Raises AttributeError, with the nearest name or that of a result."""
            if hasattr(Result, name) and name[0] != "_":
                message = f"`Model` has no attribute `{name}`, a result has: write "
                raise AttributeError(f"{message}`model.simulate().{name}`")
            if name in ("sweep", "Study"):
                message = "`Model` has no attribute `{}`, planarc has: write `planarc.sweep(model, "
                raise AttributeError(message.format(name) + '{"crank.m": [1, 2, 3]})`')
            if name.lower().startswith("set"):
                message = f"`Model` has no attribute `{name}`, it never changes: give a run other "
                raise AttributeError(f'{message}values, `simulate(parameters={{"crank.m": 2}})`')
            inside = () if name[0] == "_" else self.parameters
            found = next((p for p in inside if p == name or p.startswith(f"{name}.")), None)
            if found is None:
                raise unknown_attribute(self, name)
            message = f'`Model` has no attribute `{name}`: read `model.parameters["{found}"]`'
            raise AttributeError(f'{message}, set `simulate(parameters={{"{found}": ...}})`')

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
        contact: str | Contacts | None = None,
        backend: str | Backend | None = None,
        redundant: str | Redundant | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Result:
        """Run the model; what is not given is as the model's experiment annotation says.

        Times are in s; `tolerance` is the relative error of a step. The result has a row at every
        `interval` (s), or `intervals` + 1 of them, and two at each event. `parameters` and `start`
        set values by name (SI units; an array takes a sequence). `start_from` takes all others from
        `"equilibrium"`, `"assembly 2"` (as `assemble` lists them, from 1), or the last row of a
        Result or of a file, whatever initial equations say. `inputs` are numbers, functions of
        time or tables, one for each element of an array; Booleans, Integers and enumerations are
        held. What a function does between two rows may be stepped over. What the model needs of
        their derivatives follows, or is given as `der(u)`.
        `solver` is a member of `Solver` or its name, as `cvode-adams`; those of one step length, as
        `rk4`, take a `fixed_step` (s). `contact="stepping"` takes rigid contacts by steps of
        that length instead of at events, as a model with a crowd does by itself. `redundant`: see
        `planarc.load`; by default as the model was loaded. `progress` is called with the time that
        is reached.

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
        options = integrated(
            options,
            solver,
            fixed_step,
            contact,
            backend,
            interval=None if interval is None else finite("interval", interval, "s"),
            redundant=None if redundant is None else treatment_of(redundant),
        )
        model, options = _put_at(model, options, start_from, inputs)
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
        contact: str | Contacts | None = None,
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
        options = integrated(replace(options, intervals=1), solver, fixed_step, contact, backend)
        if not options.solver.home:
            raise usage_error("R407", f"the solver `{options.solver}` takes no single steps",
                              hint="leave the solver out")  # fmt: skip
        return open_stepper(*_put_at(model, options, start_from, None), step)

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

    @telling_keywords
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
        options, signals = self.sorted_inputs(options, inputs)
        if signals:
            if not options.solver.home:
                raise usage_error("R407", f"the solver `{options.solver}` takes no input signals",
                                  hint="leave the solver out")  # fmt: skip
            kernel = self.forced(compiled.load(), options, signals)
            rows = run(compiled, options, progress=progress, kernel=kernel)
        else:
            rows = self._run(compiled, options, progress)
        result = Result(rows, compiled, self.request)
        ended = result.ended
        if ended is not None and ended.severity is Severity.ERROR:
            raise RunStopped(ended, result)
        return result

    def _run(
        self, compiled: Compiled, options: RunOptions, progress: Callable[[float], None] | None
    ) -> Rows:
        """A run with the kernel of an earlier one, if there is one at rest."""
        shelf = self.shelf(compiled)
        kept, rows = shelf.take(compiled.load), None
        try:
            rows = run(compiled, options, progress=progress, kernel=kept)
            return rows
        finally:
            if rows is not None and rows.ended is None:
                shelf.give(kept)
            else:
                kept.close()

    def _with_redundant(self, choice: Redundant) -> Model:
        if self._otherwise is None:
            self._otherwise = Model(replace(self.request, redundant=choice), self.backend)
            self._otherwise.take_name(self.program)
        return self._otherwise

    def with_parameters(
        self, parameters: Mapping[str, Value] | None
    ) -> tuple[Model, dict[str, float]]:
        """The model to run, and values to set. Structural ones make another model."""
        values = parameter_values(self.program, parameters)
        if not values:
            return self, values
        known = slots_of(self.program)
        structural = {n: known[n] for n in values if compiles_again(self.program, known[n])}
        changed = {n: values[n] for n in structural}
        if not changed:
            return self, values
        kernel = self.compiled().load()
        kernel.parameters()
        changed = {n: v for n, v in changed.items() if differs(kernel, structural[n], v)}
        rest = {n: v for n, v in values.items() if n not in structural}
        if not changed:
            return self, rest
        key = tuple(sorted(changed.items()))
        if key not in self._variants:
            texts = texts_of(self.request, self.program, changed, self.backend)
            why = f"{why_again(self.program, changed)}: the model is compiled again"
            warnings.warn(why, Recompiled, stacklevel=4)
            self._variants[key] = variant = Model(variant_of(self.request, texts), self.backend)
            variant.take_name(self.program, changed)
        return self._variants[key], rest

    def placed(self) -> Model:
        """This model for runs that begin where all states are given: without initial equations."""
        if self._placed is None:
            self._placed = Model(replace(self.request, placed=True), self.backend)
            self._placed.take_name(self.program)
        return self._placed

    @telling_keywords
    def variant(self, values: Mapping[str, str], declarations: str = "") -> Model:
        """This model with some values as Modelica text, compiled anew."""
        model = Model(variant_of(self.request, values, declarations), self.backend)
        model.take_name(self.program)
        return model

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
        """The linear model at a point: the start (default), a time (2 or "500ms"), or given start
        values.

        `at="equilibrium"` looks for the nearest stable equilibrium first. With n states, m inputs
        and p `outputs` the matrices A, B, C and D have the shapes (n, n), (n, m), (p, n), (p, m).
        States that follow from others by what rests there, as rigid contacts do, are left out.
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
        equations of the sensitivities are integrated beside the motion, as exactly as that; a model
        with events is run with a little more and a little less of each parameter.

        Raises UnknownName, UsageError (C244, C253), and PlanarcError (R473) where a sensitivity
        cannot be followed, as it grows beyond all bounds.
        """
        from planarc.api.analysis.sensitivity import sensitivities

        times = start_time, stop_time, tolerance, intervals
        model, options = self.asked(values, start, *times)
        return sensitivities(model, parameters, options)

    # Files

    @telling_keywords
    def export_fmu(
        self,
        path: str | PathLike[str],
        *,
        fmi: int = 3,
        outputs: str | re.Pattern[str] | Sequence[str] | None = None,
        inputs: Sequence[str] = (),
        parameters: str | re.Pattern[str] | Sequence[str] | None = None,
        platforms: Sequence[str] | None = None,
        stiff: bool = False,
        source: bool = False,
    ) -> Path:
        """Write the model as an FMU, which other simulators run, as `planarc export fmu` does.

            model.export_fmu("FourBar.fmu", outputs="rev.[.](phi|w)", inputs=["revA.tau"])

        `outputs` and `parameters` (those that can be set) are names, or a regular expression that
        matches anywhere in a name; without, outputs are the model's own, or all coordinates.
        `inputs` are variables that become inputs: a torque or force that the model gives, the
        signal of a source, the coordinate of a joint. `fmi` is 3 or 2. With `stiff` co-simulation
        integrates with an implicit method, for hard springs; with `source` the FMU also holds its
        code as C99, for platforms that planarc has no code for. Gives the path. Raises
        UnknownName, UsageError (C301, C302, V501, V505, V506), and PlanarcError C300 with the
        lines of what cannot be exported.
        """
        from planarc.api.analysis.export import export_fmu

        return export_fmu(self, path, fmi, outputs, inputs, parameters, platforms, stiff, source)

    @telling_keywords
    def export_c(
        self,
        path: str | PathLike[str],
        *,
        outputs: str | re.Pattern[str] | Sequence[str] | None = None,
        inputs: Sequence[str] = (),
        parameters: str | re.Pattern[str] | Sequence[str] | None = None,
        stiff: bool = False,
    ) -> Path:
        """Write the model as C99 into a folder, as `planarc export c` does.

            model.export_c("four_bar", outputs="rev.[.](phi|w)")

        The options are those of `export_fmu`. Gives the folder. Raises UnknownName, UsageError
        (C301, V501, V505), and PlanarcError C300 with the lines of what cannot be exported.
        """
        from planarc.api.analysis.export import export_c

        return export_c(self, path, outputs, inputs, parameters, stiff)

    @telling_keywords
    def export_page(
        self, path: str | PathLike[str], *, inputs: Sequence[str] = (), stiff: bool = False
    ) -> Path:
        """Write a page that runs the model itself, as `planarc export page` does.

            model.export_page("FourBar.html")

        It has the parameters, start values and inputs of the model as fields; `inputs` are
        variables that become inputs, `stiff` takes implicit steps. Gives the path. Raises
        UsageError (V501, V506), PlanarcError C300 with the lines of what cannot be exported, and
        RunStopped where the model does not run.
        """
        from planarc.api.analysis.export import export_page

        return export_page(self, path, inputs, stiff)


def _put_at(
    model: Model, options: RunOptions, at: Place | None, inputs: Mapping[str, Signal] | None
) -> tuple[Model, RunOptions]:
    if at is None:
        return model, options
    from planarc.api.analysis.starting import put_at

    return put_at(model, options, at, inputs)
