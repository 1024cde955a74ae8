"""Modifiers merged: the outer one wins, and what is final stays."""

from __future__ import annotations

import pytest

from planarc.core.diagnostic import PlanarcError
from planarc.flatten.tree.modify import merge
from planarc.flatten.tree.nodes import NO_MOD, Mod


def test_members_of_both_modifiers_are_kept_and_the_outer_one_wins() -> None:
    own, other, weaker = (Mod(broken=True) for _ in range(3))
    merged = merge(Mod(subs={"start": own}), Mod(subs={"start": weaker, "min": other}))
    assert merged.subs.keys() == {"start", "min"}
    assert merged.sub("start").broken and merged.sub("min") is other


def test_nothing_changes_a_modifier() -> None:
    mod = Mod(subs={"start": Mod(broken=True)})
    assert merge(mod, NO_MOD) is mod
    assert merge(NO_MOD, mod) is mod


def test_a_final_modifier_is_not_overridden() -> None:
    with pytest.raises(PlanarcError, match="`x` is final"):
        merge(Mod(broken=True), Mod(final=True), "x")
