"""Events: what switches at an instant, and what follows from it.

Between events the truth of every relation is stored in the workspace and does not
change. At an event the equations are iterated at one instant of time:

    1  relations that cross zero here get the truth that lies in the direction of the
       crossing; all others are taken from the sign of their zero function
    2  continuous and discrete equations are evaluated, actions of when-clauses assign,
       until nothing changes
    3  the actions of conditions that just became true reinitialize, assert, terminate
    4  pre-values become the present values; again from 1 while anything changed
    5  a relation at zero takes the truth that it has right after this instant

The last step is what a bouncing ball needs: its `h <= 0` becomes true, the velocity
is reversed, and right after the instant `h <= 0` is false. Where that turns the motion
again, as in a sliding mode, the relation is turned back and left to the next event.

Reference: Modelica 3.6, section 8.6 and appendix B.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.ir.dae import INITIAL, TERMINAL, Assertion, Reinit, SetDiscrete, Terminate
from planarc.ir.expr import Op, postorder
from planarc.ir.program import Kernel, Let, Program
from planarc.solve import failure
from planarc.solve.instants import time_functions
from planarc.solve.values import Reader, text_of

#: Iterations at one instant before it is called endless.
MOST_ITERATIONS = 100
#: What changed within that many last iterations is named then: one round may take several.
LAST_ITERATIONS = 16
#: Relations of which all choices are tried when they chase each other.
MOST_SEARCHED = 10
#: A zero function below this part of its largest value has no sign.
NOISE = 1e-14
#: Instants of crossings are found so exactly that a function is this part of its largest
#: value there, at most.
NEAR = 1e-9
#: One that was never above this is zero by its equations; what is seen of it are rounding
#: errors (the torque limit of an open clutch).
SILENCE = 1e-12

#: The truths of the relations, and the discrete values, at one iteration.
Snapshot: TypeAlias = tuple[float, ...]


@dataclass(slots=True)
class Processed:
    """What an event did: the states to go on from, and how the run ends, if it does."""

    y: list[float]
    ended: Diagnostic | None = None
    warnings: list[Diagnostic] = field(default_factory=list)
    reset: list[str] = field(default_factory=list)  # the states that `reinit` set


class Events:
    """The discrete part of a run. All its values live in the kernel's workspace."""

    def __init__(self, program: Program, kernel: Kernel, span: float) -> None:
        self.program, self.kernel = program, kernel
        self.present = bool(
            program.relations or program.samplers or program.whens or program.discretes
        )
        self._g = [0.0] * len(program.relations)
        self._largest = [0.0] * len(program.relations)
        self._ahead = 1e-7 * (span or 1.0)
        self._at_start = _initial_conditions(program)
        self._read = Reader(program, kernel, 0.0)

    # Stored truth

    def truths(self) -> list[bool]:
        return [self.kernel.w[r.slot] != 0 for r in self.program.relations]

    def directions(self) -> list[int]:
        """The only way in which each zero function may cross next."""
        return [1 if truth else -1 for truth in self.truths()]

    def set_flag(self, name: str, value: bool) -> None:
        slot = self.program.slots.get(name)
        if slot is not None:
            self.kernel.w[slot] = float(value)

    def missed(self, t: float, y: Sequence[float]) -> dict[int, bool]:
        """Relations whose stored truth no longer agrees with their zero function."""
        if not self._g or self._roots(t, y) != 0:
            return {}
        wrong = {}
        for i, relation in enumerate(self.program.relations):
            if abs(self._g[i]) > 1e3 * NOISE * max(1.0, self._largest[i]):
                truth = self._g[i] < 0
                if truth != (self.kernel.w[relation.slot] != 0):
                    wrong[i] = truth
        return wrong

    def rises(self, t: float, y: Sequence[float]) -> list[float] | None:
        """How far each zero function moves within a short time from here, to first order."""
        now = [0.0] * len(self._g)
        ydot = [0.0] * len(y)
        if self.kernel.rhs(t, y, ydot) != 0 or self.kernel.roots(t, y, now) != 0:
            return None
        later = [a + self._ahead * d for a, d in zip(y, ydot, strict=True)]
        ahead = list(now)
        if self.kernel.roots(t + self._ahead, later, ahead) != 0:
            return None
        return [b - a for a, b in zip(now, ahead, strict=True)]

    def real(self, directions: Sequence[int], rises: Sequence[float] | None) -> dict[int, bool]:
        """The crossings among those that an integrator reports, with the truth that follows.

        A function that rises where it was seen to fall has not crossed: the integrator saw
        the errors of its own first steps. One that neither rises nor falls (the speed of
        what is stuck) has none but rounding errors; should it leave zero, `missed` tells.
        """
        found = {i: d < 0 for i, d in enumerate(directions) if d}
        if rises is None:
            return found
        return {
            i: truth
            for i, truth in found.items()
            if self._largest[i] > SILENCE
            and directions[i] * rises[i] > 4 * NOISE * self._largest[i]
        }

    def amplitude(self, i: int, rise: float, since: float) -> float:
        """The height of a bounce that took the time `since`, as a part of the largest seen."""
        return abs(rise) / self._ahead * since / 4 / max(self._largest[i], 1e-300)

    def _roots(self, t: float, y: Sequence[float]) -> int:
        flag = self.kernel.roots(t, y, self._g)
        self._largest = [max(a, abs(b)) for a, b in zip(self._largest, self._g, strict=True)]
        return flag

    # The start

    def begin(self, t: float) -> None:
        """Everything discrete before anything is solved: start values, then what follows
        from these, from time and from parameters. Relations of unknowns count as false."""
        w, program = self.kernel.w, self.program
        for d in program.discretes:
            w[d.slot] = w[d.pre] = w[d.start]
        self.set_flag(INITIAL, True)
        for i, zero in time_functions(program, self.kernel, t).items():
            g = zero(t)
            if g is not None:
                self._g[i] = g
                w[program.relations[i].slot] = float(self._sign(i))
        w[0] = t
        for _ in program.discretes:
            before = self._snapshot()
            if self.kernel.discrete() != 0:
                for d in program.discretes:  # has no value before the unknowns have
                    w[d.slot] = w[d.start]
                return
            if self._snapshot() == before:
                return

    def settle_start(self, t: float, y: Sequence[float]) -> bool:
        """One pass at the start; true when it changed something, so that the start values
        must be solved for once more."""
        before = self._snapshot()
        flag = self._roots(t, y)
        if flag == 0:
            for i, relation in enumerate(self.program.relations):
                self.kernel.w[relation.slot] = float(self._sign(i))
        self.kernel.outputs(t, y)
        self.kernel.discrete()
        self._assign(t, self._edges(initial=True))
        return self._snapshot() != before

    def finish_start(self, t: float, y: Sequence[float]) -> Processed:
        """Actions that were to run at the start; then everything is its own left limit."""
        done = Processed(list(y))
        done.ended = self._assign(t, self._edges(initial=True))
        self._act(t, self._edges(initial=True), done, {})
        self._keep_pre()
        self.set_flag(INITIAL, False)
        # Sizes seen while the start was searched for say nothing of the run.
        self._largest = [0.0] * len(self._largest)
        return done

    def _sign(self, i: int) -> bool:
        return self._g[i] < 0 or (self._g[i] == 0 and not self.program.relations[i].strict)

    # An event

    def process(
        self,
        t: float,
        y: Sequence[float],
        crossing: Mapping[int, bool],
        samples: Iterable[int],
        states: Mapping[int, int],
    ) -> Processed:
        """`crossing`: relation -> truth from here on. `states`: slot -> index in y."""
        w, program = self.kernel.w, self.program
        done = Processed(list(y))
        fired = [program.samplers[i][0] for i in samples]
        for slot in fired:
            w[slot] = 1.0
        for i, truth in crossing.items():
            w[program.relations[i].slot] = float(truth)
        if self._roots(t, done.y) != 0:
            return self._failed(t, done)
        held = dict(crossing)
        bound = {i: 2 * abs(self._g[i]) + NOISE * max(1.0, self._largest[i]) for i in held}
        turned: Counter[int] = Counter()
        trail: deque[Snapshot] = deque(maxlen=LAST_ITERATIONS)
        for _ in range(MOST_ITERATIONS):
            before = self._snapshot()
            trail.append(before)
            if not self._settle(t, done, held, bound):
                return done
            edges = self._edges()
            moved = self._act(t, edges, done, states)
            self._keep_pre()
            for slot in fired:
                w[slot] = 0.0
            fired_now, fired = bool(fired), []
            if done.ended is not None:
                break
            if moved or fired_now or self._snapshot() != before:
                continue
            if not self._look_ahead(t, done.y, held, bound, turned):
                break
        else:
            done.ended = self._endless(t, trail)
        if self.kernel.outputs(t, done.y) != 0:
            return self._failed(t, done)
        return done

    def _settle(
        self, t: float, done: Processed, held: dict[int, bool], bound: dict[int, float]
    ) -> bool:
        """Iterates with fixed pre-values until nothing changes; false where that fails.

        Relations inside of an algebraic loop (friction that sticks or slides) can chase each
        other. When a state of the iteration comes back, first only those that want to become
        false do so; when one comes back again, all choices of the restless ones are tried,
        the nearest to the present one first.
        """
        seen: set[Snapshot] = set()
        careful = False
        restless: set[int] = set()
        trail: deque[Snapshot] = deque(maxlen=LAST_ITERATIONS)
        for _ in range(MOST_ITERATIONS):
            before = self._snapshot()
            trail.append(before)
            if not self._evaluate(t, done):
                return False
            restless |= self._take_signs(held, bound, careful)
            now = self._snapshot()
            if now == before:
                return True
            if now in seen:
                if careful:
                    return self._search(t, done, held, bound, sorted(restless), trail)
                careful = True
                seen.clear()
                restless.clear()
            seen.add(now)
        done.ended = self._endless(t, trail)
        return False

    def _evaluate(self, t: float, done: Processed) -> bool:
        """The equations and the zero functions with the stored truths as they are."""
        if self.kernel.outputs(t, done.y) != 0 or self.kernel.discrete() < 0:
            self._failed(t, done)
            return False
        problem = self._assign(t, self._edges())
        if problem is not None:
            done.ended = problem
            return False
        if self._roots(t, done.y) != 0:
            self._failed(t, done)
            return False
        return True

    def _search(
        self,
        t: float,
        done: Processed,
        held: dict[int, bool],
        bound: dict[int, float],
        restless: Sequence[int],
        trail: Iterable[Snapshot],
    ) -> bool:
        """Try all truths of the restless relations until one agrees with its own equations.

        Where none does to rounding, one counts that does as exactly as instants are found.
        """
        w, relations = self.kernel.w, self.program.relations
        slots = [relations[i].slot for i in restless[:MOST_SEARCHED]]
        present = [w[s] for s in slots]
        choices = sorted(range(2 ** len(slots)), key=lambda n: (n.bit_count(), n))
        for flips, near in ((f, near) for near in (0.0, NEAR) for f in choices):
            for k, (slot, value) in enumerate(zip(slots, present, strict=True)):
                w[slot] = 1.0 - value if flips >> k & 1 else value
            for _ in range(MOST_ITERATIONS):  # discrete equations follow the truths
                discrete = self._snapshot()
                if not self._evaluate(t, done):
                    done.ended = None  # no solution here; another choice may have one
                    break
                if self._snapshot() == discrete:
                    self._hold_near(held, bound, near)
                    if not self._take_signs(held, bound, False):
                        return True
                    break
        done.ended = self._endless(t, trail)
        return False

    def _hold_near(self, held: dict[int, bool], bound: dict[int, float], near: float) -> None:
        """Relations that are as good as zero keep their truth."""
        for i, relation in enumerate(self.program.relations):
            size = abs(self._g[i])
            if size <= near * max(1.0, self._largest[i]) and not relation.time_only:
                held[i] = self.kernel.w[relation.slot] != 0
                bound[i] = 2 * size

    def _take_signs(
        self, held: dict[int, bool], bound: dict[int, float], careful: bool
    ) -> set[int]:
        """Truth from the zero functions, but not for those that are at zero here; gives those
        that changed. `careful`: none becomes true while another one becomes false."""
        w = self.kernel.w
        wanted: dict[int, bool] = {}
        for i, relation in enumerate(self.program.relations):
            size = abs(self._g[i])
            if i in held:
                if size > bound[i]:
                    del held[i]
                else:
                    continue
            if size > max(NOISE * self._largest[i], SILENCE) or relation.time_only:
                truth = self._sign(i)
                if truth != (w[relation.slot] != 0):
                    wanted[i] = truth
        if careful and not all(wanted.values()):
            wanted = {i: truth for i, truth in wanted.items() if not truth}
        for i, truth in wanted.items():
            w[self.program.relations[i].slot] = float(truth)
        return set(wanted)

    def _look_ahead(
        self,
        t: float,
        y: Sequence[float],
        held: dict[int, bool],
        bound: dict[int, float],
        turned: Counter[int],
    ) -> bool:
        """Relations at zero take their truth right after this instant; true if one changed."""
        w, relations, now = self.kernel.w, self.program.relations, self._g
        near = [
            i
            for i in range(len(relations))
            if turned[i] < 2 and abs(now[i]) <= bound.get(i, NOISE * max(1.0, self._largest[i]))
        ]
        if not near:
            return False
        rises = self.rises(t, y)
        if rises is None:
            return False
        changed = False
        for i in near:
            if abs(rises[i]) > 1e-4 * NOISE * self._largest[i]:
                truth = rises[i] < 0
                if truth != (w[relations[i].slot] != 0):
                    w[relations[i].slot] = float(truth)
                    held[i], changed = truth, True
                    bound.setdefault(i, NOISE * max(1.0, self._largest[i]))
                    turned[i] += 1
        return changed

    # When-clauses

    def _edges(self, initial: bool = False) -> list[tuple[object, ...]]:
        """The actions of every when-clause's first branch that just became true."""
        w = self.kernel.w
        actions: list[tuple[object, ...]] = []
        for when in self.program.whens:
            for slot, pre, branch in when.branches:
                if initial and slot not in self._at_start:
                    continue
                if w[slot] != 0 and w[pre] == 0:
                    actions.append(branch)
                    break
        return actions

    def _assign(self, t: float, edges: list[tuple[object, ...]]) -> Diagnostic | None:
        """Sets the discrete variables; tells the first value that does not exist."""
        read, w, slots = self._reader(t), self.kernel.w, self.program.slots
        for actions in edges:
            for action in actions:
                if isinstance(action, SetDiscrete):
                    try:
                        w[slots[action.name]] = float(read(action.value))
                    except (ArithmeticError, ValueError):
                        return _no_value(t, action.name, action)
        return None

    def _reader(self, t: float) -> Reader:
        self._read.t = t
        return self._read

    def _act(
        self,
        t: float,
        edges: list[tuple[object, ...]],
        done: Processed,
        states: Mapping[int, int],
    ) -> bool:
        """Everything but assignments; true if a state was set anew."""
        read = self._reader(t)
        moved = []
        for actions in edges:
            for action in actions:
                if isinstance(action, Reinit):
                    index = states.get(self.program.slots[repr(action.symbol)])
                    if index is None:
                        continue
                    try:
                        moved.append((index, float(read(action.value))))
                    except (ArithmeticError, ValueError):
                        done.ended = done.ended or _no_value(t, repr(action.symbol), action)
                elif isinstance(action, Assertion) and not read(action.condition):
                    self._assertion(t, action, read, done)
                elif isinstance(action, Terminate) and done.ended is None:
                    done.ended = Diagnostic(
                        "R431",
                        f"terminated at t = {t:.6g} s: {text_of(action.message, read)}",
                        action.span,
                        Severity.NOTE,
                    )
        names = {k: slot for slot, k in states.items()}
        for index, value in moved:
            done.y[index] = value
            done.reset += [c.display for c in self.program.candidates if c.slot == names[index]]
        return bool(moved)

    def _assertion(self, t: float, action: Assertion, read: Reader, done: Processed) -> None:
        found = assertion_diagnostic(t, action, text_of(action.message, read))
        if action.warning:
            done.warnings.append(found)
        elif done.ended is None:
            done.ended = found

    # Bookkeeping

    def _snapshot(self) -> Snapshot:
        w, program = self.kernel.w, self.program
        return (
            *(w[r.slot] for r in program.relations),
            *(w[d.slot] for d in program.discretes),
        )

    def _keep_pre(self) -> None:
        w = self.kernel.w
        for d in self.program.discretes:
            w[d.pre] = w[d.slot]

    def _endless(self, t: float, trail: Iterable[Snapshot]) -> Diagnostic:
        program = self.program
        names = [f"`{r.text}`" for r in program.relations]
        names += [f"`{d.name}`" for d in program.discretes]
        spans = [r.span for r in program.relations] + [None for _ in program.discretes]
        values = zip(*trail, self._snapshot(), strict=True)
        restless = [i for i, found in enumerate(values) if len(set(found)) > 1]
        culprits = ", ".join(names[i] for i in restless[:4]) or "the when-clauses"
        switch = "switches" if len(restless) == 1 else "switch"
        return Diagnostic(
            "R433",
            f"the events at t = {t:.6g} s do not come to rest: {culprits} {switch} to and fro",
            spans[restless[0]] if restless else None,
            hint="break the loop with `pre(...)`, or make the relation's two sides agree",
        )

    def _failed(self, t: float, done: Processed) -> Processed:
        done.ended = failure.at_event(self.program, self.kernel, t, done.reset)
        return done

    def causes(self, crossing: Iterable[int], samples: Iterable[int]) -> tuple[str, ...]:
        program, read = self.program, self._reader(0.0)
        texts = [program.relations[i].text for i in crossing]
        texts += [
            f"sample({read(program.samplers[i][1]):g}, {read(program.samplers[i][2]):g})"
            for i in samples
        ]
        return tuple(texts)

    def finish(self) -> None:
        self.set_flag(TERMINAL, True)


def _no_value(t: float, name: str, action: SetDiscrete | Reinit) -> Diagnostic:
    return Diagnostic(
        "R421",
        f"at t = {t:.6g} s the value that the event gives `{name}` is no finite number",
        action.span,
        hint="look for a division by zero, or the root of a negative number",
    )


def assertion_diagnostic(t: float, assertion: Assertion, message: str) -> Diagnostic:
    place = f" in `{assertion.component}`" if assertion.component else ""
    return Diagnostic(
        "R430",
        f"assertion failed at t = {t:.6g} s{place}: {message}",
        assertion.span,
        Severity.WARNING if assertion.warning else Severity.ERROR,
    )


def _initial_conditions(program: Program) -> frozenset[int]:
    """Slots of the conditions that `initial()` makes true."""
    marked = set()
    for statement in program.discrete:
        if isinstance(statement, Let) and any(
            e.op is Op.SYMBOL and (e.name == INITIAL or e in marked)
            for e in postorder((statement.value,))
        ):
            marked.add(statement.target)
    return frozenset(program.slots[repr(e)] for e in marked if repr(e) in program.slots)
