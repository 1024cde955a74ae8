"""A scene says where each drawn thing is, at each row."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planarc
from planarc.ir.expr import Exprs
from planarc.view.item import Kind
from planarc.view.scene import make_scene

TIME = np.linspace(0.0, 2.0, 5)
ANGLE = np.array([0.0, 1.0, 2.0, 3.0, 4.0])


def test_a_shape_sits_at_its_offset_turned_with_its_frame(
    table: Exprs, result_of: Callable[..., Any], shape_of: Callable[..., Any]
) -> None:
    phi = table.symbol("phi")
    rod = shape_of(
        table,
        "rod",
        r=(1.0, table.symbol("y")),
        phi=phi,
        r_shape=(0.5, 0.0),
        angle=0.25,
        length=2.0,
    )
    result = result_of(table, TIME, {"phi": ANGLE, "y": 3 * TIME}, (rod,))
    (item,) = make_scene(result).items
    assert item.kind is Kind.SHAPE
    np.testing.assert_allclose(item.x, 1.0 + 0.5 * np.cos(ANGLE))
    np.testing.assert_allclose(item.y, 3 * TIME + 0.5 * np.sin(ANGLE))
    np.testing.assert_allclose(item.angle, ANGLE + 0.25)
    assert item.length == 2.0


def test_what_never_changes_is_a_number(
    table: Exprs, result_of: Callable[..., Any], shape_of: Callable[..., Any]
) -> None:
    block = shape_of(table, "block", r=(table.symbol("d"), 0.0), phi=0.5, width=0.1)
    (item,) = make_scene(result_of(table, TIME, {"x": TIME, "d": 0.75}, (block,))).items
    assert (item.x, item.y, item.angle) == (0.75, 0.0, 0.5)


def test_higher_things_come_later_and_equal_ones_stay_in_order(
    table: Exprs, result_of: Callable[..., Any], shape_of: Callable[..., Any]
) -> None:
    heights = {"a": 0.1, "b": 0.0, "c": 0.1, "d": -1.0}
    shapes = tuple(shape_of(table, n, heightShift=h) for n, h in heights.items())
    scene = make_scene(result_of(table, TIME, {"x": TIME}, shapes))
    assert [item.component for item in scene.items] == ["d", "b", "a", "c"]


def test_an_angle_of_atan2_does_not_jump(
    table: Exprs, result_of: Callable[..., Any], shape_of: Callable[..., Any]
) -> None:
    turn = np.linspace(0.0, 4 * math.pi, 100)
    angle = table.call("atan2", table.symbol("y"), table.symbol("x"))
    spring = shape_of(table, "spring", angle=angle, length=1.0)
    columns = {"x": np.cos(turn), "y": np.sin(turn)}
    (item,) = make_scene(result_of(table, turn, columns, (spring,))).items
    np.testing.assert_allclose(item.angle, turn, atol=1e-12)


def test_the_box_holds_the_whole_motion(
    table: Exprs, result_of: Callable[..., Any], shape_of: Callable[..., Any]
) -> None:
    turn = np.linspace(0.0, 2 * math.pi, 1000)
    rod = shape_of(table, "rod", phi=table.symbol("phi"), length=1.5, width=1e-9)
    scene = make_scene(result_of(table, turn, {"phi": turn}, (rod,)))
    np.testing.assert_allclose(scene.box, (-1.5, -1.5, 1.5, 1.5), atol=1e-4)


def test_an_arrow_points_along_its_vector(
    table: Exprs, result_of: Callable[..., Any], visual_of: Callable[..., Any]
) -> None:
    force = visual_of(
        table, "force", "arrow", r=(1.0, 0.0), phi=math.pi / 2, r_tail=(1.0, 0.0),
        r_head=(0.0, -2.0), width=0.01, heightShift=0.0, color=(0, 0, 0),
    )  # fmt: skip
    (item,) = make_scene(result_of(table, TIME, {"x": TIME}, (force,))).items
    assert (item.x, item.y) == pytest.approx((1.0, 1.0))
    assert item.angle == pytest.approx(0.0)
    assert item.length == pytest.approx(2.0)


def test_what_cannot_be_drawn_is_named_and_the_rest_is_drawn(
    table: Exprs, result_of: Callable[..., Any], shape_of: Callable[..., Any]
) -> None:
    lost = shape_of(table, "lost", length=table.symbol("nowhere"))
    there = shape_of(table, "there", length=1.0)
    scene = make_scene(result_of(table, TIME, {"x": TIME}, (lost, there)))
    assert [item.component for item in scene.items] == ["there"]
    assert scene.notes == ("`lost` is not drawn: the result has no variable `nowhere`",)


def test_every_operator_has_the_values_of_the_scalar_tree(
    table: Exprs, result_of: Callable[..., Any], shape_of: Callable[..., Any]
) -> None:
    from planarc.evaluate.value import evaluate
    from planarc.runtime.elementary import TABLE

    t, x = table, table.symbol("x")
    half = t.const(0.5)
    two = ("atan2", "min", "max", "div", "mod", "rem")
    expressions = [t.call(f, x, half) if f in two else t.call(f, x) for f in TABLE]
    expressions += [
        t.add(x, half), t.mul(x, x), t.neg(x), t.div(half, x), t.pow(x, t.const(3.0)),
        t.if_(t.less(x, half), x, t.neg(x)), t.if_(t.less_equal(x, half), x, half),
        t.if_(t.and_(t.less(x, half), t.not_(t.equal(x, half))), x, half),
        t.if_(t.or_(t.less(x, half), t.less(half, x)), x, half),
    ]  # fmt: skip
    values = np.array([0.1, 0.5, 0.9])
    for expression in expressions:
        shape = shape_of(table, "s", length=expression)
        (item,) = make_scene(result_of(table, TIME[:3], {"x": values}, (shape,))).items
        expected = [evaluate(expression, lambda leaf, v=v: v) for v in values.tolist()]
        np.testing.assert_allclose(item.length, expected, err_msg=repr(expression))


def test_an_arrow_much_longer_than_the_mechanism_is_drawn_shorter_and_says_so(
    table: Exprs,
    result_of: Callable[..., Any],
    shape_of: Callable[..., Any],
    visual_of: Callable[..., Any],
) -> None:
    rod = shape_of(table, "rod", length=2.0, width=1e-9)
    force = visual_of(
        table, "force", "arrow", r=(0.0, 0.0), phi=0.0, r_tail=(0.0, 0.0),
        r_head=(table.symbol("f"), 0.0), width=0.0, heightShift=0.0, color=(0, 0, 0),
    )  # fmt: skip
    scene = make_scene(result_of(table, TIME, {"f": 500 * ANGLE}, (rod, force)))
    arrow = next(item for item in scene.items if item.component == "force")
    assert 0.2 < np.max(arrow.length) / 2.0 < 0.35
    np.testing.assert_allclose(arrow.length / np.max(arrow.length), ANGLE / 4.0)
    assert "`force` is drawn 0.0003 times as long" in scene.notes[0]
    assert scene.box is not None and scene.box[2] == pytest.approx(2.0)


def test_forces_have_one_scale_and_round_off_is_not_drawn(tmp_path: Path) -> None:
    file = tmp_path / "pushed.pmo"
    file.write_text(
        "model Pushed\n  import PlanarMultiBody.*;\n"
        "  inner World world(gravityType=Types.GravityTypes.NoGravity);\n"
        "  Joints.Revolute hinge(phi(start=0, fixed=true), w(fixed=true));\n"
        "  Parts.BodyShape bar(r={1, 0}, m=1, I=0.1);\n"
        "  Forces.WorldForce push, pull, nothing;\nequation\n"
        "  connect(world.frame_b, hinge.frame_a);\n"
        "  connect(hinge.frame_b, bar.frame_a);\n"
        "  connect(bar.frame_b, push.frame_b);\n"
        "  connect(bar.frame_b, pull.frame_b);\n"
        "  connect(bar.frame_b, nothing.frame_b);\n"
        "  push.force = {0, 5000};\n  pull.force = {0, -2500};\n  nothing.force = {0, 2e-16};\n"
        "end Pushed;\n",
        "utf-8",
    )
    scene = make_scene(planarc.load(file).simulate(0.01).rows)
    arrows = {i.component: i for i in scene.items if i.kind is Kind.ARROW}
    assert set(arrows) == {"push.arrow", "pull.arrow"}
    (scale,) = scene.scales
    assert scale.unit == "N"
    for name, force in (("push", 5000.0), ("pull", 2500.0)):
        assert np.max(arrows[f"{name}.arrow"].length) == pytest.approx(force * scale.metres)
    assert 0.2 < 5000 * scale.metres < 0.3  # of a bar 1 m long
    assert scene.notes == ("arrows are drawn 1 m long for 1.9e+04 N",)
