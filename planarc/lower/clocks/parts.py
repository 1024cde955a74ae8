"""Parts of a model that tick together.

In:   FlatModel
Out:  Parting: the continuous rest as a FlatModel, and parts, each with equations and variables

What stands in one equation ticks together, but across an operator that changes from one clock to
another. A part is clocked where an operator of clocks says so; what `sample` reads is continuous.

Example:

    der(x) = u;  u = hold(v);                       continuous: x, u
    y = sample(x, Clock(0.1));  v = -2*y;           part 1: y, v
    s = subSample(v, 5);                            part 2: s, at every fifth tick of part 1

Reference: Modelica Language Specification 3.6, section 16.7.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TypeVar

from msgspec import Struct, field
from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.disjoint import DisjointSets
from planarc.core.source import Span
from planarc.ir import flat
from planarc.ir.flatwalk import (
    CONVERSIONS,
    OUTWARDS,
    children,
    expressions_in,
    is_clock,
    is_clocked_sample,
)
from planarc.lower.clocks.refusals import (
    differentiated,
    expect_no_events,
    of_events,
    sampled_what_ticks,
    shortest_way,
    two_methods,
)
from planarc.lower.values import fixed_dims, scalar_names

Item = TypeVar("Item")

#: The set of what is continuous.
_CONTINUOUS = "$continuous"
_OF_TICKS = frozenset({"interval", "firstTick", "previous"})


class Conversion(Data):
    """A clock that follows from another one: `operator` and its whole numbers; none where a factor
    is to be found."""

    operator: str  # "" where both tick together
    numbers: tuple[int, ...]
    source: int  # parts
    target: int
    span: Span


class Part(Data):
    """What ticks together. `clocks` are those that are given for it, `method` integrates its
    derivatives."""

    equations: tuple[flat.Equation, ...]
    algorithms: tuple[flat.Algorithm, ...]
    variables: frozenset[str]  # scalars
    clocks: tuple[flat.Builtin, ...]
    span: Span  # of what says that it is clocked
    method: str = ""
    open: bool = False  # it has inputs or outputs of the model itself


class Parting(Data):
    continuous: flat.FlatModel
    parts: tuple[Part, ...]
    conversions: tuple[Conversion, ...]


def part(source: flat.FlatModel) -> Parting:
    """The clocked parts of a model. Raises PlanarcError (L370, L371)."""
    reader = _Reader(source)
    reader.read_model()
    return reader.parting()


class _Reader(Struct):
    """Joins names and equations that tick together. Equations have names of their own, `$1`."""

    source: flat.FlatModel
    sets: DisjointSets[str] = field(default_factory=lambda: DisjointSets([_CONTINUOUS]))
    unknown: dict[str, flat.Variable] = field(default_factory=dict)
    inputs: set[str] = field(default_factory=set)  # given from outside of the model
    outputs: set[str] = field(default_factory=set)  # scalars that go there
    clocked: dict[str, Span] = field(default_factory=dict)  # what says so
    clocks: list[tuple[str, flat.Builtin]] = field(default_factory=list)
    methods: list[tuple[str, str, Span]] = field(default_factory=list)
    conversions: list[tuple[str, tuple[int, ...], str, str, Span]] = field(default_factory=list)
    rates: list[tuple[str, Span]] = field(default_factory=list)  # derivatives
    befores: list[tuple[str, flat.Builtin]] = field(default_factory=list)  # `pre` and the like
    equations: list[tuple[str, flat.Equation | flat.Algorithm]] = field(default_factory=list)
    bound: dict[str, str] = field(default_factory=dict)  # variables with a binding
    given: list[str] = field(default_factory=list)  # equations with inputs of the model
    joins: list[tuple[str, str, Span]] = field(default_factory=list)
    count: int = 0

    def read_model(self) -> None:
        varying = [v for v in self.source.variables if v.variability > flat.Variability.PARAMETER]
        self.unknown = {v.name: v for v in varying if v.causality != "input" or v.binding}
        self.inputs = {v.name for v in varying} - self.unknown.keys()
        outputs = (v for v in varying if v.causality == "output")
        self.outputs = {n for v in outputs for n in scalar_names(v.name, fixed_dims(v.type))}
        for v in self.unknown.values():
            if v.type.base is flat.Base.CLOCK:
                for name in scalar_names(v.name, fixed_dims(v.type)):
                    self._mark(name, v.span)
            if v.binding is not None:
                own = flat.Reference(v.type, v.span, v.name)
                equation = flat.Equality(v.binding.span, v.component, own, v.binding)
                self.bound[v.name] = self._read_equation(equation)
        for e in self.source.equations:
            if not isinstance(e, flat.Assert):
                self._read_equation(e)
        for algorithm in self.source.algorithms:
            node = self._new(algorithm)
            for value in expressions_in(algorithm.statements):
                self.read(value, node)

    def _new(self, item: flat.Equation | flat.Algorithm | None = None) -> str:
        self.count += 1
        node = f"${self.count}"
        self.sets.add(node)
        if item is not None:
            self.equations.append((node, item))
        return node

    def _join(self, a: str, b: str, span: Span) -> None:
        self.sets.join(a, b)
        self.joins.append((a, b, span))

    def _scalars(self, e: flat.Reference) -> Sequence[str]:
        """The scalars that a reference may mean."""
        v, indices = self.unknown[e.name], [s for s in e.subscripts if isinstance(s, flat.Literal)]
        if indices and len(indices) == len(v.type.dims):
            return (f"{v.name}[{','.join(str(s.value) for s in indices)}]",)
        return scalar_names(v.name, fixed_dims(v.type))

    def _mark(self, node: str, span: Span) -> None:
        self.sets.add(node)
        self.clocked.setdefault(node, span)

    def _read_equation(self, e: flat.Equation) -> str:
        node = self._new(e)
        match e:
            case flat.Equality(left=flat.Reference() as left) if is_clock(left):
                self._read_clocks(left, e.right, node)
            case flat.WhenEquation(branches=((condition, body),)) if is_clock(condition):
                self._read_clock(condition, node)
                self._mark(node, condition.span)
                for value in expressions_in(body):
                    self.read(value, node)
            case _:
                for value in expressions_in((e,)):
                    self.read(value, node)
        return node

    def read(self, root: flat.Expression, node: str) -> None:
        """Join what stands in an expression with the equation that it stands in."""
        stack = [root]
        while stack:
            e = stack.pop()
            match e:
                case flat.Reference(name=name) if name in self.unknown:
                    for scalar in self._scalars(e):
                        self._join(node, scalar, e.span)
                    stack += e.subscripts
                case flat.Reference(name=name) if name in self.inputs:
                    self.given.append(node)
                case flat.Builtin() if is_clocked_sample(e):
                    self._mark(node, e.span)
                    self.read(e.arguments[0], _CONTINUOUS)
                    for clock in e.arguments[1:]:
                        self._read_clock(clock, node)
                case flat.Builtin(function=function) if function in OUTWARDS:
                    inner = self._new()
                    self.read(e.arguments[0], inner)
                    self._mark(inner, e.span)
                case flat.Builtin(function=function) if function in CONVERSIONS:
                    self._convert(e, node)
                case flat.Builtin(function=function) if function in _OF_TICKS:
                    self._mark(node, e.span)
                    for a in e.arguments:
                        if is_clock(a):
                            self._read_clock(a, node)
                        else:
                            stack.append(a)
                case flat.Builtin(function="der"):
                    self.rates.append((node, e.span))
                    stack += e.arguments
                case flat.Builtin(function="pre" | "edge" | "change"):
                    self.befores.append((node, e))
                    stack += e.arguments
                case _:
                    stack += children(e)

    def _read_clocks(self, left: flat.Reference, right: flat.Expression, node: str) -> None:
        """Join clocks that an equation says are one, entry by entry."""
        ours = self._scalars(left)
        match right:
            case flat.Reference() if left.type.dims:
                for name, other in zip(ours, self._scalars(right), strict=True):
                    self._join(name, other, right.span)
            case flat.Array(items=items):
                for name, item in zip(ours, items, strict=True):
                    self._read_clock(item, name)
            case _:
                self._read_clock(left, node)
                self._read_clock(right, node)

    def _read_clock(self, e: flat.Expression, node: str) -> None:
        """Join what an expression of type `Clock` says with what ticks by it."""
        self._mark(node, e.span)
        match e:
            case flat.Reference():
                for scalar in self._scalars(e):
                    self._join(node, scalar, e.span)
            case flat.Builtin(function="Clock", arguments=()):
                pass
            case flat.Builtin(function="Clock", arguments=(first, flat.Literal(value=str(method)))):
                inner = self._new()
                self._read_clock(first, inner)
                self.conversions.append(("", (), inner, node, e.span))
                self.methods.append((node, method, e.span))
            case flat.Builtin(function="Clock", arguments=(first, *_)):
                self.clocks.append((node, e))
                if first.type.base is flat.Base.BOOLEAN:
                    self.read(first, _CONTINUOUS)
            case flat.Builtin(function=function) if function in CONVERSIONS:
                self._convert(e, node)

    def _convert(self, e: flat.Builtin, node: str) -> None:
        value, *numbers = e.arguments
        inner = self._new()
        if is_clock(value):
            self._read_clock(value, inner)
        else:
            self.read(value, inner)
        self._mark(node, e.span)
        self._mark(inner, e.span)
        known = tuple(int(n.value) for n in numbers if isinstance(n, flat.Literal))
        self.conversions.append((e.function, known, inner, node, e.span))

    # What was found ------------------------------------------------------------------------

    def parting(self) -> Parting:
        roots: dict[str, Span] = {}
        for name, span in self.clocked.items():
            roots.setdefault(self.sets.find(name), span)
        if self.sets.find(_CONTINUOUS) in roots:
            raise sampled_what_ticks(self._way(_CONTINUOUS))
        number = {root: i for i, root in enumerate(roots)}
        methods: dict[str, tuple[str, Span]] = {}
        for node, method, span in self.methods:
            known, first = methods.setdefault(self.sets.find(node), (method, span))
            if known != method:
                raise two_methods(span, first)
        for node, span in self.rates:
            root = self.sets.find(node)
            if root in number and root not in methods:
                raise differentiated(span, self._way(node))
        equations = self._by_root(self.equations)
        scalars = self._by_root((n, n) for n in self._values())
        clocks = self._by_root(self.clocks)
        given = {self.sets.find(node) for node in self.given}
        parts = tuple(
            _part(
                equations.get(root, ()),
                scalars.get(root, ()),
                tuple(clocks.get(root, ())),
                span,
                methods[root][0] if root in methods else "",
                root in given or not self.outputs.isdisjoint(scalars.get(root, ())),
            )
            for root, span in roots.items()
        )
        for one in parts:
            expect_no_events(equations_of(one))
        for node, e in self.befores:
            if self.sets.find(node) in number:
                raise of_events(e)
        conversions = tuple(
            Conversion(name, numbers, number[self.sets.find(a)], number[self.sets.find(b)], span)
            for name, numbers, a, b, span in self.conversions
        )
        return Parting(self._continuous(roots), parts, conversions)

    def _values(self) -> Iterator[str]:
        """The scalars that are no clocks, and stand in equations."""
        for v in self.unknown.values():
            if v.type.base is not flat.Base.CLOCK:
                yield from (n for n in scalar_names(v.name, fixed_dims(v.type)) if n in self.sets)

    def _by_root(self, found: Iterable[tuple[str, Item]]) -> dict[str, list[Item]]:
        """What belongs to names, by their sets."""
        groups: dict[str, list[Item]] = {}
        for name, item in found:
            groups.setdefault(self.sets.find(name), []).append(item)
        return groups

    def _continuous(self, roots: Iterable[str]) -> flat.FlatModel:
        """The model without the equations of clocked parts, and without clocks."""
        clocked = set(roots)
        ours = {id(e) for node, e in self.equations if self.sets.find(node) in clocked}
        bound = {n for n, node in self.bound.items() if self.sets.find(node) in clocked}
        model = self.source
        return replace(
            model,
            variables=tuple(
                replace(v, binding=None) if v.name in bound else v
                for v in model.variables
                if v.type.base is not flat.Base.CLOCK
            ),
            equations=tuple(
                e for e in model.equations if id(e) not in ours and not _is_of_clock(e)
            ),
            algorithms=tuple(a for a in model.algorithms if id(a) not in ours),
        )

    def _way(self, start: str) -> list[Span]:
        """The places of a shortest way of joins to what is clocked, and that of its mark."""
        root = self.sets.find(start)
        ends = [n for n in self.clocked if self.sets.find(n) == root]
        way, end = shortest_way(self.joins, start, ends)
        return [*way, self.clocked[end]]


def _part(
    own: Iterable[flat.Equation | flat.Algorithm],
    names: Iterable[str],
    clocks: tuple[flat.Builtin, ...],
    span: Span,
    method: str,
    is_open: bool,
) -> Part:
    held = [e for e in own if isinstance(e, flat.Algorithm) or not _is_of_clock(e)]
    return Part(
        tuple(e for e in held if not isinstance(e, flat.Algorithm)),
        tuple(e for e in held if isinstance(e, flat.Algorithm)),
        frozenset(names),
        clocks,
        span,
        method,
        is_open,
    )


def _is_of_clock(e: flat.Equation) -> bool:
    """Whether an equation gives a clock, and no value."""
    return (
        isinstance(e, flat.Equality) and not isinstance(e.left, flat.Targets) and is_clock(e.left)
    )


def equations_of(part: Part) -> Iterator[flat.Equation]:
    """The equations of a part, those of its when-clauses too."""
    for e in part.equations:
        if isinstance(e, flat.WhenEquation) and is_clock(e.branches[0][0]):
            yield from e.branches[0][1]
        else:
            yield e
