"""Sensitivities: how every variable changes with parameters, over time.

In:   Model, names of parameters, RunOptions
Out:  Sensitivities    d(variable)/d(parameter) at the rows of a run

Where nothing switches, the sensitivity equations are integrated beside the motion,

    dS/dt = A*S + df/dp,   S(0) = d(start)/dp,   dz/dp = dz/dy*S + dz/dp|y,

with error control of both. The partial derivatives come from formulas (`partials`); where
these are missing, from differences of the equations at one point, and `derivatives` says so.
They are no differences of runs: the integrator's error does not enter. States are chosen
as in a run, and S is carried over.

A model with events gets differences of runs at a tight tolerance instead (`compared`); `method`
says so.

Reference: T. Maly, L. R. Petzold, Appl. Numer. Math. 20(1-2), 1996, 57-79.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec.structs import replace

from planarc.api.analysis.compared import compare_runs
from planarc.api.analysis.partials import Differences, Formulas, NoFormulaError, Partials
from planarc.api.analysis.point import Point, open_point
from planarc.api.values import elements_of, parameter_values, slots_of
from planarc.core.arrays import Vector
from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, PlanarcError, error, usage_error
from planarc.core.extras import need
from planarc.core.options import RunOptions
from planarc.core.prose import counted
from planarc.core.unknown import UnknownName, refuse_unknown
from planarc.ir.program import Program
from planarc.solve.deciding import not_to_be_set
from planarc.solve.settings import resolve
from planarc.solve.states.selector import lost_diagnostic

if TYPE_CHECKING:
    import pandas

    from planarc.api.model import Model

#: The relative change of a parameter whose effect is as exact as the motion.
CHANGE = 1e-5
#: The tolerance of the integration is never looser.
TOLERANCE = 1e-10


class Sensitivities(Data):
    """`s["crank.phi", "rod.L"]` is d(crank.phi)/d(rod.L) over `time`; `values` the motion.

    Units are that of the variable over that of the parameter. `data` has the shape
    (rows, variables, parameters), in the order of `names` and `parameters`. A row at an event has
    the values after it. What jumps or bends there, at an instant that moves with the parameter, has
    the derivative from the side of these values; it is NaN where events move to both sides.
    """

    time: Vector
    parameters: tuple[str, ...]
    names: tuple[str, ...]  # of the variables
    data: Vector  # rows, variables, parameters
    motion: Vector  # rows, variables
    method: str  # `equations` or `differences`
    derivatives: str  # of the equations: `formulas` or `differences`

    def __repr__(self) -> str:
        by = ", ".join(self.parameters)
        rows = counted(len(self.time), "row")
        names = counted(len(self.names), "variable")
        return f"<Sensitivities of {names} by {by}: {rows}, from {self.method}>"

    def _ipython_key_completions_(self) -> list[tuple[str, str]]:
        return [(n, p) for n in self.names for p in self.parameters]

    def __getitem__(self, key: tuple[str, str]) -> Vector:
        """One derivative over `time`, of the shape (rows,). Raises UnknownName."""
        if not isinstance(key, tuple) or len(key) != 2:
            message = "a derivative has two names, of a variable and of a parameter"
            first = key if key in self.names else self.names[0]
            hint = f'write e.g. `["{first}", "{self.parameters[0]}"]`'
            raise UnknownName(Diagnostic("C202", message, hint=hint))
        variable, parameter = key
        refuse_unknown("variable", (variable,), self.names)
        refuse_unknown("parameter that was asked for", (parameter,), self.parameters)
        at = self.names.index(variable), self.parameters.index(str(parameter))
        found: Vector = self.data[:, at[0], at[1]]
        return found

    def values(self, variable: str) -> Vector:
        """The motion itself: a variable over `time`, in its SI unit. Raises UnknownName."""
        refuse_unknown("variable", (variable,), self.names)
        found: Vector = self.motion[:, self.names.index(variable)]
        return found

    def to_pandas(self, variables: Sequence[str]) -> pandas.DataFrame:
        """Columns (variable, parameter) over time. Needs pandas. Raises UnknownName."""
        module = need("pandas", "tables")
        columns = {(v, p): self[v, p] for v in variables for p in self.parameters}
        frame: pandas.DataFrame = module.DataFrame(columns, index=self.time)
        return frame


def sensitivities(model: Model, parameters: Sequence[str], options: RunOptions) -> Sensitivities:
    """See `Model.sensitivities`."""
    names = (parameters,) if isinstance(parameters, str) else tuple(parameters or ())
    if not names:
        raise usage_error("C253", "no parameter is named")
    values = _present(model, names, options)
    program = model.program
    events = program.relations, program.whens, program.samplers, program.discretes
    if program.delays or any(events):
        return _by_runs(model, values, options)
    base = open_point(model, options)
    try:
        return _Equations(base, Formulas(base, values, options), values, options).integrate()
    except NoFormulaError:
        base = open_point(model, options)
        partials = Differences(base, model, values, options)
        return _Equations(base, partials, values, options).integrate()


def _present(model: Model, names: Sequence[str], options: RunOptions) -> dict[str, float]:
    """The values around which derivatives are taken; names are checked."""
    kinds = {p.name: p.kind.value for p in model.program.parameter_slots}
    for name in names:
        if name not in kinds:
            _refuse_others(model.program, name)
        if kinds[name] != "Real":
            raise usage_error("C244", f"`{name}` is {kinds[name]}: there is no derivative by it")
    defaults = {p.name: p.default for p in model.program.parameter_slots}
    present = {n: options.values.get(n, defaults[n] or 0.0) for n in names}
    resolve(model.program, replace(options, values={**options.values, **present}))
    return present


def _refuse_others(program: Program, name: str) -> None:
    """Raise UsageError for what is no parameter; start values give no derivative either."""
    if isinstance(name, str) and not_to_be_set(program, name) is None:
        if elements := elements_of(name, slots_of(program)):
            first = next(iter(elements.values()))
            raise usage_error("C244", f"`{name}` is an array: name its elements, as in `{first}`")
        variable = name.removesuffix(".start")
        if any(c.name == variable for c in program.columns):
            what = "a variable" if variable == name else "the start value of a variable"
            hint = None
            if any(c.display == variable for c in program.candidates):
                hint = f"let a parameter give the start, as in `{variable}(start=x0)`, and name it"
            raise UnknownName(Diagnostic("C201", f"`{name}` is {what}, not a parameter", hint=hint))
    parameter_values(program, {name: 0.0})


class _Equations:
    """The motion and its sensitivities, integrated together."""

    def __init__(
        self, base: Point, partials: Partials, values: dict[str, float], options: RunOptions
    ) -> None:
        self.program, self.parameters = base.program, tuple(values)
        request = resolve(self.program, options)
        self.grid = request.grid
        self.tolerance = min(TOLERANCE, request.tolerance)
        self.base, self.partials = base, partials
        self.changes = [CHANGE * (abs(v) or 1.0) for v in values.values()]
        self.s = partials.start()
        self._follow()

    def _follow(self) -> None:
        """The point takes its states, and all that is beside it."""
        self.base.accept(self.base.y, self.base.t)
        self.partials.follow()
        self._slots = [c.derivative for c in self.base.states]

    def _rates(self, t: float, z: Vector) -> Vector:
        """The rates of the states, then of their sensitivities; NaN where there are none."""
        n = len(self.base.y)
        try:
            f, by_state, by_parameter = self.partials.at(t, z[:n], self._slots)
        except PlanarcError:
            return np.full(len(z), np.nan)
        ds = by_state @ z[n:].reshape(n, len(self.changes)) + by_parameter
        return np.concatenate([f, ds.ravel()])

    def _values(self, t: float, z: Vector, slots: Sequence[int]) -> tuple[Vector, Vector]:
        """Values, and their derivatives by the parameters."""
        n = len(self.base.y)
        values, by_state, by_parameter = self.partials.at(t, z[:n], slots)
        return values, by_state @ z[n:].reshape(n, len(self.changes)) + by_parameter

    def integrate(self) -> Sensitivities:
        columns = [c for c in self.program.columns if not c.name.startswith("$")]
        slots = [c.slot for c in columns]
        signs = np.array([c.sign for c in columns], dtype=float)
        times, stop = self.grid.tolist(), float(self.grid[-1])
        now = times[0]
        rows = [self._values(now, np.concatenate([self.base.y, self.s.ravel()]), slots)]
        solver: Any = None
        while now < stop:
            solver = solver or self._solver(now, stop)
            solver.step()
            if solver.status == "failed":
                raise error("R473", f"the sensitivities cannot be followed beyond t = {now:.6g} s")
            now, dense = float(solver.t), solver.dense_output()
            while len(rows) < len(times) and times[len(rows)] <= now:
                t = times[len(rows)]
                rows.append(self._values(t, dense(t), slots))
            if self._accept(now, solver.y):
                solver = None
        return Sensitivities(
            time=self.grid,
            parameters=self.parameters,
            names=tuple(c.name for c in columns),
            data=np.array([signs[:, None] * dw for _, dw in rows]),
            motion=np.array([signs * w for w, _ in rows]),
            method="equations",
            derivatives=self.partials.name,
        )

    def _solver(self, now: float, stop: float) -> Any:
        from scipy.integrate import DOP853

        z = np.concatenate([self.base.y, self.s.ravel()])
        # A sensitivity is as accurate as what it says of a change of the whole parameter.
        unit = np.array([CHANGE / h for h in self.changes])
        absolute = np.concatenate(
            [np.ones(len(self.base.y)), np.tile(unit, (len(self.base.y), 1)).ravel()]
        )
        return DOP853(
            self._rates,
            now,
            z,
            stop,
            rtol=max(self.tolerance, 1e-12),
            atol=self.tolerance * absolute,
            max_step=max((stop - float(self.grid[0])) / 50, 1e-300),
        )

    def _accept(self, t: float, z: Vector) -> bool:
        """The end of a step; true where other states were chosen."""
        n = len(self.base.y)
        y, self.s = z[:n].copy(), z[n:].reshape(n, len(self.changes)).copy()
        selector = self.base.run.states.selector
        self.base.accept(y, t)
        self.partials.follow()
        if not selector.open:
            return False
        changed, lost = selector.check(urgent=True)
        if lost is not None:
            raise PlanarcError(lost_diagnostic(self.program, t, lost))
        if not changed:
            return False
        candidates = [c.slot for c in self.program.candidates]
        values, moved = self._values(t, z, candidates)
        selection = selector.selection()
        self.base.run.states.take(selection)
        self.s = moved[selection]
        self.base.y = values[selection]
        self._follow()
        return True


def _by_runs(model: Model, values: dict[str, float], options: RunOptions) -> Sensitivities:
    found = compare_runs(model, values, options)
    how = "differences", "differences"
    return Sensitivities(found.time, tuple(values), found.names, found.data, found.motion, *how)
