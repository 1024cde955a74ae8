"""Every symbol has a Python name of its own, whatever it is called in the model."""

from __future__ import annotations

import keyword

from planarc.codegen.numpy.names import Names, comment
from planarc.ir.expr import Exprs
from planarc.runtime import elementary


def test_names_are_identifiers_and_no_two_meet() -> None:
    t, names = Exprs(), Names()
    called = [
        "a.b",
        "a_b",
        "a[1]",
        "a_1",
        "'a b'",
        "der_x",
        "if",
        "match",
        "w",
        "sin",
        "1",
        "\u00fc",
        "'",
    ]
    symbols = [t.symbol(name) for name in called]
    symbols += [t.symbol("x", 1), t.symbol("x", 2), t.pre("x"), t.event(0)]
    found = [names(s) for s in symbols]
    assert len(set(found)) == len(found)
    assert not {*elementary.TABLE, "w", "t", "blocks"}.intersection(found)
    for name in found:
        assert name.isidentifier() and name.isascii() and not keyword.iskeyword(name)
    assert [names(s) for s in symbols] == found


def test_a_comment_stays_on_its_line() -> None:
    assert comment("a\nimport os\u2028b") == "a\\nimport os\\u2028b"
