"""Joints that constrain the same motion twice are named, and singular positions told from them."""

from __future__ import annotations

import numpy as np
import pytest

import planarc
from planarc.solve.start import redundancy

PARALLELOGRAM = """
model Parallelogram "Two or three parallel bars of 0.5 m under a beam of 2 m"
  import PlanarMultiBody.Joints.Revolute;
  import PlanarMultiBody.Parts;
  inner PlanarMultiBody.World world;
  Parts.Fixed groundA(r={{0, 0}});
  Parts.Fixed groundB(r={{1, 0}});
  Parts.Fixed groundC(r={{2, 0}});
  Parts.FixedTranslation barA(r={{0.5, 0}});
  Parts.FixedTranslation barB(r={{0.5, 0}});
  Parts.FixedTranslation barC(r={{{third}, 0}});
  Parts.FixedTranslation left(r={{1, 0}});
  Parts.FixedTranslation right(r={{1, 0}});
  Parts.Body body(m=2, I=0.1);
  Revolute lowA(phi(start={angle}, fixed=true), w(start=0, fixed=true));
  Revolute lowB(phi(start={angle}));
  Revolute highA(phi(start=-({angle})));
  Revolute highB(phi(start=-({angle})));
  Revolute lowC(phi(start={angle}));
  Revolute highC(phi(start=-({angle})));
equation
  connect(groundA.frame_b, lowA.frame_a);
  connect(lowA.frame_b, barA.frame_a);
  connect(barA.frame_b, highA.frame_a);
  connect(groundB.frame_b, lowB.frame_a);
  connect(lowB.frame_b, barB.frame_a);
  connect(barB.frame_b, highB.frame_a);
  connect(groundC.frame_b, lowC.frame_a);
  connect(lowC.frame_b, barC.frame_a);
  connect(barC.frame_b, highC.frame_a);
  connect(highA.frame_b, left.frame_a);
  connect(left.frame_b, highB.frame_b);
  connect(left.frame_b, right.frame_a);
  connect(right.frame_b, highC.frame_b);
  connect(left.frame_a, body.frame_a);
end Parallelogram;
"""


def parallelogram(third: float, angle: float, more: bool) -> planarc.Model:
    lines = PARALLELOGRAM.format(third=third, angle=angle).splitlines()
    third_bar = ("lowC", "highC", "barC")
    kept = [line for line in lines if more or not any(name in line for name in third_bar)]
    return planarc.load("\n".join(kept))


@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_a_third_parallel_bar_is_recognised_and_its_joints_named(backend: str) -> None:
    if backend == "native":
        pytest.importorskip("llvmlite")
    with pytest.raises(planarc.PlanarcError) as caught:
        parallelogram(0.5, 1.0, True).simulate(0, backend=backend)
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "R415"
    for joint in ("lowA", "lowB", "lowC", "highA", "highB", "highC"):
        assert f"`{joint}`" in diagnostic.message
    assert diagnostic.span is not None
    assert diagnostic.hint is not None


@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_a_third_parallel_rod_is_recognised_though_forces_have_no_solution(backend: str) -> None:
    """The start values are those of an assembled place, with no angle to hold."""
    if backend == "native":
        pytest.importorskip("llvmlite")
    text = """
    model Stand
      import PlanarMultiBody.{Joints, Parts};
      inner PlanarMultiBody.World world;
      Parts.Fixed ground[3](r={{0, 0}, {1, 0}, {2, 0}});
      Joints.JointRR leg[3](each L=1);
      Parts.FixedTranslation left(r={1, 0}), right(r={1, 0});
      Parts.Body plate(m=5, I=1, r_CM={1, 0}, r(start={0.6, 0.8}), phi(start=0));
    equation
      connect(ground.frame_b, leg.frame_a);
      connect(leg[1].frame_b, plate.frame_a);
      connect(plate.frame_a, left.frame_a);
      connect(left.frame_b, leg[2].frame_b);
      connect(left.frame_b, right.frame_a);
      connect(right.frame_b, leg[3].frame_b);
    end Stand;"""
    with pytest.raises(planarc.PlanarcError) as caught:
        planarc.load(text).simulate(0, backend=backend)
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "R415"
    assert all(f"`leg[{i}]`" in diagnostic.message for i in (1, 2, 3))


def test_two_parallel_bars_are_none_too_many() -> None:
    run = parallelogram(0.5, 1.0, False).simulate(0)
    assert run["highB.phi"][0] == pytest.approx(-1.0, abs=1e-7)


def test_bars_that_lie_flat_are_none_too_many_either() -> None:
    """Their conditions are dependent for the moment only: see `test_flat`."""
    with pytest.raises(planarc.PlanarcError) as caught:
        parallelogram(0.5, 0.0, False).simulate(0)
    assert caught.value.diagnostics[0].code == "R437"


def test_a_third_bar_of_another_length_is_a_truss_without_motion() -> None:
    """It takes the last freedom away instead of repeating a constraint."""
    with pytest.raises(planarc.PlanarcError) as caught:
        parallelogram(0.6, 1.0, True).simulate(0)
    assert caught.value.diagnostics[0].code != "R415"


def test_two_sliders_side_by_side_are_named_before_they_run() -> None:
    text = """
    model Twice
      inner PlanarMultiBody.World world;
      PlanarMultiBody.Parts.Fixed ground;
      PlanarMultiBody.Parts.Body body(m=2, I=0.1);
      PlanarMultiBody.Joints.Prismatic a(n={0, 1}, s(start=1));
      PlanarMultiBody.Joints.Prismatic b(n={0, 1});
    equation
      connect(ground.frame_b, a.frame_a);
      connect(ground.frame_b, b.frame_a);
      connect(a.frame_b, body.frame_a);
      connect(b.frame_b, body.frame_a);
    end Twice;
    """
    with pytest.raises(planarc.PlanarcError) as caught:
        planarc.load(text).simulate(0)
    (diagnostic,) = caught.value.diagnostics
    assert "`a` and `b` hold the same motion twice" in diagnostic.message
    assert diagnostic.hint is not None
    assert "freer joint" in diagnostic.hint


@pytest.mark.parametrize("exponent", range(-9, 1))
def test_rows_said_to_be_independent_have_no_suspect_singular_value(exponent: int) -> None:
    random = np.random.default_rng(exponent + 9)
    said = []
    for m in range(1, redundancy.SMALL + 1):
        for size in (1e-3, 1.0, 1e3):
            rows = random.normal(size=(m, m + 1))
            rows[-1] = rows[0] + 10.0**exponent * rows[-1] if m > 1 else rows[-1]
            plain = redundancy._are_independent((size * rows).tolist())
            said.append(plain)
            if plain:
                assert redundancy._sizes(size * rows)[-1] >= redundancy.SUSPECT
    assert any(said) and (exponent > -6 or not all(said))
    assert not redundancy._are_independent([[1.0, 2.0, np.nan], [0.0, 1.0, 0.0]])
    assert not redundancy._are_independent([[0.0, 0.0]])
