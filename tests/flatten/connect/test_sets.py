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


OUTER = (
    PIN
    + """
    model S Pin c; equation c.v = 5; end S;
    model L Pin c; equation c.i = c.v; end L;
    model Source outer Pin bus; S s; equation connect(s.c, bus); end Source;
    model Load outer Pin bus; L l; equation connect(l.c, bus); end Load;
    model Reader outer Pin bus; Real v = bus.v; end Reader;
    """
)


def flow_sums(model: flat.FlatModel) -> list[str]:
    """The sums of flows, without those of ends that nothing is connected to."""
    sums = (
        print_expression(e.left)
        for e in model.equations
        if isinstance(e, flat.Equality) and e.generated and not isinstance(e.left, flat.Targets)
    )
    return sorted(s for s in sums if ".i'" in s)


def test_an_outer_connector_is_the_inner_one_seen_from_its_own_class(flatten_text: Flatten) -> None:
    model = flatten_text(
        OUTER
        + """
        model System
          inner Pin bus; Source a; Load b; L l;
        equation
          connect(l.c, bus);
        end System;
        model T System s; L l; equation connect(s.bus, l.c); end T;
        """
    )
    assert flow_sums(model) == [
        "'s.bus.i' + 'l.c.i'",
        "'s.l.c.i' + 's.a.s.c.i' + 's.b.l.c.i' - 's.bus.i'",
    ]


def test_an_inner_connector_that_only_outer_ones_meet(flatten_text: Flatten) -> None:
    model = flatten_text(OUTER + "model T inner Pin bus; Source a; Load b; end T;")
    assert flow_sums(model) == ["'a.s.c.i' + 'b.l.c.i' - 'bus.i'", "'bus.i'"]


def test_the_outer_connector_of_a_part_is_that_of_the_class_around(flatten_text: Flatten) -> None:
    text = "model T inner Pin bus; Source a; Reader r[2]; L l; equation connect({}, l.c); end T;"
    for name in ("bus", "r[2].bus", "a.bus"):
        model = flatten_text(OUTER + text.format(name))
        assert flow_sums(model) == ["'bus.i'", "'l.c.i' + 'a.s.c.i' - 'bus.i'"], name
