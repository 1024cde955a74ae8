"""The checker of sorted models finds broken promises; the printers show what is there."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from planarc.core.source import Source, Span
from planarc.ir.dae import (
    Assertion,
    Dae,
    Equation,
    Kind,
    Message,
    Parameter,
    Reinit,
    Relation,
    SetDiscrete,
    Terminate,
    Variable,
    When,
)
from planarc.ir.expr import Exprs
from planarc.ir.flat import StateSelect
from planarc.ir.sorted import (
    Alias,
    Assignment,
    Block,
    Candidate,
    Fixed,
    Level,
    Residual,
    SortedDae,
    SourceEquation,
)
from planarc.ir.text.sorted import sorted_text
from tests.ir.check.sorted import BrokenPromise, check_sorted
from tests.ir.text.dae import dae_text

TEXT = "w = der(phi)\ny = L*cos(phi)\nL*der(w) + g*sin(phi) = 0\n"
SOURCE = Source("models/pendulum.pmo", TEXT)


def _span(line: int) -> Span:
    lines = TEXT.split("\n")
    start = sum(len(t) + 1 for t in lines[: line - 1])
    return Span(SOURCE, start, start + len(lines[line - 1]))


def _model() -> SortedDae:
    t = Exprs()
    phi, length, g = t.symbol("phi"), t.symbol("L"), t.symbol("g")
    w, z = t.der(phi), t.der(t.der(phi))
    law = t.add(t.mul(length, z), t.mul(g, t.call("sin", phi)))
    y = t.mul(length, t.call("cos", phi))
    dae = Dae(
        name="Pendulum",
        table=t,
        variables=(
            Variable("phi", start=t.const(0.5), fixed=True, span=_span(1)),
            Variable("w", state_select=StateSelect.PREFER, span=_span(1)),
            Variable("y", span=_span(2)),
        ),
        parameters=(
            Parameter("L", Kind.REAL, t.const(2), settable=True),
            Parameter("g", Kind.REAL, t.const(9.81), settable=False, constant=True),
        ),
        equations=(
            Equation(t.symbol("w"), w, _span(1)),
            Equation(t.symbol("y"), y, _span(2)),
            Equation(law, t.zero, _span(3)),
        ),
    )
    select = StateSelect.PREFER
    return SortedDae(
        dae=dae,
        equations=tuple(SourceEquation(e) for e in dae.equations),
        aliases=(Alias("w", w, 1, 0),),
        levels=(
            Level(2, (Block((phi,)),)),
            Level(1, (Block((w,)),)),
            Level(0, (Assignment(t.symbol("y"), y, 1), Block((z,), (), (Residual(law, 2),), True))),
        ),
        candidates=(
            Candidate(phi, "phi", StateSelect.DEFAULT, t.const(0.5), True, True, None, _span(1)),
            Candidate(w, "w", select, None, False, False, None, _span(1)),
        ),
        fixed=(Fixed(t.symbol("y"), t.one, "y", _span(2)),),
        equations_before=3,
        equations_after=2,
    )


EXPECTED = """\
model Pendulum
  3 equations, 2 after the elimination of 1 variable (1 alias, 0 constants)
  0 derivatives of equations added to lower the index
  2 states of 2 candidates

candidates for states
  phi  (start 0.5, fixed)  // pendulum.pmo:1
  w = der(phi)  (prefer)  // pendulum.pmo:1

level 2 below the top
  state phi

level 1 below the top
  state der(phi)

top level
  y := L*cos(phi)  // pendulum.pmo:2
  linear block, tears der(der(phi)) (1 residual)
    0 = L*der(der(phi)) + g*sin(phi)  // pendulum.pmo:3

at the start
  y = 1  // pendulum.pmo:2

aliases
  w = der(phi)
"""


def test_the_printer_shows_all_of_it() -> None:
    assert sorted_text(_model(), aliases=True) == EXPECTED


def test_a_sound_model_passes() -> None:
    check_sorted(_model())


def _broken(model: SortedDae, message: str) -> None:
    with pytest.raises(BrokenPromise, match=message):
        check_sorted(model)


def test_an_unknown_that_is_computed_twice() -> None:
    model = _model()
    low, middle, top = model.levels
    again = replace(top, steps=(*top.steps, top.steps[0]))
    _broken(replace(model, levels=(low, middle, again)), "y is computed twice")


def test_a_value_that_is_used_too_early() -> None:
    model = _model()
    low, middle, top = model.levels
    t = model.dae.table
    early = Assignment(t.symbol("y"), t.symbol("phi", 2), 1)
    top = replace(top, steps=(early, top.steps[1]))
    _broken(replace(model, levels=(low, middle, top)), "y needs .*der.*, not known yet")


def test_a_variable_that_is_forgotten() -> None:
    model = _model()
    low, middle, top = model.levels
    top = replace(top, steps=top.steps[1:])
    _broken(replace(model, levels=(low, middle, top)), "variable y is neither")


def test_a_top_block_with_too_few_residuals() -> None:
    model = _model()
    low, middle, top = model.levels
    block = top.steps[1]
    assert isinstance(block, Block)
    top = replace(top, steps=(top.steps[0], replace(block, residuals=())))
    _broken(replace(model, levels=(low, middle, top)), "at height 0 has 0 residuals")


def test_candidates_that_are_not_the_tears() -> None:
    model = _model()
    _broken(replace(model, candidates=model.candidates[:1]), "candidates are not the tears")


def test_a_candidate_whose_derivative_is_unknown() -> None:
    model = _model()
    low, _, _ = model.levels
    _broken(
        replace(model, levels=(low,), candidates=model.candidates[:1]),
        "the derivative of the candidate phi is not known",
    )


def test_an_alias_of_an_alias() -> None:
    model = _model()
    t = model.dae.table
    _broken(
        replace(model, aliases=(*model.aliases, Alias("v", t.symbol("w"), 2))),
        "alias v has the sign 2\nalias v is w, an alias again",
    )


def test_the_scalar_model_is_printed_with_its_events() -> None:
    base = _model().dae
    t = base.table
    phi = t.symbol("phi")
    dae = replace(
        base,
        discretes=(Variable("hit", Kind.BOOLEAN),),
        discrete_equations=(Equation(t.symbol("hit"), t.event(0)),),
        relations=(Relation(phi, True, False, "phi < 0"),),
        whens=(
            When(
                (
                    (
                        "hit",
                        (
                            Reinit(t.der(phi), t.neg(t.der(phi))),
                            SetDiscrete("n", t.add(t.pre("n"), t.one)),
                            Terminate(Message(("at ", (t.time, "")))),
                        ),
                    ),
                )
            ),
        ),
        assertions=(Assertion(t.less(phi, t.one), Message(("too far",))),),
    )
    assert dae_text(dae) == (
        "model Pendulum\n"
        "  parameter Real L = 2\n"
        "  constant Real g = 9.81\n"
        "variables\n"
        "  Real phi(start=0.5, fixed=true)  // pendulum.pmo:1\n"
        "  Real w(stateSelect=prefer)  // pendulum.pmo:1\n"
        "  Real y  // pendulum.pmo:2\n"
        "discrete variables\n"
        "  Boolean hit\n"
        "equations\n"
        "  w = der(phi)  // pendulum.pmo:1\n"
        "  y = L*cos(phi)  // pendulum.pmo:2\n"
        "  L*der(der(phi)) + g*sin(phi) = 0  // pendulum.pmo:3\n"
        "discrete equations\n"
        "  hit = event[0]\n"
        "relations\n"
        "  event[0]: phi < 0: phi < 0\n"
        "when hit\n"
        "  reinit(der(phi), -der(phi))\n"
        "  n := pre(n) + 1\n"
        '  terminate("at " + String(time))\n'
        "assertions\n"
        "  phi < 1\n"
    )
