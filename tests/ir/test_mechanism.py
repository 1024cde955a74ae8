"""The joints of a loop, from links and joints as plain data."""

from __future__ import annotations

from planarc.ir.mechanism import Joint, Link, Mechanism


def joint(name: str, *links: int) -> Joint:
    return Joint(name, 2, 1, links, ())


LINKS = tuple(Link(str(i), ()) for i in range(6))


def test_a_four_bar_is_one_loop_and_a_pendulum_on_it_is_in_none() -> None:
    a, b, c, d = joint("a", 0, 1), joint("b", 1, 2), joint("c", 2, 3), joint("d", 0, 3)
    hung = joint("hung", 2, 4)
    mechanism = Mechanism(LINKS, (a, b, hung, c, d))
    assert [j.name for j in mechanism.shortest_loop(b)] == ["b", "a", "d", "c"]
    assert mechanism.shortest_loop(hung) == ()


def test_two_loops_on_one_ground_are_told_apart() -> None:
    first = (joint("a", 0, 1), joint("b", 1, 2), joint("c", 0, 2))
    second = (joint("p", 0, 3), joint("q", 3, 4), joint("r", 0, 4))
    mechanism = Mechanism(LINKS, (*first, *second))
    assert {j.name for j in mechanism.shortest_loop(second[1])} == {"p", "q", "r"}


def test_a_loop_of_joints_of_two_links_does_not_lead_over_a_gear() -> None:
    a, b, gear = joint("a", 0, 1), joint("b", 0, 2), joint("gear", 0, 1, 2)
    mechanism = Mechanism(LINKS, (a, b, gear))
    assert [j.name for j in mechanism.shortest_loop(a)] == ["a", "gear"]
    assert mechanism.shortest_loop(a, paired=True) == ()
