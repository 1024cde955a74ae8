"""The touches of a model: what they are in the workspace, and what forces at them do.

In:   Program, Kernel
Out:  Points     the touches and their expressions
      Touches    their gaps and speeds; the response to forces

The equations of a model are linear in its forces. With all touches open, a unit force at one of
them therefore shows, by one evaluation more, how the derivatives of the states and the motion of
all touches change by it: the column of M^-1*J' and of J*M^-1*J', in open chains and closed
loops, whatever the states are. An impulse changes the states themselves by that column.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from planarc.core.data import Data
from planarc.core.source import Span
from planarc.ir.dae import Impact
from planarc.ir.expr import Expr
from planarc.ir.impact import KEPT, NAMES
from planarc.ir.kernel import Kernel, taker
from planarc.ir.program import Program
from planarc.solve.messages.text import Reader

if TYPE_CHECKING:
    from planarc.core.arrays import Array, Vector

#: What tells what happened to a touch (`messages.told`).
TOLD = ("held", "way", "impulse")
#: A gap that is never reached, in m.
NEVER = -1e30
#: A force whose effect is a smaller part of what acts is made larger, so that it is seen.
SEEN = 1e-3


class Touch(Data):
    """One `impact(...)`: the expressions that it reads, the slots that it sets."""

    name: str
    span: Span
    read: Mapping[str, Expr]
    slots: Mapping[str, int]


class Response(Data):
    """u = own*x + u0 of some touches, and y' = states*x + y'0, for forces x at these touches."""

    own: Vector  # motion of all touches: normal, then slip
    states: Vector


class Points:
    """The touches of a model, as it says them."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.all = tuple(_touches(program))
        #: What a joint holds together, which therefore neither parts nor meets. The distance of
        #: contours that stand still has parameters in it.
        self.bound = np.array(
            [all(t.read[n].is_const for n in ("gap", "v", "e")) for t in self.all], dtype=bool
        )
        self.components = frozenset(t.name for t in self.all)


class Touches(Points):
    """The touches of a run."""

    def __init__(self, program: Program, kernel: Kernel) -> None:
        super().__init__(program)
        self.kernel = kernel
        self._read = Reader(program, kernel, 0.0)
        self._rates = {c.slot: c.derivative for c in program.candidates}
        self.force = np.ones(2 * len(self.all))  # that shows what a force does
        self._slots = {
            n: [program.slots.get(repr(t.read[n])) for t in self.all] for n in NAMES
        }  # None where a value follows from others
        self._takers = {
            n: taker([s for s in slots if s is not None])
            for n, slots in self._slots.items()
            if None not in slots
        }

    def get(self, name: str) -> Vector:
        w, take = self.kernel.w, self._takers.get(name)
        if take is not None:
            return np.array(take(w))
        return np.array(
            [
                float(self._read(touch.read[name])) if slot is None else w[slot]
                for touch, slot in zip(self.all, self._slots[name], strict=True)
            ]
        )

    def put(self, name: str, values: Iterable[float]) -> None:
        for touch, value in zip(self.all, values, strict=True):
            self.kernel.w[touch.slots[name]] = value

    def ignore(self) -> None:
        """Let no touch make an event, from the start of a run on: none is ever low enough."""
        starts = {d.slot: d.start for d in self.program.discretes}
        for touch in self.all:
            self.kernel.w[starts[touch.slots["low"]]] = NEVER

    def evaluate(self, t: float, y: Sequence[float]) -> bool:
        self._read.t = t
        return self.kernel.outputs(t, y) == 0

    def speeds(self) -> Vector:
        """Velocities of all touches: normal, then slip."""
        return np.concatenate([self.get("v"), self.get("slip")])

    def motion(self) -> Vector:
        """Accelerations of all touches: normal, then slip."""
        return np.concatenate([self.get("a"), self.get("a_slip")])

    def respond(
        self, t: float, y: Sequence[float], states: Mapping[int, int], some: Sequence[int]
    ) -> tuple[Response, Vector] | None:
        """What forces at some touches do, and the motion without any; all are open after it."""
        n, w = len(self.all), self.kernel.w
        self.put("held", [0.0] * n)
        self.put("way", [2.0] * n)
        if not self.evaluate(t, y):
            return None
        take = taker([self._rates[slot] for slot in sorted(states, key=lambda s: states[s])])
        free, before = self.motion(), np.array(take(w))
        largest, rubs = max(1.0, float(np.abs(free).max())), self.get("mu") != 0
        own, moved = np.zeros((2 * n, 2 * len(some))), np.zeros((len(before), 2 * len(some)))
        pushes = [(i, "push_n", i) for i in some] + [(i, "push_t", n + i) for i in some]
        for column, (i, push, place) in enumerate(pushes):
            if push == "push_t" and not rubs[i]:
                continue  # no force ever acts there
            slot = self.all[i].slots[push]
            for _ in range(2):
                w[slot] = force = self.force[place]
                whole = self.evaluate(t, y)
                own[:, column] = (self.motion() - free) / force
                moved[:, column] = (np.array(take(w)) - before) / force
                w[slot] = 0.0
                if not whole:
                    return None
                effect = float(np.abs(own[:, column]).max())
                if effect == 0.0 or effect * force > SEEN * largest:
                    break
                self.force[place] = largest / effect
        return Response(own, moved), free

    def pressed(self, t: float, y: Sequence[float], some: Array, x: Vector) -> Vector | None:
        """What presses at these touches while the forces x act there; all are open."""
        half = len(some)
        for name, values in (("push_n", x[:half]), ("push_t", x[half:])):
            given = np.zeros(len(self.all))
            given[some] = values
            self.put(name, given.tolist())
        found = self.get("f_n")[some] if self.evaluate(t, y) else None
        for name in ("push_n", "push_t"):
            self.put(name, [0.0] * len(self.all))
        return found


def _touches(program: Program) -> Iterable[Touch]:
    seen: set[str] = set()
    for when in program.whens:
        for _, _, actions in when.branches:
            for action in actions:
                if isinstance(action, Impact) and not action.crowd and action.component not in seen:
                    seen.add(action.component)
                    read = dict(zip(NAMES, action.arguments, strict=True))
                    slots = {n: program.slots[repr(read[n])] for n in KEPT}
                    yield Touch(action.component, action.span, read, slots)
