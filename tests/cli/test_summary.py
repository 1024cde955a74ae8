"""The texts of the summary."""

from __future__ import annotations

import math

from planarc.cli import summary
from planarc.ir.result import Held, StateChoice


def test_states_are_named_and_so_is_every_change() -> None:
    assert summary.states(()) == "none"
    assert summary.states((StateChoice(0.0, ()),)) == "none"
    first = StateChoice(0.0, ("a.phi", "a.w"))
    assert summary.states((first,)) == "a.phi, a.w"
    assert summary.states((first, StateChoice(0.25, ("b.phi", "b.w")))) == (
        "chosen 2 times\na.phi, a.w from t = 0 s\nb.phi, b.w from t = 0.25 s"
    )


def test_a_long_list_is_cut() -> None:
    names = tuple(f"x{i}" for i in range(11))
    assert summary.states((StateChoice(0.0, names),)).endswith("x7 and 3 more")


def test_start_values_are_held_or_guessed_and_the_farthest_comes_first() -> None:
    held = (
        Held("a", 1.0, 1.0, True),
        Held("b", 0.5, 0.5, False),
        Held("c", 0.0, 0.1, False),
        Held("d", 2.0, -1.0, False),
    )
    assert summary.start_values(held) == ("held a = 1\nguessed d = 2 -> -1, c = 0 -> 0.1")
    assert summary.start_values(()) == ""


def test_times_stand_in_their_order_with_the_total_first() -> None:
    seconds = {"recall": 0.001, "parse": 0.0125, "total": 0.0251}
    assert summary.times(seconds, False) == "25 ms in all: recall 1.0 ms, parse 12 ms"
    assert summary.times(seconds, True).startswith("25 ms in all (compiled before): ")


def test_the_states_are_told_with_their_reason() -> None:
    import planarc
    from planarc.cli.summary import state_reasons

    result = planarc.load("PlanarMultiBody.Examples.Loops.FourBar").simulate(0.1).rows
    lines = state_reasons(result).splitlines()
    assert lines[0] == "StateSelect.prefer: revA.phi, revA.w"
    assert (
        lines[-1] == f"the best conditioned choice of {len(result.program.candidates)} candidates"
    )


def test_start_values_have_the_units_of_their_readers() -> None:
    held = (
        Held("hinge.phi", start=math.pi / 4, value=math.pi / 4, held=True),
        Held("slide.s", start=0.1, value=0.2, held=False),
    )
    units = {"hinge.phi": (180 / math.pi, "deg"), "slide.s": (1.0, "m")}
    told = "held hinge.phi = 45 deg\nguessed slide.s = 0.1 -> 0.2 m"
    assert summary.start_values(held, units) == told
