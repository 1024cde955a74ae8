"""A linear model as other tools take it, and how it answers to vibrations.

In:   matrices A, B, C, D with names
Out:  scipy.signal.StateSpace, control.StateSpace, Response

    H(w) = C*(j*w*I - A)^-1*B + D

Example: a mass m on a spring c answers to a force with 1/(c - m*w^2), endless at w = sqrt(c/m).
Reference: K. J. Astrom, R. M. Murray, Feedback Systems, 2nd edition, section 10.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from importlib import import_module
from typing import Any, Protocol

import numpy as np

from planarc.core.arrays import Array, Vector
from planarc.core.data import Data
from planarc.core.diagnostic import usage_error
from planarc.core.extras import need
from planarc.core.unknown import refuse_unknown

#: Frequencies of a response for which none are given, and how far they reach beyond the modes.
_POINTS, _BEYOND = 400, 10.0


class Linear(Protocol):
    """A linear model."""

    @property
    def A(self) -> Vector: ...
    @property
    def B(self) -> Vector: ...
    @property
    def C(self) -> Vector: ...
    @property
    def D(self) -> Vector: ...
    @property
    def states(self) -> tuple[str, ...]: ...
    @property
    def inputs(self) -> tuple[str, ...]: ...
    @property
    def outputs(self) -> tuple[str, ...]: ...
    @property
    def eigenvalues(self) -> Array: ...


class Response(Data, eq=False):
    """The answer of outputs to inputs that vibrate: `values[i, k, n]` is the complex amplitude of
    output i, when input k has the amplitude 1 and the frequency `w[n]` (rad/s).

    All arrays have the shape (outputs, inputs, frequencies), in units of the output over those of
    the input.
    """

    w: Vector
    values: Array
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    @property
    def magnitude(self) -> Vector:
        """The amplitudes."""
        return np.abs(self.values)

    @property
    def decibels(self) -> Vector:
        """The amplitudes in dB: 20 times their common logarithm."""
        with np.errstate(divide="ignore"):
            return np.asarray(20 * np.log10(self.magnitude))

    @property
    def phase(self) -> Vector:
        """The phase angles in rad, without jumps of a turn."""
        return np.unwrap(np.angle(self.values), axis=-1)

    def __getitem__(self, key: tuple[str, str]) -> Array:
        """The complex amplitudes of an output by an input, over `w`. Raises UnknownName."""
        output, given = key if isinstance(key, tuple) and len(key) == 2 else (key, None)
        refuse_unknown("output", (output,), self.outputs)
        refuse_unknown("input", (given,), self.inputs)
        return np.asarray(self.values[self.outputs.index(output), self.inputs.index(str(given))])

    def _ipython_key_completions_(self) -> list[tuple[str, str]]:
        return [(o, i) for o in self.outputs for i in self.inputs]

    def plot(self, axes: Any = None) -> Any:
        """Bode's diagram, by matplotlib: decibels above degrees. Gives the two axes."""
        if axes is None:
            pyplot = need("matplotlib.pyplot", "plot")
            axes = pyplot.subplots(2, sharex=True, figsize=(6.4, 5.6), layout="constrained")[1]
        size, angle = axes
        for i, output in enumerate(self.outputs):
            for k, given in enumerate(self.inputs):
                label = f"{output} / {given}"
                size.semilogx(self.w, self.decibels[i, k], lw=1.4, label=label)
                angle.semilogx(self.w, np.degrees(self.phase[i, k]), lw=1.4, label=label)
        size.set_ylabel("magnitude [dB]")
        angle.set_ylabel("phase [deg]")
        angle.set_xlabel("frequency [rad/s]")
        for panel in axes:
            panel.grid(True, which="both", alpha=0.3)
            panel.spines[["top", "right"]].set_visible(False)
        size.legend(fontsize="small", framealpha=0.9)
        return axes


def response(linear: Linear, w: Sequence[float] | Vector | None) -> Response:
    """See `Linearization.bode`. Raises UsageError C202, C248."""
    _refuse_none(linear)
    if w is None:
        sizes = [abs(s) for s in linear.eigenvalues if abs(s) > 1e-6] or [1.0]
        ends = min(sizes) / _BEYOND, max(sizes) * _BEYOND
        frequencies = np.geomspace(*ends, _POINTS)
    else:
        frequencies = _frequencies(w)
    n, unit = len(linear.A), np.eye(len(linear.A))
    values = np.empty((len(linear.outputs), len(linear.inputs), len(frequencies)), dtype=complex)
    for k, frequency in enumerate(frequencies):
        try:
            inner = np.linalg.solve(1j * frequency * unit - linear.A, linear.B) if n else linear.B
        except np.linalg.LinAlgError:  # an undamped mode
            inner = np.full(linear.B.shape, np.inf)
        with np.errstate(invalid="ignore"):
            values[:, :, k] = linear.C @ inner + linear.D
    return Response(frequencies, values, linear.inputs, linear.outputs)


def _frequencies(w: Any) -> Vector:
    try:
        found = np.atleast_1d(np.asarray(w, dtype=float))
    except (TypeError, ValueError):
        found = np.array([np.nan])
    if found.ndim != 1 or not len(found) or not np.all(np.isfinite(found) & (found >= 0)):
        raise usage_error("C202", f"`w` takes frequencies in rad/s, not `{w!r:.60}`")
    return found


def to_scipy(linear: Linear) -> Any:
    """See `Linearization.to_scipy`. Raises UsageError C248."""
    _refuse_none(linear)
    from scipy.signal import StateSpace

    return StateSpace(linear.A, linear.B, linear.C, linear.D)


def to_control(linear: Linear) -> Any:
    """See `Linearization.to_control`. Raises UsageError C221, C248."""
    _refuse_none(linear)
    try:
        control: Any = import_module("control")
    except ImportError:
        raise usage_error(
            "C221",
            "this needs `control`, which is not installed",
            hint="install it with `pip install control`",
        ) from None
    names = {
        kind: [re.sub(r"\W+", "_", n).strip("_") for n in getattr(linear, kind)]
        for kind in ("states", "inputs", "outputs")
    }
    return control.ss(linear.A, linear.B, linear.C, linear.D, **names)


def _refuse_none(linear: Linear) -> None:
    """Refuse a model without inputs or outputs."""
    for kind, found, hint in (
        ("input", linear.inputs, "declare one in the model: `input Real u;`"),
        ("output", linear.outputs, 'name some: linearize(outputs=["hinge.phi"])'),
    ):
        if not found:
            raise usage_error("C248", f"the linear model has no {kind}", hint=hint)
