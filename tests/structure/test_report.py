"""Systems that have no solution by their structure: what is said of them."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.ir.dae import Dae, Kind, Parameter
from planarc.ir.flat import Part
from planarc.structure.pipeline import structure

Make = Callable[..., Dae]


def _diagnostics(dae: Dae) -> list[Diagnostic]:
    with pytest.raises(PlanarcError) as info:
        structure(dae)
    return list(info.value.diagnostics)


def test_a_variable_without_equation(make: Make) -> None:
    (d,) = _diagnostics(make("der(x) = y - x"))
    assert (d.code, d.message) == (
        "S303",
        "1 equation for 2 unknowns (`x`, `y`): 1 missing",
    )
    assert d.related[0].message == "`der(x) = y - x`"
    assert d.hint == "add an equation, a connection or a binding for `x`"


def test_only_the_part_that_is_wrong_is_listed(make: Make) -> None:
    (d,) = _diagnostics(make("der(x) = -x", "a = 2*b", "y = x + a"))
    assert d.message == "2 equations for 3 unknowns (`a`, `b`, `y`): 1 missing"
    assert "der(x)" not in str(d.related)


def test_one_equation_too_many(make: Make) -> None:
    (d,) = _diagnostics(make("der(x) = -x", "y = x + 1", "y = 2*x", "x = time*y"))
    assert d.code == "S302"
    assert d.message == "4 equations for 2 unknowns (`x`, `y`): 2 too many"
    assert d.span is not None
    assert d.span.line == 4


def test_too_many_here_and_too_few_there(make: Make) -> None:
    over, under = _diagnostics(make("y = sin(time)", "y = time", "a = 2*b"))
    assert (over.code, under.code) == ("S302", "S303")
    assert over.message == "2 equations for 1 unknown (`y`): 1 too many"


def test_a_contradiction_shows_what_it_comes_to(make: Make) -> None:
    (d,) = _diagnostics(make("x = 1", "y = x", "y = 2", "der(z) = y"))
    assert d.code == "S301"
    assert d.message == "`y = 2` determines nothing: with the other equations it comes to `1 = 2`"
    assert d.span is not None
    assert d.span.line == 3


def test_parameters_alone_are_no_unknowns(make: Make) -> None:
    (d,) = _diagnostics(make("p = q", "der(x) = 1", p=1.0, q=1.0))
    assert d.code == "S301"


def test_a_point_mass_whose_angle_is_open(make: Make) -> None:
    dae = make("der(ball.x) = 1", "ball.frame_a.phi = rod.phi + 0*ball.x", "rod.t = 0")
    switch = Parameter("ball.fixAngle", Kind.BOOLEAN, dae.table.zero, False, True)
    dae = replace(dae, parts=(Part("ball", "Anybodys.Point"),), parameters=(switch,))
    (d,) = _diagnostics(dae)
    assert d.message == "nothing determines `ball.frame_a.phi`"
    assert d.hint == "set `fixAngle=true` in `ball`, or connect it to a part that turns with it"


def test_a_redundant_constraint_is_named(make: Make) -> None:
    # Two slides in parallel hold the same angle twice, so that one torque stays open.
    dae = make(
        "a.phi = 0",
        "b.phi = a.phi",
        "b.phi = a.phi",
        "der(s) = 1",
        "one.frame_a.t + two.frame_a.t = s",
    )
    (d,) = _diagnostics(dae)
    assert d.code == "S303"
    assert d.related[-1].message == (
        "`b.phi = a.phi` says nothing new: it follows from other equations"
    )
    assert d.hint is not None
    assert "repeats others" in d.hint
