"""Prefixes, drawings and places come from the instances to the flat model."""

from __future__ import annotations

from collections.abc import Callable

from planarc.ir import flat
from planarc.ir.text.flat import print_expression

Flatten = Callable[..., flat.FlatModel]


def test_final_and_protected_are_kept(flatten_text: Flatten) -> None:
    model = flatten_text(
        """
        model M parameter Real p = 1; protected Real hidden = p; end M;
        model T M m(final p=2); final parameter Real q = 1; end T;
        """
    )
    assert {v.name for v in model.variables if v.final} == {"m.p", "q"}
    assert {v.name for v in model.variables if v.protected} == {"m.hidden"}


def test_visuals_hold_expressions_in_the_models_variables(flatten_text: Flatten) -> None:
    model = flatten_text(
        """
        model Shape
          input Real length = 1;
          Real twice = 2*length;
          parameter String kind = "box";
          annotation(__planarc(visual="shape"));
        end Shape;
        model Part
          parameter Boolean animation = true;
          parameter Real L = 2;
          Real x = time;
          Shape shape(length=L + x) if animation;
        end Part;
        model T Part a(L=3); Part b(animation=false); end T;
        """
    )
    assert [(v.component, v.kind) for v in model.visuals] == [("a.shape", "shape")]
    shown = {name: print_expression(e) for name, e in model.visuals[0].attributes}
    assert shown == {"length": "'a.L' + 'a.x'", "twice": "2 * ('a.L' + 'a.x')", "kind": '"box"'}
    assert not any(v.name.startswith("a.shape") for v in model.variables)


def test_every_equation_knows_its_component_and_place(flatten_text: Flatten) -> None:
    text = "model M\n  Real x;\nequation\n  x = 1;\nend M;\nmodel T\n  M m;\nend T;\n"
    (equation,) = flatten_text(text).equations
    assert (equation.component, equation.span.line) == ("m", 4)
