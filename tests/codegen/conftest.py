"""Sorted models written by hand: what `structure` gives for small mechanisms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import pytest

from planarc.core.source import NOWHERE
from planarc.ir.calculus import time_derivative
from planarc.ir.dae import Dae, Equation, Kind, Parameter, Variable
from planarc.ir.expr import Expr, Exprs
from planarc.ir.flat import StateSelect
from planarc.ir.sorted import (
    Alias,
    Assignment,
    Block,
    Candidate,
    Level,
    Residual,
    SortedDae,
    SourceEquation,
    Step,
)


@dataclass
class Builder:
    """Collects parameters, variables and levels; gives the sorted model."""

    name: str
    t: Exprs = field(default_factory=Exprs)
    parameters: list[Parameter] = field(default_factory=list)
    variables: list[Variable] = field(default_factory=list)
    candidates: list[Candidate] = field(default_factory=list)
    levels: list[Level] = field(default_factory=list)
    aliases: list[Alias] = field(default_factory=list)
    guesses: list[tuple[Expr, Expr]] = field(default_factory=list)
    equations: list[SourceEquation] = field(default_factory=list)

    def parameter(self, name: str, value: float | Expr) -> Expr:
        settable = not isinstance(value, Expr)
        e = value if isinstance(value, Expr) else self.t.const(value)
        self.parameters.append(Parameter(name, Kind.REAL, e, settable))
        return self.t.symbol(name)

    def variable(self, name: str) -> Expr:
        self.variables.append(Variable(name))
        return self.t.symbol(name)

    def candidate(self, symbol: Expr, start: float) -> None:
        self.candidates.append(
            Candidate(
                symbol,
                str(symbol),
                StateSelect.PREFER,
                self.t.const(start),
                True,
                False,
                None,
                NOWHERE,
            )
        )

    def equation(self, left: Expr, right: Expr) -> int:
        self.equations.append(SourceEquation(Equation(left, right)))
        return len(self.equations) - 1

    def assign(self, target: Expr, value: Expr) -> Assignment:
        return Assignment(target, value, self.equation(target, value))

    def residual(self, value: Expr) -> Residual:
        return Residual(value, self.equation(self.t.zero, value))

    def level(self, height: int, *steps: Step) -> None:
        self.levels.append(Level(height, steps))

    def der(self, e: Expr) -> Expr:
        names = {p.name for p in self.parameters}
        return time_derivative(self.t, names.__contains__)(e)

    def sorted(self) -> SortedDae:
        dae = Dae(self.name, self.t, tuple(self.variables), tuple(self.parameters), ())
        return SortedDae(
            dae,
            tuple(self.equations),
            tuple(self.aliases),
            tuple(self.levels),
            tuple(self.candidates),
            guesses=tuple(self.guesses),
        )


@pytest.fixture
def filter() -> SortedDae:
    """T*der(x) = sin(time) - x, y = -x."""
    b = Builder("Filter")
    tau = b.parameter("T", 0.5)
    x = b.variable("x")
    b.variable("y")
    b.candidate(x, 1.0)
    b.aliases.append(Alias("y", x, -1))
    b.level(1, Block((x,)))
    value = b.t.div(b.t.sub(b.t.call("sin", b.t.time), x), tau)
    b.level(0, b.assign(b.t.der(x), value))
    return b.sorted()


@pytest.fixture
def pendulum() -> SortedDae:
    """m*L^2*der(w) = -m*g*L*sin(phi) with w = der(phi), and its power for the result."""
    b = Builder("Pendulum")
    t = b.t
    m, length, g = b.parameter("m", 2.0), b.parameter("L", 0.7), b.parameter("g", 9.81)
    b.parameter("I", t.mul(m, length, length))
    phi = b.variable("rev.phi")
    b.variable("rev.w")
    power, force = b.variable("power"), b.variable("body.f")
    w, z = t.der(phi), t.der(t.der(phi))
    b.aliases.append(Alias("rev.w", w, 1))
    b.candidate(phi, 0.3)
    b.candidate(w, -0.2)
    b.level(2, Block((phi,)))
    b.level(1, Block((w,)))
    gravity = t.mul(m, g, length, t.call("sin", phi))
    b.level(
        0,
        b.assign(force, t.neg(gravity)),
        Block((z,), (), (b.residual(t.sub(t.mul(t.symbol("I"), z), force)),), linear=True),
        b.assign(power, t.mul(w, gravity)),
    )
    return b.sorted()


def _loop(b: Builder) -> tuple[tuple[Expr, ...], tuple[Expr, ...], tuple[Assignment, ...]]:
    """Angles, closing conditions, and an inner unknown of a four-bar."""
    t = b.t
    lengths = [b.parameter(f"L{i}", v) for i, v in enumerate((1.0, 0.4, 1.1, 0.8))]
    phi = tuple(b.variable(f"j{i}.phi") for i in (1, 2, 3))
    angle = b.variable("rod.angle")
    inner = b.assign(angle, t.add(phi[0], phi[1]))
    x = t.sub(
        t.add(t.mul(lengths[1], t.call("cos", phi[0])), t.mul(lengths[2], t.call("cos", angle))),
        t.add(lengths[0], t.mul(lengths[3], t.call("cos", phi[2]))),
    )
    y = t.sub(
        t.add(t.mul(lengths[1], t.call("sin", phi[0])), t.mul(lengths[2], t.call("sin", angle))),
        t.mul(lengths[3], t.call("sin", phi[2])),
    )
    return phi, (x, y), (inner,)


@pytest.fixture
def four_bar() -> SortedDae:
    """A loop: three angles, one of them free; masses at the crank and the rocker."""
    b = Builder("FourBar")
    t = b.t
    m, g = b.parameter("m", 1.5), b.parameter("g", 9.81)
    phi, closing, inner = _loop(b)
    for p, start in zip(phi, (1.2, -0.8, 1.9), strict=True):
        b.candidate(p, start)
    speed = tuple(t.der(p) for p in phi)
    for s, start in zip(speed, (0.5, 0.0, 0.0), strict=True):
        b.candidate(s, start)
    force = (b.variable("f.x"), b.variable("f.y"))

    def differentiated(
        inner: tuple[Assignment, ...], values: tuple[Expr, ...]
    ) -> tuple[tuple[Assignment, ...], tuple[Expr, ...]]:
        return (
            tuple(b.assign(t.der(a.target), b.der(a.value)) for a in inner),
            tuple(b.der(v) for v in values),
        )

    b.level(2, Block(phi, inner, tuple(b.residual(c) for c in closing)))
    inner1, closing1 = differentiated(inner, closing)
    b.level(1, Block(speed, inner1, tuple(b.residual(c) for c in closing1), linear=True))
    inner2, closing2 = differentiated(inner1, closing1)
    acceleration = tuple(t.der(s) for s in speed)
    # Lagrange's equations of the first kind, with the closing conditions' gradients.
    from planarc.ir.calculus import partial
    from planarc.ir.expr import Substitution

    put_in = Substitution(t, {inner[0].target: inner[0].value})
    balance = []
    for i, p in enumerate(phi):
        gradient = [partial(t, p)(put_in(c)) for c in closing]
        load = t.mul(m, g, t.call("cos", p)) if i != 1 else t.mul(t.const(0.1), speed[1])
        inertia = t.mul(t.add(m, t.const(float(i))), acceleration[i])
        reaction = t.add(*(t.mul(f, k) for f, k in zip(force, gradient, strict=True)))
        balance.append(b.residual(t.add(inertia, load, reaction)))
    b.level(
        0,
        Block(
            (*acceleration, *force),
            inner2,
            (*balance, *(b.residual(c) for c in closing2)),
            linear=True,
        ),
    )
    return b.sorted()


@pytest.fixture
def nonlinear() -> SortedDae:
    """der(x) = -z where z^3 + z = x + 2: a nonlinear block in the top level."""
    b = Builder("Nonlinear")
    t = b.t
    x, z, half = b.variable("x"), b.variable("z"), b.variable("half")
    b.candidate(x, 1.0)
    b.guesses.append((z, t.const(0.5)))
    b.level(1, Block((x,)))
    cubic = t.sub(t.add(t.mul(z, z, z), t.mul(t.const(2.0), half)), t.add(x, t.const(2.0)))
    b.level(
        0,
        Block((z,), (b.assign(half, t.mul(t.const(0.5), z)),), (b.residual(cubic),)),
        b.assign(t.der(x), t.neg(z)),
    )
    return b.sorted()


@pytest.fixture(scope="session")
def build() -> Callable[[str], Builder]:
    return Builder


@pytest.fixture
def switched() -> SortedDae:
    """der(x) = if x > 0 then a + a else -x, where a = sqrt(x) + 1/x stands in the branch."""
    b = Builder("Switched")
    t = b.t
    x = b.variable("x")
    b.candidate(x, 2.0)
    b.level(1, Block((x,)))
    a = t.add(t.call("sqrt", x), t.div(t.one, x))
    twice = t.add(t.mul(a, a), t.mul(t.const(2.0), a), t.neg(t.mul(a, a)))
    b.level(0, b.assign(t.der(x), t.if_(t.less(t.zero, x), twice, t.neg(x))))
    return b.sorted()
