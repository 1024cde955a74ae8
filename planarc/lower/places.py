"""Integer inputs of a function that say which entry of an array is meant.

In:   flat.Function
Out:  the positions of such inputs

Such an input can only be one of the array's subscripts, so a function whose course hangs
on it can be run once for each of them. An input is one when it stands in a subscript,
or in what a variable is assigned that stands in one.

Example: the place where a search in a table begins.

    next := last;
    while next < n and u >= table[next, 1] loop  next := next + 1;  end while;
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from planarc.ir import flat
from planarc.ir.flatwalk import expressions_of_function, inside, names_in, nodes_of, set_by


def places(function: flat.Function) -> list[int]:
    names = _subscripts(function)
    sources = list(_assigned_from(function.body))
    grown = True
    while grown:
        before = len(names)
        for target, read in sources:
            if target in names:
                names |= read
        grown = len(names) > before
    return [
        i
        for i, v in enumerate(function.inputs)
        if v.name in names and v.type.base is flat.Base.INTEGER and not v.type.dims
    ]


def _subscripts(function: flat.Function) -> set[str]:
    """The variables in subscripts."""
    found: set[str] = set()
    for node in nodes_of(expressions_of_function(function)):
        if isinstance(node, flat.Reference | flat.Index):
            found |= names_in(node.subscripts)
    return found


def _assigned_from(statements: Sequence[flat.Statement]) -> Iterator[tuple[str, set[str]]]:
    """Each variable that is assigned, with those in its new value."""
    for statement in inside(statements):
        if isinstance(statement, flat.Assignment):
            for variable in set_by(statement):
                yield variable.name, names_in((statement.value,))
