"""A mechanism by planarc and by the reference: accelerations and all joint forces."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from mechanism import Mechanism, draw, model_text
from multipliers import Reference

import planarc

STOP = 0.5
#: Mechanisms whose constraints come nearer to being dependent are drawn again: there both
#: formulations give rounding errors, and what follows depends on them.
REGULAR = 0.03
#: Faster ones (accelerations, m/s2 and rad/s2) are drawn again too: they fly apart.
WILD = 1e4
#: Those too in which a small change grows by more than this until the end.
SPREAD = 10.0
TOLERANCE = 1e-9


def regular(seed: int) -> Mechanism:
    """The next mechanism that stays clear of singular positions."""
    while True:
        m = draw(seed)
        if usable(m):
            return m
        seed += 100_000


def usable(m: Mechanism) -> bool:
    reference = Reference(m)
    q = reference.start()
    if len(reference.constraints(q, q)[1]) >= reference.size or reference.regularity(q) < REGULAR:
        return False
    a, _ = reference.solve(0.0, q, reference.drift(q))
    if np.max(np.abs(a)) > WILD:
        return False
    q, v, least = reference.move(STOP)
    quiet = float(np.max(np.abs(reference.solve(STOP, q, v)[0]))) < WILD
    return quiet and least > REGULAR and _spread(m, reference, (q, v)) < SPREAD


def _spread(m: Mechanism, reference: Reference, end: tuple[np.ndarray, np.ndarray]) -> float:
    """How far a small change of the speeds at the start goes until the end."""
    start, change = reference.start(), 1e-5
    drift = tuple(d + change * float(np.cos(1 + 3 * i)) for i, d in enumerate(m.drift))
    other = Reference(replace(m, drift=drift))
    moved = np.max(np.abs(other.drift(start) - reference.drift(start)))
    q, v, _ = other.move(STOP)
    far = np.max(np.abs(q - end[0])) + np.max(np.abs(v - end[1]))
    return float(far / max(moved, 1e-3 * change))


def disagreement(
    m: Mechanism,
    backend: str,
    reference: Reference | None = None,
    redundant: str = "refuse",
    start: float = 1e-9,
) -> str:
    """What differs, in words; empty where nothing does. `start`: by how much positions and
    speeds may differ at the start, relative to speeds."""
    reference = reference or Reference(m)
    q = reference.start()
    v = reference.drift(q)
    text = model_text(m, reference.frame_speeds(q, v))
    try:
        model = planarc.load(text, backend=backend, redundant=redundant)
        run = model.simulate(STOP, tolerance=TOLERANCE, intervals=1)
    except planarc.PlanarcError as problem:
        return f"it does not run: {problem}"
    end = reference.move(STOP)
    for row, known, allowed in ((0, (q, v), start), (-1, end[:2], 1e-5 / end[2] ** 2)):
        here, speed = _motion(m, run, row)
        far = np.max(np.abs(here - known[0])) + np.max(np.abs(speed - known[1]))
        if not far < allowed * (1 + np.max(np.abs(known[1]))):
            return f"after {STOP * (row == -1)} s the bodies are elsewhere, by {far:.3g}"
        found = _difference(m, run, row, reference.solve(float(run.time[row]), here, speed))
        if found:
            return f"after {STOP * (row == -1)} s {found}"
    return ""


def _motion(m: Mechanism, run: Any, row: int) -> tuple[np.ndarray, np.ndarray]:
    def of(*names: str) -> np.ndarray:
        return np.array([run[f"body{i}.{n}"][row] for i in range(len(m.bodies)) for n in names])

    return of("r_0CM[1]", "r_0CM[2]", "phi"), of("v_CM[1]", "v_CM[2]", "w")


def _difference(m: Mechanism, run: Any, row: int, expected: Any) -> str:
    accelerations, forces = expected
    names = [f"body{i}.{n}" for i in range(len(m.bodies)) for n in ("a_CM[1]", "a_CM[2]", "z")]
    wanted = accelerations.tolist()
    scale = 1 + max(map(abs, wanted))
    for name, value in zip(names, wanted, strict=True):
        got = float(run[name][row])
        if not abs(got - value) < 1e-6 * scale:
            return f"{name} = {got:.9g}, not {value:.9g}"
    scale = 1 + max(abs(x) for force in forces for x in force)
    for i, force in enumerate(forces):
        for name, value in zip(("f[1]", "f[2]", "t"), force, strict=True):
            got = -float(run[f"joint{i}.frame_b.{name}"][row])  # cut forces act on the joint
            if not abs(got - value) < 1e-6 * scale:
                return f"-joint{i}.frame_b.{name} = {got:.9g}, not {value:.9g}"
    return ""
