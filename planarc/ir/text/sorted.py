"""Prints a SortedDae: what `planarc equations` shows.

First the counts and the states, then the levels from the positions up: assignments in
order, blocks with what they guess (tears), what follows inside, and what must vanish
(residuals), each with the source line that it came from.
"""

from __future__ import annotations

from collections.abc import Iterator

from planarc.core.prose import counted
from planarc.core.source import NOWHERE, Span
from planarc.ir.expr import symbol_text, text
from planarc.ir.flat import StateSelect
from planarc.ir.sorted import Alias, Assignment, Block, Level, Residual, SortedDae


def sorted_text(model: SortedDae, *, aliases: bool = False) -> str:
    """The model as text. `aliases`: list every eliminated variable too."""
    lines = [*_head(model), *_candidates(model)]
    for level in model.levels:
        lines += ["", *_level(model, level)]
    lines += _start(model)
    if model.discrete:
        lines += ["", "discrete"]
        lines += [_assignment(model, a, "  ") for a in model.discrete]
    if aliases:
        lines += ["", "aliases"]
        for a in model.aliases:
            lines.append(f"  {a.name} = {'-' if a.sign < 0 else ''}{text(a.target)}")
    return "\n".join(lines) + "\n"


def _head(model: SortedDae) -> Iterator[str]:
    constant = sum(not _is_variable(model, a) for a in model.aliases)
    derived = sum(e.derived_from is not None for e in model.equations)
    yield f"model {model.dae.name}"
    yield (
        f"  {model.equations_before} equations, {model.equations_after} after the elimination of "
        f"{counted(len(model.aliases), 'variable')} "
        f"({counted(len(model.aliases) - constant, 'alias')}, {counted(constant, 'constant')})"
    )
    yield f"  {derived} derivatives of equations added to lower the index"
    candidates = counted(len(model.candidates), "candidate")
    yield f"  {counted(model.state_count, 'state')} of {candidates}"


def _candidates(model: SortedDae) -> Iterator[str]:
    if model.candidates:
        yield ""
        yield "candidates for states"
    for c in model.candidates:
        symbol = symbol_text(*c.symbol.data)
        shown = c.display if c.display == symbol else f"{c.display} = {symbol}"
        notes = [] if c.select is StateSelect.DEFAULT else [c.select.name.lower()]
        if c.start is not None:
            notes.append(f"start {text(c.start)}")
        if c.fixed:
            notes.append("fixed")
        yield noted(f"  {shown}" + (f"  ({', '.join(notes)})" if notes else ""), c.span)


def _level(model: SortedDae, level: Level) -> Iterator[str]:
    yield "top level" if not level.height else f"level {level.height} below the top"
    for step in level.steps:
        if isinstance(step, Assignment):
            yield _assignment(model, step, "  ")
        else:
            yield from _block(model, step, level.height)


def _block(model: SortedDae, block: Block, height: int) -> Iterator[str]:
    tears = ", ".join(symbol_text(*t.data) for t in block.tears)
    if not block.residuals:
        yield f"  state {tears}" if len(block.tears) == 1 else f"  states {tears}"
        return
    kind = "linear" if block.linear else "nonlinear"
    states = f", {counted(block.free, 'state')} among them" if height else ""
    size = f"{counted(len(block.residuals), 'residual')}{states}"
    yield f"  {kind} block, tears {tears} ({size})"
    for a in block.inner:
        yield _assignment(model, a, "    ")
    for r in block.residuals:
        yield _residual(model, r, "    ")


def _assignment(model: SortedDae, a: Assignment, indent: str) -> str:
    line = f"{indent}{symbol_text(*a.target.data)} := {text(a.value)}"
    return noted(line, model.equations[a.equation].span)


def _residual(model: SortedDae, r: Residual, indent: str) -> str:
    return noted(f"{indent}0 = {text(r.value)}", model.equations[r.equation].span)


def _start(model: SortedDae) -> list[str]:
    lines = []
    for f in model.fixed:
        if not f.fixed:
            continue
        symbol = symbol_text(*f.symbol.data)
        shown = f.display if f.display == symbol else f"{f.display} = {symbol}"
        lines.append(noted(f"  {shown} = {text(f.start)}", f.span))
    lines += [_residual(model, r, "  ") for r in model.initial_residuals]
    return ["", "at the start", *lines] if lines else []


def _is_variable(model: SortedDae, alias: Alias) -> bool:
    parameters = {p.name for p in model.dae.parameters}
    return alias.target.is_symbol and alias.target.name not in parameters


def noted(line: str, span: Span) -> str:
    """A line with the place it came from, `model.pmo:12`, where a file holds it."""
    if span is NOWHERE or span.source.name == NOWHERE.source.name:
        return line
    return f"{line}  // {span.source.name.rsplit('/', 1)[-1]}:{span.line}"
