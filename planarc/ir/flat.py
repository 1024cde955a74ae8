"""The flat model: every component opened, every name resolved, arrays still arrays.

Given by `flatten`, read by `lower`. Components are gone: a variable is a name
such as `crank.frame_b.r` or `link[3].body.m`, of a built-in type, with the
dimensions that it was declared with (arrays of components are opened, arrays of
built-in types are kept). Expressions are typed and refer to variables by their
full names. Nothing here is scalar yet, and nothing is simplified.

The file is long because the model has that many nodes; each is a few lines.
"""

from __future__ import annotations

from enum import Enum, IntEnum
from typing import TypeAlias

from planarc.core.data import Data, Located
from planarc.core.diagnostic import Diagnostic
from planarc.core.source import NOWHERE, Span
from planarc.ir.figure import Figure


class Base(Enum):
    __hash__ = object.__hash__  # of the member, not of its name: in a tenth of the time

    REAL = "Real"
    INTEGER = "Integer"
    BOOLEAN = "Boolean"
    STRING = "String"
    ENUMERATION = "enumeration"
    RECORD = "record"
    FUNCTION = "function"  # an argument that is itself a function
    CLOCK = "Clock"


#: Sizes, None where they are known only when run (functions).
Dims: TypeAlias = "tuple[int | None, ...]"


class Type(Data):
    """A built-in type with dimensions; None is a size known only when run (functions).

    `name` is the full name of an enumeration or record, `literals` those of the
    enumeration, `fields` those of the record.
    """

    base: Base
    dims: Dims = ()
    name: str = ""
    literals: tuple[str, ...] = ()
    fields: tuple[tuple[str, Type], ...] = ()

    def element(self, drop: int = 1) -> Type:
        """The type with its first `drop` dimensions taken away."""
        return Type(self.base, self.dims[drop:], self.name, self.literals, self.fields)

    def with_dims(self, dims: Dims) -> Type:
        return Type(self.base, dims, self.name, self.literals, self.fields)


REAL = Type(Base.REAL)
INTEGER = Type(Base.INTEGER)
BOOLEAN = Type(Base.BOOLEAN)
STRING = Type(Base.STRING)
CLOCK = Type(Base.CLOCK)


class Variability(IntEnum):
    """Ordered: a value may depend on values of lower or equal variability only (3.8)."""

    CONSTANT = 0
    PARAMETER = 1
    DISCRETE = 2
    CONTINUOUS = 3


class StateSelect(IntEnum):
    NEVER = 1
    AVOID = 2
    DEFAULT = 3
    PREFER = 4
    ALWAYS = 5


# Expressions -----------------------------------------------------------------------------


class Node(Located):
    type: Type
    span: Span


class Literal(Node):
    """A number, truth value, string, or enumeration (its number from 1 as `value`)."""

    value: float | int | bool | str


class Reference(Node):
    """A variable of the model by its full name, or a local one inside a function.

    `subscripts` index the variable's own dimensions; one that is an array (a range,
    or `Slice` for `:`) keeps a dimension. Component subscripts are in the name.
    """

    name: str
    subscripts: tuple[Expression, ...] = ()


class Slice(Node):
    """`:` as a subscript."""


class Unary(Node):
    """`op`: `-`, `not`."""

    op: str
    operand: Expression


class Binary(Node):
    """`op` as in the language: `+ - * / ^ .+ .- .* ./ .^ < <= > >= == <> and or`.

    `*` follows the operands' dimensions (scalar, matrix, inner product; 10.6.4);
    string concatenation is `+` on strings.
    """

    op: str
    left: Expression
    right: Expression


class If(Node):
    branches: tuple[tuple[Expression, Expression], ...]
    otherwise: Expression


class Array(Node):
    """`{...}`: the items are the entries along the first dimension."""

    items: tuple[Expression, ...]


class Range(Node):
    start: Expression
    step: Expression | None
    stop: Expression


class Index(Node):
    """Subscripts on an expression that is no variable."""

    base: Expression
    subscripts: tuple[Expression, ...]


class Field(Node):
    """A field of a record value."""

    base: Expression
    name: str


class Record(Node):
    """A record value; the items stand in the order of `type.fields`."""

    items: tuple[Expression, ...]


class Builtin(Node):
    """A call of a built-in operator or function by its Modelica name (`sin`, `der`, `pre`,
    `noEvent`, `sum`, `transpose`, `sample`, `time` without arguments ...)."""

    function: str
    arguments: tuple[Expression, ...] = ()


class Call(Node):
    """A call of a function of `FlatModel.functions`; arguments are complete and in the
    order of its inputs (defaults and bound inputs filled in). `output` chooses one result,
    None (left side of a several-result equation) stands for all."""

    function: str
    arguments: tuple[Expression, ...] = ()
    output: int | None = 0


class PartialCall(Node):
    """A function as a value, some inputs bound (12.4.2.1): names and expressions.

    Where `function` is itself an argument, `inputs` are the names that its interface gives them.
    """

    function: str
    bound: tuple[tuple[str, Expression], ...] = ()
    inputs: tuple[str, ...] = ()


class Comprehension(Node):
    """An iteration inside a function, where sizes are unknown.

    `reduce` is `array sum product min max`."""

    body: Expression
    iterators: tuple[tuple[str, Expression], ...]
    reduce: str = "array"
    alike: Expressions = ()  # arrays that must have the same number of entries


Expression: TypeAlias = (
    Literal
    | Reference
    | Slice
    | Unary
    | Binary
    | If
    | Array
    | Range
    | Index
    | Field
    | Record
    | Builtin
    | Call
    | PartialCall
    | Comprehension
)


#: Expressions side by side: subscripts, arguments.
Expressions: TypeAlias = tuple[Expression, ...]
#: Expressions by the names of what they are the values of.
Named: TypeAlias = dict[str, Expression]


# Variables ----------------------------------------------------------------------------------


class Attributes(Data):
    """Attributes of a built-in type (4.9); an array variable holds an array or, with
    `each`, a scalar, which stands for all elements."""

    start: Expression | None = None
    fixed: Expression | None = None
    min: Expression | None = None
    max: Expression | None = None
    nominal: Expression | None = None
    state_select: StateSelect = StateSelect.DEFAULT
    unit: str = ""
    display_unit: str = ""
    quantity: str = ""
    #: True when a modifier outside the declared type wrote `start`: it then counts more
    #: than a default when a loop is assembled.
    start_written: bool = False
    #: The same of `fixed`: a library's own hold gives way to what a user writes.
    fixed_written: bool = False


class Variable(Located):
    name: str
    type: Type
    variability: Variability
    span: Span = NOWHERE
    binding: Expression | None = None
    attributes: Attributes = Attributes()
    causality: str = ""  # `input` or `output` of the model itself, else empty
    protected: bool = False
    final: bool = False  # not to be set from outside
    structural: bool = False  # a parameter whose value shaped the model: cannot be set later
    description: str = ""
    component: str = ""  # full name of the component that declares it
    at_start: bool = False  # a parameter that the start finds: `fixed = false`
    #: variables of functions: an expression for each size that `type.dims` leaves None
    #: and the declaration gives (`Real y[size(x, 1)]`); empty when there is none
    sizes: tuple[Expression | None, ...] = ()


# Equations and statements ---------------------------------------------------------------------


class EquationNode(Located):
    span: Span
    component: str  # full name of the component that it stands in, "" for the model


class Equality(EquationNode):
    """Equal types, maybe arrays or records; for several results `left` is `Targets`."""

    left: Expression | Targets
    right: Expression
    generated: bool = False  # from a connection set


class Targets(Data):
    """`(a, , b) = f(x)`."""

    items: tuple[Expression | None, ...]


class IfEquation(EquationNode):
    """The condition changes while running; all branches hold as many equations."""

    branches: tuple[tuple[Expression, tuple[Equation, ...]], ...]
    otherwise: tuple[Equation, ...]


class WhenEquation(EquationNode):
    """A condition that is a vector stands as an `Array` of Booleans."""

    branches: tuple[tuple[Expression, tuple[Equation, ...]], ...]


class Assert(EquationNode):
    condition: Expression
    message: Expression
    warning: bool = False


class Terminate(EquationNode):
    message: Expression


class Reinit(EquationNode):
    variable: Reference
    value: Expression


class Impact(EquationNode):
    """`impact(...)` or `crowd(...)`: its arguments in the order of `ir.impact`."""

    arguments: tuple[Expression, ...]
    crowd: bool = False


Equation: TypeAlias = Equality | IfEquation | WhenEquation | Assert | Terminate | Reinit | Impact


#: The target of an assignment: a variable, or several ones, as items of a record or an array.
Target: TypeAlias = "Reference | Record | Array"


class Assignment(EquationNode):
    target: Target
    value: Expression


class TupleAssignment(EquationNode):
    targets: tuple[Target | None, ...]
    value: Call


class IfStatement(EquationNode):
    branches: tuple[tuple[Expression, tuple[Statement, ...]], ...]
    otherwise: tuple[Statement, ...] = ()


class ForStatement(EquationNode):
    iterator: str
    range: Expression
    body: tuple[Statement, ...]


class WhileStatement(EquationNode):
    condition: Expression
    body: tuple[Statement, ...]


class WhenStatement(EquationNode):
    branches: tuple[tuple[Expression, tuple[Statement, ...]], ...]


class Break(EquationNode):
    """`break;`"""


class Return(EquationNode):
    """`return;`"""


Statement: TypeAlias = (
    Assignment
    | TupleAssignment
    | IfStatement
    | ForStatement
    | WhileStatement
    | WhenStatement
    | Break
    | Return
    | Assert
    | Terminate
    | Reinit
)


class Algorithm(EquationNode):
    statements: tuple[Statement, ...]


class Derivative(Data):
    """`annotation(derivative(order=2, noDerivative=p) = f_d)` of a function."""

    function: str
    order: int = 1
    still: frozenset[str] = frozenset()  # inputs whose derivatives it does not take


class Function(Located):
    """A function that the model calls. `outputs` and `locals` may have bindings, which are
    assigned first; `derivative_of` is (function, inputs) for `f_s = der(f, s)`. `external`
    is an elementary function, called with the inputs as they are, or one of
    `planarc.runtime.external`, called with `given`, expressions of the inputs; `results` are the
    outputs that it sets, in its order."""

    name: str
    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    locals: tuple[Variable, ...] = ()
    body: tuple[Statement, ...] = ()
    external: str | None = None
    given: tuple[Expression, ...] = ()
    results: tuple[str, ...] = ()
    derivative_of: tuple[str, tuple[str, ...]] | None = None
    derivatives: tuple[Derivative, ...] = ()
    span: Span = NOWHERE
    partial: bool = False  # only the interface of an input that is a function; has no body


# What is drawn and how it is run ----------------------------------------------------------------


class Visual(Located):
    """Something drawn: an instance of a class with `annotation(__planarc(visual="kind"))`.

    It has no variables and no equations in the model; its attributes are expressions in
    the model's variables, evaluated from the result when somebody looks.
    """

    component: str
    kind: str
    attributes: tuple[tuple[str, Expression], ...]
    span: Span = NOWHERE


class Declared(Located):
    """A statement of a component about itself in `annotation(__planarc(energy(kinetic = ...)))`:
    a value in a `unit`, evaluated from the result; kinds and names are those of
    `flatten.sections.declared`."""

    component: str
    kind: str
    name: str
    unit: str
    value: Expression
    foreign: bool = False  # planarc says so of another library's class


class Experiment(Data):
    start: float = 0.0
    stop: float = 1.0
    interval: float | None = None  # None: 500 intervals
    tolerance: float = 1e-6


class Part(Located):
    """A component instance: what messages and counts need to know of it."""

    name: str
    class_name: str
    span: Span = NOWHERE
    inner: bool = False  # others refer to it, as they do to the world


class Connect(Located):
    """A connection of two connectors, by their full names."""

    left: str
    right: str
    span: Span = NOWHERE


class LeftOut(Diagnostic):
    """The warning that a connection was left out: without it equations may not fit."""


class Misplaced(Diagnostic):
    """The warning that a component was connected beside the connector that was meant."""

    component: str = ""


class FlatModel(Located):
    name: str
    variables: tuple[Variable, ...]
    equations: tuple[Equation, ...]
    initial_equations: tuple[Equation, ...] = ()
    algorithms: tuple[Algorithm, ...] = ()
    initial_algorithms: tuple[Algorithm, ...] = ()
    functions: tuple[Function, ...] = ()
    visuals: tuple[Visual, ...] = ()
    declared: tuple[Declared, ...] = ()
    parts: tuple[Part, ...] = ()
    #: connection sets of physical connectors: the connectors' full names
    connections: tuple[tuple[str, ...], ...] = ()
    experiment: Experiment = Experiment()
    description: str = ""
    span: Span = NOWHERE
    figures: tuple[Figure, ...] = ()
    connects: tuple[Connect, ...] = ()
    signals: tuple[Connect, ...] = ()  # the connections of inputs and outputs
    warnings: tuple[Diagnostic, ...] = ()
    clocked: bool = False  # operators of clocks stand in it
