"""Checks a program against what `ir.program` promises.

Every statement reads only what the same list set before, or what a slot holds; every
slot of the tables lies in the workspace; every block is solved at one place; blocks
below the top hold candidates, and as many unknowns as residuals otherwise. A
complaint is a bug in `codegen`, not a fault of the user's model.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from planarc.ir.expr import Expr, Op, postorder, text
from planarc.ir.program import BlockCode, Let, Program, Solve, Statement


class BrokenProgramError(AssertionError):
    """The program does not keep its promises."""


def check(program: Program) -> None:
    """Raise `BrokenProgramError` with the first complaint."""
    for complaint in _complaints(program):
        raise BrokenProgramError(complaint)


def _complaints(program: Program) -> Iterator[str]:
    yield from _slots(program)
    yield from _blocks(program)
    levels = [s for statements in program.levels for s in statements]
    yield from _list(program, "parameters", program.parameters, ())
    yield from _list(program, "levels", levels, ())
    yield from _list(program, "rest", program.rest, ())
    yield from _list(program, "initial", program.initial, program.initial_residuals)
    yield from _list(program, "roots", program.roots, [r.zero for r in program.relations])
    yield from _list(program, "discrete", program.discrete, ())


def _slots(program: Program) -> Iterator[str]:
    if sorted(program.slots.values()) != list(range(program.size)):
        yield "the slots are not the numbers below the size of the workspace"
    named = [(c.name, c.slot) for c in program.columns]
    named += [(p.name, p.slot) for p in program.parameter_slots]
    for c in program.candidates:
        named += [(c.name, s) for s in (c.slot, c.derivative, c.start, c.nominal or 0)]
    for name, slot in named:
        if not 0 <= slot < program.size:
            yield f"`{name}` lies at {slot}, outside the workspace"
    starts = [c.start for c in program.candidates]
    if len(set(starts)) != len(starts):
        yield "two candidates share the slot of their start values"


def _blocks(program: Program) -> Iterator[str]:
    lists = (*program.levels, program.rest)
    solved = [s.block for statements in lists for s in statements if isinstance(s, Solve)]
    if sorted(solved) != list(range(len(program.blocks))):
        yield "a block is solved twice or never"
    names = [c.name for c in program.candidates]
    for i, b in enumerate(program.blocks):
        tears = [text(tear) for tear in b.tears]
        if b.height and names[b.first : b.first + len(tears)] != tears:
            yield f"the tears of block {i} are not its candidates"
        if b.free < 0 or (not b.height and b.free):
            yield f"block {i} has {len(b.tears)} tears and {len(b.residuals)} residuals"
        if len(b.equations) != len(b.residuals):
            yield f"block {i} does not know the equations of its residuals"


def _list(
    program: Program, name: str, statements: Iterable[Statement], results: Iterable[Expr]
) -> Iterator[str]:
    known: set[Expr] = set()
    for s in statements:
        if isinstance(s, Let):
            yield from _let(program, name, s, known)
        else:
            yield from _block(program, f"{name}, block {s.block}", s, known)
    for e in results:
        yield from _unknown(program, name, e, known)


def _block(program: Program, name: str, s: Solve, known: set[Expr]) -> Iterator[str]:
    code = program.blocks[s.block]
    inside = set(known)
    if code.direct is not None:
        for e in code.direct.values:
            yield from _unknown(program, name, e, set())  # in slots, and nowhere else
    elif code.linear:  # residuals at zero and matrix are known before
        yield from _matrix(program, name, code, inside)
    known.update(code.tears)
    for let in code.body[: code.inner]:
        yield from _let(program, name, let, known)
    inside |= known
    for let in (*code.body[code.inner :], *code.jacobian_body):
        yield from _let(program, name, let, inside)
    if code.direct is not None or not code.linear:
        yield from _matrix(program, name, code, inside)


def _matrix(program: Program, name: str, code: BlockCode, inside: set[Expr]) -> Iterator[str]:
    entries = [value for _, _, value in code.jacobian]
    if code.tangent is not None:
        inside.update(code.tangent.seeds)
        for let in code.tangent.body:
            yield from _let(program, name, let, inside)
        entries += code.tangent.entries
    for e in (*code.residuals, *entries):
        yield from _unknown(program, name, e, inside)


def _let(program: Program, name: str, let: Let, known: set[Expr]) -> Iterator[str]:
    yield from _unknown(program, name, let.value, known)
    if let.target in known:
        yield f"{name}: `{let.target}` is set twice"
    known.add(let.target)


def _unknown(program: Program, name: str, value: Expr, known: set[Expr]) -> Iterator[str]:
    for e in postorder((value,)):
        stored = e.op in (Op.SYMBOL, Op.PRE, Op.EVENT)
        if stored and e not in known and text(e) not in program.slots:
            yield f"{name}: `{e}` is read before it is set, and has no slot"
