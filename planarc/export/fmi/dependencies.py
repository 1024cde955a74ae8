"""What outputs and derivatives of states depend on: which states and inputs, the time, and how.

In:   Slopes, the nodes of what is known
Out:  of each node what it depends on: {known node: kind}

A value that is computed by a formula depends on what that reads; what is solved for in a block
depends on all that its equations read. The kind is the worst of the factors on the way: a number,
an expression of parameters, or one that changes while running.

Example: der(x) = v depends on v in a `constant` way, der(v) = -c/m*x on x in a `fixed` one.

Reference: FMI 3.0.2, section 2.4.8, and FMI 2.0.4, section 2.2.8 (dependenciesKind).
"""

from __future__ import annotations

from collections.abc import Collection, Iterable

from planarc.codegen.slopes import Slopes
from planarc.ir.expr import Expr, Op, fold, text

#: From the simplest to the least known.
KINDS = ("constant", "fixed", "tunable", "dependent")
_CONSTANT, _FIXED, _TUNABLE, _DEPENDENT = range(len(KINDS))


def find_dependencies(
    slopes: Slopes, knowns: Iterable[int], fixed: Collection[str], tunable: Collection[str]
) -> list[dict[int, int]]:
    """Places in `KINDS`; `fixed` and `tunable` are names of parameters."""

    kinds: dict[Expr, int] = {}

    def kind_of(e: Expr) -> int:
        if e.args:
            return max(map(kinds.__getitem__, e.args))
        if e.op is Op.SYMBOL:
            name = text(e)
            return _FIXED if name in fixed else _TUNABLE if name in tunable else _DEPENDENT
        return _CONSTANT if e.op is Op.CONST else _DEPENDENT

    found: list[dict[int, int]] = [{} for _ in slopes.nodes]
    own = set(knowns)
    for node in own:
        found[node] = {node: _CONSTANT}

    def follow(first: int, stop: int) -> int:
        """Rows one by one; gives the worst of their factors."""
        worst = _CONSTANT
        for row in slopes.rows[first:stop]:
            total: dict[int, int] = {}
            for source, slope in row.terms:
                factor = fold(slope, kinds, kind_of)
                worst = max(worst, factor)
                for known, kind in found[source].items():
                    if kind < factor:
                        kind = factor
                    if total.get(known, -1) < kind:
                        total[known] = kind
            if row.target not in own:
                found[row.target] = total
        return worst

    for run in slopes.runs:
        factor = follow(run.first, run.stop)
        if not run.residuals:
            continue
        together: dict[int, int] = {}
        for node in run.residuals:
            for known, kind in found[node].items():
                together[known] = max(together.get(known, _CONSTANT), kind, factor)
        for node in run.tears:
            if node not in own:
                found[node] = together
        follow(run.first, run.inner)
    return found
