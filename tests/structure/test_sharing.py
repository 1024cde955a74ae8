"""Forces that equations leave open: least squares by hand, and what is refused."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from planarc.codegen.numpy.printer import source
from planarc.codegen.pipeline import generate
from planarc.core.diagnostic import PlanarcError
from planarc.ir.dae import Dae
from planarc.solve.kernels.numpy.kernel import NumpyKernel
from planarc.structure.pipeline import structure
from planarc.structure.sharing import share_forces, surplus_equations
from tests.ir.check.sorted import check_sorted

Maker = Callable[..., Dae]


def solved(dae: Dae, forces: list[str]) -> dict[str, float]:
    """The values of all variables of a model without states."""
    shared = share_forces(dae, forces)
    model = structure(shared.dae)
    check_sorted(model)
    program = generate(model)
    kernel = NumpyKernel(program, source(program))
    assert kernel.parameters() == 0
    assert kernel.outputs(0.0, []) == 0
    return {c.name: c.sign * kernel.w[c.slot] for c in program.columns}


def test_two_rods_side_by_side_share_a_load(make: Maker) -> None:
    dae = make("a + b = p", p=6.0)
    assert share_forces(dae, ["a", "b"]).open == 1
    found = solved(dae, ["a", "b"])
    assert (found["a"], found["b"]) == pytest.approx((3.0, 3.0))


def test_a_force_at_two_frames_counts_twice(make: Maker) -> None:
    # 2*a^2 + b^2 is least with a + b = 6 where 2*a = b.
    found = solved(make("a + b = p", "c = -a", p=6.0), ["a", "b", "c"])
    assert (found["a"], found["b"]) == pytest.approx((2.0, 4.0))


def test_a_beam_on_four_supports_is_shared_as_by_the_pseudo_inverse(make: Maker) -> None:
    names = ["a", "b", "c", "d"]
    dae = make("a + b + c + d = p", "b*1.0 + c*2.5 + d*x = 0.7*p", p=6.0, x=4.0)
    assert share_forces(dae, names).open == 2
    matrix = np.array([[1, 1, 1, 1], [0, 1, 2.5, 4.0]])
    expected = np.linalg.pinv(matrix) @ [6.0, 4.2]
    found = solved(dae, names)
    np.testing.assert_allclose([found[n] for n in names], expected, rtol=1e-12)


@pytest.mark.parametrize("turn", range(4))
def test_the_order_of_equations_and_unknowns_does_not_matter(make: Maker, turn: int) -> None:
    lines = ["a + b + c = p", "m*z = 2*a - c", "y = z*b", "z = 1"]
    names = ["a", "b", "c"]
    first = solved(make(*lines, p=6.0, m=0.4), names)
    other = solved(make(*lines[turn:], *lines[:turn], p=6.0, m=0.4), names[::-1])
    assert other == pytest.approx({n: first[n] for n in other}, rel=1e-12)


def test_what_the_equations_determine_stays(make: Maker) -> None:
    """The acceleration of a mass that two open forces hold up together with a third."""
    found = solved(make("a + b - m*g = m*z", "a + b = 3*c", "c = 2", m=2.0, g=9.81), ["a", "b"])
    assert found["z"] == pytest.approx(6 / 2 - 9.81)
    assert found["a"] == pytest.approx(3.0)


def test_where_nothing_is_open_the_model_is_as_it_was(make: Maker) -> None:
    dae = make("a + b = p", "a - b = 1", p=6.0)
    shared = share_forces(dae, ["a", "b"])
    assert shared.dae is dae
    assert shared.open == 0


def test_what_is_no_force_is_not_made_up(make: Maker) -> None:
    dae = make("x + y = p", "f = 2*x", p=6.0)
    assert share_forces(dae, []).dae is dae
    with pytest.raises(PlanarcError) as caught:
        structure(share_forces(dae, []).dae)
    assert caught.value.diagnostics[0].code == "S303"


def test_an_open_force_in_a_curved_equation_is_refused_with_its_name(make: Maker) -> None:
    dae = make("a + b = p", "r = a*b", "m*z = r", p=6.0, m=1.0)
    with pytest.raises(PlanarcError) as caught:
        share_forces(dae, ["a", "b"])
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "S316"
    assert diagnostic.span is not None
    assert "`r = a * b`" in diagnostic.message.replace("*", " * ").replace("  ", " ")


def test_an_equation_without_an_unknown_of_its_own_is_surplus(make: Maker) -> None:
    lines = ["x*x*x + x = p", "y = x*x + p", "sin(y) = x", "a + b = x"]
    surplus = surplus_equations(make(*lines, p=6.0))
    assert len(surplus) == 1
    assert surplus[0] in (0, 1, 2)
    assert surplus_equations(make(*lines[:2], "a = x", p=6.0)) == ()


@pytest.mark.parametrize("order", [[0, 1, 2], [2, 0, 1], [1, 2, 0]], ids=str)
def test_a_balance_of_forces_is_not_surplus(make: Maker, order: list[int]) -> None:
    lines = ["x*x + x = p", "cos(x) = y", "sin(y) = f + x"]  # f is given besides
    dae = make(*(lines[i] for i in order), "f = x*y", p=6.0)
    components = {e.component for e in dae.equations}
    (surplus,) = surplus_equations(dae, components, {"f"})
    assert "f" not in dae.equations[surplus].shown


def test_the_bias_moves_the_open_forces_and_nothing_else(make: Maker) -> None:
    dae = make("a + b = p", "c = a + b", p=6.0)
    program = generate(structure(share_forces(dae, ["a", "b"]).dae))
    kernel: Any = NumpyKernel(program, source(program))
    values = []
    for bias in (0.0, 1.0):
        kernel.w[program.slots["$sharing"]] = bias
        kernel.parameters()
        kernel.outputs(0.0, [])
        values.append({c.name: c.sign * kernel.w[c.slot] for c in program.columns})
    assert values[0]["c"] == pytest.approx(values[1]["c"])
    assert abs(values[0]["a"] - values[1]["a"]) > 0.1
