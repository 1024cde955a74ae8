"""What is held at the start, guesses, initial and discrete equations, the rest rewritten."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from msgspec.structs import replace

from planarc.core.diagnostic import PlanarcError
from planarc.ir.dae import Assertion, Dae, Equation, Message, Reinit, When
from planarc.ir.expr import text
from planarc.ir.sorted import SortedDae
from planarc.structure.pipeline import structure

Sort = Callable[..., SortedDae]


def test_a_fixed_variable_that_is_no_candidate_is_held(sort: Sort) -> None:
    attributes = {"x": {"select": "prefer"}, "y": {"start": 4, "fixed": True}}
    model = sort("der(x) = -x", "y = 2*x", attributes=attributes)
    assert [(text(f.symbol), f.display, text(f.start)) for f in model.fixed] == [("y", "y", "4")]
    assert not model.candidates[0].fixed


def test_a_held_alias_has_its_sign(sort: Sort) -> None:
    attributes = {"x": {"select": "prefer"}, "z": {"start": 4, "fixed": True}}
    model = sort("der(x) = -x", "y = 2*x", "z = -y", attributes=attributes)
    assert [(text(f.symbol), text(f.start)) for f in model.fixed] == [("y", "-4")]


def test_of_equal_priority_the_written_start_makes_the_candidate(sort: Sort) -> None:
    for written in ("x", "y"):
        model = sort("der(x) = 1", "y = 2*x", "z = der(y)", attributes={written: {"start": 3}})
        assert [c.display for c in model.candidates] == [written]


def test_a_written_start_of_a_dependent_variable_is_kept(sort: Sort) -> None:
    attributes = {"x": {"select": "prefer"}, "y": {"start": 3}}
    model = sort("der(x) = 1", "y = 2*x", "z = der(y)", attributes=attributes)
    (kept,) = model.fixed
    assert (kept.display, text(kept.start), kept.fixed, kept.written) == ("y", "3", False, True)
    assert kept.height == 1


def test_torn_unknowns_of_the_top_start_from_their_guess(sort: Sort) -> None:
    model = sort("cos(y) = y", attributes={"y": {"start": 0.7}})
    assert [(text(s), text(v)) for s, v in model.guesses] == [("y", "0.7")]


def test_initial_equations_are_in_kept_symbols(sort: Sort) -> None:
    model = sort("w = der(phi)", "der(w) = -sin(phi)", initial=["w = 2*q"], q=1.0)
    (r,) = model.initial_residuals
    assert text(r.value) == "der(phi) - 2*q"
    assert model.equations[r.equation].span.line == 3


def test_an_initial_equation_that_cannot_hold_is_refused(sort: Sort) -> None:
    with pytest.raises(PlanarcError, match="S309"):
        sort("x = 1", "der(y) = x", initial=["x = 2"])
    assert sort("x = 1", "der(y) = x", initial=["x = 1"]).initial_residuals == ()


# Discrete equations ---------------------------------------------------------------------------


def test_discrete_equations_follow_what_they_need(sort: Sort) -> None:
    model = sort(
        "der(x) = 1", discrete={"c": "a and b", "a": "event[0] or pre(c)", "b": "not a", "m": ""}
    )
    assert [text(a.target) for a in model.discrete] == ["a", "b", "c"]
    first = len(model.dae.equations)
    assert [a.equation for a in model.discrete] == [first + 1, first + 2, first]


def test_a_discrete_loop_names_its_variables(sort: Sort) -> None:
    with pytest.raises(PlanarcError) as info:
        sort("der(x) = 1", discrete={"a": "b or event[0]", "b": "not a"})
    (d,) = info.value.diagnostics
    assert d.code == "S311"
    assert d.message == "discrete variables depend on each other at one instant: `a`, `b`"


def test_two_equations_for_one_discrete_variable(make: Callable[..., Dae]) -> None:
    dae = make("der(x) = 1", discrete={"a": "event[0]"})
    twice = replace(dae, discrete_equations=dae.discrete_equations * 2)
    with pytest.raises(PlanarcError) as info:
        structure(twice)
    (d,) = info.value.diagnostics
    assert (d.code, d.message) == (
        "S314",
        "the discrete equation `a = event[0]` is one too many: others set `a`",
    )


def test_a_discrete_equation_without_a_variable(make: Callable[..., Dae]) -> None:
    dae = make("der(x) = 1", discrete={"a": ""})
    t = dae.table
    odd = Equation(t.and_(t.symbol("a"), t.event(0)), t.true)
    with pytest.raises(PlanarcError, match="S310"):
        structure(replace(dae, discrete_equations=(odd,)))


def test_eliminated_variables_leave_discrete_equations(sort: Sort) -> None:
    model = sort("x = y", "der(x) = 1", discrete={"a": "y > 1"})
    assert text(model.discrete[0].value) == "1 < x"


# The rest of the model --------------------------------------------------------------------------


def test_a_reinit_follows_the_sign_of_an_alias(make: Callable[..., Dae]) -> None:
    dae = make("w = -der(phi)", "der(w) = phi", "u = w", discrete={"b": "event[0]"})
    t = dae.table
    reinit = Reinit(t.symbol("w"), t.mul(t.const(-0.5), t.symbol("u")))
    check = Assertion(t.less(t.symbol("u"), t.one), Message(("too fast: ", (t.symbol("u"), ""))))
    model = structure(replace(dae, whens=(When((("b", (reinit, check)),)),), assertions=(check,)))
    ((_, (after, inside)),) = model.dae.whens[0].branches
    assert isinstance(after, Reinit)
    assert (text(after.symbol), text(after.value)) == ("der(phi)", "-0.5*der(phi)")
    assert isinstance(inside, Assertion)
    assert text(inside.condition) == "-der(phi) < 1"
    assert model.dae.assertions == (inside,)


def test_a_constant_cannot_be_reset(make: Callable[..., Dae]) -> None:
    dae = make("x = 1", "der(y) = x", discrete={"b": "event[0]"})
    reinit = Reinit(dae.table.symbol("x"), dae.table.zero)
    with pytest.raises(PlanarcError, match="S312"):
        structure(replace(dae, whens=(When((("b", (reinit,)),)),)))


def _reset(dae: Dae, name: str) -> SortedDae:
    reinit = Reinit(dae.table.symbol(name), dae.table.zero)
    return structure(replace(dae, whens=(When((("b", (reinit,)),)),)))


def test_what_a_reinit_sets_is_kept_as_a_state(make: Callable[..., Dae]) -> None:
    attributes = {"x": {"select": "prefer"}}
    dae = make("der(x) = 1", "y = 2*x", discrete={"b": "event[0]"}, attributes=attributes)
    assert [(c.display, c.select.name) for c in _reset(dae, "y").candidates] == [("y", "ALWAYS")]


def test_a_reinit_of_what_cannot_be_a_state_is_refused(make: Callable[..., Dae]) -> None:
    dae = make("y = sin(time)", discrete={"b": "event[0]"})
    with pytest.raises(PlanarcError) as info:
        _reset(dae, "y")
    (d,) = info.value.diagnostics
    assert (d.code, d.message) == (
        "S313",
        "`y` is set by `reinit`, but follows from other variables",
    )
