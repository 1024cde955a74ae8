"""Any joint's start value counts, whichever coordinates the structure chose as candidates."""

from __future__ import annotations

import itertools
import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import planarc
from planarc.api.model import Model
from planarc.solve.start import branch

FOUR_BAR = Path(__file__).parents[3] / "examples" / "four_bar.pmo"
JOINTS = ("revA", "revB", "revC", "revD")
ORDERS = (JOINTS, JOINTS[::-1], ("revC", "revA", "revD", "revB"))


def assembly(side: int) -> dict[str, float]:
    """The angles with the crank at 1 rad, from the triangle B, C, D."""
    bx, by = 0.4 * math.cos(1), 0.4 * math.sin(1)
    r, beside = math.hypot(1 - bx, by), math.atan2(-by, 1 - bx)
    coupler = beside + side * math.acos((0.9**2 + r * r - 0.8**2) / (2 * 0.9 * r))
    cx, cy = bx + 0.9 * math.cos(coupler), by + 0.9 * math.sin(coupler)
    rocker = math.atan2(cy, cx - 1)
    return {"revA": 1.0, "revB": coupler - 1.0, "revC": rocker - coupler, "revD": rocker}


OPEN, CROSSED = assembly(1), assembly(-1)


@cache
def model(starts: tuple[tuple[str, str], ...], order: tuple[str, ...]) -> Model:
    """The example with these modifiers and its joints declared in this order."""
    lines = FOUR_BAR.read_text(encoding="utf-8").splitlines()
    kept = [line for line in lines if not line.startswith("  Revolute rev")]
    place = kept.index("equation")
    given = dict(starts)
    hinges = [f"  Revolute {name}({given.get(name, '')});" for name in order]
    return planarc.load("\n".join([*kept[:place], *hinges, *kept[place:]]))


def positions(starts: dict[str, str], order: tuple[str, ...] = JOINTS) -> dict[str, float]:
    result = model(tuple(starts.items()), order).simulate(0)
    return {name: float(result[f"{name}.phi"][0]) for name in JOINTS}


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("joint", JOINTS)
def test_the_only_written_start_is_held_at_any_joint(joint: str, order: tuple[str, ...]) -> None:
    found = positions({joint: f"phi(start={OPEN[joint]})"}, order)
    assert found[joint] == pytest.approx(OPEN[joint], abs=1e-10)


@pytest.mark.parametrize("joint", JOINTS)
def test_the_order_of_declaration_does_not_choose_the_assembly(joint: str) -> None:
    """Only one start is written; the others' defaults say where the rest is looked for."""
    first, *others = (positions({joint: f"phi(start={OPEN[joint]})"}, o) for o in ORDERS)
    for other in others:
        assert other == pytest.approx(first, abs=1e-9)


@pytest.mark.parametrize("hint", JOINTS[1:])
@pytest.mark.parametrize("branch", ["open", "crossed"])
def test_any_joint_chooses_the_branch(branch: str, hint: str) -> None:
    wanted = OPEN if branch == "open" else CROSSED
    starts = {"revA": "phi(start=1, fixed=true)", hint: f"phi(start={wanted[hint] + 0.1})"}
    for order in ORDERS:
        assert positions(starts, order) == pytest.approx(wanted, abs=1e-9)


def test_any_pair_of_joints_gives_the_same_motion() -> None:
    """One start exactly, another roughly: where it begins, it goes."""
    runs = []
    for held, hint in itertools.islice(itertools.permutations(JOINTS, 2), 0, None, 3):
        modifiers = {
            held: f"phi(start={OPEN[held]}, fixed=true)",
            hint: f"phi(start={OPEN[hint] - 0.05})",
        }
        run = model(tuple(modifiers.items()), ORDERS[2]).simulate(0.5, intervals=10, tolerance=1e-9)
        runs.append([run[f"{n}.phi"] for n in JOINTS])
    for run_ in runs[1:]:
        assert np.allclose(run_, runs[0], atol=2e-5)


def test_a_start_given_for_a_run_counts_as_written() -> None:
    plain = model((), JOINTS)
    for name in JOINTS:
        found = plain.simulate(0, start={f"{name}.phi": OPEN[name]})
        assert found[f"{name}.phi"][0] == pytest.approx(OPEN[name], abs=1e-10)


def test_a_dependent_joint_is_listed_as_held_or_guessed() -> None:
    starts = {"revA": "phi(start=1)", "revD": "phi(start=1.7)"}
    listed = {h.name: h for h in model(tuple(starts.items()), JOINTS).simulate(0).start}
    assert listed["revA.phi"].held
    assert not listed["revD.phi"].held
    assert listed["revD.phi"].value - listed["revD.phi"].start == pytest.approx(-0.113832, abs=1e-5)


STEADY = """
model Steady
  Real x;
  parameter Real p = 3;
initial equation
  der(x) = 0;
equation
  der(x) = p - x*x{power};
end Steady;
"""


def test_a_steady_state_is_found_from_a_singular_guess() -> None:
    """At x = 0 the equation of the steady state does not feel x."""
    run = planarc.load(STEADY.format(power="*x")).simulate(0)
    assert run["x"][0] == pytest.approx(3 ** (1 / 3), abs=1e-9)


def test_where_no_loop_is_concerned_no_length_is_spoken_of() -> None:
    with pytest.raises(planarc.PlanarcError) as caught:
        planarc.load(STEADY.format(power="")).simulate(0, parameters={"p": -3})
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "R412"
    assert diagnostic.hint is not None
    assert "length" not in diagnostic.hint
    assert "parameter" in diagnostic.hint


ROPE = """
model Rope "Six links of 0.1 m between two posts"
  import PlanarMultiBody.{{Joints, Parts}};
  inner PlanarMultiBody.World world;
  Parts.Fixed post(r={{{far}, 0}});
  Joints.Revolute hinge[6](phi(start={{if i == 1 then -0.6 else 0.2 for i in 1:6}})), last;
  Parts.BodyShape link[6](each r={{0.1, 0}}, each m=0.1, each I=1e-4);
equation
  connect(world.frame_b, hinge[1].frame_a);
  for i in 1:6 loop
    connect(hinge[i].frame_b, link[i].frame_a);
  end for;
  for i in 1:5 loop
    connect(link[i].frame_b, hinge[i + 1].frame_a);
  end for;
  connect(link[6].frame_b, last.frame_a);
  connect(last.frame_b, post.frame_b);
end Rope;
"""


def test_tries_that_all_miss_by_as_much_are_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    """Parts that do not reach each other end equally far apart from every guess."""
    calls = list[int]()

    def counted(level: branch._Level, guess: np.ndarray) -> object:
        calls[-1] += 1
        return solved(level, guess)

    def begun(*given: object) -> object:
        calls.append(0)
        return nearest(*given)

    solved, nearest = branch._Level.solve, branch.nearest_root
    monkeypatch.setattr(branch._Level, "solve", counted)
    monkeypatch.setattr("planarc.solve.start.assembly.nearest_root", begun)
    with pytest.raises(planarc.PlanarcError, match=r"R412.*its ends stay 0\.2 m apart"):
        planarc.load(ROPE.format(far=0.8)).simulate(0)
    assert max(calls) == branch.ENOUGH
    assert planarc.load(ROPE.format(far=0.5)).simulate(0).ended is None


TROLLEY = """model Trolley
  import PlanarMultiBody.*;
  inner World world;
  Parts.Body chassis(m=10, I=0.5, r_CM={0, 0.1});
  Parts.FixedTranslation toFront(r={0.4, 0}), toRear(r={-0.4, 0});
  Joints.Revolute frontHub(phi(fixed=true), w(fixed=true)), rearHub;
  Parts.RollingWheel front(R=0.15, m=1), rear(R=0.15, m=1);
equation
  connect(chassis.frame_a, toFront.frame_a);
  connect(chassis.frame_a, toRear.frame_a);
  connect(toFront.frame_b, frontHub.frame_a);
  connect(frontHub.frame_b, front.frame_a);
  connect(toRear.frame_b, rearHub.frame_a);
  connect(rearHub.frame_b, rear.frame_a);
end Trolley;
"""


def test_a_chassis_stays_upright_though_its_wheels_turn_less_if_it_is_turned_over() -> None:
    """Upright, the rear wheel rolls back by 0.8 m; upside down both roll by less than that."""
    result = planarc.load(TROLLEY).simulate(0)
    assert result["chassis.frame_a.phi"][0] == pytest.approx(0, abs=1e-9)
    assert result["rear.rolling.x"][0] == pytest.approx(-0.8)
