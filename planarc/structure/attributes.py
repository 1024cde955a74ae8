"""The attributes of each symbol that remains: start, fixed, StateSelect, name.

In:   Dae, Elimination
Out:  one `Attributes` for each kept symbol that some variable of the model stands for

An alias set may have said several things. The highest StateSelect wins. Of the start
values a fixed one wins, then a written one, then that of higher StateSelect, then the
first; it carries the sign of its variable. `v = der(x)` makes the start of `v` that
of the symbol der(x), and `v` the name that the user knows it by.

Promises:  two `fixed` values that disagree, in an alias set or with a constant, are
           an error that names both lines.
"""

from __future__ import annotations

from collections.abc import Iterable

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, HeldAgainst, PlanarcError, Related
from planarc.core.source import Span
from planarc.ir.dae import Dae, Variable
from planarc.ir.expr import Expr, Exprs, brief, symbol_text
from planarc.ir.flat import StateSelect
from planarc.structure.alias import Elimination
from planarc.structure.numbers import ParameterNumbers
from planarc.structure.places import owner_span


class Attributes(Data):
    display: str
    select: StateSelect
    start: Expr | None
    start_written: bool
    fixed: bool
    nominal: Expr | None
    span: Span
    holder: str = ""  # the variable whose start it is, where that is not the one displayed
    at_start: bool = False  # a parameter that the start finds


class _Member(Data):
    variable: Variable
    sign: int
    place: int  # in the order of declaration

    def start(self, table: Exprs) -> Expr | None:
        if self.variable.start is None or self.sign > 0:
            return self.variable.start
        return table.neg(self.variable.start)


def merge_attributes(
    dae: Dae, elimination: Elimination, numbers: ParameterNumbers
) -> dict[Expr, Attributes]:
    table = dae.table
    targets = {a.name: (a.target, a.sign) for a in elimination.aliases}
    kept = set(elimination.kept)
    sets: dict[Expr, list[_Member]] = {}
    wrong: list[Diagnostic] = []
    for place, variable in enumerate(dae.variables):
        target, sign = targets.get(variable.name, (table.symbol(variable.name), 1))
        if target.is_symbol and target.name in kept:
            sets.setdefault(target, []).append(_Member(variable, sign, place))
        elif variable.fixed:
            wrong.extend(_check_constant(dae, variable, target, sign, numbers))
    merged = {}
    for symbol, members in sets.items():
        wrong.extend(_check_fixed(dae, members, numbers))
        merged[symbol] = _merge(symbol, members, table)
    if wrong:
        raise PlanarcError(wrong)
    return merged


def hold_states(
    dae: Dae, attributes: dict[Expr, Attributes], symbols: Iterable[Expr]
) -> dict[Expr, Attributes]:
    """The attributes, with StateSelect.always for `symbols`."""
    held = dict(attributes)
    for symbol in symbols:
        known = held.get(symbol) or plain_attributes(dae, symbol)
        held[symbol] = replace(known, select=StateSelect.ALWAYS)
    return held


def plain_attributes(dae: Dae, symbol: Expr) -> Attributes:
    """The attributes of a symbol that no variable of the model stands for."""
    span = next(v.span for v in dae.variables if v.name == symbol.name)
    shown = symbol_text(symbol.name, symbol.order)
    return Attributes(shown, StateSelect.DEFAULT, None, False, False, None, span)


def _merge(symbol: Expr, members: list[_Member], table: Exprs) -> Attributes:
    if len(members) == 1 and members[0].sign > 0:
        v = members[0].variable
        return Attributes(
            display=v.name,
            select=v.state_select,
            start=v.start,
            start_written=v.start_written,
            fixed=v.fixed,
            nominal=v.nominal,
            span=v.span,
            at_start=v.at_start,
        )
    by_start = sorted(
        members,
        key=lambda m: (
            not m.variable.fixed or _is_default(m.variable),
            not m.variable.start_written,
            not m.variable.fixed,
            m.variable.start is None,
            -m.variable.state_select,
            m.place,
        ),
    )
    by_name = sorted(
        (m for m in members if m.sign > 0),
        key=lambda m: (
            m.variable.name != symbol.name,
            -m.variable.state_select,
            m.variable.protected,
            m.place,
        ),
    )
    first = by_start[0].variable
    nominals = (m.variable.nominal for m in (*by_name, *members))
    shown = by_name[0].variable if by_name else None
    display = shown.name if shown else symbol_text(symbol.name, symbol.order)
    held = by_start[0].sign > 0 and (first.fixed or first.start_written)
    fixed = any(m.variable.fixed for m in members)
    return Attributes(
        display=display,
        select=max(m.variable.state_select for m in members),
        start=by_start[0].start(table),
        start_written=first.start_written,
        fixed=fixed,
        nominal=next((n for n in nominals if n is not None), None),
        span=first.span if first.fixed or first.start_written else (shown or first).span,
        holder=first.name if held and first.name != display else "",
        at_start=any(m.variable.at_start for m in members),
    )


def _is_default(variable: Variable) -> bool:
    """Whether a library holds a variable by itself, as `ConstantSpeed` its angle at 0: there may be
    another start that somebody wrote, at which it is held then."""
    return variable.fixed and not variable.fixed_written and not variable.start_written


def _check_fixed(
    dae: Dae, members: list[_Member], numbers: ParameterNumbers
) -> Iterable[Diagnostic]:
    table = dae.table
    fixed = [m for m in members if m.variable.fixed]
    fixed = [m for m in fixed if not _is_default(m.variable)] or fixed
    for other in fixed[1:]:
        first = fixed[0]
        a, b = first.start(table) or table.zero, other.start(table) or table.zero
        if numbers.differ(a, b):
            one, two, wanted = first.variable, other.variable, b if first.sign > 0 else table.neg(b)
            if one.start_written and not two.start_written:  # who wrote a start finds it told there
                one, two, wanted = two, one, a if other.sign > 0 else table.neg(a)
            hint = "remove `fixed=true` from one of them"
            if two.start_written > one.start_written:
                part, _, name = one.name.rpartition(".")
                hint = f"write `{part}({name}(start={brief(wanted)}))`, "
                hint += f"or remove `fixed=true` from `{two.name}`"
            sign = "-" if first.sign != other.sign else ""
            place = Related(f"`{one.name}` is held here", owner_span(dae, one.name))
            yield Diagnostic(
                "S304",
                f"`{one.name}` and `{two.name}` are held at starts that "
                f"disagree: `{one.name} = {sign}{two.name}`, but {_held(one)} and {_held(two)}",
                owner_span(dae, two.name),
                hint=hint,
                related=(place,),
            )


def _check_constant(
    dae: Dae, variable: Variable, target: Expr, sign: int, numbers: ParameterNumbers
) -> Iterable[Diagnostic]:
    start = variable.start or dae.table.zero
    value = target if sign > 0 else dae.table.neg(target)
    if numbers.differ(start, value):
        yield HeldAgainst(
            "S305",
            f"`{variable.name}` is held at {_held(variable)}, but the equations make it "
            f"{brief(value)}",
            owner_span(dae, variable.name),
            hint="remove `fixed=true`, or give it the value that the equations say",
        )


def _held(variable: Variable) -> str:
    return f"start = {brief(variable.start)}" if variable.start is not None else "start = 0"
