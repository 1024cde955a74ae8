"""Consistent start values: what is held, which branch is taken, what is refused."""

from __future__ import annotations

import math
from typing import Any

import pytest

from planarc.core.diagnostic import PlanarcError
from planarc.core.options import Backend, RunOptions
from planarc.solve.simulate import simulate
from planarc.solve.start import assembly

CROSSED, OPEN = -1, 1


def start(tools: Any, mechanism: Any, **options: Any) -> Any:
    program = mechanism.program()
    kernel = tools.Interpreter(program)
    return simulate(program, kernel, RunOptions(stop=0.0, backend=Backend.NUMPY, **options))


def closed_form(phi: float, branch: int, lengths: Any = (0.4, 0.9, 0.8, 1.0)) -> tuple[float, ...]:
    """Angles of coupler and rocker of a four-bar."""
    a, b, c, d = lengths
    bx, by = a * math.cos(phi), a * math.sin(phi)
    dx, dy = d - bx, -by
    r = math.hypot(dx, dy)
    alpha = branch * math.acos((b * b + r * r - c * c) / (2 * b * r))
    coupler = math.atan2(dy, dx) + alpha
    cx, cy = bx + b * math.cos(coupler), by + b * math.sin(coupler)
    return coupler, math.atan2(cy, cx - d)


@pytest.mark.parametrize("branch", [OPEN, CROSSED])
@pytest.mark.parametrize("phi", [-2.5, -1.0, 0.3, 1.0, 2.9])
def test_the_loop_closes_on_the_branch_nearest_to_the_guesses(
    tools: Any, phi: float, branch: int
) -> None:
    coupler, rocker = closed_form(phi, branch)
    result = start(
        tools,
        tools.four_bar(
            [
                tools.Coordinate("revA.phi", phi, written=True),
                tools.Coordinate("revB.phi", coupler + 0.3, written=True),
                tools.Coordinate("revD.phi", rocker - 0.2, written=True),
            ]
        ),
    )
    assert result["revA.phi"][0] == phi
    assert result["revB.phi"][0] == pytest.approx(coupler, abs=1e-12)
    assert result["revD.phi"][0] == pytest.approx(rocker, abs=1e-12)
    held = {h.name: h.held for h in result.held}
    assert [held[n] for n in ("revA.phi", "revB.phi", "revD.phi")] == [True, False, False]


def test_an_angle_is_never_whole_turns_away(tools: Any) -> None:
    coupler, rocker = closed_form(1.0, OPEN)
    result = start(
        tools,
        tools.four_bar(
            [
                tools.Coordinate("revA.phi", 1.0 + 4 * math.pi, fixed=True),
                tools.Coordinate("revB.phi", coupler - 2 * math.pi + 0.2),
                tools.Coordinate("revD.phi", rocker + 2 * math.pi),
            ]
        ),
    )
    assert result["revB.phi"][0] == pytest.approx(coupler - 2 * math.pi, abs=1e-12)
    assert result["revD.phi"][0] == pytest.approx(rocker + 2 * math.pi, abs=1e-12)


def test_a_written_start_value_counts_more_than_a_default(tools: Any) -> None:
    result = start(
        tools,
        tools.four_bar(
            [
                tools.Coordinate("revA.phi", 0.9),
                tools.Coordinate("revB.phi", 0.5),
                tools.Coordinate("revD.phi", 1.7, written=True),
            ]
        ),
    )
    assert result["revD.phi"][0] == 1.7
    assert abs(result["revA.phi"][0] - 0.9) > 1e-3


def test_fixed_counts_more_than_written_and_speeds_follow(tools: Any) -> None:
    result = start(
        tools,
        tools.four_bar(
            [
                tools.Coordinate("revA.phi", 0.9, written=True),
                tools.Coordinate("revB.phi", 0.5, speed=0.7, speed_fixed=True),
                tools.Coordinate("revD.phi", 1.7, fixed=True),
            ]
        ),
    )
    assert result["revD.phi"][0] == 1.7
    assert result["der(revB.phi)"][0] == 0.7
    a, b, d = (result[f"rev{n}.phi"][0] for n in "ABD")
    va, vb, vd = (result[f"der(rev{n}.phi)"][0] for n in "ABD")
    for f in (math.sin, math.cos):
        assert 0.4 * f(a) * va + 0.9 * f(b) * vb == pytest.approx(0.8 * f(d) * vd, abs=1e-12)


def test_the_start_does_not_depend_on_the_tolerance(tools: Any) -> None:
    loose, tight = (start(tools, tools.four_bar(), tolerance=t) for t in (1e-2, 1e-10))
    for name in ("revA.phi", "revB.phi", "revD.phi"):
        assert loose[name][0] == tight[name][0]


def test_start_values_of_the_user_are_held(tools: Any) -> None:
    result = start(tools, tools.four_bar(), starts={"revA.phi": 1.3})
    assert result["revA.phi"][0] == 1.3
    assert result["revB.phi"][0] == pytest.approx(closed_form(1.3, OPEN)[0], abs=1e-12)


def test_far_guesses_are_reached_by_continuation_or_damping(tools: Any) -> None:
    result = start(
        tools,
        tools.four_bar(
            [
                tools.Coordinate("revA.phi", 1.0, fixed=True),
                tools.Coordinate("revB.phi"),
                tools.Coordinate("revD.phi"),
            ]
        ),
    )
    found = result["revB.phi"][0], result["revD.phi"][0]
    assert any(
        all(
            math.isclose(math.sin(x - y), 0, abs_tol=1e-9)
            for x, y in zip(found, known, strict=True)
        )
        for known in (closed_form(1.0, OPEN), closed_form(1.0, CROSSED))
    )


def test_an_initial_equation_may_ask_for_an_acceleration(tools: Any) -> None:
    """A pendulum in equilibrium: der(der(phi)) = 0, near the lower dead centre."""
    mechanism = tools.pendulum(initial=lambda t: [t.symbol("rev.phi", 2)])
    mechanism.coordinates[0].start = -1.3
    result = start(tools, mechanism)
    assert result["rev.phi"][0] == pytest.approx(-math.pi / 2, abs=1e-9)


def test_a_fixed_variable_that_is_no_candidate_is_met(tools: Any) -> None:
    """The height of the rod's end is fixed; the angle follows, on the near side."""
    mechanism = tools.pendulum(
        extra=lambda t: [("tip.y", t.call("sin", t.symbol("rev.phi")))], fixed=[("tip.y", 0.5)]
    )
    mechanism.coordinates[0].start = 2.0
    result = start(tools, mechanism)
    assert result["rev.phi"][0] == pytest.approx(math.pi - math.asin(0.5), abs=1e-12)


def test_rods_too_short_name_the_loop_the_equation_and_its_line(tools: Any) -> None:
    with pytest.raises(PlanarcError) as caught:
        start(tools, tools.four_bar(lengths=(0.4, 0.2, 0.3, 1.0)))
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "R412"
    assert "cannot be met" in diagnostic.message  # no mechanism is known of which it is a loop
    assert "`revA`" in diagnostic.message
    assert "`loop.revC`" in diagnostic.message
    assert diagnostic.span is not None
    assert diagnostic.span.line in (10, 11)
    assert "off by" in diagnostic.related[0].message
    assert "holds the same motion twice" in (diagnostic.hint or "")


def test_a_held_value_out_of_reach_tells_what_is_in_reach(tools: Any) -> None:
    """A rocker that cannot swing as far as it is asked to."""
    with pytest.raises(PlanarcError) as caught:
        start(
            tools,
            tools.four_bar(
                [
                    tools.Coordinate("revA.phi", 1.0),
                    tools.Coordinate("revB.phi", 0.5),
                    tools.Coordinate("revD.phi", 0.2, fixed=True),
                ]
            ),
        )
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "R412"
    assert "`revD.phi` = 0.2" in diagnostic.message
    assert "revD.phi(start = " in (diagnostic.hint or "")


def test_other_branches_are_not_looked_for_while_a_held_value_moves(
    tools: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each of a dozen steps towards what is out of reach would try all of them."""
    looks, beside = [], []
    nearest = assembly.nearest_root

    def counted(*given: Any) -> Any:
        (beside if given[-1] is True else looks).append(1)
        return nearest(*given)

    monkeypatch.setattr(assembly, "nearest_root", counted)
    test_a_held_value_out_of_reach_tells_what_is_in_reach(tools)
    assert len(looks) <= 12
    assert len(beside) > len(looks)


def test_two_fixed_values_that_disagree_are_both_named(tools: Any) -> None:
    coordinates = [
        tools.Coordinate("revA.phi", 1.0, fixed=True),
        tools.Coordinate("revB.phi", 0.5),
        tools.Coordinate("revD.phi", 1.8, fixed=True),
    ]
    with pytest.raises(PlanarcError) as caught:
        start(tools, tools.four_bar(coordinates))
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "R411"
    assert "`revA.phi` and `revD.phi`" in diagnostic.message
    assert "1.58617" in (diagnostic.hint or "")
    assert diagnostic.span is not None
    assert diagnostic.span.line == 3
    assert [r.span.line for r in diagnostic.related if r.span] == [1]


def test_two_fixed_values_that_agree_are_accepted(tools: Any) -> None:
    rocker = closed_form(1.0, OPEN)[1]
    result = start(
        tools,
        tools.four_bar(
            [
                tools.Coordinate("revA.phi", 1.0, fixed=True),
                tools.Coordinate("revB.phi", 0.5),
                tools.Coordinate("revD.phi", rocker, fixed=True),
            ]
        ),
    )
    assert result["revD.phi"][0] == pytest.approx(rocker, abs=1e-12)


def test_contradicting_speeds_are_named_as_such(tools: Any) -> None:
    with pytest.raises(PlanarcError, match=r"`der\(revA.phi\)` and `der\(revD.phi\)`"):
        start(
            tools,
            tools.four_bar(
                [
                    tools.Coordinate("revA.phi", 1.0, fixed=True, speed=1.0, speed_fixed=True),
                    tools.Coordinate("revB.phi", 0.5),
                    tools.Coordinate("revD.phi", 1.6, speed=5.0, speed_fixed=True),
                ]
            ),
        )


def test_a_division_by_zero_at_the_start_is_no_traceback(tools: Any) -> None:
    mechanism = tools.pendulum(extra=lambda t: [("x", t.div(t.one, t.symbol("rev.phi")))])
    with pytest.raises(PlanarcError, match="R413"):
        start(tools, mechanism)
