"""Formulas in the symbols that are computed."""

from __future__ import annotations

import pytest

from planarc.codegen.aliases import Aliases
from planarc.ir.dae import Dae
from planarc.ir.expr import Expr, Exprs
from planarc.ir.sorted import Alias


@pytest.fixture
def table() -> Exprs:
    return Exprs()


def aliases(table: Exprs) -> Aliases:
    """w = der(phi), f = -force"""
    found = (
        Alias("w", table.symbol("phi", 1), 1),
        Alias("f", table.symbol("force"), -1),
    )
    return Aliases(Dae("M", table, (), (), ()), found)


def test_aliases_are_put_in_with_signs_and_derivatives(table: Exprs) -> None:
    t, rewrite = table, aliases(table)
    w, f, x = t.symbol("w"), t.symbol("f"), t.symbol("x")
    assert rewrite(t.mul(t.const(2.0), f)) is t.mul(t.const(-2.0), t.symbol("force"))
    assert rewrite(t.symbol("w", 1)) is t.symbol("phi", 2)
    assert rewrite(t.add(w, x)) is t.add(t.symbol("phi", 1), x)
    plain = t.less(x, t.one)
    assert rewrite(plain) is plain


def test_what_many_formulas_share_is_rewritten_once(
    table: Exprs, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An array that is set at an index that varies is thousands of assignments that share all."""
    shared = table.symbol("f")
    for i in range(500):
        shared = table.call("sin", table.add(shared, table.const(float(i))))
    roots = [table.mul(shared, table.symbol(f"x{i}")) for i in range(100)]
    count = 0
    plain = Exprs.rebuild

    def counted(self: Exprs, e: Expr, args: tuple[Expr, ...]) -> Expr:
        nonlocal count
        count += 1
        return plain(self, e, args)

    monkeypatch.setattr(Exprs, "rebuild", counted)
    rewrite = aliases(table)
    assert len({rewrite(root) for root in roots}) == 100
    assert count <= 1000 + 2 * 100
