"""The syntax tree: what the text says, before any name has a meaning.

Given by `parse`, read by `flatten`. Section numbers are those of the Modelica
Language Specification 3.6. Nodes compare by content; spans do not take part.

The file is long because the syntax has that many nodes; each is a few lines.
"""

from __future__ import annotations

from enum import Enum
from typing import TypeAlias

from planarc.core.data import Data, Located
from planarc.core.source import Span


class Node(Located):
    span: Span


# Expressions (chapter 3) ------------------------------------------------------------


class Integer(Node):
    value: int


class Real(Node):
    value: float
    text: str  # as written, so that a printed model keeps `1e-6`


class String(Node):
    value: str  # escapes resolved


class Boolean(Node):
    value: bool


class End(Node):
    """`end` inside a subscript (10.5.2)."""


class Colon(Node):
    """`:` as a subscript or a dimension (10.1)."""


class RefPart(Node):
    """An identifier of a reference, quotes kept (`'my name'`), with its subscripts."""

    name: str
    subscripts: tuple[Expression, ...] = ()


class Ref(Node):
    """A component reference or name: `a.b[1].c`; `.A.b` is absolute."""

    parts: tuple[RefPart, ...]
    absolute: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(p.name for p in self.parts)

    def __str__(self) -> str:
        return ("." if self.absolute else "") + ".".join(self.names)


class Unary(Node):
    """`op` is one of `- + .- .+ not`."""

    op: str
    operand: Expression


class Binary(Node):
    """`op` is an operator of 3.4 to 3.5 as written: `+ .+ * ./ ^ < == and ...`."""

    op: str
    left: Expression
    right: Expression


class If(Node):
    branches: tuple[tuple[Expression, Expression], ...]  # (condition, value)
    otherwise: Expression


class Range(Node):
    start: Expression
    step: Expression | None
    stop: Expression


class NamedArgument(Node):
    name: str
    value: Expression


class Call(Node):
    """A function call; `der(x)`, `initial()` and `pure(f(x))` are calls too."""

    function: Ref
    arguments: tuple[Expression, ...] = ()
    named: tuple[NamedArgument, ...] = ()


class PartialApplication(Node):
    """`function f(a = 1)` as an argument (12.4.2.1)."""

    function: Ref
    named: tuple[NamedArgument, ...] = ()


class Iterator(Node):
    name: str
    range: Expression | None  # None: deduced from the use as a subscript (11.2.2.1)


class Comprehension(Node):
    """`e for i in r, j in s`, as the argument of a reduction or inside braces."""

    body: Expression
    iterators: tuple[Iterator, ...]


class Array(Node):
    """`{a, b}`; `{e for i in r}` holds one `Comprehension`."""

    items: tuple[Expression, ...]


class Matrix(Node):
    """`[a, b; c, d]`."""

    rows: tuple[tuple[Expression, ...], ...]


class Tuple(Node):
    """`(a, , b)`: the left side of a call with several results; None is left out."""

    items: tuple[Expression | None, ...]


class Index(Node):
    """`(expression)[i, j]`."""

    base: Expression
    subscripts: tuple[Expression, ...]


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


#: Expressions side by side: subscripts, sizes, arguments.
Expressions: TypeAlias = tuple[Expression, ...]


# Modifications (7.2) ------------------------------------------------------------------


class Modification(Node):
    """`(arguments) = binding`, either part may be missing; `broken` is `= break`."""

    arguments: tuple[Argument, ...] = ()
    binding: Expression | None = None
    broken: bool = False


class ElementModification(Node):
    """`each final a.b(...) = e "comment"`."""

    name: tuple[str, ...]
    modification: Modification | None = None
    each: bool = False
    final: bool = False
    comment: str = ""


class ElementRedeclaration(Node):
    """`redeclare ...` or `replaceable ...` as an argument of a modification (7.3)."""

    element: Declaration
    redeclare: bool = True  # False: only `replaceable`
    each: bool = False
    final: bool = False


class Deselection(Node):
    """`break x` or `break connect(a, b)` in an extends clause (7.4)."""

    target: str | Connect


Argument: TypeAlias = ElementModification | ElementRedeclaration | Deselection


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


class Import(Node):
    """`import A.B;` `import C = A.B;` `import A.B.*;` `import A.{x, y};` (13.2.1)."""

    path: tuple[str, ...]
    alias: str | None = None
    wildcard: bool = False
    names: tuple[str, ...] = ()


class Constraint(Node):
    """`constrainedby T(...)`, or the older `extends T(...)` in its place (7.3.2)."""

    base: Ref
    modification: Modification | None = None


class Extends(Node):
    base: Ref
    modification: Modification | None = None
    protected: bool = False
    annotation: Annotation | None = None


class Prefixes(Data):
    """The words in front of an element."""

    redeclare: bool = False
    final: bool = False
    inner: bool = False
    outer: bool = False
    replaceable: bool = False
    protected: bool = False


class Component(Node):
    """A declared name; `Real x, y[2];` gives two of these."""

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


class External(Node):
    """`external "C" y = f(x) annotation(...)` (12.9)."""

    language: str | None = None
    result: Ref | None = None
    function: str | None = None
    arguments: tuple[Expression, ...] = ()
    annotation: Annotation | None = None


class EquationSection(Node):
    equations: tuple[Equation, ...]
    initial: bool = False


class AlgorithmSection(Node):
    statements: tuple[Statement, ...]
    initial: bool = False


#: An element with a name.
Declaration: TypeAlias = "Component | ClassDef"
Element: TypeAlias = "Import | Extends | Component | ClassDef"


class Composition(Node):
    """The long form of a class: elements and sections in their order."""

    elements: tuple[Element, ...] = ()
    sections: tuple[EquationSection | AlgorithmSection, ...] = ()
    external: External | None = None


class ShortClass(Node):
    """`type T = input Real[3](unit="m")`."""

    base: Ref
    dimensions: tuple[Expression, ...] = ()
    modification: Modification | None = None
    causality: Causality = Causality.NONE
    flow: Flow = Flow.NONE


class EnumerationLiteral(Node):
    name: str
    comment: str = ""


class Enumeration(Node):
    """`enumeration(a, b)`; literals None stands for `enumeration(:)`."""

    literals: tuple[EnumerationLiteral, ...] | None


class DerivativeClass(Node):
    """`function f_x = der(f, x)` (12.7.2)."""

    function: Ref
    variables: tuple[str, ...]


class ExtendsClass(Node):
    """`redeclare model extends M(...) ... end M` (7.3.1)."""

    composition: Composition
    modification: Modification | None = None


ClassBody: TypeAlias = Composition | ShortClass | Enumeration | DerivativeClass | ExtendsClass


class ClassDef(Node):
    """A class; `span` covers all of it, `name_span` its name."""

    name: str
    kind: ClassKind
    body: ClassBody
    name_span: Span
    partial: bool = False
    encapsulated: bool = False
    pure: bool | None = None  # functions: `pure`, `impure` or not said
    prefixes: Prefixes = Prefixes()
    constraint: Constraint | None = None
    comment: str = ""
    annotation: Annotation | None = None

    @property
    def composition(self) -> Composition | None:
        """The elements and sections, where the class is written in the long form."""
        body = self.body.composition if isinstance(self.body, ExtendsClass) else self.body
        return body if isinstance(body, Composition) else None

    @property
    def sections(self) -> tuple[EquationSection | AlgorithmSection, ...]:
        return () if self.composition is None else self.composition.sections


class StoredDefinition(Node):
    """A file; `within` is None when the file does not say, () for `within;`."""

    classes: tuple[ClassDef, ...]
    within: tuple[str, ...] | None = None


# Equations (chapter 8) ----------------------------------------------------------------------


class Equality(Node):
    left: Expression
    right: Expression
    comment: str = ""


class IfEquation(Node):
    branches: tuple[tuple[Expression, tuple[Equation, ...]], ...]
    otherwise: tuple[Equation, ...] = ()


class ForEquation(Node):
    iterators: tuple[Iterator, ...]
    body: tuple[Equation, ...]


class WhenEquation(Node):
    branches: tuple[tuple[Expression, tuple[Equation, ...]], ...]


class Connect(Node):
    left: Ref
    right: Ref


class CallEquation(Node):
    """`assert(...)`, `terminate(...)`, `reinit(...)`, `Connections.branch(...)`."""

    call: Call


Equation: TypeAlias = Equality | IfEquation | ForEquation | WhenEquation | Connect | CallEquation


# Statements (chapter 11) ------------------------------------------------------------------------


class Assignment(Node):
    target: Ref
    value: Expression


class TupleAssignment(Node):
    """`(a, , b) := f(x)`."""

    targets: tuple[Ref | None, ...]
    value: Call


class CallStatement(Node):
    call: Call


class IfStatement(Node):
    branches: tuple[tuple[Expression, tuple[Statement, ...]], ...]
    otherwise: tuple[Statement, ...] = ()


class ForStatement(Node):
    iterators: tuple[Iterator, ...]
    body: tuple[Statement, ...]


class WhileStatement(Node):
    condition: Expression
    body: tuple[Statement, ...]


class WhenStatement(Node):
    branches: tuple[tuple[Expression, tuple[Statement, ...]], ...]


class Break(Node):
    """`break;`"""


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
