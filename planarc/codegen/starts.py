"""Start and nominal values, each under a symbol of its own.

In:   SortedDae
Out:  (symbol, formula of parameters): `start(rev.phi)`, `nominal(rev.phi)`

Start values are computed once and then read from the workspace, so that a user may
overwrite them before the run without compiling again.
"""

from __future__ import annotations

from planarc.codegen.aliases import Aliases
from planarc.ir.expr import Expr
from planarc.ir.sorted import SortedDae


def start_values(sorted: SortedDae, aliases: Aliases) -> list[tuple[Expr, Expr]]:
    """Starts of candidates, held variables, unknowns of blocks at the top, and discrete values."""
    table = sorted.dae.table
    zero = table.zero
    found: dict[str, Expr] = {}
    for c in sorted.candidates:
        found[f"start({c.symbol})"] = c.start or zero
    for f in sorted.fixed:
        found.setdefault(f"start({f.symbol})", f.start)
    for symbol, start in sorted.guesses:
        found.setdefault(f"start({symbol})", start)
    for step in sorted.levels[-1].steps if sorted.levels else ():
        for tear in step.tears:
            found.setdefault(f"start({tear})", zero)
    for d in (*sorted.dae.discretes, *sorted.dae.inputs):
        found[f"start({d.name})"] = d.start or zero
    for c in sorted.candidates:
        if c.nominal is not None:
            found[f"nominal({c.symbol})"] = c.nominal
    return [(table.symbol(name), aliases(e)) for name, e in found.items()]
