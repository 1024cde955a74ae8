"""Levels, candidates and blocks of small models, and what the evaluated model does."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from planarc.core.diagnostic import PlanarcError
from planarc.ir.dae import Dae
from planarc.ir.expr import text
from planarc.ir.sorted import Assignment, Block, SortedDae

Sort = Callable[..., SortedDae]


def _shape(model: SortedDae) -> list[list[str]]:
    """`x` for an assignment, `[a b|2]` for a block with its tears and number of residuals."""
    return [
        [
            text(s.target)
            if isinstance(s, Assignment)
            else f"[{' '.join(map(text, s.tears))}|{len(s.residuals)}]"
            for s in level.steps
        ]
        for level in model.levels
    ]


CARTESIAN = ("m*der(der(x)) = -F*x", "m*der(der(y)) = -F*y - m*g", "x^2 + y^2 = L^2")


def test_the_cartesian_pendulum(sort: Sort, point: Any) -> None:
    model = sort(*CARTESIAN, m=2.0, g=9.81, L=1.5)
    assert _shape(model) == [
        ["[x y|1]"],
        ["[der(x) der(y)|1]"],
        ["[der(der(x)) F der(der(y))|3]"],
    ]
    assert model.state_count == 2
    phi, w, length = -0.7, 1.3, 1.5
    x, y = length * math.cos(phi), length * math.sin(phi)
    p = point(model, {"x": x, "der(x)": -y * w}, {"y": y})
    assert p.values["y", 1] == pytest.approx(x * w, rel=1e-9)
    z = -9.81 * math.cos(phi) / length
    assert p.values["x", 2] == pytest.approx(-y * z - x * w * w, rel=1e-7)
    assert p.of("F") == pytest.approx(2 * (w * w - 9.81 * y / length**2), rel=1e-7)
    other = point(model, {"y": y, "der(x)": -y * w}, {"x": x})  # the state can be another one
    assert other.values["x", 2] == pytest.approx(p.values["x", 2], rel=1e-7)


def test_an_ordinary_equation_has_only_states(sort: Sort, point: Any) -> None:
    model = sort("T*der(y) = u - y", "u = sin(time)", T=0.5, minima={"T": 1e-6})
    assert _shape(model) == [["[y|0]"], ["u", "der(y)"]]
    assert point(model, {"y": 0.25}, time=1.0).values["y", 1] == pytest.approx(
        (math.sin(1.0) - 0.25) / 0.5
    )


def test_a_factor_that_may_vanish_is_not_divided_by(sort: Sort) -> None:
    model = sort("T*der(y) = -y", T=0.5)
    assert _shape(model) == [["[y|0]"], ["[der(y)|1]"]]
    (block,) = model.levels[1].steps
    assert isinstance(block, Block)
    assert block.linear


def test_driven_kinematics_has_no_states(sort: Sort, point: Any) -> None:
    model = sort("phi = w0*time", "x = cos(phi)", "v = der(x)", "a = der(v)", "F = m*a", w0=2, m=3)
    assert model.state_count == 0
    assert model.candidates == ()
    p = point(model, {}, time=0.3)
    assert p.of("v") == pytest.approx(-2 * math.sin(0.6))
    assert p.of("F") == pytest.approx(-12 * math.cos(0.6))


def test_a_rolling_wheel_ties_velocities_only(sort: Sort, point: Any) -> None:
    model = sort(
        "m*der(v) = f + m*g", "J*der(w) = -R*f", "v = der(x)", "w = der(phi)", "v = R*w",
        m=2.0, J=0.5, R=0.3, g=4.0,
    )  # fmt: skip
    assert _shape(model)[:2] == [["[x|0]", "[phi|0]"], ["[der(phi)|0]", "der(x)"]]
    p = point(model, {"x": 0.0, "phi": 0.0, "der(phi)": 1.0})
    assert p.values["x", 2] == pytest.approx(2.0 * 4.0 / (2.0 + 0.5 / 0.09))


def test_a_state_can_be_asked_for(sort: Sort) -> None:
    for name in ("x", "y"):
        attributes = {name: {"select": "prefer"}}
        model = sort("der(x) = 1", "y = 2*x", "v = der(y)", attributes=attributes)
        assert [c.display for c in model.candidates] == [name]


def test_always_makes_a_state_of_what_is_not_differentiated(sort: Sort) -> None:
    model = sort("der(x) = 1", "y = 2*x", attributes={"y": {"select": "always"}})
    assert _shape(model) == [["[y|0]", "x"], ["der(x)", "der(y)"]]


def test_never_is_the_last_choice(sort: Sort) -> None:
    attributes = {"x": {"select": "never"}}
    model = sort("der(x) = 1", "y = 2*x", "v = der(y)", attributes=attributes)
    assert [c.display for c in model.candidates] == ["y"]
    alone = sort("der(x) = 1", attributes={"x": {"select": "never"}})
    assert [c.display for c in alone.candidates] == ["x"]


def test_a_preferred_velocity_is_kept_beside_another_position(sort: Sort) -> None:
    attributes = {"w": {"select": "always"}}
    model = sort("w = der(y)", "y = 2*x", "der(w) = 1", attributes=attributes)
    assert [text(c.symbol) for c in model.candidates][1] == "der(y)"


def test_always_that_follows_from_another_always_is_refused(sort: Sort) -> None:
    attributes = {"x": {"select": "always"}, "y": {"select": "always"}}
    with pytest.raises(PlanarcError) as info:
        sort("der(x) = 1", "y = 2*x", attributes=attributes)
    (d,) = info.value.diagnostics
    assert d.code == "S307"
    assert d.message == "`y` has `StateSelect.always`, but follows from other variables"


def test_more_always_than_degrees_of_freedom_are_refused(sort: Sort) -> None:
    attributes = {"x": {"select": "always"}, "y": {"select": "always"}}
    with pytest.raises(PlanarcError) as info:
        sort(*CARTESIAN, m=2.0, g=9.81, L=1.5, attributes=attributes)
    (d,) = info.value.diagnostics
    assert d.code == "S308"
    assert "`x`, `y` cannot all be states: only 1 of them is independent" in d.message
    assert d.related[0].span is not None


def test_independent_constraints_are_independent_blocks(sort: Sort) -> None:
    two = [line.replace("x", f"x{i}").replace("y", f"y{i}").replace("F", f"F{i}")
           for i in (1, 2) for line in CARTESIAN]  # fmt: skip
    model = sort(*two, m=2.0, g=9.81, L=1.5)
    assert _shape(model)[0] == ["[x1 y1|1]", "[x2 y2|1]"]
    assert len(model.levels[2].steps) == 2


def test_equations_keep_their_numbers_and_lines(sort: Sort) -> None:
    model = sort(*CARTESIAN, m=2.0, g=9.81, L=1.5)
    last = model.equations[-1]
    assert last.order == 2
    assert last.span.line == 3
    assert last.derived_from is not None
    assert model.equations[last.derived_from].derived_from == 2
    for level in model.levels:
        for step in level.steps:
            for r in step.residuals if isinstance(step, Block) else ():
                e = model.equations[r.equation]
                table = model.dae.table
                assert r.value is table.sub(e.equation.left, e.equation.right)


def test_what_is_used_by_a_relation_is_computed(sort: Sort) -> None:
    # The acceleration is in no equation, only where an event looks.
    model = sort("x = sin(time)", relations=("der(der(x))",))
    assert _shape(model) == [["x"], ["der(x)"], ["der(der(x))"]]


def test_an_input_is_differentiated_twice_at_most(make: Callable[..., Dae], sort: Sort) -> None:
    model = sort("x = u", "v = der(x)", "a = der(v)", inputs=["u"])
    assert [v.name for v in model.dae.inputs] == ["u", "der(u)", "der(der(u))"]
    with pytest.raises(PlanarcError) as info:
        sort("x = u", "v = der(x)", "a = der(v)", "j = der(a)", inputs=["u"])
    (d,) = info.value.diagnostics
    assert d.code == "S306"
    assert "a derivative of order 3 of the input `u` is needed" in d.message
    assert d.span is not None
    assert d.span.line == 1
    assert sort("der(x) = u - x", inputs=["u"]).state_count == 1


def test_branches_of_an_if_are_solved_when_each_can_be(sort: Sort) -> None:
    model = sort("a + 2 = (b if event[0] else 2*b)", "a = time")
    assert _shape(model) == [["a", "b"]]
    locked = sort("a = (0 if event[0] else s)", "a + s = time")
    assert _shape(locked) == [["[s|1]"]]
    (block,) = locked.levels[0].steps
    assert isinstance(block, Block)
    assert [text(a.target) for a in block.inner] == ["a"]


def test_a_time_derivative_past_an_event_holds_the_condition(sort: Sort, point: Any) -> None:
    model = sort("x = (time^2 if event[0] else 3*time)", "v = der(x)")
    assert point(model, {}, time=2.0, events=[True]).of("v") == 4
    assert point(model, {}, time=2.0, events=[False]).of("v") == 3
