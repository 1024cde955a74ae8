"""Discrete equations in order of evaluation.

In:   Dae        its discrete equations, of Boolean, Integer and discrete Real unknowns
Out:  Assignment for each, after those that it needs

Example: b = a and u;  a = x > 1    ->    a := x > 1;  b := a and u

pre(x) is known at an event, so it makes no order. Variables that when-clauses set are
known, too: no equation gives them a value, but for the algorithm that sets them itself.

What ticks with a clock is given by an equation with this clock, of any form, and keeps its value
between ticks: with `t` for the tick, `0 = y + x` at it is `y := if t then -x else pre(y)`.
Variables of one clock that need each other are solved together (`together`).

Promises:  a loop over discrete variables, an equation that cannot be solved for a
           discrete variable, or two equations for one, are errors that name them.
"""

from __future__ import annotations

from collections.abc import Collection

from planarc.core.blocks import sort_blocks
from planarc.core.diagnostic import Diagnostic, PlanarcError, Related
from planarc.core.prose import ticked
from planarc.ir.dae import Dae, Equation, Kind, set_by_whens
from planarc.ir.expr import Expr, Exprs, Substitution, symbols, text
from planarc.ir.sorted import Assignment
from planarc.structure.linear import Contents, coefficients, solve_affine
from planarc.structure.matching import match_equations
from planarc.structure.signs import Signs
from planarc.structure.together import solve_together


def sort_discrete(
    dae: Dae, rewrite: Substitution, signs: Signs, first: int
) -> tuple[Assignment, ...]:
    """The discrete equations in their order. `first` is the number of the first discrete equation
    among all equations."""
    table, equations = dae.table, dae.discrete_equations
    names = {v.name: i for i, v in enumerate(dae.discretes)}
    contents = Contents(names.__contains__)
    sides = [(rewrite(e.left), rewrite(e.right)) for e in equations]
    clocked = frozenset(name for c in dae.clocks for name in c.variables)
    held = {table.symbol(name) for name in set_by_whens(dae.whens) | clocked}
    reals = {table.symbol(v.name) for v in dae.discretes if v.kind is Kind.REAL}
    beside = [{table.symbol(n) for n in names if n not in c.variables} for c in dae.clocks]
    solved = [
        _solutions(table, contents, signs, left, right, () if e.assigned else held)
        if e.clock is None
        else _at_ticks(dae, contents, signs, e, (left, right), beside[e.clock], reals)
        for e, (left, right) in zip(equations, sides, strict=True)
    ]
    rows = [[names[s.name] for s in options] for options in solved]
    matching = match_equations(rows, len(names))
    if matching.exposed:
        raise PlanarcError([_unsolvable(dae, equations[e], solved[e]) for e in matching.exposed])
    targets = [table.symbol(dae.discretes[v].name) for v in matching.variable]
    values = [solved[e][target] for e, target in enumerate(targets)]
    needs = [
        [e for s in contents.ordered(value) if (e := matching.equation[names[s.name]]) >= 0]
        for value in values
    ]
    steps = []
    for block in sort_blocks(needs):
        if len(block) > 1 or block[0] in needs[block[0]]:
            unknowns = [targets[e] for e in block]
            together = None
            if len({equations[e].clock for e in block} - {None}) == 1:
                ours = [sides[e] for e in block]
                together = solve_together(table, contents, signs, ours, unknowns, reals)
            if together is None:
                raise PlanarcError(_loop(dae, block, [u.name for u in unknowns]))
            for e in block:
                values[e] = _kept_between(dae, equations[e], targets[e], together[targets[e]])
        steps += [Assignment(targets[e], values[e], first + e) for e in block]
    return tuple(steps)


def _at_ticks(
    dae: Dae,
    contents: Contents,
    signs: Signs,
    equation: Equation,
    sides: tuple[Expr, Expr],
    held: Collection[Expr],
    reals: Collection[Expr],
) -> dict[Expr, Expr]:
    """The variables that an equation with a clock can give: any number in it. The value of one
    that is to be solved for holds the variable itself."""
    table = dae.table
    options = _solutions(table, contents, signs, *sides, held)
    if equation.integrates or equation.assigned:
        options = {s: value for s, value in options.items() if s is sides[0]}
    else:
        residual = table.sub(*sides)
        open_ = (s for s in contents.ordered(residual) if s in reals and s not in held)
        options |= {s: table.add(s, residual) for s in open_ if s not in options}
    return {s: _kept_between(dae, equation, s, value) for s, value in options.items()}


def _kept_between(dae: Dae, equation: Equation, target: Expr, value: Expr) -> Expr:
    """What an equation gives a variable at the ticks of its clock; between them it is kept."""
    assert equation.clock is not None
    t = dae.table
    return t.if_(t.symbol(dae.clocks[equation.clock].tick), value, t.pre(target.name))


def _solutions(
    table: Exprs,
    contents: Contents,
    signs: Signs,
    left: Expr,
    right: Expr,
    held: Collection[Expr],
) -> dict[Expr, Expr]:
    """The variables that an equation can give, with the values; left = right comes first."""
    options = {}
    for a, b in ((left, right), (right, left)):
        if a.is_symbol and contents(a) and a not in contents(b) and a not in held:
            options[a] = b
    if options:
        return options
    residual = table.sub(left, right)
    for symbol, factor in sorted(coefficients(table, contents, residual).items()):
        if factor is not None and symbol not in held and signs.never_zero(factor):
            options[symbol] = solve_affine(table, contents, left, right, symbol, factor)
    return options


def _unsolvable(dae: Dae, equation: Equation, options: dict[Expr, Expr]) -> Diagnostic:
    held = set_by_whens(dae.whens)
    ours = [e.name for e in symbols(equation.left, equation.right) if e.name in held]
    related: tuple[Related, ...] = ()
    if equation.integrates:
        return _given_besides(equation)
    if ours and not options:
        clause = next(w for w in dae.whens if ours[0] in set_by_whens((w,)))
        said = f"is one too many: a when-clause sets `{ours[0]}`"
        hint = "remove the equation, or the assignment in the when-clause"
        related = (Related("this when-clause", clause.span),)
    elif options:
        said = f"is one too many: others set {ticked(text(s) for s in options)}"
        hint = "remove one of these equations"
    else:
        said = "has no variable to be solved for"
        hint = "write it as `variable = expression`, once for each discrete variable"
        again = equation.left
        if again.is_symbol and again in symbols(equation.right):
            hint = f"write it in a `when`, with `pre({again.name})` for the value before"
            if equation.clock is not None:
                hint = f"write `previous({again.name})` for the value at the tick before"
    message = f"the discrete equation {equation.shown} {said}"
    code = "S314" if ours or options else "S310"
    return Diagnostic(code, message, equation.span, hint=hint, related=related)


def _given_besides(equation: Equation) -> Diagnostic:
    name = equation.left.name
    message = f"`{name}` is integrated from tick to tick, and given besides"
    hint = "planarc differentiates no equation from tick to tick: where its derivative is meant, "
    hint += f"write `({name} - previous({name}))/interval()`"
    return Diagnostic("S314", message, equation.span, hint=hint)


def _loop(dae: Dae, block: list[int], names: list[str]) -> Diagnostic:
    first, *others = (dae.discrete_equations[e] for e in block)
    return Diagnostic(
        "S311",
        f"discrete variables depend on each other at one instant: {ticked(names)}",
        first.span,
        hint=f"break the loop with `{'pre' if first.clock is None else 'previous'}(...)`",
        related=tuple(Related("and in this equation", e.span) for e in others),
    )
