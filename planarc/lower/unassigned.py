"""Outputs of the user's functions that some way through the algorithm leaves without a value.

In:   FlatModel
Out:  warnings L321; where no way gives a value, `functions` refuses the call

A way that ends in an assertion that is always false, or in `return`, needs none.

Example: `if x > 1 then y := 1; end if;` gives `y` no value for x <= 1.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.ir import flat
from planarc.ir.flatwalk import inside, set_by
from planarc.ir.places import is_own


def warn_of_unassigned(model: flat.FlatModel) -> Iterator[Diagnostic]:
    for function in model.functions:
        given = function.external or function.derivative_of
        if given or not is_own(model, function.span):
            continue
        always = _given(function.body)
        for output in function.outputs:
            open_ = output.binding is None and always is not None
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
