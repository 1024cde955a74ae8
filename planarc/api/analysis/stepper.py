"""A run that goes on step by step: for controllers, games and learning environments.

In:   Model, RunOptions, the length of a step
Out:  Stepper    set inputs, step, read

    with model.stepper(0.01) as s:
        while not s.done:
            s["torque"] = -2 * s["hinge.phi"] - 0.3 * s["hinge.w"]
            s.step()

Inputs stand still within a step. A step ends exactly where it should; on the way the integrator
takes as many steps as the tolerance asks for, events happen at their instants, and states are
exchanged where they must be. Where an input changes, the integrator begins anew.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isfinite
from types import TracebackType
from typing import TYPE_CHECKING, Any

from planarc.api.inputs import held_inputs, held_value, input_names
from planarc.api.values import elements_of, finite
from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, RunError, Severity, error, usage_error
from planarc.core.options import RunOptions
from planarc.core.unknown import refuse_unknown, unknown_name
from planarc.ir.kernel import Kernel
from planarc.ir.program import Program
from planarc.solve.run import Run
from planarc.solve.settings import resolve

if TYPE_CHECKING:
    from planarc.api.model import Model

#: Rows that are kept for assertions, before all but the last are forgotten.
_ROWS = 256


class Snapshot(Data):
    """All that a run needs to go on from an instant."""

    time: float
    steps: int
    states: tuple[float, ...]
    selection: tuple[int, ...]
    workspace: tuple[float, ...]
    fired: tuple[int, ...]  # how often each sampler fired


class Stepper:
    """A run under way, as `Model.stepper` gives it.

    `s["u"] = 1.0` sets an input from the next step on, `s["x"]` reads any variable, `s["x", "y"]`
    several as an array. `time` (s) is where the run stands; `done` is true where it has come to its
    end, or a model ended it. Close it, or use it in a `with` statement.
    """

    def __init__(self, model: Model, options: RunOptions, step: float) -> None:
        self._model, self._options, self.step_size = model, options, step
        self._program: Program = model.program
        known = {c.name: (c.slot, float(c.sign)) for c in self._program.columns}
        self._held = held_inputs(self._program)
        self._inputs = {n: self._program.slots[n] for n in input_names(self._program)}
        self._known = known | {n: (slot, 1.0) for n, slot in self._inputs.items()}
        self._readers: dict[str | tuple[str, ...], Callable[[], Any]] = {}
        self._units = {c.name: c.unit for c in self._program.columns}
        self._run: Run | None = None
        self._begin()

    def _begin(self) -> None:
        self.close()
        compiled = self._model.compiled(self._options.backend)
        self._kernel: Kernel = compiled.load()
        request = resolve(self._program, self._options)
        run = Run(self._program, self._kernel, request, str(self._options.backend))
        try:
            run.begin()
        except BaseException:
            run.close()
            raise
        self._run, self._start, self._stop = run, request.start, request.stop
        self._steps, self._since, self._changed = 0, request.start, False
        self._readers.clear()
        self._w = self._kernel.w
        self._first = None if self._program.delays else self.save()
        self._judge(run)

    # Where it is

    @property
    def time(self) -> float:
        """The time in seconds."""
        return self._running().integrator.t

    @property
    def done(self) -> bool:
        """True where the run is over: at its stop time, or where the model ended it."""
        run = self._running()
        return run.ended is not None or run.integrator.t >= self._stop

    @property
    def ended(self) -> Diagnostic | None:
        """Why the model ended the run, as `terminate` says; else None."""
        return self._running().ended

    @property
    def inputs(self) -> tuple[str, ...]:
        """The names of the inputs."""
        return tuple(self._inputs)

    def __getitem__(self, name: str | Sequence[str]) -> Any:
        """A number, or an array of an array's elements or of several names."""
        key = name if isinstance(name, str) else tuple(name) if _is_several(name) else str(name)
        reader = self._readers.get(key)
        if reader is None:
            self._running()
            reader = self._readers[key] = self._reader(key)
        return reader()

    def __setitem__(self, name: str, value: float | bool | str) -> None:
        slot = self._inputs.get(name)
        if slot is None:
            refuse_unknown("input", (name,), self._inputs)
        self._running()
        if name in self._held:
            value = held_value(self._held[name], value)
        elif type(value) is not float or not isfinite(value):
            value = finite(name, value, self._units.get(name, ""))
        if self._w[slot] != value:  # type: ignore[index]
            self._w[slot], self._changed = value, True  # type: ignore[index]

    def _ipython_key_completions_(self) -> list[str]:
        return list(self._known)

    def _reader(self, name: str | tuple[str, ...]) -> Callable[[], Any]:
        w = self._w
        if isinstance(name, str) and name in self._known:
            slot, sign = self._known[name]
            return lambda: float(sign * w[slot])
        import numpy as np

        if isinstance(name, str):
            found = elements_of(name, self._known)
            names: Sequence[str] = [found[at] for at in sorted(found)]
            if not names:
                raise unknown_name("variable", name, self._known)
        else:
            names = name
            refuse_unknown("variable", names, self._known)
        places = [self._known[n] for n in names]
        return lambda: np.array([sign * w[slot] for slot, sign in places])

    # On the way

    def step(self, seconds: float | None = None) -> float:
        """Go on by one step, or by so many seconds; gives the time reached.

        Raises RunError where the run cannot go on, UsageError C216 at its end.
        """
        run = self._running()
        if self.done:
            hint = "`reset()` begins again; `stop_time=...` lets it go further"
            raise usage_error("C216", f"the run is over at t = {run.integrator.t:g} s", hint=hint)
        if seconds is None:
            self._steps += 1
            end = self._since + self._steps * self.step_size
        else:
            self._since = end = run.integrator.t + _length(seconds)
            self._steps = 0
        if self._changed:
            self._changed = False
            run.take_inputs()
        if run.ended is None:
            run.march_to(min(end, self._stop))
        if run.ended is None:
            run.stand()
        self._judge(run)
        return run.integrator.t

    def _judge(self, run: Run) -> None:
        if run.ended is not None and run.ended.severity is Severity.ERROR:
            raise RunError(run.ended)
        if run.recorder.count > _ROWS:
            run.forget_rows()

    # Back and forth

    def reset(self) -> None:
        """Begin again, with the inputs as they were at the start."""
        if self._first is None:
            self._begin()
        else:
            self.restore(self._first)

    def save(self) -> Snapshot:
        """The present instant, to which `restore` comes back. Raises PlanarcError R474 for a model
        with delays, whose past belongs to its state."""
        run = self._running()
        if self._program.delays:
            name, span = self._program.name, self._program.delays[0].span
            raise error("R474", f"`{name}` uses `delay`: its past belongs to its state", span)
        fired = tuple(s.fired for s in run.schedule.samplers)
        t, y, selection = run.integrator.t, tuple(run.integrator.y), tuple(run.states.selection)
        return Snapshot(t, self._steps, y, selection, tuple(self._w), fired)

    def restore(self, snapshot: Snapshot) -> None:
        """Go back to an instant that was saved by this stepper."""
        run = self._running()
        if not isinstance(snapshot, Snapshot) or len(snapshot.workspace) != len(self._w):
            hint = "`save()` gives one"
            raise usage_error(
                "C202", f"`restore` takes a Snapshot, not {snapshot!r:.40}", hint=hint
            )
        self._w[:] = list(snapshot.workspace)
        self._steps, self._changed = snapshot.steps, False
        self._since = snapshot.time - snapshot.steps * self.step_size
        for sampler, fired in zip(run.schedule.samplers, snapshot.fired, strict=True):
            sampler.fired = fired
        run.go_back(snapshot.time, snapshot.states, snapshot.selection)
        self._judge(run)

    def close(self) -> None:
        """Give back what the integrator holds."""
        if self._run is not None:
            self._run.close()
            self._run = None

    def _running(self) -> Run:
        if self._run is None:
            raise usage_error("C216", "the stepper is closed", hint="make a new one")
        return self._run

    def __enter__(self) -> Stepper:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_run", None) is not None:
            self.close()

    def __repr__(self) -> str:
        where = "closed" if self._run is None else f"t = {self.time:g} s of {self._stop:g} s"
        return f"<Stepper of {self._program.name}: {where}, steps of {self.step_size:g} s>"


def _is_several(names: object) -> bool:
    return hasattr(names, "__iter__")


def _length(step: Any) -> float:
    """The length of a step in seconds."""
    seconds = finite("step", step, "s")
    if seconds <= 0:
        raise usage_error("C216", f"a step is a time above 0 s, not {seconds:g} s")
    return seconds


def open_stepper(model: Model, options: RunOptions, step: Any) -> Stepper:
    """See `Model.stepper`."""
    return Stepper(model, options, _length(step))
