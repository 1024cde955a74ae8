"""Links, joints, loops and mobility by count, against what books say of these mechanisms."""

from __future__ import annotations

from itertools import combinations_with_replacement
from pathlib import Path

import pytest

from planarc import stages
from planarc.insight.topology import find_mechanism
from planarc.ir.mechanism import Mechanism
from planarc.request.request import Request, open_target

STDLIB = Path(__file__).parents[2] / "stdlib"

EXAMPLES = "PlanarMultiBody.Examples"

#: moving bodies, joints, independent loops, mobility
KNOWN = {
    "Elementary.Pendulum": (1, 1, 0, 1),
    "Elementary.DoublePendulum": (2, 2, 0, 2),
    "Elementary.FreeBody": (1, 0, 0, 3),
    "Elementary.PointGravity": (2, 0, 0, 4),
    "Elementary.SpringDamperSystem": (1, 1, 0, 1),
    "Loops.FourBar": (3, 4, 1, 1),
    "Loops.CrankSlider": (3, 4, 1, 1),
    "Loops.PistonEngine": (3, 4, 1, 1),
    "Loops.AndrewsSqueezer": (7, 10, 3, 1),
    "Loops.TwoLoops": (3, 5, 2, 1),
    "Loops.TwoLoopsWithRevolutes": (5, 7, 2, 1),
    "Loops.NFourBar": (5, 7, 2, 1),
    "CurveCurveJoint.CamFollower": (2, 3, 1, 1),
    "Systems.QuickReturn": (4, 6, 2, 1),
    "Systems.Excavator": (2, 2, 0, 2),
}


def mechanism_of(class_name: str | None, text: str | None = None) -> Mechanism | None:
    target = open_target(Request(None, class_name, text=text))
    return find_mechanism(stages.to_dae(stages.flatten(target)))


@pytest.mark.parametrize("name", KNOWN)
def test_examples_have_the_numbers_of_the_books(name: str) -> None:
    found = mechanism_of(f"{EXAMPLES}.{name}")
    assert found is not None
    assert (found.bodies, found.pairs, found.loops, found.mobility) == KNOWN[name]


def test_links_carry_the_names_of_their_components() -> None:
    found = mechanism_of(f"{EXAMPLES}.Loops.FourBar")
    assert found is not None
    assert [link.name for link in found.links] == ["ground", "crank", "coupler", "rocker"]
    ends = {joint.name: joint.links for joint in found.joints}
    assert ends == {"revA": (0, 1), "revB": (1, 2), "revC": (2, 3), "revD": (0, 3)}


def test_a_third_parallel_bar_takes_away_a_freedom_by_count() -> None:
    bars = "".join(
        f"P.Joints.Revolute a{i}; P.Joints.Revolute b{i};"
        f"P.Parts.FixedTranslation bar{i}(r={{0,1}});"
        for i in range(3)
    )
    ties = "".join(
        f"connect(g.frame_b, base{i}.frame_a); connect(base{i}.frame_b, a{i}.frame_a);"
        f"connect(a{i}.frame_b, bar{i}.frame_a); connect(bar{i}.frame_b, b{i}.frame_a);"
        f"connect(b{i}.frame_b, top{i}.frame_b); connect(top{i}.frame_a, body.frame_a);"
        for i in range(3)
    )
    feet = "".join(
        f"P.Parts.FixedTranslation base{i}(r={{{i},0}});"
        f"P.Parts.FixedTranslation top{i}(r={{{i},0}});"
        for i in range(3)
    )
    found = mechanism_of(
        None,
        f"model M import P = PlanarMultiBody; inner P.World world; P.Parts.Fixed g; "
        f"P.Parts.Body body(m=1); {bars} {feet} equation {ties} end M;",
    )
    assert found is not None
    assert (found.bodies, found.pairs, found.loops, found.mobility) == (4, 6, 2, 0)


def test_a_joint_of_ones_own_counts_by_its_equations() -> None:
    # A pin in a straight slot: frame_b lies on the x-axis of frame_a, and may turn.
    found = mechanism_of(
        None,
        """
        model M
          model Slot
            extends PlanarMultiBody.Interfaces.PartialTwoFrames;
            Real d[2];
            Real f_n;
          equation
            d = PlanarMultiBody.Frames.resolve2(frame_a.phi, frame_b.r - frame_a.r);
            d[2] = 0;
            frame_b.f = PlanarMultiBody.Frames.resolve1(frame_a.phi, {0, f_n});
            frame_b.t = 0;
            frame_a.f = -frame_b.f;
            frame_a.t = -PlanarMultiBody.Frames.cross(frame_b.r - frame_a.r, frame_b.f);
          end Slot;
          inner PlanarMultiBody.World world;
          Slot slot;
          PlanarMultiBody.Parts.Body body(m=1, I=1);
        equation
          connect(world.frame_b, slot.frame_a);
          connect(slot.frame_b, body.frame_a);
        end M;
        """,
    )
    assert found is not None
    assert [(j.name, j.conditions, j.links) for j in found.joints] == [("slot", 1, (0, 1))]
    assert found.mobility == 2


_SENSORS = tuple(sorted(f.stem for f in (STDLIB / "PlanarMultiBody/Sensors").glob("Relative*.pmo")))
_AXES = ("world", "frame_a", "frame_b")


@pytest.mark.parametrize("axes", _AXES)
@pytest.mark.parametrize("sensor", [*_SENSORS, "Distance"])
def test_a_sensor_holds_nothing(sensor: str, axes: str) -> None:
    has_axes = "Angle" not in sensor and "Angular" not in sensor and sensor != "Distance"
    given = f"(resolveInFrame=P.Types.ResolveInFrameAB.{axes})" if has_axes else ""
    found = mechanism_of(
        None,
        f"""
        model M
          import P = PlanarMultiBody;
          inner P.World world;
          P.Joints.Revolute hinge;
          P.Parts.BodyShape bar(r={{1,0}}, m=1);
          P.Sensors.{sensor} first{given};
          P.Sensors.{sensor} second{given};
          P.Parts.Body ball(m=1, I=1);
        equation
          connect(world.frame_b, hinge.frame_a);
          connect(hinge.frame_b, bar.frame_a);
          connect(bar.frame_b, first.frame_a);
          connect(first.frame_b, ball.frame_a);
          connect(world.frame_b, second.frame_a);
          connect(second.frame_b, bar.frame_b);
        end M;
        """,
    )
    assert found is not None
    assert [(j.name, j.conditions, j.links) for j in found.joints] == [("hinge", 2, (0, 1))]
    assert (found.bridged, found.mobility) == ((), 4)


#: Components between two frames, and whether they hold these together.
_BETWEEN = {
    "Parts.FixedTranslation(r={1,0})": True,
    "Sensors.CutForce": True,
    "Sensors.RelativePosition": False,
    "Sensors.Distance": False,
    "Forces.Spring(c=1)": False,
    "Joints.Prismatic": False,
}


@pytest.mark.parametrize("pair", list(combinations_with_replacement(_BETWEEN, 2)))
def test_a_joint_is_bridged_by_what_is_rigid_alone(pair: tuple[str, str]) -> None:
    first, second = (c.replace("(", " {}(", 1) if "(" in c else c + " {}" for c in pair)
    found = mechanism_of(
        None,
        f"""
        model M
          import P = PlanarMultiBody;
          inner P.World world;
          P.Joints.Revolute hinge;
          P.{first.replace("{}", "first")};
          P.{second.replace("{}", "second")};
          P.Parts.Body body(m=1, I=1);
        equation
          connect(world.frame_b, hinge.frame_a);
          connect(hinge.frame_b, body.frame_a);
          connect(world.frame_b, first.frame_a);
          connect(first.frame_b, second.frame_a);
          connect(second.frame_b, body.frame_a);
        end M;
        """,
    )
    assert found is not None
    assert found.bridged == (("hinge",) if all(_BETWEEN[c] for c in pair) else ())


def test_a_frame_held_by_its_own_component_carries_the_others_of_it() -> None:
    found = mechanism_of(
        None,
        """
        model M
          model Rail "A post with a slide along y"
            extends PlanarMultiBody.Interfaces.PartialTwoFrames;
          equation
            frame_a.r = {1, 2};
            frame_a.phi = 0;
            frame_b.phi = frame_a.phi;
            frame_b.r[1] = frame_a.r[1];
            frame_b.f[2] = 0;
          end Rail;
          inner PlanarMultiBody.World world;
          Rail rail;
          PlanarMultiBody.Parts.Body body(m=1, I=1);
        equation
          connect(rail.frame_b, body.frame_a);
        end M;
        """,
    )
    assert found is not None
    assert [(j.name, j.conditions, j.links) for j in found.joints] == [("rail", 2, (0, 1))]
    assert found.mobility == 1


def test_a_model_without_frames_is_no_mechanism() -> None:
    assert mechanism_of(None, "model M Real x; equation der(x) = -x; end M;") is None
