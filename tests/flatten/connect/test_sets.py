"""Connections over the whole hierarchy become sets and equations."""

from __future__ import annotations

from collections.abc import Callable

from planarc.ir import flat
from planarc.ir.text.flat import print_expression

Flatten = Callable[..., flat.FlatModel]

PIN = "connector Pin Real v; flow Real i; end Pin;"
RESISTOR = PIN + (
    "model R parameter Real R = 1; Pin p; Pin n; equation p.v - n.v = R*p.i; p.i + n.i = 0; end R;"
)


def test_parts_and_connection_sets(flatten_text: Flatten) -> None:
    model = flatten_text(
        RESISTOR
        + """
        model T
          R a; R b[2];
        equation
          connect(a.n, b[1].p); connect(b[1].n, b[2].p); connect(b[1].p, b[2].n);
        end T;
        """
    )
    assert [(p.name, p.class_name) for p in model.parts if "." not in p.name] == [
        ("a", "R"),
        ("b[1]", "R"),
        ("b[2]", "R"),
    ]
    assert model.connections == (("a.n", "b[1].p", "b[2].n"), ("b[1].n", "b[2].p"))


def test_flows_into_a_node_sum_to_zero_and_a_lone_one_is_zero(flatten_text: Flatten) -> None:
    model = flatten_text(RESISTOR + "model T R a; R b; equation connect(a.n, b.p); end T;")
    sides = (
        f"{print_expression(e.left)} = {print_expression(e.right)}"
        for e in model.equations
        if isinstance(e, flat.Equality) and e.generated and not isinstance(e.left, flat.Targets)
    )
    assert sorted(sides) == [
        "'a.n.i' + 'b.p.i' = 0",
        "'a.n.v' = 'b.p.v'",
        "'a.p.i' = 0",
        "'b.n.i' = 0",
    ]
