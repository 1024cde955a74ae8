"""The sorted model: what is evaluated in which order, and what the states may be.

Given by `structure`, read by `codegen`. After index reduction the unknowns lie in
levels. The top level (the last) holds the highest derivatives and all algebraic
unknowns. The level below it holds their first antiderivatives (velocities), the
next one the second (positions); a constraint that was differentiated k times
appears in the top level and in the k levels below it.

Each level is a sequence of steps, evaluated in order:

    Assignment   an unknown from known ones, explicitly
    Block        a torn system: guess the tears, run the inner assignments, and the
                 residuals must vanish

Below the top, a block may have more tears than residuals. Its tears are the
*candidates* for states: `free = tears - residuals` of them are states, which ones
is chosen while running, per block, by pivoting its Jacobian. A block without
residuals has only states (an ordinary differential equation). So one sorted model
serves every choice of states. In the top level tears and residuals are equal in
number.

A plain double pendulum has the levels

    1 positions      Block(tears=(rev1.phi,)), Block(tears=(rev2.phi,)), assignments ...
    0 top            Block(tears=(der(der(rev1.phi)), ...), linear), assignments ...

where the velocities, `level 1` of three, look like the positions.
"""

from __future__ import annotations

from typing import ClassVar, TypeAlias

from planarc.core.data import Data
from planarc.core.source import Span
from planarc.ir.dae import Dae, Equation
from planarc.ir.expr import Expr
from planarc.ir.flat import StateSelect


class SourceEquation(Data):
    """An equation of the reduced system and where it came from.

    `derived_from` is the index of the equation whose time derivative this is;
    `order` how often the user's equation was differentiated in all.
    """

    equation: Equation
    derived_from: int | None = None
    order: int = 0

    @property
    def span(self) -> Span:
        return self.equation.span


class Alias(Data):
    """A variable that needs no computation of its own: sign * symbol, or a constant.

    `target` is a symbol (maybe a derivative: `w` is `der(phi)`), or an expression of
    parameters and time alone. `sign` is 1 or -1.
    """

    name: str
    target: Expr
    sign: int
    equation: int | None = None  # the equation that said so


class Residual(Data):
    value: Expr  # must be zero
    equation: int


class Assignment(Data):
    """A variable with its value. As a step it is a block of one inner assignment, in which nothing
    is guessed."""

    target: Expr  # a symbol
    value: Expr
    equation: int  # index in SortedDae.equations
    tears: ClassVar[tuple[Expr, ...]] = ()
    residuals: ClassVar[tuple[Residual, ...]] = ()
    free: ClassVar[int] = 0

    @property
    def inner(self) -> tuple[Assignment, ...]:
        return (self,)


class Block(Data):
    """A torn system. `inner` depends on the tears and is evaluated in its order."""

    tears: tuple[Expr, ...]
    inner: tuple[Assignment, ...] = ()
    residuals: tuple[Residual, ...] = ()
    linear: bool = False  # all residuals are affine in the tears, inner assignments put in

    @property
    def free(self) -> int:
        return len(self.tears) - len(self.residuals)


Step: TypeAlias = Assignment | Block


def computed(step: Step) -> tuple[Expr, ...]:
    """The symbols that a step computes."""
    return (*step.tears, *(a.target for a in step.inner))


class Level(Data):
    """`height` 0 is the top; the states lie in the levels above 0."""

    height: int
    steps: tuple[Step, ...]


class Candidate(Data):
    """A symbol that can be a state. Its derivative is known in a level above."""

    symbol: Expr
    display: str  # the user's name for it (`rev.w` for `der(rev.phi)` when there is one)
    select: StateSelect
    start: Expr | None
    start_written: bool
    fixed: bool
    nominal: Expr | None
    span: Span
    holder: str = ""  # the variable whose start it is, where that is not the one displayed
    at_start: bool = False  # a parameter that the start finds: no state of the mechanism


class Fixed(Data):
    """The attributes given to the start of a variable that is no candidate.

    Held where `fixed`; a `written` start is held where it is independent of others, as
    those of candidates are, and a guess elsewhere. Joint coordinates (StateSelect.prefer)
    whose start was not written are listed too: they tell on which side a loop closes.
    """

    symbol: Expr  # with `sign` already applied to `start`
    start: Expr
    display: str
    span: Span
    fixed: bool = True
    written: bool = True
    select: StateSelect = StateSelect.DEFAULT
    height: int = 0  # of the candidates that it follows from; 0: of accelerations too
    holder: str = ""  # as of a candidate


class SortedDae(Data):
    dae: Dae
    equations: tuple[SourceEquation, ...]
    aliases: tuple[Alias, ...]  # every variable is an alias, a candidate, or assigned
    levels: tuple[Level, ...]  # from the lowest (positions) to the top
    candidates: tuple[Candidate, ...]  # the tears of the levels below the top, in their order
    fixed: tuple[Fixed, ...] = ()
    guesses: tuple[tuple[Expr, Expr], ...] = ()  # start values of top tears: (symbol, start)
    initial_residuals: tuple[Residual, ...] = ()  # initial equations, in the kept symbols
    discrete: tuple[Assignment, ...] = ()  # discrete equations in evaluation order
    equations_before: int = 0  # scalar equations of the flat model
    equations_after: int = 0  # those left after alias elimination

    @property
    def state_count(self) -> int:
        return sum(step.free for level in self.levels if level.height for step in level.steps)
