"""What has no value in the user's functions: outputs in the end, entries where they are read.

In:   FlatModel
Out:  warnings L321 of outputs; where no way gives a value, `functions` refuses the call
      warnings L301 of entries of arrays that are read while no statement before gives them a value

A way that ends in an assertion that is always false, or in `return`, needs none. Entries that are
chosen by what is no number in the text may be any.

Example: `if x > 1 then y := 1; end if;` gives `y` no value for x <= 1; behind `z[1] := x;`
the entry `z[2]` has none.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from math import prod
from typing import TypeAlias

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Severity
from planarc.ir import flat
from planarc.ir.flatwalk import children, inside, set_by
from planarc.ir.places import is_own

MAX_ENTRIES = 1000  # of an array that is looked at entry by entry

#: The subscripts of an entry.
Place: TypeAlias = "tuple[int, ...]"


def warn_of_unassigned(model: flat.FlatModel) -> Iterator[Diagnostic]:
    for function in model.functions:
        given = function.external or function.derivative_of
        if given or not is_own(model, function.span):
            continue
        always = _given(function.body)
        for output in function.outputs:
            open_ = output.binding is None and always is not None and 0 not in output.type.dims
            if open_ and not _has_value(output.name, output.type, always or set()):
                yield Diagnostic(
                    "L321",
                    f"not every way through `{function.name}` gives its output `{output.name}` a "
                    "value",
                    output.span,
                    Severity.WARNING,
                    hint=f"give `{output.name}` a value first, or in an `else`",
                )
            missing = _never(output, function.body)
            if missing:
                yield Diagnostic(
                    "L321",
                    f"`{function.name}` never gives `{output.name}[{missing[0]}]` a value: it is 0",
                    output.span,
                    Severity.WARNING,
                    hint="assign each entry, or give the output a value where it is declared",
                )
            else:
                yield from _read_too_early(output, function.body)
        for variable in function.locals:
            yield from _read_too_early(variable, function.body)


def _read_too_early(
    variable: flat.Variable, body: Sequence[flat.Statement]
) -> Iterator[Diagnostic]:
    """The first place that reads an entry which has no value there."""
    dims = tuple(n or 0 for n in variable.type.dims)
    if variable.binding is not None or not 0 < prod(dims) <= MAX_ENTRIES or not dims:
        return
    array = _Array(variable.name, dims)
    for reference, place in array.unset_reads(body, set()):
        entry = f"`{variable.name}[{', '.join(map(str, place))}]`"
        message = f"{entry} is used before it has a value: it is 0"
        hint = f"give {entry} a value above, or all of `{variable.name}` where it is declared"
        yield Diagnostic("L301", message, reference.span, Severity.WARNING, hint=hint)
        return


class _Array(Data):
    """An array of a function, whose entries are followed through its statements."""

    name: str
    dims: Place

    def unset_reads(
        self, body: Sequence[flat.Statement], given: set[Place]
    ) -> Iterator[tuple[flat.Reference, Place]]:
        """What is read without a value; `given` are the entries that may have one, and grows."""
        for statement in body:
            for reference in _read_by(statement):
                if reference.name == self.name:
                    unset = (p for p in self._read(reference) if p not in given)
                    yield from ((reference, p) for p in unset)
            match statement:
                case flat.IfStatement(branches=branches, otherwise=otherwise):
                    ways = [(b, set(given)) for b in (*(b for _, b in branches), otherwise)]
                    for way, here in ways:
                        yield from self.unset_reads(way, here)
                        given |= here
                case flat.ForStatement(body=inner) | flat.WhileStatement(body=inner):
                    given |= self._set(inside(inner))  # by an earlier turn
                    yield from self.unset_reads(inner, given)
                case _:
                    given |= self._set((statement,))

    def _set(self, statements: Iterable[flat.Statement]) -> set[Place]:
        """The entries that statements may give a value."""
        targets = (v for s in statements for v in set_by(s) if v.name.split(".")[0] == self.name)
        return {place for target in targets for place in self._chosen(target) or self._all()}

    def _read(self, reference: flat.Reference) -> Sequence[Place]:
        """The entries that a reference certainly reads; an iterator may have the array's name."""
        iterator = not reference.subscripts and not reference.type.dims
        return () if iterator else self._chosen(reference) or ()

    def _chosen(self, reference: flat.Reference) -> Sequence[Place] | None:
        """The entries that a reference means; None where its subscripts do not tell."""
        subscripts = reference.subscripts
        if not all(isinstance(s, flat.Literal | flat.Slice) for s in subscripts):
            return None
        fixed = [int(s.value) if isinstance(s, flat.Literal) else None for s in subscripts]
        fixed = [*fixed, *(None,) * len(self.dims)][: len(self.dims)]
        ranges = (
            range(1, n + 1) if k is None else (k,) for k, n in zip(fixed, self.dims, strict=True)
        )
        return list(product(*ranges))

    def _all(self) -> Sequence[Place]:
        return list(product(*(range(1, n + 1) for n in self.dims)))


def _read_by(statement: flat.Statement) -> Iterator[flat.Reference]:
    """The variables that a statement itself reads, but for those of which it asks the size."""
    stack = list(_expressions(statement))
    stack.reverse()
    while stack:
        node = stack.pop()
        if isinstance(node, flat.Builtin) and node.function in ("size", "ndims"):
            stack += node.arguments[1:]
            continue
        if isinstance(node, flat.Reference):
            yield node
        stack += children(node)[::-1]


def _expressions(statement: flat.Statement) -> Iterator[flat.Expression]:
    match statement:
        case flat.Assignment(value=value) | flat.TupleAssignment(value=value):
            yield value
            for target in set_by(statement):
                yield from target.subscripts
        case flat.IfStatement(branches=branches):
            yield from (condition for condition, _ in branches)
        case flat.ForStatement(range=range_):
            yield range_
        case flat.WhileStatement(condition=condition):
            yield condition
        case flat.Assert(condition=condition, message=message):
            yield from (condition, message)


def _has_value(name: str, type_: flat.Type, given: set[str]) -> bool:
    """Whether a variable is among those that are given a value, or each field of a record."""
    if name in given:
        return True
    return bool(type_.fields) and all(_has_value(f"{name}.{n}", t, given) for n, t in type_.fields)


def _never(output: flat.Variable, body: Sequence[flat.Statement]) -> list[int]:
    """The entries of a vector that no statement gives a value, where all say which they give."""
    dims, given = output.type.dims, set[int]()
    if output.binding is not None or len(dims) != 1 or not dims[0]:
        return []
    for target in (v for s in inside(body) for v in set_by(s) if v.name == output.name):
        index = target.subscripts[0] if len(target.subscripts) == 1 else None
        if not isinstance(index, flat.Literal):
            return []
        given.add(int(index.value))
    return [n for n in range(1, dims[0] + 1) if n not in given] if given else []


def _given(body: Sequence[flat.Statement]) -> set[str] | None:
    """What is certainly assigned behind statements; None where nothing comes behind them."""
    found: set[str] = set()
    for statement in body:
        match statement:
            case flat.IfStatement(branches=branches, otherwise=otherwise):
                ways = [_given(b) for b in (*(b for _, b in branches), otherwise)]
                open_ways = [w for w in ways if w is not None]
                if not open_ways:
                    return None
                found |= set.intersection(*open_ways)
            case flat.ForStatement(body=inner) | flat.WhileStatement(body=inner):
                found |= _given(inner) or set()  # it is taken to run at least once
            case flat.Return():
                return None
            case flat.Assert(condition=flat.Literal(value=False)):
                return None
            case _:
                found |= {v.name for v in set_by(statement)}
    return found
