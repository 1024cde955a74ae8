"""A mechanism begins, and moves, as the same one of another size does."""

from __future__ import annotations

import math
import re
from functools import cache

import numpy as np
import pytest

import planarc
from planarc.core.options import RunOptions
from planarc.solve import measure
from planarc.solve.opened import open_program

#: Factors to the lengths of mechanisms of about 1 m.
FACTORS = (1e-6, 1e-4, 1e-2, 100.0, 500.0, 1e4)
BACKENDS = ("native", "numpy")

#: In the models <x> stands for a length, or anything else in m, and <<x>> for one in m2.
SLIDER = """
model Slider
  import PlanarMultiBody.{Joints, Parts};
  inner PlanarMultiBody.World world(g=<0.05>);
  Joints.Revolute main(MAIN);
  Parts.BodyShape crank(r={<0.3>, 0}, m=1.2, I=<<0.009>>);
  Joints.Revolute bigEnd;
  Parts.BodyShape rod(r={<0.8>, 0}, r_CM={<0.35>, 0}, m=2, I=<<0.1>>);
  Joints.Revolute smallEnd;
  Parts.Body slider(m=1.5);
  Joints.Prismatic slide(n={1, 0}SLIDE);
equation
  connect(world.frame_b, main.frame_a);
  connect(main.frame_b, crank.frame_a);
  connect(crank.frame_b, bigEnd.frame_a);
  connect(bigEnd.frame_b, rod.frame_a);
  connect(rod.frame_b, smallEnd.frame_a);
  connect(smallEnd.frame_b, slider.frame_a);
  connect(slide.frame_b, slider.frame_a);
  connect(world.frame_b, slide.frame_a);
end Slider;
"""

FOUR_BAR = """
model FourBar
  import PlanarMultiBody.{Joints, Parts};
  inner PlanarMultiBody.World world(g=<0.05>);
  Parts.Fixed ground(r={<1>, 0});
  Joints.Revolute revA(phi(start=1, fixed=true), w(start=1, fixed=true));
  Joints.Revolute revB;
  Joints.Revolute revC;
  Joints.Revolute revD(D);
  Parts.BodyShape crank(r={<0.4>, 0}, m=1, I=<<0.0134>>);
  Parts.BodyShape coupler(r={<0.9>, 0}, m=2, I=<<0.14>>);
  Parts.BodyShape rocker(r={<0.8>, 0}, m=1.5, I=<<0.08>>);
equation
  connect(world.frame_b, revA.frame_a);
  connect(revA.frame_b, crank.frame_a);
  connect(crank.frame_b, revB.frame_a);
  connect(revB.frame_b, coupler.frame_a);
  connect(coupler.frame_b, revC.frame_a);
  connect(ground.frame_b, revD.frame_a);
  connect(revD.frame_b, rocker.frame_a);
  connect(rocker.frame_b, revC.frame_b);
end FourBar;
"""

#: The ends of a bar of 1 slide along x and y.
TRAMMEL = """
model Trammel
  import PlanarMultiBody.{Joints, Parts};
  inner PlanarMultiBody.World world(g=<0.05>);
  Joints.Prismatic px(n={1, 0}, s(start=<0.6>, fixed=true), v(start=<0.3>, fixed=true));
  Joints.Prismatic py(n={0, 1}, s(start=<0.5>));
  Joints.Revolute r1;
  Joints.Revolute r2;
  Parts.BodyShape bar(r={<1>, 0}, m=1, I=<<0.1>>);
equation
  connect(world.frame_b, px.frame_a);
  connect(world.frame_b, py.frame_a);
  connect(px.frame_b, r1.frame_a);
  connect(r1.frame_b, bar.frame_a);
  connect(bar.frame_b, r2.frame_a);
  connect(py.frame_b, r2.frame_b);
end Trammel;
"""

#: A condition of m2, and the place of a free body.
BOB = """
model Bob
  import PlanarMultiBody.{Joints, Parts};
  inner PlanarMultiBody.World world(g=<0.05>);
  Parts.Body bob(m=1, I=<<0.01>>, r(start={<0.6>, <-0.5>}, fixed={true, false}),
    v(start={<0.3>, 0}, fixed={true, false}));
  Joints.JointRRWithMass rod(L=<1>, m=0.1);
equation
  connect(world.frame_b, rod.frame_a);
  connect(rod.frame_b, bob.frame_a);
end Bob;
"""

#: Three parallel bars, of which the third one has a length of its own.
PARALLEL = """
model Parallel
  import PlanarMultiBody.{Joints, Parts};
  parameter Real odd=1;
  inner PlanarMultiBody.World world(g=<0.05>);
  Parts.Fixed ground[3](r={{0, 0}, {<0.4>, 0}, {<1>, 0}});
  Joints.Revolute low[3](phi(start={1.2, 1.1, 1.1}, fixed={true, false, false}));
  Joints.Revolute high[3];
  Parts.BodyShape bar[3](r={{<0.5>, 0}, {<0.5>*odd, 0}, {<0.5>, 0}}, each m=1, each I=<<0.01>>);
  Parts.FixedTranslation top[2](r={{<0.4>, 0}, {<0.6>, 0}});
equation
  for i in 1:3 loop
    connect(ground[i].frame_b, low[i].frame_a);
    connect(low[i].frame_b, bar[i].frame_a);
    connect(bar[i].frame_b, high[i].frame_a);
  end for;
  connect(high[1].frame_b, top[1].frame_a);
  connect(top[1].frame_b, top[2].frame_a);
  connect(high[2].frame_b, top[1].frame_b);
  connect(high[3].frame_b, top[2].frame_b);
end Parallel;
"""


def sized(text: str) -> str:
    """The model with a parameter `k` by which all its lengths are multiplied."""
    text = re.sub(r"<<(.*?)>>", r"(\1)*k^2", text)
    text = re.sub(r"<(.*?)>", r"(\1)*k", text)
    return text.replace("  import", "  parameter Real k=1;\n  import")


@cache
def model(text: str, backend: str = "native") -> planarc.Model:
    return planarc.load(sized(text), backend=backend)


def begin(text: str, factor: float, backend: str = "native") -> planarc.Result:
    return model(text, backend).simulate(0, parameters={"k": factor})


def slider(main: str, slide: str) -> str:
    slide = slide and f", {slide}"
    return SLIDER.replace("MAIN", main).replace("SLIDE", slide)


HELD = "phi(start=2, fixed=true), w(start=1, fixed=true)"


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize(
    ("slide", "side"),
    [("", 1), ("s(start=<2>)", 1), ("s(start=<-0.9>)", -1)],
)
def test_a_slider_crank_closes_on_its_side(
    factor: float, slide: str, side: int, backend: str
) -> None:
    found = begin(slider(HELD, slide), factor, backend)
    x, y = 0.3 * math.cos(2), 0.3 * math.sin(2)
    s = x + side * math.sqrt(0.8**2 - y**2)
    assert found["slide.s"][0] == pytest.approx(s * factor, rel=1e-9)
    assert math.cos(found["bigEnd.phi"][0] + 2) == pytest.approx((s - x) / 0.8, abs=1e-9)
    v = -y - side * x * y / math.sqrt(0.8**2 - y**2)
    assert found["slide.v"][0] == pytest.approx(v * factor, rel=1e-9)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("factor", FACTORS)
def test_a_place_and_a_speed_that_are_written_are_held(factor: float, backend: str) -> None:
    held = "s(start=<0.7>, fixed=true), v(start=<-0.5>, fixed=true)"
    found = begin(slider("", held), factor, backend)
    assert found["slide.s"][0] == pytest.approx(0.7 * factor, rel=1e-12)
    assert found["slide.v"][0] == pytest.approx(-0.5 * factor, rel=1e-12)
    phi = float(found["main.phi"][0])
    assert math.cos(phi) == pytest.approx((0.7**2 + 0.3**2 - 0.8**2) / (2 * 0.7 * 0.3), abs=1e-9)
    # v*(s - a*cos(phi)) = -a*s*sin(phi)*w
    w = -0.5 * (0.7 - 0.3 * math.cos(phi)) / (-0.3 * 0.7 * math.sin(phi))
    assert found["main.w"][0] == pytest.approx(w, rel=1e-9)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize(("rocker", "side"), [("phi(start=1)", 1), ("phi(start=-2)", -1)])
def test_a_four_bar_closes_on_its_side(factor: float, rocker: str, side: int, backend: str) -> None:
    found = begin(FOUR_BAR.replace("D);", f"{rocker});"), factor, backend)
    bx, by = 0.4 * math.cos(1), 0.4 * math.sin(1)
    r, beside = math.hypot(1 - bx, by), math.atan2(-by, 1 - bx)
    coupler = beside + side * math.acos((0.9**2 + r * r - 0.8**2) / (2 * 0.9 * r))
    cx, cy = bx + 0.9 * math.cos(coupler), by + 0.9 * math.sin(coupler)
    assert found["revD.phi"][0] == pytest.approx(math.atan2(cy, cx - 1), abs=1e-9)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("factor", FACTORS)
def test_a_trammel_is_no_dead_centre(factor: float, backend: str) -> None:
    found = begin(TRAMMEL, factor, backend)
    assert found["py.s"][0] == pytest.approx(0.8 * factor, rel=1e-9)
    assert found["py.v"][0] == pytest.approx(-0.3 * 0.6 / 0.8 * factor, rel=1e-9)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("factor", FACTORS)
def test_a_condition_between_squares_holds_what_one_between_lengths_does(
    factor: float, backend: str
) -> None:
    found = begin(BOB, factor, backend)
    assert found["bob.r[2]"][0] == pytest.approx(-0.8 * factor, rel=1e-9)
    assert found["bob.v[2]"][0] == pytest.approx(0.225 * factor, rel=1e-9)
    assert found["bob.phi"][0] == 0.0


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize(
    "text",
    [
        slider("phi(start=1)", "s(start=<0.7>), v(start=<-0.5>)"),
        slider("", "s(start=<0.7>, fixed=true), v(start=<-0.5>, fixed=true)"),
        FOUR_BAR.replace("D);", ");"),
        TRAMMEL,
        BOB,
    ],
    ids=["guesses", "slider", "four-bar", "trammel", "bob"],
)
def test_the_same_starts_are_held_and_the_motion_is_the_same(text: str, factor: float) -> None:
    one, other = (
        model(text).simulate(0.5, intervals=20, tolerance=1e-8, parameters={"k": k})
        for k in (1.0, factor)
    )
    assert [(h.name, h.held) for h in other.start] == [(h.name, h.held) for h in one.start]
    for name in one.names:
        size = {"phi": 1.0, "w": 1.0, "s": factor, "v": factor}.get(name.rpartition(".")[2])
        if size is not None:
            assert np.allclose(other[name] / size, one[name], rtol=1e-4, atol=1e-4), name


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize(
    ("text", "code", "told"),
    [
        (slider("", "s(start=<1.5>, fixed=true)"), "R412", "stay {:g} m apart"),
        (slider("", "s(start=<1.1>, fixed=true), v(start=<0.5>, fixed=true)"), "R428", ""),
    ],
)
def test_what_cannot_begin_is_told_in_metres(
    text: str, code: str, told: str, factor: float
) -> None:
    with pytest.raises(planarc.PlanarcError) as caught:
        begin(text, factor)
    (found,) = caught.value.diagnostics
    assert found.code == code
    assert told.format(0.4 * factor) in found.message


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("factor", FACTORS)
def test_a_length_that_is_declared_without_its_unit_is_held(factor: float, backend: str) -> None:
    text = slider("", "").replace(
        "equation", "  Real twice(start=<1.4>, fixed=true) = 2*slide.s;\nequation"
    )
    found = begin(text, factor, backend)
    assert found["slide.s"][0] == pytest.approx(0.7 * factor, rel=1e-9)


@pytest.mark.parametrize("factor", FACTORS)
def test_redundant_bars_fit_or_do_not_as_those_of_a_metre_do(factor: float) -> None:
    loaded = planarc.load(sized(PARALLEL), redundant="accept")
    found = loaded.simulate(0, parameters={"k": factor})
    assert found["low[2].phi"][0] == pytest.approx(1.2, abs=1e-9)
    with pytest.raises(planarc.PlanarcError, match="nothing can move"):
        loaded.simulate(0, parameters={"k": factor, "odd": 0.94})


# The measure itself


def length_of(text: str, factor: float = 1.0) -> float:
    loaded = model(text)
    kernel = loaded.compiled().load()
    open_program(loaded.program, kernel, RunOptions(values={"k": factor}))
    return measure.length_of(loaded.program, kernel)


@pytest.mark.parametrize("factor", [0.5, 1.0, 2.0, 4.0])
def test_about_a_metre_is_measured_in_metres(factor: float) -> None:
    assert length_of(slider(HELD, ""), factor) == 1.0


@pytest.mark.parametrize("factor", FACTORS)
def test_others_are_measured_by_a_power_of_two(factor: float) -> None:
    found = length_of(slider(HELD, ""), factor)
    assert math.frexp(found)[0] == 0.5
    assert 0.5 < 0.8 * factor / found < 2.0


def test_neither_the_place_of_a_bearing_counts_nor_a_length_beyond_all_others() -> None:
    text = FOUR_BAR.replace("D);", ");")
    assert length_of(text.replace("<1>", "<1000>")) == 1.0
    assert length_of(text.replace("<0.9>", "<1e6>")) == 1.0


def test_rows_are_measured_by_what_they_compare() -> None:
    program = model(BOB).program
    assert measure.sizes_of_rows(program, 0.5).tolist() == [0.25, 0.25]
    assert measure.sizes_of_candidates(program, 0.5).tolist() == [0.5, 0.5, 1.0] * 2
    program = model(slider(HELD, "")).program
    assert measure.sizes_of_rows(program, 0.5).tolist() == [0.5] * 4


def test_errors_of_lengths_and_speeds_alone_are_measured_so() -> None:
    text = slider(HELD, "").replace(
        "equation",
        """  Real u(unit="V", start=1, fixed=true);
  Modelica.Units.SI.Position x(start=<0.1>, fixed=true);
equation
  der(u) = -u;
  der(x) = -x;""",
    )
    program = model(text).program
    units = {c.slot: c.unit for c in program.columns if c.unit}
    slots = [c.slot for c in program.candidates]
    sizes = measure.sizes_of_errors(program, 0.5, slots)
    found = {(units[slot], size) for slot, size in zip(slots, sizes, strict=True)}
    assert found == {("rad", 1.0), ("rad/s", 1.0), ("m", 0.5), ("m/s", 0.5), ("V", 1.0)}
