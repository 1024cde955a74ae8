"""Expressions written as bytes and read back: the same trees, shared as before, nothing more."""

from __future__ import annotations

from msgspec.structs import replace

from planarc.core.source import NOWHERE
from planarc.ir.expr import Exprs, Op, postorder, text
from planarc.ir.program import EquationInfo, Let, Program, Solve
from planarc.ir.store import dumps, loads


def test_what_is_read_says_what_was_written() -> None:
    t = Exprs()
    x, y = t.symbol("x"), t.symbol("y", 2)
    values = (
        t.add(t.mul(t.const(2.5), x, y), t.neg(t.call("sin", x))),
        t.if_(t.less(x, t.const(-0.0)), t.time, t.div(x, y)),
        t.and_(t.event(3), t.not_(t.pre("b"))),
        t.past(1, t.time, 2),
        t.true,
        t.one,
    )
    table, read = loads(dumps((t, {"values": values}), t))
    assert [text(e) for e in read["values"]] == [text(e) for e in values]
    assert all(e in table.all for e in read["values"])
    assert read["values"][4] is table.true
    assert read["values"][5] is table.one


def test_shared_nodes_stay_shared() -> None:
    t = Exprs()
    part = t.call("cos", t.symbol("phi"))
    a, b = loads(dumps((t.mul(part, t.symbol("a")), t.mul(part, t.symbol("b"))), t))
    assert a.args[0] is b.args[0]


def test_a_chain_may_be_deeper_than_recursion_goes() -> None:
    t = Exprs()
    e = t.symbol("x")
    for _ in range(20_000):
        e = t.call("sin", e)
    assert len(postorder((loads(dumps(e, t)),))) == 20_001


def test_nodes_that_nothing_uses_are_left_out() -> None:
    t = Exprs()
    for i in range(100):
        t.call("sin", t.symbol(f"unused{i}"))
    table, _ = loads(dumps((t, t.call("sin", t.symbol("x"))), t))
    assert [e for e in table.all if e.op is Op.SYMBOL] == [table.symbol("x")]


def test_order_of_numbers_is_kept() -> None:
    t = Exprs()
    names = [f"x{i}" for i in range(50)]
    for name in names:
        t.symbol(name)
    read = loads(dumps([t.symbol(name) for name in reversed(names)], t))
    assert [e.name for e in sorted(read)] == names


def test_what_a_program_has_many_of_is_read_as_it_was() -> None:
    """Also where it is not of one kind, or of one length."""
    t = Exprs()
    x, y = t.symbol("x"), t.symbol("y")
    for statements in (
        (Let(x, y), Let(y, x, 3)),
        (Let(x, y), Solve(2)),
        (Solve(1), Solve(2)),
        (),
    ):
        program = Program("p", t, 2, {}, *((),) * 10, statements, *((),) * 7)
        for equations in (
            (EquationInfo("x = y", NOWHERE, "a"), EquationInfo((x, y), NOWHERE, "b")),
            (EquationInfo((y, x), NOWHERE, "a", ("x > 0",)),),
        ):
            written = replace(program, equations=equations, turning=((1, x), (2, y)))
            read = loads(dumps(written, t))
            assert repr((read.parameters, read.equations)) == repr((statements, equations))
            assert repr(read.turning) == repr(written.turning)
