"""Loops taken apart: each statement reads what it would read in the loop."""

from __future__ import annotations

from collections.abc import Sequence

from hypothesis import given
from hypothesis import strategies as st

from planarc.codegen.native.parting import Vector, vectors
from planarc.codegen.native.rolling import Roll
from planarc.ir.expr import Expr, Exprs, postorder, text
from planarc.ir.program import Let

#: What a leaf holds: the statement and time that set it last, or nothing so far.
Held = tuple[int, int] | None


def leaves(e: Expr) -> list[Expr]:
    return [part for part in postorder((e,)) if not part.args]


def looped(bodies: Sequence[Sequence[Let]]) -> Roll:
    """A loop of equal groups, time by time."""
    by_statement = [*zip(*bodies, strict=True)]
    targets = tuple(tuple(let.target for let in group) for group in by_statement)
    columns = (zip(*(leaves(let.value) for let in group), strict=True) for group in by_statement)
    statements = tuple(let for body in bodies for let in body)
    return Roll(statements, tuple(bodies[0]), targets, tuple(map(tuple, columns)))


def chain(t: Exprs, times: int, *later: int) -> Roll:
    """Each link begins where the one before ends; `later` are added operands that wait, too."""
    c, h, x, y, z = ([t.symbol(f"{name}{i}") for i in range(times + 1)] for name in "chxyz")
    return looped(
        [
            [
                Let(h[i], t.call("sin", x[i])),
                Let(x[i + 1], t.sub(c[i], x[i])),
                Let(c[i], t.call("cos", y[i])),
                *(Let(z[i + 1], t.less(t.less(z[i], x[i]), y[i])) for _ in later),
            ]
            for i in range(times)
        ]
    )


def place(e: Expr) -> Expr:
    return e


def widths(parts: Sequence[Vector] | None) -> list[tuple[str, int]]:
    assert parts is not None
    return [(text(let.target)[:1], len(target)) for let, target, _ in parts]


def test_what_waits_next_to_nowhere_is_done_for_all_times() -> None:
    run = chain(Exprs(), 30)
    # `c` is set behind what reads it: the old values are read first.
    assert sorted(widths(vectors(run, place))) == [("c", 30), ("h", 30), ("x", 30)]
    assert [name for name, _ in widths(vectors(run, place))].index("x") < 2


def test_what_reads_itself_before_its_last_operation_is_done_time_by_time() -> None:
    found = widths(vectors(chain(Exprs(), 8, 1), place))
    assert found.count(("z", 1)) == 8 and ("x", 8) in found


def test_loops_of_which_most_would_be_done_time_by_time_stay() -> None:
    assert vectors(chain(Exprs(), 60, 1), place) is None


def test_loops_that_set_a_value_again_stay() -> None:
    t = Exprs()
    x, y = t.symbol("x"), t.symbol("y")
    assert vectors(looped([[Let(x, t.call("sin", y))]] * 3), place) is None


def in_the_loop(run: Roll) -> dict[tuple[Expr, ...], list[Held]]:
    held: dict[Expr, Held] = {}
    found = {}
    for k, let in enumerate(run.statements):
        found[let.target,] = [held.get(e) for e in leaves(let.value)]
        held[let.target] = divmod(k, len(run.body))
    return found


def by_operations(run: Roll, parts: Sequence[Vector]) -> dict[tuple[Expr, ...], list[Held]]:
    """Of `(a < b) < c` the first operation reads for all times, then the second, time by time,
    while the target is set."""
    setters = {let.target: divmod(k, len(run.body)) for k, let in enumerate(run.statements)}
    held: dict[Expr, Held] = {}
    found = {}
    for let, target, columns in parts:
        by_leaf = dict(zip(leaves(let.value), columns, strict=True))
        inner, outer = (leaves(e) for e in let.value.args)
        early = [[held.get(by_leaf[e][t]) for e in inner] for t in range(len(target))]
        for t, e in enumerate(target):
            late = [held.get(by_leaf[x][t]) for x in outer]
            seen = dict(zip((*inner, *outer), (*early[t], *late), strict=True))
            found[e,] = [seen[x] for x in leaves(let.value)]
            held[e] = setters[e]
    return found


@st.composite
def loops(draw: st.DrawFn) -> Roll:
    """Statements `(a < b) < c` that read each other from the time before, now and behind."""
    t, count, times = Exprs(), draw(st.integers(1, 5)), draw(st.integers(2, 4))
    read = st.tuples(st.integers(0, count), st.integers(0, 2))
    told = [draw(st.lists(read, min_size=3, max_size=3, unique=True)) for _ in range(count)]

    def at(statement: int, time: int) -> Expr:
        return t.symbol(f"x{statement}_{time}")

    bodies = []
    for time in range(times):
        operands = [[at(i, time + shift) for i, shift in reads] for reads in told]
        bodies.append(
            [Let(at(i, time + 1), t.less(t.less(a, b), c)) for i, (a, b, c) in enumerate(operands)]
        )
    return looped(bodies)


@given(loops())
def test_each_statement_reads_what_it_would_read_in_the_loop(run: Roll) -> None:
    parts = vectors(run, place)
    assert parts is not None
    assert by_operations(run, parts) == in_the_loop(run)
