"""The instance tree: what `flatten` builds between the syntax tree and the flat model.

    Class      a class in its place: definition, enclosing scope, modifier
    Instance   a class opened: as the model, as a component, or as a package
    Scope      one part of an instance (the class itself or a base class), in which
               names of its text are looked up
    Element    one member of an instance: a component or a class, opened on demand
    Leaf       a component of a built-in type: a variable of the flat model
    Family     an array of component instances

Everything is made when first asked for, so that array sizes and conditions may
depend on parameters anywhere in the tree. The nodes are filled in lazily and
never change once filled.
"""

from __future__ import annotations

from collections import Counter
from enum import Enum
from typing import TYPE_CHECKING, TypeAlias

from msgspec import Struct, field

from planarc.core.diagnostic import Diagnostic, PlanarcError, Severity
from planarc.core.source import Span
from planarc.ir import flat, syntax

if TYPE_CHECKING:
    from planarc.flatten.connect.rooting import Rooting
    from planarc.flatten.functions.signature import FunctionInfo, Signature
    from planarc.flatten.library.library import Entry, Library
    from planarc.flatten.values.constant import Value

#: Depth of bindings of classes that belong to no component (types, packages).
STATIC_DEPTH = 1_000_000


# Modifiers --------------------------------------------------------------------------------


class Binding(Struct, eq=False):
    """An expression of a modifier, with the scope that it was written in.

    `subscripts` pick the element that belongs to one member of an array of components.
    """

    expression: syntax.Expression
    scope: Scope
    span: Span
    #: how many levels above this modifier `each` stands (0: on itself), None: nowhere
    each_height: int | None = None
    final: bool = False
    subscripts: tuple[int, ...] = ()
    #: written as a declaration's own `= value` in the class that declares the variable
    default: bool = False
    typed: flat.Expression | None = None

    @property
    def each(self) -> bool:
        return self.each_height == 0

    @property
    def depth(self) -> int:
        """How far inside the component tree the modifier stands; less is stronger."""
        instance = self.scope.instance
        return STATIC_DEPTH if instance.prefix is None else instance.depth


class Redeclaration(Struct, eq=False):
    """A new declaration for a replaceable element, with the scope it was written in."""

    element: syntax.Component | syntax.ClassDef
    scope: Scope
    each_height: int | None = None
    final: bool = False
    subscripts: tuple[int, ...] = ()


class Mod(Struct, eq=False):
    """A modifier: a value, modifiers of the members, a redeclaration."""

    binding: Binding | None = None
    subs: dict[str, Mod] = field(default_factory=dict)
    redeclaration: Redeclaration | None = None
    final: bool = False
    span: Span | None = None
    broken: bool = False

    def __bool__(self) -> bool:
        return bool(self.subs or self.binding or self.redeclaration or self.final or self.broken)

    def sub(self, name: str) -> Mod:
        return self.subs.get(name, NO_MOD)


NO_MOD = Mod()


# Classes ------------------------------------------------------------------------------------


class Part(Struct, eq=False):
    """A class or one of its base classes, within a layout."""

    cls: Class
    index: int
    own: dict[str, syntax.Component | syntax.ClassDef]
    imports: tuple[syntax.Import, ...] = ()
    redeclarations: tuple[syntax.Component | syntax.ClassDef, ...] = ()
    #: names that the text of this part can see: its own and those of its bases
    visible: set[str] = field(default_factory=set)
    entries: list[Entry | Library] = field(default_factory=list)
    derived: int | None = None  # the part that extends this one
    modification: syntax.Modification | None = None  # of the extends clause
    mod_scope: Scope | None = None  # where it is resolved; None: in the deriving part
    protected: bool = False

    @property
    def definition(self) -> syntax.ClassDef:
        return self.cls.definition


class Layout(Struct, eq=False):
    """What a class consists of after inheritance, shared by all its instances."""

    parts: list[Part]
    #: name -> (part that declares it, its declaration), in order of declaration
    members: dict[str, tuple[int, syntax.Component | syntax.ClassDef]]
    builtin: flat.Type | None = None
    dimensions: tuple[tuple[syntax.Expression, Scope], ...] = ()
    causality: syntax.Causality = syntax.Causality.NONE
    flow: syntax.Flow = syntax.Flow.NONE
    kind: syntax.ClassKind = syntax.ClassKind.CLASS
    done: bool = False
    type_mod: Mod | None = None
    type_attributes: flat.Attributes | None = None
    derivative: tuple[syntax.DerivativeClass, Scope] | None = None
    visual: str | None = None  # what instances are drawn as, "" for nothing, None: not asked


class Class:
    """A class definition in its place."""

    __slots__ = (
        "definition",
        "entry",
        "function",
        "layout",
        "lookups",
        "mod",
        "name",
        "original",
        "parent",
        "record",
        "static",
    )

    def __init__(
        self,
        definition: syntax.ClassDef,
        parent: Scope | None,
        name: str,
        mod: Mod = NO_MOD,
        entry: Entry | Library | None = None,
        original: Class | None = None,
    ) -> None:
        self.definition = definition
        self.parent = parent
        self.name = name
        self.mod = mod
        self.entry = entry
        self.original = original  # the class that `redeclare ... extends` widens
        self.layout: Layout | None = None
        self.static: Instance | None = None
        self.function: FunctionInfo | None = None
        self.record: flat.Type | None = None
        self.lookups: dict[str, tuple[Element, bool] | None] = {}

    @property
    def kind(self) -> syntax.ClassKind:
        return self.definition.kind

    @property
    def span(self) -> Span:
        return self.definition.name_span


# Instances ------------------------------------------------------------------------------------


class State(Enum):
    NEW = 0
    BUSY = 1
    DONE = 2
    BROKEN = 3


class Element:
    """One member of an instance."""

    __slots__ = (
        "cls",
        "definition",
        "entry",
        "inner",
        "mod",
        "name",
        "node",
        "protected",
        "scope",
        "state",
    )

    def __init__(
        self,
        name: str,
        definition: syntax.Component | syntax.ClassDef,
        scope: Scope,
        mod: Mod,
        protected: bool = False,
        entry: Entry | None = None,
    ) -> None:
        self.name = name
        self.definition = definition
        self.scope = scope
        self.mod = mod
        self.protected = protected
        self.entry = entry
        self.node: Node | None = None
        self.cls: Class | None = None
        self.state = State.NEW
        self.inner: Element | None = None  # of an `inner outer` one: the inner half

    @property
    def is_class(self) -> bool:
        return isinstance(self.definition, syntax.ClassDef)


class Scope:
    """A part of an instance: where the names of its text are looked up."""

    __slots__ = ("instance", "part")

    def __init__(self, instance: Instance, part: Part) -> None:
        self.instance = instance
        self.part = part

    @property
    def cls(self) -> Class:
        return self.part.cls

    @property
    def parent(self) -> Scope | None:
        return self.part.cls.parent

    @property
    def session(self) -> Session:
        return self.instance.session


class Instance:
    """A class opened; `prefix` is its full component name, None for a class as such."""

    __slots__ = (
        "causality",
        "cls",
        "depth",
        "drawn",
        "element",
        "elements",
        "layout",
        "mod",
        "parent",
        "part_mods",
        "prefix",
        "scopes",
        "session",
        "value",
        "variability",
    )

    def __init__(
        self,
        cls: Class,
        layout: Layout,
        prefix: str | None,
        mod: Mod,
        parent: Instance | None,
        session: Session,
        variability: flat.Variability = flat.Variability.CONTINUOUS,
        element: Element | None = None,
    ) -> None:
        self.cls = cls
        self.layout = layout
        self.prefix = prefix
        self.mod = mod
        self.parent = parent
        self.session = session
        self.variability = variability
        self.element = element
        #: of all its variables that declare none: `input Orientation R`
        self.causality = syntax.Causality.NONE
        self.depth: int = 0 if parent is None else parent.depth + 1
        #: belongs to a visual: it has values, but no variables
        self.drawn: bool = bool(layout.visual) or (parent is not None and parent.drawn)
        self.elements: dict[str, Element] = {}
        self.scopes: dict[int, Scope] = {}
        self.part_mods: dict[int, Mod] = {}
        self.value: flat.Expression | None = None  # typed record binding

    @property
    def name(self) -> str:
        return self.cls.name if self.prefix is None else self.prefix

    def full_name(self, member: str) -> str:
        if self.prefix is None:
            return f"{self.cls.name}.{member}"
        return f"{self.prefix}.{member}" if self.prefix else member

    def scope(self, index: int = 0) -> Scope:
        found = self.scopes.get(index)
        if found is None:
            found = self.scopes[index] = Scope(self, self.layout.parts[index])
        return found

    @property
    def is_connector(self) -> bool:
        return self.layout.kind in CONNECTOR_KINDS

    @property
    def is_record(self) -> bool:
        return self.layout.kind in RECORD_KINDS


CONNECTOR_KINDS = (syntax.ClassKind.CONNECTOR, syntax.ClassKind.EXPANDABLE_CONNECTOR)
RECORD_KINDS = (syntax.ClassKind.RECORD, syntax.ClassKind.OPERATOR_RECORD)


class Leaf:
    """A variable of a built-in type."""

    __slots__ = (
        "attributes",
        "binding",
        "binding_state",
        "causality",
        "element",
        "evaluated",
        "evaluating",
        "flow",
        "is_connector",
        "layout",
        "mod",
        "name",
        "parent",
        "shapes",
        "structural",
        "type",
        "variability",
    )

    def __init__(
        self,
        name: str,
        type_: flat.Type,
        variability: flat.Variability,
        element: Element,
        parent: Instance,
        mod: Mod,
        layout: Layout,
    ) -> None:
        self.name = name
        self.type = type_
        self.variability = variability
        self.element = element
        self.parent = parent
        self.mod = mod
        self.layout = layout
        self.causality = syntax.Causality.NONE
        self.flow = syntax.Flow.NONE
        self.is_connector = False
        self.structural = False
        self.shapes = False  # structural, and so is all that its value comes from
        self.binding: flat.Expression | None = None
        self.binding_state = State.NEW
        self.evaluated: Value | None = None
        self.evaluating = False
        self.attributes: flat.Attributes | None = None

    @property
    def span(self) -> Span:
        return self.element.definition.span


class Family:
    """An array of instances; `dims` are its sizes, `items` in row-major order."""

    __slots__ = ("cls", "dims", "element", "items", "name")

    def __init__(
        self, name: str, dims: tuple[int, ...], items: list[Instance], cls: Class, element: Element
    ) -> None:
        self.name = name
        self.dims = dims
        self.items = items
        self.cls = cls
        self.element = element


class Absent:
    """A conditional component whose condition is false."""

    __slots__ = ("element", "name")

    def __init__(self, name: str, element: Element) -> None:
        self.name = name
        self.element = element


Node: TypeAlias = Leaf | Instance | Family | Absent


# The run ------------------------------------------------------------------------------------------


class Session:
    """One run of `flatten`: what its passes share."""

    def __init__(self, library: Library) -> None:
        self.library = library
        self.root_scope: Scope | None = None
        self.root: Instance | None = None
        self.errors: list[Diagnostic] = []
        self.warnings: list[Diagnostic] = []
        self.functions: dict[str, flat.Function] = {}
        self.signatures: dict[str, Signature] = {}
        self.formals: dict[str, Signature] = {}  # interfaces of inputs that are functions
        self.leaves: dict[str, Leaf] = {}
        self.annotations: dict[int, tuple[syntax.Annotation, tuple[syntax.Argument, ...]]] = {}
        self.defaults: dict[str, Instance] = {}  # default instances for missing inner ones
        self.component_count = 0
        # known when all connections are, before equations are typed:
        self.rooting: Rooting | None = None
        self.cardinalities: Counter[str] | None = None

    def warn(self, code: str, message: str, span: Span | None, hint: str | None = None) -> None:
        self.warnings.append(Diagnostic(code, message, span, Severity.WARNING, hint))

    def keep(self, problem: PlanarcError) -> None:
        """Remember an error and go on, so that all errors of a model are told at once."""
        self.errors.extend(problem.diagnostics)


def silent() -> PlanarcError:
    """Raised where an error was already reported: stops the work, says nothing more."""
    return PlanarcError(())
