"""The linear model at a point, and its modes.

    dx/dt = A*x + B*u,   y = C*x + D*u     (deviations from the point)

Jacobians come from formulas (`codegen.slopes`). Where a function has no derivative, or none
at this point, they are central differences of order four of the compiled equations, which
are solved to rounding; their error is about 1e-12 of the values. `derivatives` says which.
What rigid touches hold there is left out (`holding`): it moves as the other states do.
Reference: the natural frequency of an eigenvalue s is |s|, its damping ratio -Re(s)/|s|.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from msgspec.structs import replace

from planarc.api.analysis.equilibrium import settle_down
from planarc.api.analysis.holding import what_holds
from planarc.api.analysis.point import Point, derivative, open_point
from planarc.api.analysis.response import Response, response, to_control, to_scipy
from planarc.api.analysis.rubbing import told_of_modes
from planarc.api.analysis.starting import model_at
from planarc.api.htmltable import html_table
from planarc.api.result import Page, Result
from planarc.api.signals import Signal
from planarc.api.values import Value, finite, start_values
from planarc.core.arrays import Array, Vector
from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, usage_error
from planarc.core.options import RunOptions
from planarc.core.prose import counted
from planarc.core.quantity import split
from planarc.core.unknown import UnknownName, refuse_unknown
from planarc.ir.result import Result as Rows
from planarc.ir.result import StateChoice, Statistics

if TYPE_CHECKING:
    from planarc.api.model import Model


class Mode(Data):
    """An eigenvalue with its shape: the complex amplitude of each state."""

    eigenvalue: complex
    shape: Mapping[str, complex]

    @property
    def natural_frequency(self) -> float:
        """The frequency in rad/s that the mode would have without damping."""
        return abs(self.eigenvalue)

    @property
    def frequency(self) -> float:
        """The frequency in Hz of the motion as it is."""
        return abs(self.eigenvalue.imag) / (2 * math.pi)

    @property
    def mostly(self) -> str:
        """The state that moves most."""
        return max(self.shape, key=lambda name: abs(self.shape[name]))

    @property
    def damping(self) -> float:
        """The damping ratio: 0 undamped, 1 no oscillation; negative where it grows."""
        size = abs(self.eigenvalue)
        return -self.eigenvalue.real / size if size else 0.0


class Linearization(Data, eq=False):
    """Matrices with the names of their rows and columns, and the point (`time`, `values`).

    dx/dt = A x + B u,  y = C x + D u, where x, u and y are deviations from the point, of `states`,
    `inputs` and `outputs`, in SI units. Parameters that the start finds (`fixed=false`) are no
    states. `derivatives` tells whether they come from `formulas` or from `differences`. `holding`
    names rigid contacts and joints with friction that rest there and stay so: states that follow
    from others by them are left out. `warnings` tell of joints that dry friction holds (R475).
    """

    A: Vector
    B: Vector
    C: Vector
    D: Vector
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    time: float
    values: Mapping[str, float]
    derivatives: str  # `formulas` or `differences`
    point: Point
    holding: tuple[str, ...]
    lift: Vector  # deviations of the point's states from those of `states`
    warnings: tuple[Diagnostic, ...] = ()

    def __repr__(self) -> str:
        stable = "stable" if self.stable else "unstable"
        given = f", {counted(len(self.inputs), 'input')}" if self.inputs else ""
        states = ", ".join(self.states)
        return f"<Linearization at t = {self.time:g} s, {stable}: states {states}{given}>"

    def _repr_html_(self) -> str:
        rows = (
            (m.eigenvalue, m.natural_frequency, m.frequency, m.damping, m.mostly)
            for m in self.modes
        )
        head = ("eigenvalue [1/s]", "natural [rad/s]", "damped [Hz]", "damping", "mostly")
        return html_table(head, rows, repr(self).strip("<>"))

    @property
    def eigenvalues(self) -> Array:
        """The eigenvalues in 1/s, in the order of `modes`."""
        return np.array([m.eigenvalue for m in self._all()], dtype=complex)

    @property
    def stable(self) -> bool:
        """True where no eigenvalue lies to the right of the imaginary axis (but for rounding)."""
        values = self.eigenvalues
        return bool(all(v.real <= 1e-7 * max(1.0, abs(v)) for v in values))

    @property
    def modes(self) -> tuple[Mode, ...]:
        """The modes, the slowest first; of a conjugate pair the one with Im > 0."""
        return tuple(m for m in self._all() if m.eigenvalue.imag >= 0)

    def _all(self) -> list[Mode]:
        if not len(self.states):
            return []
        values, vectors = np.linalg.eig(self.A)
        order = sorted(
            range(len(values)),
            key=lambda i: (round(float(abs(values[i])), 9), -values[i].imag, values[i].real),
        )
        modes = []
        for i in order:
            shape = vectors[:, i] / vectors[np.argmax(np.abs(vectors[:, i])), i]
            named = dict(zip(self.states, (complex(x) for x in shape), strict=True))
            modes.append(Mode(complex(values[i]), named))
        return modes

    def to_scipy(self) -> Any:
        """The linear model as a `scipy.signal.StateSpace`. Raises UsageError C248 where it has no
        inputs or no outputs."""
        return to_scipy(self)

    def to_control(self) -> Any:
        """The linear model as a `control.StateSpace`, with names in which `_` stands for dots.
        Needs python-control (`pip install control`)."""
        return to_control(self)

    def bode(self, w: Sequence[float] | Vector | None = None) -> Response:
        """The answer of outputs to inputs that vibrate with frequencies `w` (rad/s), by default
        around those of the modes. It has `magnitude`, `decibels`, `phase` and `plot()`.

        Raises UsageError: C202 for other frequencies, C248 where there are no inputs or outputs."""
        return response(self, w)

    @overload
    def animate(self, mode: Mode | int, amplitude: float = 0.2) -> Page: ...

    @overload
    def animate(
        self, mode: Mode | int, amplitude: float = 0.2, *, path: str | Path, **picture: Any
    ) -> Path: ...

    def animate(
        self,
        mode: Mode | int,
        amplitude: float = 0.2,
        *,
        path: str | Path | None = None,
        **picture: Any,
    ) -> Page | Path:
        """The mechanism moving in one mode, the largest state by `amplitude`.

        As a page for a notebook, or as a picture at `path`: see `Result.animate`. `mode` is one of
        `modes`, or its number from 0. Raises UsageError C245 where there is none of this number.
        """
        motion = self.motion(mode, amplitude)
        return motion.animate() if path is None else motion.animate(path, **picture)

    def _mode(self, number: int) -> Mode:
        modes = self.modes
        if isinstance(number, int) and -len(modes) <= number < len(modes):
            return modes[number]
        raise usage_error(
            "C245",
            f"there is no mode {number!r}: the linear model has {len(modes)}",
            hint="give one of `modes`, or its number, beginning at 0",
        )

    def motion(self, mode: Mode | int, amplitude: float = 0.2, rows: int = 60) -> Result:
        """Three periods of a mode, undamped, as a result: small deviations, drawn large."""
        mode = mode if isinstance(mode, Mode) else self._mode(mode)
        amplitude = finite("amplitude", amplitude)
        shape = self.lift @ np.array([mode.shape[n] for n in self.states])
        angles = np.linspace(0, 6 * math.pi, 3 * rows + 1)
        return _frames(self.point, mode.natural_frequency or 1.0, angles, amplitude * shape)


def linearize(
    model: Model,
    options: RunOptions,
    at: float | str | Mapping[str, Value] | None,
    inputs: Mapping[str, Signal] | None,
    outputs: Sequence[str] | None,
) -> Linearization:
    """See `Model.linearize`."""
    names, time = _outputs(model, outputs), None
    given: Mapping[str, float] = {}
    if isinstance(at, Mapping):
        given = start_values(model.program, at)
        model = model_at(model, given)
    elif at == "equilibrium":
        point = open_point(model, options, inputs)
        settle_down(point)
        return at_point(point, names)
    elif isinstance(at, str) and at != "start" and split(at) is None:
        message = f"there is no point to linearize at called `{at}`"
        hint = "give `start`, `equilibrium` or a time in seconds, or with a unit: `500ms`"
        raise UnknownName(Diagnostic("C201", message, hint=hint))
    elif at is not None and at != "start":
        time = finite("at", at, "s")
    if time is not None and time < model.program.experiment.start:
        raise usage_error("C240", f"t = {time:g} s lies before the start of the run")
    options = replace(options, starts={**options.starts, **given})
    return at_point(open_point(model, options, inputs, time), names)


def at_point(point: Point, outputs: Sequence[str] = ()) -> Linearization:
    """The linear model at a point whose states are `point.y`."""
    n, names = len(point.y), point.names
    whole, derivatives = jacobian(point, outputs)
    holding = what_holds(point)
    left, lift = holding.left, holding.lift
    rates, values = whole[list(left)], whole[n:]
    return Linearization(
        A=rates[:, :n] @ lift,
        B=rates[:, n:],
        C=values[:, :n] @ lift,
        D=values[:, n:],
        states=tuple(names[i] for i in left),
        inputs=point.program.inputs,
        outputs=tuple(outputs),
        time=point.t,
        values=point.values(),
        derivatives=derivatives,
        point=point,
        holding=holding.touches,
        lift=lift,
        warnings=told_of_modes(point),
    )


def jacobian(point: Point, outputs: Sequence[str] = ()) -> tuple[Vector, str]:
    """d(derivatives of all states, outputs)/d(states, inputs), and whether that comes from
    `formulas` or from `differences`."""
    program = point.program
    columns = {c.name: c for c in program.columns}
    slots = [columns[name].slot for name in outputs]
    signs = np.array([columns[name].sign for name in outputs], dtype=float)
    given = [program.slots[name] for name in program.inputs]
    found = _by_formulas(point, given, slots, signs)
    if found is not None:
        return found, "formulas"
    return _by_differences(point, given, slots, signs), "differences"


def _by_formulas(
    point: Point, held: Sequence[int], slots: Sequence[int], signs: Vector
) -> Vector | None:
    """d(rates, outputs)/d(states, inputs), or None."""
    rows = [*(c.derivative for c in point.states), *slots]
    formulas = point.kernel.capabilities.formulas
    at = point.t, point.y.tolist(), held, rows
    found = None if formulas is None else formulas.derivatives(*at)
    if found is None:
        return None
    whole: Vector = np.concatenate([np.ones(len(point.y)), signs])[:, None] * found
    return whole


def _by_differences(
    point: Point, held: Sequence[int], slots: Sequence[int], signs: Vector
) -> Vector:
    n = len(point.y)

    def both(z: Vector) -> Vector:
        for slot, value in zip(held, z[n:].tolist(), strict=True):
            point.kernel.w[slot] = value
        y = z[:n]
        rates = point.rhs(y)
        return np.concatenate([rates, signs * point.outputs(y)[slots]]) if slots else rates

    z = np.concatenate([point.y, [float(point.kernel.w[slot]) for slot in held]])
    found = derivative(both, z)
    both(z)
    point.accept(point.y)
    return found


def _outputs(model: Model, outputs: Sequence[str] | None) -> tuple[str, ...]:
    if outputs is None:
        return model.program.outputs
    names = (outputs,) if isinstance(outputs, str) else tuple(outputs)
    refuse_unknown("variable", names, {c.name for c in model.program.columns})
    return names


def _frames(point: Point, frequency: float, angles: Any, shape: Any) -> Result:
    """A result with a row for each phase angle of a small motion around the point."""
    program = point.program
    varying = list(dict.fromkeys(c.slot for c in program.columns if not c.constant))
    rows = []
    for angle in angles:
        y = point.y + np.real(shape * np.exp(1j * angle))
        rows.append(point.outputs(y)[varying])
    w = point.outputs(point.y)
    return Result(
        Rows(
            program=program,
            time=np.asarray(angles) / frequency,
            data=np.array(rows),
            stored={slot: i for i, slot in enumerate(varying)},
            constants={c.slot: float(w[c.slot]) for c in program.columns if c.constant},
            statistics=Statistics("linear", str(point.backend)),
            states=(StateChoice(point.t, point.names),),
        )
    )
