"""The scalar model: a hybrid differential-algebraic system over one expression table.

Given by `lower`, read by `structure`. Every variable is a scalar with its Modelica
name (`crank.frame_b.r[1]`). Parameters are symbols too, but of names that never
change while running. Relations that can switch are taken out of the equations:
`EVENT(i)` stands for the stored truth of relation i, which changes at events only.

Reserved names, set by the solver: `$initial` (true in the first event iteration),
`$terminal`, and `$sample[i]` (true at the instants of sampler i).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from enum import Enum
from typing import Any, Protocol, TypeAlias

from msgspec import field

from planarc.core.data import Data, Located
from planarc.core.diagnostic import Diagnostic
from planarc.core.source import NOWHERE, Span
from planarc.ir.expr import CUT, Expr, Exprs, Op, brief, postorder
from planarc.ir.flat import Connect, Experiment, Part, StateSelect

INITIAL = "$initial"
TERMINAL = "$terminal"
#: With an index, discrete: the condition of a when-clause that is no variable.
WHEN = "$when"
#: With an index: true in the pass of an event in which one of several conditions became true.
EDGE = "$edge"
#: With an index, discrete: whether the argument of a rounding function began in an odd interval.
PHASE = "$phase"
#: With an index, discrete: a continuous variable whose left limit is asked for at events.
LEFT = "$left"
#: A parameter: the time at which the run starts, for start values that depend on it.
START_TIME = "$start"
#: The part of `actual` in what `homotopy` gives, of a model that leads to a start
HOMOTOPY = "$homotopy"
#: Whole numbers are float64: beyond this one, not each of them can be told from its neighbours.
LARGEST_INTEGER = 2**53 - 1
#: A parameter of models with redundant joints, which moves the forces that are open; with an
#: index the multipliers that make these least squares (`structure.sharing`). None is a result.
SHARING = "$sharing"
#: With an index: by how much a condition is missed that was left out as redundant.
MISFIT = "$misfit"


class Kind(Enum):
    __hash__ = object.__hash__  # as `flat.Base`

    REAL = "Real"
    INTEGER = "Integer"
    BOOLEAN = "Boolean"
    ENUMERATION = "enumeration"  # valued by the literal's number, from 1
    STRING = "String"  # valued by the number that stands for the text


class Variable(Located):
    """An unknown of the model: continuous, or discrete (constant between events)."""

    name: str
    kind: Kind = Kind.REAL
    start: Expr | None = None  # an expression of parameters; None stands for 0 or false
    fixed: bool = False
    start_written: bool = False  # see flat.Attributes
    fixed_written: bool = False
    state_select: StateSelect = StateSelect.DEFAULT
    nominal: Expr | None = None
    minimum: Expr | None = None
    maximum: Expr | None = None
    unit: str = ""
    display_unit: str = ""
    description: str = ""
    protected: bool = False
    causality: str = ""  # `input`, `output` of the model, or empty
    component: str = ""
    literals: tuple[str, ...] = ()  # of an enumeration
    type_name: str = ""  # that of the enumeration
    at_start: bool = False  # a parameter that the start finds, constant from then on
    span: Span = NOWHERE


class Parameter(Located):
    """A parameter or constant. `value` refers to earlier parameters of the list only.

    `settable`: its value is a number that a user may replace without recompiling.
    """

    name: str
    kind: Kind
    value: Expr
    settable: bool
    structural: bool = False
    constant: bool = False
    unit: str = ""
    display_unit: str = ""
    description: str = ""
    protected: bool = False
    component: str = ""
    literals: tuple[str, ...] = ()
    type_name: str = ""
    minimum: Expr | None = None
    maximum: Expr | None = None
    final: bool = False
    span: Span = NOWHERE


#: Letters that an equation may have where it is shown as it is written.
_SHORT = 80


class Equation(Located):
    """left = right, scalar. `component` is where it stands, "" for the model itself."""

    left: Expr
    right: Expr
    span: Span = NOWHERE
    component: str = ""
    generated: bool = False  # from a connection set
    assigned: bool = False  # by an algorithm: it gives `left` its value, and nothing else
    rates: tuple[Expr, ...] = ()  # the first derivatives of `right`, where they are given
    clock: int | None = None  # of `Dae.clocks`: it holds where that ticks
    integrates: bool = False  # `left`, from its derivative, at each tick

    @property
    def shown(self) -> str:
        """The equation as messages show it."""
        written = as_written(self.span)
        if written and any(e.op is Op.EVENT for e in postorder((self.left, self.right))):
            return f"`{written}`"  # there relations have names of their own
        return f"`{equation_text(self.left, self.right, self.span)}`"


def equation_text(left: Expr, right: Expr, span: Span, relations: Sequence[str] = ()) -> str:
    """An equation for a message: scalar by scalar, or as it is written where that is too long."""
    sides = brief(left, relations), brief(right, relations)
    return (any(CUT in side for side in sides) and as_written(span)) or " = ".join(sides)


def as_written(span: Span) -> str:
    """A short equation as it stands in the text, on one line; nothing where it is none."""
    written = " ".join(span.text.split()) if span is not NOWHERE else ""
    return written if "=" in written and len(written) < _SHORT else ""


class Relation(Located):
    """A relation that makes an event when it switches.

    It is true where `zero` < 0 (strict) or `zero` <= 0. `time_only`: `zero` depends on
    time and parameters alone, so its instants can be met exactly.
    """

    zero: Expr
    strict: bool
    time_only: bool
    text: str  # as the user wrote it, for messages
    span: Span = NOWHERE
    component: str = ""  # whose equation or algorithm it stands in first


class Sampler(Located):
    """`sample(start, interval)`; its truth is the symbol `$sample[i]`, i from 0."""

    start: Expr
    interval: Expr
    span: Span = NOWHERE


class Delay(Located):
    """`delay(signal, interval, maximum)`; its value is `past(i, time - interval)`.

    `signal` is the name of a continuous variable. `interval` is an expression of parameters,
    or the symbol of a variable; then there is a `maximum`, an expression of parameters.
    """

    signal: str
    interval: Expr
    maximum: Expr | None
    text: str  # as the user wrote it, for messages
    span: Span = NOWHERE


class Message(Data):
    """A text with values in it: strings and (expression, format) in their order."""

    parts: tuple[str | tuple[Expr, str], ...]


class SetDiscrete(Located):
    """name := value, at an event."""

    name: str
    value: Expr
    span: Span = NOWHERE


class Reinit(Located):
    """The state `symbol` continues from `value`."""

    symbol: Expr
    value: Expr
    span: Span = NOWHERE


class Assertion(Located):
    """Checked where the model is evaluated at accepted points; false ends the run."""

    condition: Expr
    message: Message
    warning: bool = False
    component: str = ""
    span: Span = NOWHERE
    given: Span = NOWHERE  # of the user's one value that it is about


class Terminate(Located):
    message: Message
    span: Span = NOWHERE


class Impact(Located):
    """A touch whose velocity jumps, whose modes are set, or a body of a crowd: its arguments are
    those of `ir.impact`."""

    arguments: tuple[Expr, ...]
    component: str = ""
    span: Span = NOWHERE
    crowd: bool = False


Action: TypeAlias = SetDiscrete | Reinit | Assertion | Terminate | Impact


class Clock(Located):
    """What ticks together. `tick` is a discrete Boolean that is true in the pass of an event in
    which it does; equations with this clock give `variables` values then, which they keep."""

    tick: str
    variables: frozenset[str]
    span: Span = NOWHERE


class When(Located):
    """`when`/`elsewhen`: the first branch whose condition just became true acts.

    A condition is the name of a discrete Boolean variable, which has its own discrete
    equation; it has just become true when it holds and pre() of it does not.
    """

    branches: tuple[tuple[str, tuple[Action, ...]], ...]
    span: Span = NOWHERE
    component: str = ""


def is_initial(e: Expr) -> bool:
    """Whether it is `initial()`, and not merely follows from it."""
    return e.is_symbol and e.name == INITIAL


class Clause(Protocol):
    """A when-clause; the actions of a branch come last."""

    @property
    def branches(self) -> tuple[tuple[*tuple[Any, ...], tuple[Action, ...]], ...]: ...


def set_by_whens(whens: Iterable[Clause]) -> frozenset[str]:
    """The variables that when-clauses give their values."""
    return frozenset(
        action.name
        for when in whens
        for branch in when.branches
        for action in branch[-1]
        if isinstance(action, SetDiscrete)
    )


#: A value that a drawn thing has: a number, truth, text, or (nested) tuples of such.
VisualValue: TypeAlias = "Expr | str | tuple[VisualValue, ...]"


def expressions_in(value: VisualValue) -> Iterator[Expr]:
    """The numbers and truth values in what a drawn thing has."""
    if isinstance(value, tuple):
        for inner in value:
            yield from expressions_in(inner)
    elif isinstance(value, Expr):
        yield value


class Visual(Data):
    """Something drawn; see flat.Visual. Numbers and truth values are expressions."""

    component: str
    kind: str
    attributes: tuple[tuple[str, VisualValue], ...]

    def get(self, name: str) -> VisualValue:
        return dict(self.attributes)[name]


#: The size of what turns with a frame begins so, as of a pulley; the frame's name follows.
WHEEL = "radius of the wheel in "


class Declared(Data):
    """A statement of a component about itself; see flat.Declared. A vector is a tuple."""

    component: str
    kind: str
    name: str
    value: VisualValue
    foreign: bool = False


class Dae(Located):
    name: str
    table: Exprs
    variables: tuple[Variable, ...]  # continuous unknowns, in declaration order
    parameters: tuple[Parameter, ...]  # in evaluation order
    equations: tuple[Equation, ...]  # continuous ones
    discretes: tuple[Variable, ...] = ()
    inputs: tuple[Variable, ...] = ()  # top-level inputs, given from outside
    initial_equations: tuple[Equation, ...] = ()
    discrete_equations: tuple[Equation, ...] = ()  # of Boolean, Integer and discrete unknowns
    relations: tuple[Relation, ...] = ()
    samplers: tuple[Sampler, ...] = ()
    delays: tuple[Delay, ...] = ()
    whens: tuple[When, ...] = ()
    clocks: tuple[Clock, ...] = ()
    assertions: tuple[Assertion, ...] = ()
    visuals: tuple[Visual, ...] = ()
    declared: tuple[Declared, ...] = ()
    parts: tuple[Part, ...] = ()
    start_places: tuple[tuple[str, Span], ...] = ()  # of variables, see `ir.places`
    connections: tuple[tuple[str, ...], ...] = ()
    connects: tuple[Connect, ...] = ()  # of physical connectors
    signals: tuple[Connect, ...] = ()  # of inputs and outputs
    experiment: Experiment = field(default_factory=Experiment)
    description: str = ""
    span: Span = NOWHERE
    warnings: tuple[Diagnostic, ...] = ()
    texts: tuple[str, ...] = ()  # the String parameters, which are part of the equations
    simplified: bool = False  # True where simplified forms of `homotopy` were left out

    @property
    def drives(self) -> frozenset[str]:
        """The components that declare what power they supply."""
        return frozenset(d.component for d in self.declared if d.name == "suppliedPower")
