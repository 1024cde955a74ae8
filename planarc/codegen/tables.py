"""The tables of a program: what a slot means to a user and to the solver.

In:   SortedDae and the sections written from it
Out:  the columns of the result, their limits, parameters, candidates, discrete values, relations

Result columns: all variables in the order of their declaration, then derivatives of
candidates, discrete variables but texts, inputs, parameters and constants.
"""

from __future__ import annotations

from planarc.codegen.sections import Sections
from planarc.core.diagnostic import PlanarcError
from planarc.core.source import Span
from planarc.core.unit import rate_text
from planarc.evaluate.value import evaluate
from planarc.ir.actions import rewrite_action
from planarc.ir.calculus import partial
from planarc.ir.dae import SHARING, Action, Kind, Parameter, Variable, set_by_whens
from planarc.ir.expr import Expr, Exprs, Op, postorder, symbol_text, symbols
from planarc.ir.program import (
    CandidateSlot,
    Column,
    DelayCode,
    DiscreteSlot,
    Enumeration,
    FixedSlot,
    Limits,
    ParameterSlot,
    RelationSlot,
    WhenCode,
    limit,
)
from planarc.ir.sorted import Candidate, SortedDae

#: Functions that turn back again and again where their argument goes on.
WAVES = ("sin", "cos", "tan")


class Tables:
    def __init__(self, sorted: SortedDae, sections: Sections) -> None:
        self._sorted = sorted
        self._dae = sorted.dae
        self._sections = sections
        self._layout = sections.layout
        self._units = {v.name: v.unit for v in sorted.dae.variables}

    # Columns

    def columns(self) -> tuple[Column, ...]:
        found: dict[str, Column] = {}
        for v in self._dae.variables:
            if not v.name.startswith(SHARING):
                found[v.name] = self._column(v, *self._home(v.name))
        for c in self._sorted.candidates:
            for column in self._derivative_columns(c):
                found.setdefault(column.name, column)
        for d in (*self._dae.discretes, *self._dae.inputs):
            if d.kind is not Kind.STRING:
                found[d.name] = self._column(d, self._layout[d.name], 1)
        for p in self._dae.parameters:
            if p.name != SHARING:
                found[p.name] = self._column(p, self._layout[p.name], 1)
        return tuple(found.values())

    def limits(self) -> tuple[Limits, ...]:
        known, dae = self._sections.aliases, self._dae
        return tuple(
            Limits(v.name, *(None if e is None else known(e) for e in told))
            for v in (*dae.variables, *dae.discretes, *dae.inputs)
            if any(told := (v.minimum, v.maximum, v.nominal))
        )

    def enumerations(self) -> tuple[Enumeration, ...]:
        found: dict[tuple[str, tuple[str, ...]], list[str]] = {}
        declared: tuple[Variable | Parameter, ...] = (*self._dae.discretes, *self._dae.parameters)
        for v in declared:
            if v.kind is Kind.ENUMERATION:
                found.setdefault((v.type_name, v.literals), []).append(v.name)
        return tuple(Enumeration(*type_, tuple(names)) for type_, names in found.items())

    def _home(self, name: str) -> tuple[int, int]:
        """Slot and sign of a variable."""
        e = self._sections.homes.get(name)
        if e is None:
            return self._layout[name], 1
        return (self._layout[e.args[0]], -1) if e.op is Op.NEG else (self._layout[e], 1)

    def _column(self, v: Variable | Parameter, slot: int, sign: int) -> Column:
        return Column(
            name=v.name,
            slot=slot,
            sign=sign,
            kind=v.kind,
            unit=v.unit,
            description=v.description,
            constant=slot in self._sections.constant_slots,
            protected=v.protected,
            display_unit=v.display_unit,
        )

    def _derivative_columns(self, c: Candidate) -> list[Column]:
        slot = self._layout[self._dae.table.der(c.symbol)]
        names = dict.fromkeys((f"der({c.display})", f"der({c.symbol})"))
        unit = rate_text(self._unit(c.display))
        return [Column(name, slot, 1, Kind.REAL, unit) for name in names]

    def _unit(self, shown: str) -> str:
        """The unit of a variable, or of a derivative `der(x)`."""
        inner = shown.removeprefix("der(")
        if inner != shown:
            return rate_text(self._unit(inner.removesuffix(")")))
        return self._units.get(shown, "")

    # Values that are set or held

    def parameters(self) -> tuple[ParameterSlot, ...]:
        return tuple(
            ParameterSlot(
                name=p.name,
                slot=self._layout[p.name],
                kind=p.kind,
                settable=p.settable,
                structural=p.structural,
                unit=p.unit,
                description=p.description,
                default=float(evaluate(p.value, _no_leaf)) if p.settable else None,
                literals=p.literals,
                minimum=limit(p.minimum),
                maximum=limit(p.maximum),
                final=p.final,
                span=p.span,
            )
            for p in self._dae.parameters
        )

    def candidates(self) -> tuple[CandidateSlot, ...]:
        below = ((i, b) for i, b in enumerate(self._sections.blocks) if b.height)
        blocks = {tear: i for i, block in below for tear in block.tears}
        return tuple(self._candidate(c, blocks[c.symbol]) for c in self._sorted.candidates)

    def _candidate(self, c: Candidate, block: int) -> CandidateSlot:
        layout = self._layout
        return CandidateSlot(
            name=symbol_text(c.symbol.name, c.symbol.order),
            display=c.display,
            slot=layout[c.symbol],
            derivative=layout[self._dae.table.der(c.symbol)],
            start=layout[f"start({c.symbol})"],
            start_written=c.start_written,
            fixed=c.fixed,
            select=c.select,
            nominal=layout[f"nominal({c.symbol})"] if c.nominal is not None else None,
            block=block,
            span=c.span,
            holder=c.holder,
            at_start=c.at_start,
        )

    def fixed(self) -> tuple[FixedSlot, ...]:
        found = []
        for f in self._sorted.fixed:
            told = (f.span, f.fixed, f.written, f.select, f.height, f.holder)
            slot = self._layout[f.symbol]
            found.append(FixedSlot(f.display, slot, self._start(f.symbol), *told))
        return tuple(found)

    def guesses(self) -> tuple[tuple[int, int], ...]:
        top = (block for block in self._sections.blocks if not block.height)
        tears = dict.fromkeys(tear for block in top for tear in block.tears)
        return tuple((self._layout[tear], self._start(tear)) for tear in tears)

    def _start(self, symbol: Expr) -> int:
        return self._layout[f"start({symbol})"]

    # Events

    def discretes(self) -> tuple[DiscreteSlot, ...]:
        at, dae = self._layout, self._dae
        sides = (e for q in dae.discrete_equations for e in (q.left, q.right))
        known = set_by_whens(dae.whens) | {e.name for e in sides if e.is_symbol}
        return tuple(
            DiscreteSlot(
                d.name,
                d.kind,
                at[d.name],
                at[f"pre({d.name})"],
                at[f"start({d.name})"],
                d.span if d.causality == "input" and d.name not in known else None,
            )
            for d in dae.discretes
        )

    def relations(self) -> tuple[RelationSlot, ...]:
        found = []
        for i, (r, zero) in enumerate(zip(self._dae.relations, self._sections.zeros, strict=True)):
            told = (r.strict, r.time_only, r.text, r.span, r.component)
            waves = not r.time_only and self._waves(r.zero)
            found.append(RelationSlot(self._layout[f"event[{i}]"], zero, *told, waves=waves))
        return tuple(found)

    def _waves(self, zero: Expr) -> bool:
        """Whether a formula swings with what changes between events."""
        swings = [e for e in postorder((zero,)) if e.op is Op.CALL and e.data in WAVES]
        if not swings:
            return False
        known = {p.name for p in self._dae.parameters} | {v.name for v in self._dae.discretes}
        return any(s.name not in known for s in symbols(*swings))

    def turning(self) -> tuple[tuple[int, Expr], ...]:
        """Where there are relations, the slots of what sines are asked of, with factors of
        parameters: `sin(k*x)` turns k times as far as x moves."""
        dae = self._dae
        if all(r.time_only for r in dae.relations):
            return ()
        known = {p.name for p in dae.parameters}
        slots, constant = self._layout.slots, self._sections.constant_slots
        found: dict[tuple[int, Expr], None] = {}
        for e in list(dae.table.all):
            if e.op is not Op.CALL or e.data not in WAVES:
                continue
            for symbol in symbols(e):
                slot = slots.get(repr(symbol))
                if slot is None or slot in constant or symbol.name in known:
                    continue
                factor = _slope(dae.table, e.args[0], symbol)
                plain = all(s.name in known for s in symbols(factor))
                found[slot, self._sections.aliases(factor) if plain else dae.table.one] = None
        return tuple(sorted(found, key=lambda pair: (pair[0], pair[1].id)))

    def samplers(self) -> tuple[tuple[int, Expr, Expr, Span], ...]:
        aliases = self._sections.aliases
        return tuple(
            (self._layout[f"$sample[{i}]"], aliases(s.start), aliases(s.interval), s.span)
            for i, s in enumerate(self._dae.samplers)
        )

    def delays(self) -> tuple[DelayCode, ...]:
        found, dae = [], self._dae
        if not dae.delays:
            return ()
        from planarc.codegen.held import Held

        parameters = {p.name for p in dae.parameters}
        held = Held(self._sorted)
        for d in dae.delays:
            slot, sign = self._home(d.signal)
            varies = d.interval.is_symbol and d.interval.name not in parameters
            interval = self._home(d.interval.name)[0] if varies else None
            home = self._sections.homes.get(d.signal)
            stays = d.signal in held.names if home is None else held(home)
            told = (d.interval, interval, d.maximum, stays)
            found.append(DelayCode(slot, sign, *told, d.text, d.span))
        return tuple(found)

    def whens(self) -> tuple[WhenCode, ...]:
        at, aliases = self._layout, self._sections.aliases

        def branch(name: str, actions: tuple[Action, ...]) -> tuple[int, int, tuple[Action, ...]]:
            rewritten = tuple(rewrite_action(a, self._dae.table, aliases) for a in actions)
            return at[name], at[f"pre({name})"], rewritten

        return tuple(
            WhenCode(tuple(branch(*b) for b in when.branches), when.span)
            for when in self._dae.whens
        )


def _slope(table: Exprs, e: Expr, symbol: Expr) -> Expr:
    """How fast an expression changes with a symbol; 1 where nothing tells."""
    if e is symbol:
        return table.one
    try:
        return partial(table, symbol)(e)
    except PlanarcError:
        return table.one


def _no_leaf(e: Expr) -> float:
    raise AssertionError(f"a settable parameter depends on `{e}`")
