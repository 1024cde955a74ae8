"""The syntax tree: what the text says, before any name has a meaning.

Given by `parse`, read by `flatten`. Section numbers are those of the Modelica
Language Specification 3.6. Nodes compare by content; spans do not take part.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import TypeAlias

from planarc.core.source import Span


@dataclass(frozen=True, slots=True)
class Node:
    span: Span = field(compare=False, repr=False)


# Expressions (chapter 3) ------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Integer(Node):
    value: int


@dataclass(frozen=True, slots=True)
class Real(Node):
    value: float
    text: str  # as written, so that a printed model keeps `1e-6`


@dataclass(frozen=True, slots=True)
class String(Node):
    value: str  # escapes resolved


@dataclass(frozen=True, slots=True)
class Boolean(Node):
    value: bool


@dataclass(frozen=True, slots=True)
class End(Node):
    """`end` inside a subscript (10.5.2)."""


@dataclass(frozen=True, slots=True)
class Colon(Node):
    """`:` as a subscript or a dimension (10.1)."""


@dataclass(frozen=True, slots=True)
class RefPart(Node):
    """One identifier of a reference, quotes kept (`'my name'`), with its subscripts."""

    name: str
    subscripts: tuple[Expression, ...] = ()


@dataclass(frozen=True, slots=True)
class Ref(Node):
    """A component reference or name: `a.b[1].c`; `.A.b` is absolute."""

    parts: tuple[RefPart, ...]
    absolute: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(p.name for p in self.parts)

    def __str__(self) -> str:
        return ("." if self.absolute else "") + ".".join(self.names)


@dataclass(frozen=True, slots=True)
class Unary(Node):
    """`op` is one of `- + .- .+ not`."""

    op: str
    operand: Expression


@dataclass(frozen=True, slots=True)
class Binary(Node):
    """`op` is an operator of 3.4 to 3.5 as written: `+ .+ * ./ ^ < == and ...`."""

    op: str
    left: Expression
    right: Expression


@dataclass(frozen=True, slots=True)
class If(Node):
    branches: tuple[tuple[Expression, Expression], ...]  # (condition, value)
    otherwise: Expression


@dataclass(frozen=True, slots=True)
class Range(Node):
    start: Expression
    step: Expression | None
    stop: Expression


@dataclass(frozen=True, slots=True)
class NamedArgument(Node):
    name: str
    value: Expression


@dataclass(frozen=True, slots=True)
class Call(Node):
    """A function call; `der(x)`, `initial()` and `pure(f(x))` are calls too."""

    function: Ref
    arguments: tuple[Expression, ...] = ()
    named: tuple[NamedArgument, ...] = ()


@dataclass(frozen=True, slots=True)
class PartialApplication(Node):
    """`function f(a = 1)` as an argument (12.4.2.1)."""

    function: Ref
    named: tuple[NamedArgument, ...] = ()


@dataclass(frozen=True, slots=True)
class Iterator(Node):
    name: str
    range: Expression | None  # None: deduced from the use as a subscript (11.2.2.1)


@dataclass(frozen=True, slots=True)
class Comprehension(Node):
    """`e for i in r, j in s`, as the argument of a reduction or inside braces."""

    body: Expression
    iterators: tuple[Iterator, ...]


@dataclass(frozen=True, slots=True)
class Array(Node):
    """`{a, b}`; `{e for i in r}` holds one `Comprehension`."""

    items: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Matrix(Node):
    """`[a, b; c, d]`."""

    rows: tuple[tuple[Expression, ...], ...]


@dataclass(frozen=True, slots=True)
class Tuple(Node):
    """`(a, , b)`: the left side of a call with several results; None is left out."""

    items: tuple[Expression | None, ...]


@dataclass(frozen=True, slots=True)
class Index(Node):
    """`(expression)[i, j]`."""

    base: Expression
    subscripts: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Member(Node):
    """`(expression).name`."""

    base: Expression
    name: str


Expression: TypeAlias = (
    Integer
    | Real
    | String
    | Boolean
    | End
    | Colon
    | Ref
    | Unary
    | Binary
    | If
    | Range
    | Call
    | PartialApplication
    | Comprehension
    | Array
    | Matrix
    | Tuple
    | Index
    | Member
)


# Modifications (7.2) ------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Modification(Node):
    """`(arguments) = binding`, either part may be missing; `broken` is `= break`."""

    arguments: tuple[Argument, ...] = ()
    binding: Expression | None = None
    broken: bool = False


@dataclass(frozen=True, slots=True)
class ElementModification(Node):
    """`each final a.b(...) = e "comment"`."""

    name: tuple[str, ...]
    modification: Modification | None = None
    each: bool = False
    final: bool = False
    comment: str = ""


@dataclass(frozen=True, slots=True)
class ElementRedeclaration(Node):
    """`redeclare ...` or `replaceable ...` as an argument of a modification (7.3)."""

    element: Component | ClassDef
    redeclare: bool = True  # False: only `replaceable`
    each: bool = False
    final: bool = False


@dataclass(frozen=True, slots=True)
class Deselection(Node):
    """`break x` or `break connect(a, b)` in an extends clause (7.4)."""

    target: str | Connect


Argument: TypeAlias = ElementModification | ElementRedeclaration | Deselection


@dataclass(frozen=True, slots=True)
class Annotation(Node):
    """`annotation(...)`: its span covers the parenthesised body, parsed when asked for."""


# Elements (4, 5, 7) ---------------------------------------------------------------------


class Variability(Enum):
    CONSTANT = "constant"
    PARAMETER = "parameter"
    DISCRETE = "discrete"
    CONTINUOUS = ""


class Causality(Enum):
    INPUT = "input"
    OUTPUT = "output"
    NONE = ""


class Flow(Enum):
    FLOW = "flow"
    STREAM = "stream"
    NONE = ""


@dataclass(frozen=True, slots=True)
class Import(Node):
    """`import A.B;` `import C = A.B;` `import A.B.*;` `import A.{x, y};` (13.2.1)."""

    path: tuple[str, ...]
    alias: str | None = None
    wildcard: bool = False
    names: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Constraint(Node):
    """`constrainedby T(...)`, or the older `extends T(...)` in its place (7.3.2)."""

    base: Ref
    modification: Modification | None = None


@dataclass(frozen=True, slots=True)
class Extends(Node):
    base: Ref
    modification: Modification | None = None
    protected: bool = False
    annotation: Annotation | None = None


@dataclass(frozen=True, slots=True)
class Prefixes:
    """The words in front of an element."""

    redeclare: bool = False
    final: bool = False
    inner: bool = False
    outer: bool = False
    replaceable: bool = False
    protected: bool = False


@dataclass(frozen=True, slots=True)
class Component(Node):
    """One declared name; `Real x, y[2];` gives two of these."""

    name: str
    type: Ref
    type_dimensions: tuple[Expression, ...] = ()  # `Real[3] x`
    dimensions: tuple[Expression, ...] = ()  # `Real x[3]`
    modification: Modification | None = None
    condition: Expression | None = None
    variability: Variability = Variability.CONTINUOUS
    causality: Causality = Causality.NONE
    flow: Flow = Flow.NONE
    prefixes: Prefixes = Prefixes()
    constraint: Constraint | None = None
    comment: str = ""
    annotation: Annotation | None = None


# Classes (4.5) ----------------------------------------------------------------------------


class ClassKind(Enum):
    CLASS = "class"
    MODEL = "model"
    RECORD = "record"
    OPERATOR_RECORD = "operator record"
    BLOCK = "block"
    CONNECTOR = "connector"
    EXPANDABLE_CONNECTOR = "expandable connector"
    TYPE = "type"
    PACKAGE = "package"
    FUNCTION = "function"
    OPERATOR_FUNCTION = "operator function"
    OPERATOR = "operator"


@dataclass(frozen=True, slots=True)
class External(Node):
    """`external "C" y = f(x) annotation(...)` (12.9)."""

    language: str | None = None
    result: Ref | None = None
    function: str | None = None
    arguments: tuple[Expression, ...] = ()
    annotation: Annotation | None = None


@dataclass(frozen=True, slots=True)
class EquationSection(Node):
    equations: tuple[Equation, ...]
    initial: bool = False


@dataclass(frozen=True, slots=True)
class AlgorithmSection(Node):
    statements: tuple[Statement, ...]
    initial: bool = False


Element: TypeAlias = "Import | Extends | Component | ClassDef"


@dataclass(frozen=True, slots=True)
class Composition(Node):
    """The long form of a class: elements and sections in their order."""

    elements: tuple[Element, ...] = ()
    sections: tuple[EquationSection | AlgorithmSection, ...] = ()
    external: External | None = None


@dataclass(frozen=True, slots=True)
class ShortClass(Node):
    """`type T = input Real[3](unit="m")`."""

    base: Ref
    dimensions: tuple[Expression, ...] = ()
    modification: Modification | None = None
    causality: Causality = Causality.NONE
    flow: Flow = Flow.NONE


@dataclass(frozen=True, slots=True)
class EnumerationLiteral(Node):
    name: str
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Enumeration(Node):
    """`enumeration(a, b)`; literals None stands for `enumeration(:)`."""

    literals: tuple[EnumerationLiteral, ...] | None


@dataclass(frozen=True, slots=True)
class DerivativeClass(Node):
    """`function f_x = der(f, x)` (12.7.2)."""

    function: Ref
    variables: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ExtendsClass(Node):
    """`redeclare model extends M(...) ... end M` (7.3.1)."""

    composition: Composition
    modification: Modification | None = None


ClassBody: TypeAlias = Composition | ShortClass | Enumeration | DerivativeClass | ExtendsClass


@dataclass(frozen=True, slots=True)
class ClassDef(Node):
    """A class; `span` covers all of it, `name_span` its name."""

    name: str
    kind: ClassKind
    body: ClassBody
    name_span: Span = field(compare=False, repr=False)
    partial: bool = False
    encapsulated: bool = False
    pure: bool | None = None  # functions: `pure`, `impure` or not said
    prefixes: Prefixes = Prefixes()
    constraint: Constraint | None = None
    comment: str = ""
    annotation: Annotation | None = None


@dataclass(frozen=True, slots=True)
class StoredDefinition(Node):
    """One file; `within` is None when the file does not say, () for `within;`."""

    classes: tuple[ClassDef, ...]
    within: tuple[str, ...] | None = None


# Equations (chapter 8) ----------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Equality(Node):
    left: Expression
    right: Expression
    comment: str = ""


@dataclass(frozen=True, slots=True)
class IfEquation(Node):
    branches: tuple[tuple[Expression, tuple[Equation, ...]], ...]
    otherwise: tuple[Equation, ...] = ()


@dataclass(frozen=True, slots=True)
class ForEquation(Node):
    iterators: tuple[Iterator, ...]
    body: tuple[Equation, ...]


@dataclass(frozen=True, slots=True)
class WhenEquation(Node):
    branches: tuple[tuple[Expression, tuple[Equation, ...]], ...]


@dataclass(frozen=True, slots=True)
class Connect(Node):
    left: Ref
    right: Ref


@dataclass(frozen=True, slots=True)
class CallEquation(Node):
    """`assert(...)`, `terminate(...)`, `reinit(...)`, `Connections.branch(...)`."""

    call: Call


Equation: TypeAlias = Equality | IfEquation | ForEquation | WhenEquation | Connect | CallEquation


# Statements (chapter 11) ------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Assignment(Node):
    target: Ref
    value: Expression


@dataclass(frozen=True, slots=True)
class TupleAssignment(Node):
    """`(a, , b) := f(x)`."""

    targets: tuple[Ref | None, ...]
    value: Call


@dataclass(frozen=True, slots=True)
class CallStatement(Node):
    call: Call


@dataclass(frozen=True, slots=True)
class IfStatement(Node):
    branches: tuple[tuple[Expression, tuple[Statement, ...]], ...]
    otherwise: tuple[Statement, ...] = ()


@dataclass(frozen=True, slots=True)
class ForStatement(Node):
    iterators: tuple[Iterator, ...]
    body: tuple[Statement, ...]


@dataclass(frozen=True, slots=True)
class WhileStatement(Node):
    condition: Expression
    body: tuple[Statement, ...]


@dataclass(frozen=True, slots=True)
class WhenStatement(Node):
    branches: tuple[tuple[Expression, tuple[Statement, ...]], ...]


@dataclass(frozen=True, slots=True)
class Break(Node):
    """`break;`"""


@dataclass(frozen=True, slots=True)
class Return(Node):
    """`return;`"""


Statement: TypeAlias = (
    Assignment
    | TupleAssignment
    | CallStatement
    | IfStatement
    | ForStatement
    | WhileStatement
    | WhenStatement
    | Break
    | Return
)
