"""Programs written by hand, and a kernel that needs no code generation.

`Interpreter` turns the statement lists into Python and solves blocks with NumPy: a
third back end, slow and simple, that the solver is tested with. `Mechanism` writes the
program of a mechanism in coordinates q with masses M(q), forces Q(q, v) and position
constraints c(q) = 0, as `structure` and `codegen` would.
"""

from __future__ import annotations

import math
from collections.abc import Callable, MutableSequence, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

import planarc
from planarc.core.diagnostic import Diagnostic
from planarc.core.source import NOWHERE, Source, Span
from planarc.ir import mechanism
from planarc.ir.calculus import Differentiator
from planarc.ir.dae import Action, Assertion, Kind
from planarc.ir.expr import Expr, Exprs, Op, postorder, symbol_text
from planarc.ir.flat import Experiment, StateSelect
from planarc.ir.kernel import Capabilities
from planarc.ir.program import (
    BlockCode,
    CandidateSlot,
    Column,
    DiscreteSlot,
    EquationInfo,
    FixedSlot,
    Let,
    ParameterSlot,
    Program,
    RelationSlot,
    Solve,
    Statement,
    WhenCode,
)
from planarc.runtime.elementary import TABLE
from planarc.runtime.history import History
from planarc.solve.states.exchange import GoOn, States
from planarc.solve.states.selector import Selector

# The kernel ----------------------------------------------------------------------------------


def _python(e: Expr, slots: dict[str, int]) -> str:
    """The expression as Python over `w` (slots), `v` (temporaries) and `t`."""
    done: dict[Expr, str] = {}
    for x in postorder((e,)):
        a = [done[y] for y in x.args]
        match x.op:
            case Op.CONST:
                done[x] = repr(x.data)
            case Op.TIME:
                done[x] = "t"
            case Op.SYMBOL | Op.PRE | Op.EVENT:
                name = repr(x)
                done[x] = f"w[{slots[name]}]" if name in slots else f"v[{name!r}]"
            case Op.ADD:
                done[x] = "(" + " + ".join(a) + ")"
            case Op.MUL:
                done[x] = "(" + " * ".join(a) + ")"
            case Op.NEG:
                done[x] = f"(-{a[0]})"
            case Op.CALL:
                done[x] = f"F[{x.data!r}]({', '.join(a)})"
            case Op.IF:
                done[x] = f"({a[1]} if {a[0]} else {a[2]})"
            case Op.NOT:
                done[x] = f"(not {a[0]})"
            case _:
                sign = {
                    Op.DIV: "/",
                    Op.POW: "**",
                    Op.LESS: "<",
                    Op.LESS_EQUAL: "<=",
                    Op.EQUAL: "==",
                    Op.AND: "and",
                    Op.OR: "or",
                }[x.op]
                done[x] = f"({a[0]} {sign} {a[1]})"
    return done[e]


class Interpreter:
    """See `planarc.ir.kernel.Kernel`."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.w: MutableSequence[float] = [0.0] * program.size
        self.failed_block = self.failed_equation = self.open_block = -1
        self.near_singular = False
        self.capabilities = Capabilities()
        self.history = History(0)
        self._v: dict[str, float] = {}
        self._run = {
            name: self._function(statements)
            for name, statements in (
                ("parameters", program.parameters),
                ("levels", [s for level in program.levels for s in level]),
                ("rest", program.rest),
                ("initial", program.initial),
                ("roots", program.roots),
                ("discrete", program.discrete),
            )
        }
        self._bodies = [self._function(b.body, b.residuals) for b in program.blocks]
        self._tears = [[program.slots[repr(x)] for x in b.tears] for b in program.blocks]
        self._states: set[int] = set()
        self._given = False
        self._accepted = (0.0, list(self.w))
        self._t = 0.0

    def _function(
        self, statements: Sequence[Statement], values: Sequence[Expr] = ()
    ) -> Callable[[float], list[float]]:
        """The statements as Python, which gives these values in the end."""
        slots = dict(self.program.slots)

        def place(name: str) -> str:
            return f"w[{slots[name]}]" if name in slots else f"v[{name!r}]"

        lines = ["def f(t):"]
        for s in statements:
            if isinstance(s, Solve):
                lines.append(f"    solve({s.block}, t)")
            else:
                target = place(repr(s.target))
                lines.append(f"    {target} = float({_python(s.value, slots)})")
        lines.append(f"    return [{', '.join(place(repr(x)) for x in values)}]")
        space = {
            "w": self.w,
            "v": self._v,
            "F": {n: row.value for n, row in TABLE.items()},
            "solve": self._solve,
        }
        exec("\n".join(lines), space)
        return space["f"]

    def _solve(self, index: int, t: float) -> None:
        block, w = self.program.blocks[index], self.w
        slots = self._tears[index]
        if block.height:
            unknown = [k for k in range(len(slots)) if block.first + k not in self._states]
            if self._given:
                unknown = []
        else:
            unknown = list(range(len(slots)))
        if not unknown:
            self._bodies[index](t)
            return
        t0, past = self._accepted
        for k in unknown:
            w[slots[k]] = past[slots[k]]
            if block.height:
                w[slots[k]] += (t - t0) * past[self.program.candidates[block.first + k].derivative]
        for _ in range(20):
            r = self._residuals(index, t)
            jacobian = np.empty((len(r), len(unknown)))
            for column, k in enumerate(unknown):
                old = w[slots[k]]
                h = 1.0 if block.linear else 1e-7 * max(1.0, abs(old))
                w[slots[k]] = old + h
                jacobian[:, column] = (self._residuals(index, t) - r) / h
                w[slots[k]] = old
            if len(unknown) > 1 or jacobian[0, 0] == 0.0:
                sizes = np.linalg.svd(jacobian, compute_uv=False)
                if sizes[-1] <= 1e-13 * sizes[0]:
                    raise Unsolved(index)
            step = np.linalg.solve(jacobian, -r)
            for k, d in zip(unknown, step, strict=True):
                w[slots[k]] += d
            if block.linear or max(abs(step)) < 1e-11:
                self._bodies[index](t)
                return
        raise Unsolved(index)

    def _residuals(self, index: int, t: float) -> np.ndarray:
        return np.array(self._bodies[index](t))

    def _value(self, e: Expr) -> float:
        name = repr(e)
        return self.w[self.program.slots[name]] if name in self.program.slots else self._v[name]

    def _guarded(self, *parts: str, t: float) -> int:
        self.failed_block = -1
        self._t = self.w[0] = t
        try:
            for part in parts:
                self._run[part](t)
        except Unsolved as problem:
            self.failed_block = problem.block
            return 1
        except (ArithmeticError, ValueError):
            return -1
        return 0

    def parameters(self) -> int:
        return self._guarded("parameters", t=0.0)

    def select(self, selection: Sequence[int]) -> None:
        self.selection = list(selection)
        self._states = set(selection)

    def accept(self, t: float) -> None:
        self._accepted = (t, list(self.w))

    def _set(self, y: Sequence[float]) -> None:
        for i, value in zip(self.selection, y, strict=True):
            self.w[self.program.candidates[i].slot] = float(value)

    def rhs(self, t: float, y: Sequence[float], ydot: MutableSequence[float]) -> int:
        self._set(y)
        flag = self._guarded("levels", t=t)
        for k, i in enumerate(self.selection):
            ydot[k] = self.w[self.program.candidates[i].derivative]
        if flag == 0 and not all(map(math.isfinite, ydot)):
            return -1
        return flag

    def outputs(self, t: float, y: Sequence[float]) -> int:
        self._set(y)
        return self._guarded("levels", "rest", t=t)

    def residuals(self, t: float, u: Sequence[float], r: MutableSequence[float]) -> int:
        for c, value in zip(self.program.candidates, u, strict=True):
            self.w[c.slot] = value
        self._given = True
        flag = self._guarded("levels", "rest", "initial", t=t)
        self._given = False
        below = [x for b in self.program.blocks if b.height for x in b.residuals]
        found = [self._value(x) for x in (*below, *self.program.initial_residuals)]
        r[: len(found)] = found
        return flag

    def jacobian(self, block: int) -> Sequence[Sequence[float]]:
        code = self.program.blocks[block]
        r = self._residuals(block, self._t)
        result = np.empty((len(r), len(code.tears)))
        for k, tear in enumerate(code.tears):
            slot = self.program.slots[repr(tear)]
            old = self.w[slot]
            self.w[slot] = old + 1e-7
            above = self._residuals(block, self._t)
            self.w[slot] = old - 1e-7
            result[:, k] = (above - self._residuals(block, self._t)) / 2e-7
            self.w[slot] = old
        self._residuals(block, self._t)
        return result.tolist()

    def roots(self, t: float, y: Sequence[float], g: MutableSequence[float]) -> int:
        self._set(y)
        flag = self._guarded("levels", "roots", t=t)
        for i, relation in enumerate(self.program.relations):
            g[i] = self._value(relation.zero)
        return flag

    def discrete(self) -> int:
        return self._guarded("discrete", t=self._t)


class Unsolved(Exception):
    def __init__(self, block: int) -> None:
        self.block = block


# Programs -------------------------------------------------------------------------------------


@dataclass
class Coordinate:
    name: str
    start: float = 0.0
    speed: float = 0.0
    written: bool = False
    speed_written: bool = False
    fixed: bool = False
    speed_fixed: bool = False
    select: StateSelect = StateSelect.PREFER


@dataclass
class Mechanism:
    """M*a + G'*l = Q, G*a = -dG/dt*v, written as one linear block in the top level.

    Without constraints each acceleration is assigned. `parameters` get slots of their
    own. `extra` are further variables, computed last.
    """

    coordinates: Sequence[Coordinate]
    mass: Callable[[Exprs, list[Expr]], list[list[Expr]]]
    force: Callable[[Exprs, list[Expr], list[Expr]], list[Expr]]
    constraints: Callable[[Exprs, list[Expr]], list[Expr]] = lambda t, q: []
    components: Sequence[str] = ()
    parameters: dict[str, float] = field(default_factory=dict)
    extra: Callable[[Exprs], list[tuple[str, Expr]]] = lambda t: []
    relations: Callable[[Exprs], list[tuple[Expr, bool, bool, str]]] = lambda t: []
    discretes: Callable[[Exprs], list[tuple[str, Expr | None, float]]] = lambda t: []
    whens: Callable[[Exprs], list[tuple[str, list[Action]]]] = lambda t: []
    asserts: Callable[[Exprs], list[Assertion]] = lambda t: []
    initial: Callable[[Exprs], list[Expr]] = lambda t: []
    fixed: Sequence[tuple[str, float]] = ()
    samplers: Sequence[tuple[float, float]] = ()
    stop: float = 1.0

    def program(self) -> Program:
        return _Writer(self).write()


SOURCE = Source("test.pmo", "\n".join(f"line {i + 1}" for i in range(60)))


def line(number: int) -> Span:
    offset = len("\n".join(SOURCE.text.split("\n")[: number - 1])) + (number > 1)
    return Span(SOURCE, offset, offset + 4)


class _Writer:
    def __init__(self, m: Mechanism) -> None:
        self.m, self.t = m, Exprs()
        self.slots: dict[str, int] = {"time": 0}

    def slot(self, name: str) -> int:
        return self.slots.setdefault(name, len(self.slots))

    def write(self) -> Program:
        m, t = self.m, self.t
        parameters = tuple(
            ParameterSlot(n, self.slot(n), Kind.REAL, True, False, default=v)
            for n, v in m.parameters.items()
        )
        q = [t.symbol(c.name) for c in m.coordinates]
        v, a = [t.der(x) for x in q], [t.der(t.der(x)) for x in q]
        n = len(q)
        for x in (*q, *v, *a):
            self.slot(repr(x))
        rules = {**dict(zip(q, v, strict=True)), **dict(zip(v, a, strict=True))}
        dt = Differentiator(t, lambda e: rules.get(e, t.one if e.op is Op.TIME else t.zero))
        c = m.constraints(t, q)
        c1 = [dt(x) for x in c]
        c2 = [dt(x) for x in c1]
        k = len(c)
        multipliers = [t.symbol(f"lambda{i}") for i in range(k)]
        for x in multipliers:
            self.slot(repr(x))
        names = m.components or [x.name.rpartition(".")[0] for x in q]
        equations = tuple(
            EquationInfo(f"constraint {i + 1} = 0", line(10 + i), names[i % len(names)])
            for i in range(k)
        )

        def below(height: int, tears: list[Expr], residuals: list[Expr], first: int) -> BlockCode:
            temps = [t.symbol(f"$r{height}_{i}") for i in range(k)]
            body = tuple(
                Let(x, r, i) for i, (x, r) in enumerate(zip(temps, residuals, strict=True))
            )
            return BlockCode(
                height,
                tuple(tears),
                body,
                tuple(temps),
                (),
                (),
                height == 1,
                tuple(range(k)),
                first,
            )

        blocks = [below(2, q, c, 0), below(1, v, c1, n)]
        levels: list[tuple[Statement, ...]] = [(Solve(0),), (Solve(1),)]
        mass, force = m.mass(t, q), m.force(t, q, v)
        if k == 0 and all(mass[i][j] is t.zero for i in range(n) for j in range(n) if i != j):
            levels.append(tuple(Let(a[i], t.div(force[i], mass[i][i])) for i in range(n)))
        else:
            temps = [t.symbol(f"$r0_{i}") for i in range(n + k)]
            rows = []
            for i in range(n):
                by = Differentiator(t, lambda e, i=i: t.one if e is q[i] else t.zero)
                rows.append(
                    t.add(
                        *(t.mul(mass[i][j], a[j]) for j in range(n)),
                        *(t.mul(by(x), y) for x, y in zip(c, multipliers, strict=True)),
                        t.neg(force[i]),
                    )
                )
            body = tuple(Let(x, r) for x, r in zip(temps, [*rows, *c2], strict=True))
            blocks.append(
                BlockCode(0, (*a, *multipliers), body, tuple(temps), (), (), True, (), -1)
            )
            levels.append((Solve(2),))
        extra = [(t.symbol(name), e) for name, e in m.extra(t)]
        for x, _ in extra:
            self.slot(repr(x))
        rest = tuple(Let(x, e) for x, e in extra)
        relations = m.relations(t)
        relation_slots = tuple(
            RelationSlot(self.slot(f"event[{i}]"), t.symbol(f"$g{i}"), s, only, text, line(20 + i))
            for i, (_, s, only, text) in enumerate(relations)
        )
        roots = tuple(Let(t.symbol(f"$g{i}"), r[0]) for i, r in enumerate(relations))
        samplers = tuple(
            (self.slot(f"$sample[{i}]"), t.const(s), t.const(d), NOWHERE)
            for i, (s, d) in enumerate(m.samplers)
        )
        self.slot("$initial")
        self.slot("$terminal")
        discretes = m.discretes(t)
        for name, _, _ in discretes:
            self.slot(name)
            self.slot(f"pre({name})")
        starts: list[Let] = []

        def start(name: str, value: float) -> int:
            symbol = t.symbol(f"start({name})")
            slot = self.slot(repr(symbol))
            starts.append(Let(symbol, t.const(value)))
            return slot

        discrete_slots = tuple(
            DiscreteSlot(
                name, Kind.REAL, self.slot(name), self.slot(f"pre({name})"), start(name, value)
            )
            for name, _, value in discretes
        )
        discrete = tuple(Let(t.symbol(name), e) for name, e, _ in discretes if e is not None)
        whens = tuple(
            WhenCode(((self.slot(name), self.slot(f"pre({name})"), tuple(actions)),), line(30))
            for name, actions in m.whens(t)
        )
        candidates = []
        for i, x in enumerate(m.coordinates):
            candidates.append(
                CandidateSlot(
                    x.name,
                    x.name,
                    self.slot(x.name),
                    self.slot(symbol_text(x.name, 1)),
                    start(x.name, x.start),
                    x.written or x.fixed,
                    x.fixed,
                    x.select,
                    None,
                    0,
                    line(1 + i),
                )
            )
        for i, x in enumerate(m.coordinates):
            name = symbol_text(x.name, 1)
            candidates.append(
                CandidateSlot(
                    name,
                    name,
                    self.slot(name),
                    self.slot(symbol_text(x.name, 2)),
                    start(name, x.speed),
                    x.speed_written or x.speed_fixed,
                    x.speed_fixed,
                    x.select,
                    None,
                    1,
                    line(1 + i),
                )
            )
        fixed = tuple(
            FixedSlot(name, self.slot(name), start(f"fixed {name}", value), line(40))
            for name, value in m.fixed
        )
        initial = m.initial(t)
        initial_symbols = [t.symbol(f"$i{i}") for i in range(len(initial))]
        columns = [
            Column(repr(x), self.slot(repr(x)), 1, Kind.REAL)
            for x in (*q, *v, *a, *multipliers, *(x for x, _ in extra))
        ]
        columns += [Column(d.name, d.slot, 1, Kind.REAL) for d in discrete_slots]
        columns += [Column(p.name, p.slot, 1, Kind.REAL, constant=True) for p in parameters]
        return Program(
            name="Test",
            table=t,
            size=len(self.slots) + 1,
            slots=dict(self.slots),
            columns=tuple(columns),
            parameter_slots=parameters,
            candidates=tuple(candidates),
            fixed=fixed,
            discretes=discrete_slots,
            relations=relation_slots,
            samplers=samplers,
            whens=whens,
            assertions=tuple(m.asserts(t)),
            blocks=tuple(blocks),
            parameters=tuple(starts),
            levels=tuple(levels),
            rest=rest,
            initial=tuple(Let(x, e) for x, e in zip(initial_symbols, initial, strict=True)),
            initial_residuals=tuple(initial_symbols),
            roots=roots,
            discrete=discrete,
            equations=equations,
            initial_equations=tuple(
                EquationInfo(f"initial {i + 1}", line(45 + i), "") for i in range(len(initial))
            ),
            experiment=Experiment(stop=m.stop),
            mechanism=mechanism.Mechanism((mechanism.Link("ground", ()),), ()),
        )


# Mechanisms -----------------------------------------------------------------------------------


def pendulum(**changes: object) -> Mechanism:
    """m = L = 1; phi from the x-axis; gravity 9.81 along -y."""
    return Mechanism(
        [Coordinate("rev.phi", start=0.0)],
        mass=lambda t, q: [[t.one]],
        force=lambda t, q, v: [t.mul(t.const(-9.81), t.call("cos", q[0]))],
        **changes,  # type: ignore[arg-type]
    )


def four_bar(
    coordinates: Sequence[Coordinate] | None = None,
    lengths: tuple[float, float, float, float] = (0.4, 0.9, 0.8, 1.0),
    **changes: object,
) -> Mechanism:
    """Absolute angles of crank, coupler, rocker; unit masses at the bars' ends, gravity."""
    a, b, c, d = lengths
    given = coordinates or [
        Coordinate("revA.phi", 1.0, fixed=True, speed_fixed=True),
        Coordinate("revB.phi", 0.5, written=True),
        Coordinate("revD.phi", 1.6, written=True),
    ]

    def constraints(t: Exprs, q: list[Expr]) -> list[Expr]:
        def along(f: str) -> Expr:
            return t.add(
                t.mul(t.const(a), t.call(f, q[0])),
                t.mul(t.const(b), t.call(f, q[1])),
                t.mul(t.const(-c), t.call(f, q[2])),
            )

        return [t.add(along("cos"), t.const(-d)), along("sin")]

    def mass(t: Exprs, q: list[Expr]) -> list[list[Expr]]:
        cross = t.mul(t.const(a * b), t.call("cos", t.sub(q[0], q[1])))
        return [
            [t.const(2 * a * a), cross, t.zero],
            [cross, t.const(b * b), t.zero],
            [t.zero, t.zero, t.const(c * c)],
        ]

    def force(t: Exprs, q: list[Expr], v: list[Expr]) -> list[Expr]:
        s = t.mul(t.const(a * b), t.call("sin", t.sub(q[0], q[1])))
        g = -9.81
        return [
            t.add(t.mul(t.const(2 * a * g), t.call("cos", q[0])), t.neg(t.mul(s, v[1], v[1]))),
            t.add(t.mul(t.const(b * g), t.call("cos", q[1])), t.mul(s, v[0], v[0])),
            t.mul(t.const(c * g), t.call("cos", q[2])),
        ]

    options = {"constraints": constraints, "components": ("loop.revC",), "stop": 2.0, **changes}
    return Mechanism(given, mass=mass, force=force, **options)  # type: ignore[arg-type]


def crank_slider(
    crank: Coordinate, slider: Coordinate, rod: float = 1.0, radius: float = 0.3
) -> Mechanism:
    """Crank with inertia 1 turning freely; a slider without mass to speak of (0.1 kg)."""

    def constraints(t: Exprs, q: list[Expr]) -> list[Expr]:
        x = t.sub(q[1], t.mul(t.const(radius), t.call("cos", q[0])))
        y = t.mul(t.const(radius), t.call("sin", q[0]))
        return [t.add(t.mul(x, x), t.mul(y, y), t.const(-rod * rod))]

    return Mechanism(
        [crank, slider],
        mass=lambda t, q: [[t.one, t.zero], [t.zero, t.const(0.1)]],
        force=lambda t, q, v: [t.zero, t.zero],
        constraints=constraints,
        components=("joint",),
        stop=5.0,
    )


@dataclass
class Toolbox:
    Interpreter = Interpreter
    Mechanism = Mechanism
    Coordinate = Coordinate
    pendulum = staticmethod(pendulum)
    four_bar = staticmethod(four_bar)
    crank_slider = staticmethod(crank_slider)
    line = staticmethod(line)


@pytest.fixture
def tools() -> Toolbox:
    return Toolbox()


# Runs that end early ---------------------------------------------------------------------------


def run_until_stopped(
    text: str, backend: str, stop: float, **options: Any
) -> tuple[Diagnostic, planarc.Result]:
    """Why a model cannot go on, and the rows until then."""
    if backend == "native":
        pytest.importorskip("llvmlite")
    with pytest.raises(planarc.RunStopped) as caught:
        planarc.load(text, backend=backend).simulate(stop, **options)
    (diagnostic,) = caught.value.diagnostics
    return diagnostic, caught.value.result


@pytest.fixture
def stopped() -> Callable[..., tuple[Diagnostic, planarc.Result]]:
    return run_until_stopped


@pytest.fixture
def made_late(monkeypatch: pytest.MonkeyPatch) -> Callable[[], list[tuple[float, float]]]:
    """Once called, the first look that exchanges states finds that it came too late; gives the
    times from which runs go back, and to which."""

    def begin() -> list[tuple[float, float]]:
        look, back = Selector.check, States._go_back
        late: list[bool] = []
        times: list[tuple[float, float]] = []

        def check(selector: Selector, urgent: bool = False) -> Any:
            found = look(selector, urgent)
            if found[0] and not late:
                selector.overdue = True
                late.append(True)
            return found

        def go_back(states: States, t: float) -> GoOn | None:
            if states.selector.overdue:
                found = back(states, t)
                times.append((t, t if found is None else found.t))
                return found
            return None

        monkeypatch.setattr(Selector, "check", check)
        monkeypatch.setattr(States, "_go_back", go_back)
        return times

    return begin
