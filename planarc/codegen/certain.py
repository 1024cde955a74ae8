"""What is evaluated whatever the conditions say, and what only where a condition asks for it.

A root of a negative number is a mistake of the model in the first case and none in the second.

    y = if x > 0 then sqrt(x) else 0      x > 0 always, sqrt(x) not
    b = x > 0 and sqrt(x) > 1             the relation x > 0 is certain, the other is not
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from msgspec.structs import replace

from planarc.ir.expr import Expr, Op, text
from planarc.ir.program import BlockCode, Let, Program, Statement


def mark_certain(program: Program) -> Program:
    """The program, with what its relations say of themselves."""
    if not program.relations:
        return program
    always: set[Expr] = set()
    known = -1
    events = {program.table.event(i): i for i in range(len(program.relations))}
    while len(certain := {i for e, i in events.items() if e in always}) > known:
        known = len(certain)
        always = evaluated_always(_marked(program, certain))
    return _marked(program, certain)


def _marked(program: Program, certain: set[int]) -> Program:
    relations = enumerate(program.relations)
    return replace(program, relations=tuple(replace(r, certain=i in certain) for i, r in relations))


def evaluated_always(program: Program) -> set[Expr]:
    """The nodes that are used outside the branches of every condition of a program."""
    lists = (program.parameters, *program.levels, program.rest, program.initial)
    lets = [let for s in (*lists, program.roots, program.discrete) for let in all_lets(program, s)]
    wanted = [*program.initial_residuals, *(r.zero for r in program.relations if r.certain)]
    wanted += [a.condition for a in program.assertions]
    for code in program.blocks:
        wanted += taken_values(code)
        if code.direct is not None:
            wanted += code.direct.values
    return used_always(lets, wanted, lambda e: is_part(program, e))


def used_always(
    lets: Iterable[Let], wanted: Iterable[Expr], is_part: Callable[[Expr], bool]
) -> set[Expr]:
    """The nodes that are used outside the branches of every condition.

    `wanted` are values that are used as they are; `is_part` tells targets that are
    parts of formulas, and count only when a formula needs them.
    """
    always: set[Expr] = set()
    for value in wanted:
        always.update(unconditional(value))
    for let in reversed(list(lets)):
        if let.target in always or not is_part(let.target):
            always.update(unconditional(let.value))
    return always


def unconditional(root: Expr) -> set[Expr]:
    """The nodes that evaluating the root must evaluate."""
    seen: set[Expr] = set()
    stack = [root]
    while stack:
        e = stack.pop()
        if e not in seen:
            seen.add(e)
            stack.extend(e.args[:1] if e.op in (Op.IF, Op.AND, Op.OR) else e.args)
    return seen


def is_hidden(symbol: Expr) -> bool:
    """Whether planarc named it (`$t4`, `$p2`), and not the user."""
    return symbol.data[0].startswith("$")  # type: ignore[no-any-return]


def all_lets(program: Program, statements: Iterable[Statement]) -> Iterator[Let]:
    """The assignments, those of blocks included."""
    for s in statements:
        if isinstance(s, Let):
            yield s
        else:
            code = program.blocks[s.block]
            yield from (*code.body, *code.jacobian_body)
            if code.tangent is not None:
                yield from code.tangent.body


def is_part(program: Program, symbol: Expr) -> bool:
    """Whether it holds a part of a formula: a temporary, or `$p3`."""
    name = text(symbol)
    return name not in program.slots or (name[:2] == "$p" and name[2:].isdigit())


def taken_values(code: BlockCode) -> list[Expr]:
    """The values that solving a block takes."""
    entries = [value for _, _, value in code.jacobian]
    columns = code.tangent.entries if code.tangent is not None else ()
    return [*code.residuals, *entries, *columns]
