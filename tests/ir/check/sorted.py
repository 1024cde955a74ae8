"""Checks what a SortedDae promises. A broken promise is a bug of `structure`.

every variable is an alias or computed, once, up to its highest order
nothing is used before it is known
a level below the top has at least as many tears as residuals, the top as many
the candidates are the tears below the top, and the derivative of each is known
expressions hold kept symbols only
"""

from __future__ import annotations

from collections.abc import Iterator

from planarc.ir.expr import Expr, symbol_text, symbols, text
from planarc.ir.sorted import Assignment, Block, SortedDae, computed


class BrokenPromise(AssertionError):
    """The sorted model is inconsistent."""


def check_sorted(model: SortedDae) -> None:
    """Raise BrokenPromise with all that is wrong."""
    wrong = [*_check_order(model), *_check_candidates(model), *_check_aliases(model)]
    if wrong:
        raise BrokenPromise("\n".join(wrong))


def _check_order(model: SortedDae) -> Iterator[str]:
    dae = model.dae
    always = {p.name for p in dae.parameters} | {v.name for v in (*dae.discretes, *dae.inputs)}
    known: set[Expr] = set()

    def unknown(e: Expr) -> list[str]:
        return [
            symbol_text(*s.data)
            for s in symbols(e)
            if s not in known and symbol_text(s.name, s.order) not in always and s.name[0] != "$"
        ]

    def define(symbol: Expr) -> Iterator[str]:
        if symbol in known:
            yield f"{text(symbol)} is computed twice"
        known.add(symbol)

    def assign(a: Assignment) -> Iterator[str]:
        if missing := unknown(a.value):
            yield f"{text(a.target)} needs {missing}, not known yet"
        yield from define(a.target)

    for level in model.levels:
        for step in level.steps:
            if isinstance(step, Block):
                yield from _check_size(step, level.height)
            for tear in step.tears:
                yield from define(tear)
            for a in step.inner:
                yield from assign(a)
            for r in step.residuals:
                if missing := unknown(r.value):
                    yield f"residual {text(r.value)} needs {missing}, not known yet"
    for alias in model.aliases:
        if missing := unknown(alias.target):
            yield f"alias {alias.name} is {text(alias.target)}, never computed: {missing}"
    aliases = {a.name for a in model.aliases}
    for v in dae.variables:
        if v.name not in aliases and dae.table.symbol(v.name) not in known:
            yield f"variable {v.name} is neither an alias nor computed"


def _check_size(block: Block, height: int) -> Iterator[str]:
    names = [text(t) for t in block.tears]
    if block.free < 0 or (not height and block.free):
        yield f"block {names} at height {height} has {len(block.residuals)} residuals"
    if not block.residuals and len(block.tears) != 1:
        yield f"block {names} has no residual and not one tear"


def _check_candidates(model: SortedDae) -> Iterator[str]:
    below = (level for level in model.levels if level.height)
    tears = [tear for level in below for step in level.steps for tear in step.tears]
    if tears != [c.symbol for c in model.candidates]:
        yield "the candidates are not the tears below the top"
    known = {t for level in model.levels for step in level.steps for t in computed(step)}
    for tear in tears:
        if model.dae.table.der(tear) not in known:
            yield f"the derivative of the candidate {text(tear)} is not known"


def _check_aliases(model: SortedDae) -> Iterator[str]:
    names = {a.name for a in model.aliases}
    for a in model.aliases:
        if abs(a.sign) != 1:
            yield f"alias {a.name} has the sign {a.sign}"
        for s in symbols(a.target):
            if s.name in names:
                yield f"alias {a.name} is {text(a.target)}, an alias again"
