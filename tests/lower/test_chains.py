"""Chains of branches cost as much as they are long, not its square: operations are counted."""

from __future__ import annotations

import pytest

import planarc
from planarc.ir.expr import Exprs

CHAINS = {
    "expression": ("Real x = if time < 0 then 0", " elseif time < {} then {}", " else 1;"),
    "equations": (
        "Real x; equation if time < 0 then x = 0;",
        " elseif time < {} then x = {};",
        " else x = 1; end if;",
    ),
}


@pytest.mark.parametrize("parts", CHAINS.values(), ids=CHAINS)
def test_the_cost_of_a_chain_grows_with_its_length(
    parts: tuple[str, str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    made = [0]
    original = Exprs.not_

    def counted(table: Exprs, e: object) -> object:
        made[0] += 1
        return original(table, e)  # type: ignore[arg-type]

    monkeypatch.setattr(Exprs, "not_", counted)
    counts = []
    for length in (50, 100):
        made[0] = 0
        branches = "".join(parts[1].format(k, k) for k in range(1, length))
        planarc.load(f"model M {parts[0]}{branches}{parts[2]} end M;")
        counts.append(made[0])
    assert counts[1] < 3 * counts[0] + 100
