"""What is drawn, and where: shapes, arrows and axes move with their frames and carry no load."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

Run = Callable[..., Any]

SWING = """
  Joints.Revolute hinge(phi(start=0.4, fixed=true), w(start=1, fixed=true));
  Parts.FixedTranslation rod(r={1, 0}, animation=false);
  Parts.Body bob(m=1, I=0.1, animation=false);
"""
CONNECTED = """
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, rod.frame_a);
  connect(rod.frame_b, bob.frame_a);
"""
DRAWN = """
  Visualizers.FixedShape plate(shapeType="box", r_shape={0.1, 0.2}, angle=0.3, length=0.5,
    width=0.2, color={1, 2, 3}, heightShift=0.7);
  Visualizers.FixedShape wheel(shapeType="gearwheel", length=0.3, width=0.3, zDirection=true,
    extra=12);
  Visualizers.FixedShape2 bar(r={0.3, 0.4}, width=0.05);
  Visualizers.FixedFrame axes(axisLength=0.4, label1="u", label2="v");
  Visualizers.FixedArrow arrow(r_tail={0, 0.1}, n={0, 3}, length=0.2);
  Visualizers.SignalArrow speed;
  Visualizers.SignalArrow turned(resolveInFrame=Types.ResolveInFrameA.frame_a);
  Visualizers.Advanced.DoubleArrow torque(r=bob.r, r_head={0, 0.1}, width=0.01);
  Visualizers.Advanced.Curve line(points={{0, 0}, {1, 2}}, r=bob.r, phi=bob.phi);
  Visualizers.Advanced.Arrow force(r=bob.r, phi=0.1, r_tail={0.2, 0}, r_head={0.3, 0});
  Visualizers.Advanced.CoordinateSystem corner(r=bob.r, phi=0.2, axisLength=0.3);
  Visualizers.Advanced.Shape ball(shapeType="sphere", r=bob.r, length=0.1 + 0*time, width=0.1);
  Visualizers.FixedShape hidden(animation=false, length=1);
"""
ATTACHED = """
  connect(rod.frame_b, plate.frame_a);
  connect(rod.frame_b, wheel.frame_a);
  connect(rod.frame_b, bar.frame_a);
  connect(rod.frame_b, axes.frame_a);
  connect(rod.frame_b, arrow.frame_a);
  connect(rod.frame_b, speed.frame_a);
  connect(rod.frame_b, turned.frame_a);
  connect(rod.frame_b, hidden.frame_a);
  speed.r_head = 0.1*bob.v;
  turned.r_head = {0, 0.1};
"""


def swing(run: Run, drawn: str, attached: str) -> Any:
    head = "import PlanarMultiBody.Visualizers;\n"
    return run(f"{head}{SWING}{drawn}equation\n{CONNECTED}{attached}")


def test_what_is_fixed_in_a_frame_moves_with_it(run: Run) -> None:
    from planarc.view.item import Kind
    from planarc.view.scene import make_scene

    result = swing(run, DRAWN, ATTACHED)
    items = {item.component.split(".")[0]: item for item in make_scene(result).items}
    phi = result["hinge.phi"]
    turn = np.exp(1j * phi)

    def at(name: str) -> Any:
        return items[name].x + 1j * items[name].y

    plate = items["plate"]
    np.testing.assert_allclose(at("plate"), turn * (1 + 0.1 + 0.2j), atol=1e-12)
    np.testing.assert_allclose(plate.angle, phi + 0.3)
    assert (plate.shape, plate.length, plate.width) == ("box", 0.5, 0.2)
    assert plate.color == (1, 2, 3)
    # Over the first link behind the ground, and among what is on that by its heightShift.
    np.testing.assert_allclose(plate.height, 1.2 + 0.1 * np.tanh(0.7))
    assert (items["wheel"].shape, items["wheel"].upright, items["wheel"].extra) == (
        "gearwheel",
        True,
        12,
    )
    np.testing.assert_allclose(items["bar"].angle, phi + np.arctan2(0.4, 0.3))
    np.testing.assert_allclose(items["bar"].length, 0.5)
    tip = result["bar.frame_b.r[1]"] + 1j * result["bar.frame_b.r[2]"]
    np.testing.assert_allclose(tip, turn * (1.3 + 0.4j), atol=1e-12)
    axes = items["axes"]
    assert (axes.kind, axes.labels, axes.length) == (Kind.FRAME, ("u", "v"), 0.4)
    np.testing.assert_allclose(axes.angle, phi)
    np.testing.assert_allclose(at("arrow"), turn * (1 + 0.1j), atol=1e-12)
    np.testing.assert_allclose(items["arrow"].angle, phi + np.pi / 2)
    np.testing.assert_allclose(items["arrow"].length, 0.2)
    v = result["bob.v[1]"] + 1j * result["bob.v[2]"]
    drawn = items["speed"].length * np.exp(1j * items["speed"].angle)
    np.testing.assert_allclose(drawn, 0.1 * v, atol=1e-12)
    np.testing.assert_allclose(items["turned"].angle, phi + np.pi / 2)
    assert items["torque"].kind is Kind.DOUBLE_ARROW
    assert items["line"].points == ((0, 0), (1, 2))
    np.testing.assert_allclose(items["line"].angle, phi)
    tip = result["bob.r[1]"] + 1j * result["bob.r[2]"]
    np.testing.assert_allclose(at("force"), tip + 0.2 * np.exp(0.1j), atol=1e-12)
    np.testing.assert_allclose(items["force"].length, 0.3)
    for name in ("corner", "ball"):
        np.testing.assert_allclose(at(name), tip, atol=1e-12)
    assert (items["corner"].angle, items["ball"].shape) == (0.2, "sphere")
    assert "hidden" not in items


def test_what_is_drawn_carries_no_load(run: Run) -> None:
    bare, drawn = swing(run, "", ""), swing(run, DRAWN, ATTACHED)
    np.testing.assert_allclose(drawn["hinge.phi"], bare["hinge.phi"], atol=1e-9)
    for quantity in ("f[1]", "f[2]", "t"):
        for name in ("plate", "axes", "arrow", "speed"):
            assert not np.any(drawn[f"{name}.frame_a.{quantity}"])


def test_one_switch_of_the_world_hides_what_components_draw(run: Run) -> None:
    text = "import PlanarMultiBody.Visualizers;\n  inner World world(enableAnimation=false);\n"
    result = run(
        f"{text}{SWING.replace(', animation=false', '')}"
        "  Visualizers.FixedFrame axes;\nequation\n"
        f"{CONNECTED}  connect(rod.frame_b, axes.frame_a);\n"
    )
    assert not result.program.visuals  # a viewer draws frames and joints in their place
