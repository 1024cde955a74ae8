"""Steps of crowds in machine code: the bits of those in Python, whoever makes which."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Sequence

import numpy as np
import pytest

import planarc
from planarc.compiler import compile_model
from planarc.instance.crowd.stepper import Stepper
from planarc.ir.kernel import Stepped
from planarc.request.request import Request
from planarc.solve.solvers.integrator import Settings
from planarc.solve.stepping.moreau import Moreau
from tests.export.test_crowd import BOX, DRUM, LOOP

Step = Callable[..., Stepped | None]


def rows(text: str) -> np.ndarray:
    """All numbers of a run, which end at the time of the last row."""
    result = planarc.load(text).simulate(0.6, fixed_step=2e-3)
    return np.array([result[name] for name in result.names])


def only(monkeypatch: pytest.MonkeyPatch, wanted: Callable[[int], bool]) -> list[bool]:
    """Leave those steps to machine code whose number, from 0 on, is wanted; which it made."""
    made: list[bool] = []
    step = Stepper.step

    def some(self: Stepper, t: float, h: float, y: Sequence[float], depth: float) -> Stepped | None:
        found = step(self, t, h, y, depth) if wanted(len(made)) else None
        made.append(found is not None)
        return found

    monkeypatch.setattr(Stepper, "step", some)
    return made


@pytest.mark.parametrize("text", [BOX, LOOP, DRUM])
def test_steps_have_the_bits_of_those_in_python(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patch:
        made = only(patch, lambda _: True)
        native = rows(text)
    assert len(made) >= 300 and all(made)
    with monkeypatch.context() as patch:
        made = only(patch, lambda _: False)
        assert np.array_equal(native, rows(text), equal_nan=True)
    assert len(made) >= 300 and not any(made)


@pytest.mark.parametrize("text", [BOX, LOOP, DRUM])
def test_either_goes_on_from_what_pressed_before(
    text: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A step begins with the impulses of the last one, and friction hangs on where it begins."""
    native = rows(text)
    made = only(monkeypatch, lambda number: number % 5 < 3)
    assert np.array_equal(native, rows(text), equal_nan=True)
    assert any(made) and not all(made)


def test_what_pressed_is_kept_without_zeros() -> None:
    steps = compile_model(Request(text=BOX)).load().capabilities.reacting().steps
    assert steps is not None
    steps.pressed = np.array([3, 5, 9]), np.array([[1.0, 0.5], [0.0, 0.0], [0.0, -2.0]])
    keys, impulses = steps.pressed
    assert keys.tolist() == [3, 9] and impulses.tolist() == [[1.0, 0.5], [0.0, -2.0]]


def test_a_run_begins_without_what_pressed_in_an_earlier_one() -> None:
    """A kernel goes on from run to run, and its steps with it."""
    compiled = compile_model(Request(text=BOX))
    kernel = compiled.load()
    steps, machine = kernel.capabilities.reacting().steps, kernel.capabilities.machine
    assert steps is not None and machine is not None
    steps.pressed = np.array([3]), np.array([[1.0, 0.5]])
    machine.renew()
    settings = Settings(tolerance=1e-6, span=1.0, relations=0, fixed_step=1e-3)
    Moreau(compiled.program, kernel, compiled.program.state_count, settings)
    assert steps.pressed[0].tolist() == []


def test_a_state_that_is_no_number_is_left_to_python(monkeypatch: pytest.MonkeyPatch) -> None:
    """There it is told where that comes from."""
    text = BOX.replace("equation\n", "  Forces.WorldForce push;\nequation\n", 1)
    text = text.replace(
        "  annotation",
        "  push.force = {noEvent(sqrt(0.1 - time)), 0};\n  connect(push.frame_b, a.frame_a);\n"
        "  annotation",
    )
    made = only(monkeypatch, lambda _: True)
    with pytest.raises(planarc.PlanarcError):
        rows(text)
    assert any(made) and not made[-1]


def test_a_crowd_needs_no_sparse_matrices_of_scipy() -> None:
    """Loading them takes longer than a short run."""
    code = (
        "import sys, planarc\n"
        f"planarc.load({BOX!r}).simulate(0.2, fixed_step=2e-3)\n"
        "print([m for m in ('scipy.sparse', 'scipy.spatial') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_bodies_that_begin_in_each_other_are_refused() -> None:
    text = BOX.replace("R={0.05, 0.06, 0.05, 0.04}", "R={0.05, 0.3, 0.05, 0.04}")
    with pytest.raises(planarc.PlanarcError) as caught:
        rows(text)
    assert caught.value.diagnostics[0].code == "R480"
