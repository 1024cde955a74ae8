"""The instance tree: what `flatten` builds between the syntax tree and the flat model.

    Class      a class in its place: definition, enclosing scope, modifier
    Instance   a class opened: as the model, as a component, or as a package
    Scope      one part of an instance (the class itself or a base class), in which
               names of its text are looked up
    Element    one member of an instance: a component or a class, opened on demand
    Leaf       a component of a built-in type: a variable of the flat model
    Family     an array of component instances
    Env        a scope with local names, in which expressions are typed
    Signature  the inputs and outputs of a function
    Session    one run of `flatten`, with the `Makers` that fill the nodes

Everything is made when first asked for (`demand`), so that array sizes and conditions may
depend on parameters anywhere in the tree. The nodes are filled in lazily and never change
once filled. All these types refer to each other: hence one file.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from enum import Enum
from typing import TypeAlias

from msgspec import Struct, field
from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, PlanarcError, Severity, error
from planarc.core.mend import Meant, Mend
from planarc.core.source import Span
from planarc.flatten.library.library import Entry, Library
from planarc.flatten.terms.constant import Value
from planarc.ir import flat, syntax

#: What is added to the depth of bindings of classes that belong to no component (types, packages).
STATIC_DEPTH = 1_000_000


# Modifiers --------------------------------------------------------------------------------


class Binding(Struct, eq=False):
    """An expression of a modifier, with the scope that it was written in.

    `subscripts` pick the element that belongs to one member of an array of components, which has
    `sizes`.
    """

    expression: syntax.Expression
    scope: Scope
    span: Span
    #: levels between `each` and this modifier below it (0: on itself), None: there is none
    each_height: int | None = None
    final: bool = False
    subscripts: tuple[int, ...] = ()
    sizes: tuple[int, ...] = ()
    #: true for a declaration's own `= value` in the class that declares the variable
    default: bool = False
    #: true for a part of a record whose whole has a value from further outside
    beaten: bool = False
    typed: flat.Expression | None = None
    #: the expression with its types, once for all members of an array of components
    whole: list[flat.Expression] = field(default_factory=list)

    @property
    def each(self) -> bool:
        return self.each_height == 0

    @property
    def depth(self) -> int:
        """The depth of the modifier in the component tree; less is stronger."""
        instance = self.scope.instance
        return instance.depth + (STATIC_DEPTH if instance.prefix is None else 0)

    def yields_to(self, whole: Binding) -> bool:
        """The value of the record around it is stronger than this one of a part."""
        return self.beaten or whole.depth < self.depth

    def is_under(self, whole: Binding) -> bool:
        """It yields, or is what the class of the part itself declares: whatever modifies the
        record around stands further outside, that of a static class, too."""
        return self.default or self.yields_to(whole)


class Redeclaration(Struct, eq=False):
    """A new declaration for a replaceable element, with the scope it was written in."""

    element: syntax.Declaration
    scope: Scope
    each_height: int | None = None
    final: bool = False
    subscripts: tuple[int, ...] = ()
    sizes: tuple[int, ...] = ()
    #: what stands further inside than this one, the redeclaration that it replaces included
    inside: Mod = field(default_factory=lambda: NO_MOD)


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


NO_MOD: Mod = Mod()


# Classes ------------------------------------------------------------------------------------


class Part(Struct, eq=False):
    """A class or one of its base classes, within a layout."""

    cls: Class
    index: int
    own: dict[str, syntax.Declaration]
    imports: tuple[syntax.Import, ...] = ()
    redeclarations: tuple[syntax.Declaration, ...] = ()
    #: names that the text of this part can see: its own and those of its bases
    visible: set[str] = field(default_factory=set)
    entries: list[Entry | Library] = field(default_factory=list)
    derived: int | None = None  # the part that extends this one
    modification: syntax.Modification | None = None  # of the extends clause
    mod_scope: Scope | None = None  # where it is resolved; None: in the deriving part
    base_at: Span | None = None  # where the deriving class names it
    protected: bool = False
    #: components and connections that a class which extends this one leaves out
    left_out: frozenset[str] = frozenset()
    cut: tuple[syntax.Connect, ...] = ()
    #: classes that names of its text mean in every instance, by the name's identity
    types: dict[int, tuple[syntax.Ref, Class]] = field(default_factory=dict)

    @property
    def definition(self) -> syntax.ClassDef:
        return self.cls.definition

    def holds(self, connect: syntax.Connect) -> bool:
        """False for a connection that is left out, itself or with a component."""
        ends = {connect.left.parts[0].name, connect.right.parts[0].name}
        return connect not in self.cut and self.left_out.isdisjoint(ends)

    def is_in_file(self, name: str) -> bool:
        """True for a class of a package that has its own file."""
        return any(entry.child(name) is not None for entry in self.entries)


class Layout(Struct, eq=False):
    """The parts and members of a class after inheritance, shared by all its instances."""

    parts: list[Part]
    #: name -> (part that declares it, its declaration), in order of declaration
    members: dict[str, tuple[int, syntax.Declaration]]
    builtin: flat.Type | None = None
    dimensions: tuple[tuple[syntax.Expression, Scope], ...] = ()
    causality: syntax.Causality = syntax.Causality.NONE
    flow: syntax.Flow = syntax.Flow.NONE
    kind: syntax.ClassKind = syntax.ClassKind.CLASS
    done: bool = False
    type_mod: Mod | None = None
    #: of variables without modifiers, by their sizes
    type_attributes: dict[flat.Dims, flat.Attributes] = field(default_factory=dict)
    derivative: tuple[syntax.DerivativeClass, Scope] | None = None
    visual: str | None = None  # what instances are drawn as, "" for nothing, None: not asked
    #: (part, foreign, kind, name, expression) that instances declare; None: not asked
    told: tuple[tuple[int, bool, str, str, syntax.Expression], ...] | None = None
    #: the texts of equations that stand in several parts, with the first one; None: not asked
    repeated: dict[str, int] | None = None


class Class(Struct, eq=False):
    """A class definition in its place."""

    definition: syntax.ClassDef
    parent: Scope | None
    name: str
    mod: Mod = field(default_factory=lambda: NO_MOD)
    entry: Entry | Library | None = None
    original: Class | None = None  # the class that `redeclare ... extends` widens
    under: Mod = field(default_factory=lambda: NO_MOD)  # of the constraint of a short class
    layout: Layout | None = None
    static: Instance | None = None
    function: FunctionInfo | None = None
    record: flat.Type | None = None
    lookups: dict[str, tuple[Element, bool] | None] = field(default_factory=dict)

    @property
    def span(self) -> Span:
        return self.definition.name_span


# Instances ------------------------------------------------------------------------------------


class State(Enum):
    NEW = 0
    BUSY = 1
    DONE = 2
    BROKEN = 3


class Element(Struct, eq=False):
    """One member of an instance."""

    name: str
    definition: syntax.Declaration
    scope: Scope
    mod: Mod
    protected: bool = False
    entry: Entry | None = None
    node: Node | None = None
    cls: Class | None = None
    state: State = State.NEW
    inner: Element | None = None  # of an `inner outer` one: the inner half

    @property
    def is_class(self) -> bool:
        return isinstance(self.definition, syntax.ClassDef)


class Scope(Struct, eq=False):
    """A part of an instance: where the names of its text are looked up."""

    instance: Instance
    part: Part

    @property
    def cls(self) -> Class:
        return self.part.cls

    @property
    def parent(self) -> Scope | None:
        return self.part.cls.parent

    @property
    def session(self) -> Session:
        return self.instance.session


class Instance(Struct, eq=False):
    """A class opened; `prefix` is its full component name, None for a class as such."""

    cls: Class
    layout: Layout
    prefix: str | None
    mod: Mod
    parent: Instance | None
    session: Session
    variability: flat.Variability = flat.Variability.CONTINUOUS
    element: Element | None = None
    #: the causality of its variables that declare none: `input Orientation R`
    causality: syntax.Causality = syntax.Causality.NONE
    #: likewise `flow`: `flow Force f` of a record
    flow: syntax.Flow = syntax.Flow.NONE
    #: of a member of an array of components: its place in it, and the sizes of the array
    indices: tuple[int, ...] = ()
    sizes: tuple[int, ...] = ()
    depth: int = 0  # of components around
    drawn: bool = False  # belongs to a visual: it has values, but no variables
    hidden: bool = False  # protected, or in what is protected
    elements: dict[str, Element] = field(default_factory=dict)
    scopes: dict[int, Scope] = field(default_factory=dict)
    part_mods: dict[int, Mod] = field(default_factory=dict)
    value: flat.Expression | None = None  # typed record binding

    def __post_init__(self) -> None:
        self.drawn = bool(self.layout.visual)
        self.hidden = self.element is not None and self.element.protected
        if self.parent is not None:
            self.depth = self.parent.depth + 1
            self.drawn = self.drawn or self.parent.drawn
            self.hidden = self.hidden or self.parent.hidden

    @property
    def name(self) -> str:
        return self.cls.name if self.prefix is None else self.prefix

    @property
    def span(self) -> Span:
        """The declaration; of the model, and of a class as such, its name."""
        return self.cls.span if self.element is None else self.element.definition.span

    def outwards(self) -> Iterator[Instance]:
        """The instance itself and those around it, the nearest first."""
        current: Instance | None = self
        while current is not None:
            yield current
            current = current.parent

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

    @property
    def has_value(self) -> bool:
        """A record, or a connector that is one, as in `connector Signal = input Record`."""
        return self.is_record or (
            self.is_connector and any(p.definition.kind in RECORD_KINDS for p in self.layout.parts)
        )


CONNECTOR_KINDS = (syntax.ClassKind.CONNECTOR, syntax.ClassKind.EXPANDABLE_CONNECTOR)
RECORD_KINDS = (syntax.ClassKind.RECORD, syntax.ClassKind.OPERATOR_RECORD)


class Leaf(Struct, eq=False):
    """A variable of a built-in type."""

    name: str
    type: flat.Type
    variability: flat.Variability
    element: Element
    parent: Instance
    mod: Mod
    layout: Layout
    causality: syntax.Causality = syntax.Causality.NONE
    flow: syntax.Flow = syntax.Flow.NONE
    is_connector: bool = False
    structural: bool = False
    shapes: bool = False  # structural, and so is all that its value comes from
    binding: flat.Expression | None = None
    binding_state: State = State.NEW
    evaluated: Value | None = None
    evaluating: bool = False
    attributes: flat.Attributes | None = None

    @property
    def span(self) -> Span:
        return self.element.definition.span


class Family(Struct, eq=False):
    """An array of instances; `dims` are its sizes, `items` in row-major order."""

    name: str
    dims: tuple[int, ...]
    items: list[Instance]
    cls: Class
    element: Element


class Absent(Struct, eq=False):
    """A conditional component whose condition is false."""

    name: str
    element: Element


Node: TypeAlias = Leaf | Instance | Family | Absent


# Expressions and functions --------------------------------------------------------------------


class Env(Data):
    """The surroundings of an expression: scope, local names, the function around it."""

    scope: Scope
    #: iterators and, inside functions, the function's own variables
    locals: flat.Named = field(default_factory=dict)
    function: Signature | None = None
    #: the array and the dimension (from 0) that `end` in a subscript refers to
    end: tuple[flat.Expression, int] | None = None
    #: true in an algorithm, where a loop whose body needs constant indices is unrolled
    in_algorithm: bool = False
    #: the iterators of the loops around
    iterators: frozenset[str] = frozenset()
    #: where the innermost of them is written
    loop: Span | None = None
    #: true in the body of a loop that `break` can leave
    in_loop: bool = False
    in_when: bool = False
    at_tick: bool = False  # in a `when` of a clock
    #: true where a member of an array of components may be chosen while the model runs
    picks: bool = False

    @property
    def session(self) -> Session:
        return self.scope.session

    @property
    def component(self) -> str:
        """The full name of the component around; empty for the model itself, and in functions."""
        return self.scope.instance.prefix or ""

    def typed(self, expression: syntax.Expression) -> flat.Expression:
        """The typed form of an expression: every name resolved, every node with its type."""
        return self.scope.instance.session.makers.typed(expression, self)

    @property
    def hidden(self) -> frozenset[str]:
        """Local names that have no value yet; they hide variables of the model."""
        return frozenset(n for n, v in self.locals.items() if isinstance(v, flat.Reference))

    def with_local(self, name: str, value: flat.Expression) -> Env:
        return replace(self, locals={**self.locals, name: value})

    def with_iterator(self, iterator: syntax.Iterator, value: flat.Expression) -> Env:
        inner, name = self.with_local(iterator.name, value), iterator.name
        return replace(inner, iterators=self.iterators | {name}, loop=iterator.span)

    def picking(self) -> Env:
        return replace(self, picks=True)

    def with_end(self, base: flat.Expression, dimension: int) -> Env:
        return replace(self, end=(base, dimension))


class Signature(Struct, eq=False):
    """Inputs and outputs of a function, and what it reads from the model."""

    name: str
    inputs: tuple[flat.Variable, ...] = ()
    outputs: tuple[flat.Variable, ...] = ()
    defaults: dict[str, tuple[syntax.Expression, Scope]] = field(default_factory=dict)
    constants: flat.Named = field(default_factory=dict)
    captures: dict[str, Leaf] = field(default_factory=dict)
    builtin: str | None = None  # the function only stands for this built-in
    done: bool = False
    called_early: bool = False  # by itself, while it was being made

    def capture(self, leaf: Leaf, span: Span) -> flat.Expression:
        """A variable of the model, as the function's body reads it."""
        self.captures.setdefault(leaf.name, leaf)
        return flat.Reference(leaf.type, span, leaf.name)


class FunctionInfo(Struct, eq=False):
    """A function class as seen by a call."""

    name: str
    signature: Signature
    bound: dict[str, Binding]


# The run ------------------------------------------------------------------------------------------


class Forest(Struct):
    """The spanning forest of overconstrained connectors, as far as expressions ask for it."""

    roots: set[str] = field(default_factory=set)
    distance: dict[str, int] = field(default_factory=dict)
    partner: dict[str, str] = field(default_factory=dict)  # by branches


class Makers(Data):
    """The passes that fill the nodes on demand; `pipeline` hands them in.

    A size needs a value, a value its expression's type, a type the sizes of variables: these
    passes need each other. Their modules do not; each asks the session through `demand`.
    """

    layout: Callable[[Class], Layout]
    cls: Callable[[Element, Span | None], Class]
    node: Callable[[Element], Node]
    binding: Callable[[Leaf], flat.Expression | None]
    attributes: Callable[[Leaf], flat.Attributes]
    typed: Callable[[syntax.Expression, Env], flat.Expression]
    call: Callable[[syntax.Call, Env], flat.Expression]
    function: Callable[[Class, Span], FunctionInfo]
    operate: Callable[[str, tuple[flat.Expression, ...], Span, Env], flat.Expression]


def is_overloaded(value: flat.Expression, env: Env) -> bool:
    """Whether a value is an operator record, or an array's entries are."""
    type_ = value.type
    return type_.base is flat.Base.RECORD and type_.name in env.session.operator_records


#: A variable that was asked for its value, and whether that makes it structural; None for what has
#: another answer in each component, such as its own name, and what is connected to it.
Question: TypeAlias = "tuple[Leaf, bool] | None"


#: An if-equation of which parameters choose a branch: its number, that of `else` the last.
Chosen: TypeAlias = "tuple[syntax.IfEquation, int, Env]"


class Session:
    """One run of `flatten`: what its passes share."""

    def __init__(self, library: Library, makers: Makers) -> None:
        self.library = library
        self.makers = makers
        self.root_scope: Scope  # the outermost one, in which top-level classes are found
        self.root: Instance | None = None
        self.errors: list[Diagnostic] = []
        self.warnings: list[Diagnostic] = []
        self.functions: dict[str, flat.Function] = {}
        self.signatures: dict[str, Signature] = {}
        self.operator_records: dict[str, Class] = {}  # those of which there are values
        self.formals: dict[str, Signature] = {}  # interfaces of inputs that are functions
        self.leaves: dict[str, Leaf] = {}
        #: variables that nobody has asked for yet: their instance, and their name in it
        self.closed: dict[str, tuple[Instance, str]] = {}
        self.asked: list[Question] = []
        self.annotations: dict[int, tuple[syntax.Annotation, tuple[syntax.Argument, ...]]] = {}
        self.defaults: dict[str, Instance] = {}  # default instances for missing inner ones
        self.met: set[tuple[Instance, str]] = set()  # inner components that outer ones met
        self.opened: list[Class] = []  # classes with a layout, in the order of their use
        self.inner_classes: set[str] = set()  # the names of classes that these hold
        self.chosen: list[Chosen] = []
        #: the scope of an expression that may name what is not there, of which nobody is told
        self.doubted: Scope | None = None
        self.component_count = 0
        self.clocked = False  # operators of clocks stand in what was typed
        #: discrete variables with a value that moves, and the error where they do not tick
        self.unsettled: list[tuple[str, PlanarcError]] = []
        # known when all connections are, before equations are typed:
        self.rooting: Forest | None = None
        self.cardinalities: Counter[str] | None = None

    def warn(
        self,
        code: str,
        message: str,
        span: Span | None,
        hint: str | Meant | None = None,
        mend: Mend | None = None,
    ) -> None:
        (found,) = error(code, message, span, hint=hint, mend=mend).diagnostics
        self.warnings.append(replace(found, severity=Severity.WARNING))

    def own_files(self) -> set[str]:
        """The names of the user's files, and of that of the model, which may be a library's."""
        model = () if self.root is None else (self.root.cls.span.source.name,)
        return {*self.library.user_files(), *model}

    def keep(self, problem: PlanarcError) -> None:
        """Remember an error and go on, so that all errors of a model are told at once."""
        self.errors.extend(problem.diagnostics)

    def take_apart(self) -> None:
        """Nobody asks for nodes any more: components let go of each other, and of their memory,
        without a search for cycles."""
        instances = [*dict.fromkeys(leaf.parent for leaf in self.leaves.values())]
        instances += [*self.defaults.values(), *([] if self.root is None else [self.root])]
        instances.append(self.root_scope.instance)
        for cls in self.opened:
            instances += [] if cls.static is None else [cls.static]
            for part in [] if cls.layout is None else cls.layout.parts:
                part.types = {}
            cls.static, cls.layout, cls.lookups = None, None, {}
        for instance in instances:
            for element in instance.elements.values():
                node, element.node = element.node, None
                if isinstance(node, Instance):
                    instances.append(node)
                elif isinstance(node, Family):
                    instances += node.items
            instance.elements, instance.scopes, instance.parent = {}, {}, None
        self.leaves, self.closed, self.asked = {}, {}, []


def silent() -> PlanarcError:
    """Raised where an error was already reported: stops the work, says nothing more."""
    return PlanarcError(())
