"""The program: everything a run needs, as plain data.

Given by `codegen`, read by `solve`. All values of a run live in one workspace `w`
of float64 (truth values are 0 and 1). The layout says which slot holds what; the
statement lists say how slots are computed, and are printed twice: as NumPy source
and as LLVM. What is loaded and called is a `planarc.ir.kernel.Kernel`, made from a program
by `solve` with either back end.

Statements read and write slots through symbols, so one expression tree serves
both printers. Shared subexpressions stand as `Let` with temporaries.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import TypeAlias

from msgspec import field

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic
from planarc.core.source import NOWHERE, Span
from planarc.ir.dae import Action, Assertion, Declared, Kind, Visual, equation_text
from planarc.ir.expr import Expr, Exprs
from planarc.ir.figure import Figure
from planarc.ir.flat import Experiment, Part, StateSelect
from planarc.ir.mechanism import Mechanism
from planarc.ir.once import once

# Statements ----------------------------------------------------------------------------


class Let(Data):
    """target := value; a target is a symbol with a slot, or a temporary (`$t12`)."""

    target: Expr
    value: Expr
    equation: int | None = None


class Solve(Data):
    """Solve block `block` of `Program.blocks` (choosing among its candidates by selection)."""

    block: int


Statement: TypeAlias = Let | Solve


class Tangent(Data):
    """A column of a Jacobian as statements: `entries[i]` is that of residual i."""

    seeds: tuple[Expr, ...]  # a temporary for each tear
    body: tuple[Let, ...]
    entries: tuple[Expr, ...]


class Direct(Data):
    """A linear block as a sparse system that is eliminated in a fixed order (`planarc.ir.sparse`).

    What comes out counts when every residual is within rounding of its size
    (`planarc.ir.newton.FITS`); else the block is solved with pivoting.
    """

    unknowns: tuple[Expr, ...]  # the tears, then the inner ones that residuals depend on
    values: tuple[Expr, ...]  # what has a slot, and numbers
    rows: tuple[int, ...]
    operations: tuple[tuple[int, ...], ...]
    tears: tuple[int, ...]


class BlockCode(Data):
    """A torn block as code.

    `body` computes inner unknowns, then the residuals into `residuals`; `jacobian`
    computes d(residual i)/d(tear j), inner assignments put in, as (i, j, value) with
    its own temporaries, valid after `body` ran. `height` > 0: `tears` are candidates
    with the indices `first .. first + len(tears)` and `free` of them are states.

    The first `inner` statements of `body` give every unknown of the block; the others
    only the residuals. A `linear` block has no others: its residuals where all tears
    are zero, and its constant Jacobian, are known before it. A large block
    has no `jacobian` but a `tangent`: run `jacobian_body` once, then the tangent for
    each column j with seed j = 1, all other seeds 0. One with a `direct` solution has
    neither, and its residuals are formulas of its unknowns.

    `modal`: its matrix depends on discrete values, so that it may be singular in some
    modes (`planarc.ir.newton`).
    """

    height: int
    tears: tuple[Expr, ...]
    body: tuple[Let, ...]
    residuals: tuple[Expr, ...]  # temporaries set by body
    jacobian_body: tuple[Let, ...]
    jacobian: tuple[tuple[int, int, Expr], ...]
    linear: bool
    equations: tuple[int, ...]  # of the residuals, into Program.equations
    first: int = -1
    inner: int = 0
    tangent: Tangent | None = None
    direct: Direct | None = None
    modal: bool = False

    @property
    def free(self) -> int:
        return len(self.tears) - len(self.residuals)


# Layout ----------------------------------------------------------------------------------


class Column(Data):
    """A column of the result: sign * w[slot]."""

    name: str
    slot: int
    sign: int
    kind: Kind
    unit: str = ""
    description: str = ""
    constant: bool = False  # a parameter or constant: one value for the whole run
    protected: bool = False
    display_unit: str = ""


class ParameterSlot(Data):
    name: str
    slot: int
    kind: Kind
    settable: bool
    structural: bool
    unit: str = ""
    description: str = ""
    default: float | None = None  # of a settable one
    literals: tuple[str, ...] = ()
    minimum: float | None = None  # where they are numbers, in the unit of the parameter
    maximum: float | None = None
    final: bool = False
    span: Span = NOWHERE


class Limits(Data):
    """What is declared of a variable's values, as expressions of parameters."""

    name: str
    minimum: Expr | None = None
    maximum: Expr | None = None
    nominal: Expr | None = None

    @property
    def numbers(self) -> tuple[float | None, float | None]:
        """Those that hang on no parameter."""
        return limit(self.minimum), limit(self.maximum)


def limit(e: Expr | None) -> float | None:
    """A limit that is a number; one that depends on other parameters is none here."""
    value = float(e.data) if e is not None and e.is_const else math.inf
    return value if math.isfinite(value) else None


class Enumeration(Data):
    """A type whose values are numbers from 1, each with a name; `members` are columns of it."""

    name: str
    literals: tuple[str, ...]
    members: tuple[str, ...]


class CandidateSlot(Data):
    """A candidate for a state. `start` is the slot of its start value, which
    `parameters` computes."""

    name: str  # symbol text: `rev.phi`, `der(rev.phi)`
    display: str
    slot: int
    derivative: int  # slot of its derivative
    start: int
    start_written: bool
    fixed: bool
    select: StateSelect
    nominal: int | None
    block: int  # index in Program.blocks
    span: Span
    holder: str = ""  # the variable whose start it is, where that is not the one displayed
    at_start: bool = False  # a parameter that the start finds: no state of the mechanism

    @property
    def start_name(self) -> str:
        """The variable for whose start the user gave a value."""
        return self.holder or self.display


class FixedSlot(Data):
    """The start of a variable that is no candidate: see `sorted.Fixed`."""

    display: str
    slot: int
    start: int
    span: Span
    fixed: bool = True
    written: bool = True
    select: StateSelect = StateSelect.DEFAULT
    height: int = 0
    holder: str = ""

    @property
    def start_name(self) -> str:
        """The variable for whose start the user gave a value."""
        return self.holder or self.display


class DiscreteSlot(Data):
    name: str
    kind: Kind
    slot: int
    pre: int  # slot of pre(name)
    start: int
    given: Span | None = None  # of an input of the model that nothing sets


class RelationSlot(Data):
    """Truth of a relation in `slot`; its zero function in the statement list `roots`.

    A `certain` one is looked at whatever others say, so that its zero function must be a number;
    one that `waves` may switch any number of times within a step.
    """

    slot: int
    zero: Expr  # temporary or slot set by the `roots` statements
    strict: bool
    time_only: bool
    text: str
    span: Span
    component: str = ""
    certain: bool = True
    waves: bool = False


class WhenCode(Data):
    """A when-clause in the event iteration; conditions are discrete slots."""

    branches: tuple[tuple[int, int, tuple[Action, ...]], ...]  # (slot, pre slot, actions)
    span: Span


class DelayCode(Data):
    """A delayed signal: sign * w[slot]. How long it is delayed is an expression of
    parameters, or w[interval_slot] and at most `maximum`, again of parameters. `held`: it
    changes at events only."""

    slot: int
    sign: int
    interval: Expr
    interval_slot: int | None
    maximum: Expr | None
    held: bool
    text: str
    span: Span


class EquationInfo(Data):
    """The words of messages about an equation."""

    written: str | tuple[Expr, Expr]  # as text, or the two sides
    span: Span
    component: str
    relations: tuple[str, ...] = ()  # of the model, as they are written
    ticks: bool = False  # it holds at the ticks of a clock

    @property
    def text(self) -> str:
        """Made when a message needs it: few of a model's equations ever fail."""
        if isinstance(self.written, str):
            return self.written
        return equation_text(*self.written, self.span, self.relations)


class Condition(Data):
    """A condition that was left out since it follows from others; `name` is the variable (a
    column) that tells by how much it is missed. `held` is None where parameters alone say so."""

    name: str
    held: FixedSlot | None
    info: EquationInfo


class Sharing(Data):
    """The forces that redundant joints leave open, and their shares: see `solve.start.sharing`."""

    open: int  # cut forces and torques that the equations leave open
    conditions: tuple[Condition, ...]
    everywhere: bool = False  # forces at all frames share, not only those of joints


class Program(Data):
    """See the fields' types. Statement lists:

    `parameters`   dependent parameters and all start values, from settable parameters
    `levels`       one list a level from the lowest to the top: what `rhs` runs
    `rest`         what only results need (not the derivatives)
    `initial`      residuals of initial equations
    `roots`        the zero functions of the relations
    `discrete`     one pass of the discrete equations
    """

    name: str
    table: Exprs
    size: int  # of the workspace
    slots: Mapping[str, int]  # by symbol text, `pre(x)`, `event[i]`
    columns: tuple[Column, ...]
    parameter_slots: tuple[ParameterSlot, ...]
    candidates: tuple[CandidateSlot, ...]
    fixed: tuple[FixedSlot, ...]
    discretes: tuple[DiscreteSlot, ...]
    relations: tuple[RelationSlot, ...]
    samplers: tuple[tuple[int, Expr, Expr, Span], ...]  # (slot, start, interval, place)
    whens: tuple[WhenCode, ...]
    assertions: tuple[Assertion, ...]
    blocks: tuple[BlockCode, ...]
    parameters: tuple[Statement, ...]
    levels: tuple[tuple[Statement, ...], ...]
    rest: tuple[Statement, ...]
    initial: tuple[Statement, ...]
    initial_residuals: tuple[Expr, ...]  # temporaries or symbols set by `initial`
    roots: tuple[Statement, ...]
    discrete: tuple[Statement, ...]
    equations: tuple[EquationInfo, ...]
    initial_equations: tuple[EquationInfo, ...] = ()
    guesses: tuple[tuple[int, int], ...] = ()  # of tears of the top: (slot, slot of start)
    visuals: tuple[Visual, ...] = ()
    declared: tuple[Declared, ...] = ()
    parts: tuple[Part, ...] = ()
    start_places: tuple[tuple[str, Span], ...] = ()  # of variables, see `ir.places`
    figures: tuple[Figure, ...] = ()
    mechanism: Mechanism | None = None  # None where it has no frames
    locked: Diagnostic | None = None  # what is told of parts that are held where they are
    experiment: Experiment = field(default_factory=Experiment)
    equations_before: int = 0
    equations_after: int = 0
    description: str = ""
    inputs: tuple[str, ...] = ()  # of the model itself
    outputs: tuple[str, ...] = ()
    delays: tuple[DelayCode, ...] = ()
    turning: tuple[tuple[int, Expr], ...] = ()  # see `codegen.tables.Tables.turning`
    sharing: Sharing | None = None  # None where nothing is redundant, or nothing is accepted
    limits: tuple[Limits, ...] = ()  # of variables that declare some
    enumerations: tuple[Enumeration, ...] = ()
    texts: tuple[str, ...] = ()  # the String parameters, which are part of the program
    span: Span = NOWHERE  # of the model

    @property
    def state_count(self) -> int:
        return sum(b.free for b in self.blocks if b.height)

    @property
    def switches(self) -> bool:
        """Whether anything happens at instants, but for what returns from a delay."""
        return bool(self.relations or self.samplers or self.whens or self.discretes)


def whole_name(name: str) -> str:
    """The array of which a scalar is an element: `a.n` of `a[2].n[1]`."""
    return re.sub(r"\[[\d,]+\]", "", name)


@once
def literals_of(program: Program) -> dict[str, tuple[str, ...]]:
    """The literals of the variables and parameters of enumerations, by their names."""
    return {name: e.literals for e in program.enumerations for name in e.members}
