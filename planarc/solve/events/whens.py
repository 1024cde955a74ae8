"""When-clauses: which conditions became true, and what their actions do.

Assignments belong to the iteration with fixed pre-values (`Whens.assign`); what acts on
the run (`reinit`, `assert`, `terminate`) follows once that has come to rest (`Whens.act`).

Reference: Modelica 3.6, sections 8.3.5 and 8.3.6.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from msgspec import Struct, field

from planarc.core.diagnostic import Diagnostic
from planarc.ir.dae import (
    EDGE,
    WHEN,
    Action,
    Assertion,
    Impact,
    Reinit,
    Terminate,
    is_initial,
    set_by_whens,
)
from planarc.ir.expr import Expr, postorder
from planarc.ir.kernel import Copier, Kernel, copier
from planarc.ir.program import Let, Program
from planarc.solve.events.assignments import Assignments
from planarc.solve.messages.text import Reader, text_of
from planarc.solve.settings import Request

if TYPE_CHECKING:
    from planarc.solve.contact.impacts import Impacts


#: Sets of branches, each with what it leaves as it was, that are remembered.
MOST_KEPT = 64


class Processed(Struct):
    """The outcome of an event: the states to go on from, and how the run ends, if it does."""

    y: list[float]
    ended: Diagnostic | None = None
    warnings: list[Diagnostic] = field(default_factory=list)
    reset: list[str] = field(default_factory=list)  # the states that `reinit` set
    told: list[str] = field(default_factory=list)  # what touches did


class Whens:
    """The when-clauses of a run."""

    def __init__(self, program: Program, kernel: Kernel, request: Request) -> None:
        self.program, self.kernel = program, kernel
        self.impacts = None if request.stepping else _impacts(program, kernel, request)
        self._at_start = initial_conditions(program)
        self._slots = own_slots(program)
        self._keeping: dict[tuple[int, ...], Copier] = {}
        self._read = Reader(program, kernel, 0.0)
        self._assignments = Assignments(program, kernel, self._read)
        self._edges = edge_conditions(program)

    def reader(self, t: float) -> Reader:
        self._read.t = t
        return self._read

    def edges(self, initial: bool = False) -> list[tuple[Action, ...]]:
        """The actions of every when-clause's first branch that just became true."""
        w = self.kernel.w
        actions: list[tuple[Action, ...]] = []
        for when in self.program.whens:
            for slot, pre, branch in when.branches:
                if initial and slot not in self._at_start:
                    continue
                if w[slot] != 0 and (w[pre] == 0 or slot in self._edges):
                    actions.append(branch)
                    break
        return actions

    def assign(self, t: float, edges: list[tuple[Action, ...]]) -> Diagnostic | None:
        """Set the discrete variables; gives the first value that does not exist.

        What no clause assigns keeps the value that it had before, also where an earlier
        pass of this instant has set it.
        """
        self.reader(t)
        for actions in edges:
            failed = self._assignments.do(actions)
            if failed is not None:
                from planarc.solve.messages.event import no_value

                return no_value(self.program, t, failed.name, failed)
        self._keep(edges)(self.kernel.w)
        return None

    def _keep(self, edges: list[tuple[Action, ...]]) -> Copier:
        """What gives the variables that these branches do not set the values from before."""
        key = tuple(map(id, edges))
        if key not in self._keeping:
            if len(self._keeping) == MOST_KEPT:
                self._keeping.clear()
            set_ = {slot for actions in edges for slot in self._assignments.targets(actions)}
            kept = {slot: pre for slot, pre in self._slots.items() if slot not in set_}
            self._keeping[key] = copier(list(kept), list(kept.values()))
        return self._keeping[key]

    def act(
        self,
        t: float,
        edges: list[tuple[Action, ...]],
        done: Processed,
        states: Mapping[int, int],
    ) -> bool:
        """Everything but assignments; true if a state was set anew.

        `states`: slot -> index in `done.y`.
        """
        read = self.reader(t)
        moved = []
        for actions in edges:
            for action in self._assignments.others(actions):
                if isinstance(action, Reinit):
                    index = states.get(self.program.slots[repr(action.symbol)])
                    if index is None:
                        continue
                    value = _value(action, read)
                    if value is not None:
                        moved.append((index, value))
                    elif done.ended is None:
                        from planarc.solve.messages.event import no_value

                        done.ended = no_value(self.program, t, repr(action.symbol), action)
                elif isinstance(action, Assertion) and not read(action.condition):
                    _assertion(self.program, t, action, read, done)
                elif isinstance(action, Terminate) and done.ended is None:
                    from planarc.solve.messages.event import terminated

                    done.ended = terminated(t, action, text_of(action.message, read))
        names = {k: slot for slot, k in states.items()}
        for index, value in moved:
            done.y[index] = value
            done.reset += [c.display for c in self.program.candidates if c.slot == names[index]]
        return bool(moved)

    def strike(
        self,
        t: float,
        edges: list[tuple[Action, ...]],
        done: Processed,
        states: Mapping[int, int],
    ) -> bool:
        """What touches do, once all else has acted; true if they were asked."""
        if self.impacts is None or done.ended is not None or not _strikes(edges):
            return False
        told, done.ended = self.impacts.resolve(t, done.y, states)
        done.told += told
        return True


def _strikes(edges: list[tuple[Action, ...]]) -> bool:
    return any(
        isinstance(action, Impact) and not action.crowd for actions in edges for action in actions
    )


def _impacts(program: Program, kernel: Kernel, request: Request) -> Impacts | None:
    """The touches of a run, where it has some."""
    if not _strikes([actions for when in program.whens for *_, actions in when.branches]):
        return None
    from planarc.solve.contact.impacts import Impacts

    return Impacts(program, kernel, request.span, request.tolerance, request.fixed_step)


def _value(action: Reinit, read: Reader) -> float | None:
    """The value that an action gives; None where there is none."""
    try:
        return float(read(action.value))
    except (ArithmeticError, ValueError):
        return None


def _assertion(
    program: Program, t: float, action: Assertion, read: Reader, done: Processed
) -> None:
    from planarc.solve.messages.assertion import assertion_diagnostic

    found = assertion_diagnostic(program, t, action, text_of(action.message, read))
    if action.warning:
        done.warnings.append(found)
    elif done.ended is None:
        done.ended = found


def own_slots(program: Program) -> dict[int, int]:
    """Slots of the variables that when-clauses alone set, with those of their left limits."""
    given = {s.target for s in program.discrete if isinstance(s, Let)}
    names = set_by_whens(program.whens)
    return {
        d.slot: d.pre
        for d in program.discretes
        if d.name in names and program.table.symbol(d.name) not in given
    }


def edge_conditions(program: Program) -> frozenset[int]:
    """Slots of the conditions that are true for an instant."""
    return frozenset(d.slot for d in program.discretes if d.name.startswith(f"{EDGE}["))


def initial_conditions(program: Program) -> frozenset[int]:
    """Slots of the conditions that act at the start: `initial()` itself, and several ones with it.

    What merely depends on `initial()` does not, as a variable that is given it (8.6).
    """
    slots = program.slots
    marked: set[Expr] = set()
    for statement in program.discrete:
        if not isinstance(statement, Let):
            continue
        name, value = repr(statement.target), statement.value
        if is_initial(value):
            found = name.startswith(f"{WHEN}[")
        else:  # several conditions, or a part of them
            found = name.startswith(f"{EDGE}[") or name not in slots
            found = found and not marked.isdisjoint(postorder((value,)))
        if found:
            marked.add(statement.target)
    return frozenset(slots[repr(e)] for e in marked if repr(e) in slots)
