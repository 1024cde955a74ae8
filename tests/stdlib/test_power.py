"""Balance of power in every example: over each component, and over all of them at once.

What flows into a component through its frames is f*v + t*w of each. A joint without drive takes
none, a line force its tension times the speed of its ends, a body what its mass and inertia need.
Connections take none either, so all components together take nothing: that holds only where the
forces in each connection sum to zero (Newton's third law) and its frames move alike.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from planarc.core.resources import stdlib

EXAMPLES = stdlib() / "PlanarMultiBody" / "Examples"
NAMES = sorted(
    ".".join(path.relative_to(EXAMPLES).with_suffix("").parts)
    for path in EXAMPLES.rglob("*.pmo")
    if path.stem != "package"
)

GRAVITY = "world.gravityAcceleration"
BODY = f"{{0}}.m*({{0}}.a_CM - {GRAVITY}({{0}}.r_0CM))*{{0}}.v_CM + {{0}}.I*{{0}}.z*{{0}}.w"
POINT = f"{{0}}.m*({{0}}.a - {GRAVITY}({{0}}.%s))*{{0}}.v"
MASS = f"{{0}}.m_{{1}}*(der({{0}}.v_CM_{{1}}) - {GRAVITY}({{0}}.r_CM_{{1}}))*{{0}}.v_CM_{{1}}"
NONE = "0"
LINE = "{0}.f*der({0}.s)"

#: The power that a component takes, by its class.
TAKEN = {
    "World": NONE,
    "Parts.Fixed": NONE,
    "Parts.FixedTranslation": NONE,
    "Parts.Body": BODY,
    "Parts.BodyShape": BODY.replace("{0}", "{0}.body"),
    "Parts.PointMass": POINT % "r",
    "Joints.Revolute": "-{0}.tau*{0}.w",
    "Joints.Prismatic": "-{0}.f*{0}.v",
    "Joints.RevoluteWithFriction": "-{0}.tau*{0}.w",
    "Joints.PrismaticWithFriction": "-{0}.f*{0}.v",
    "Joints.JointRR": NONE,
    "Joints.JointRRWithMass": POINT % "r_mass",
    "Joints.CurveCurveJoint": NONE,
    "Joints.Assemblies.JointRRP": NONE,
    "Contacts.Contact": "-{0}.f_n*der({0}.gap) - {0}.f_t*{0}.slip",
    "Contacts.Crowd": "-{0}.f_b*der({0}.frame_b.r) - {0}.t_b*der({0}.frame_b.phi)"
    " - sum({0}.f[i,:]*der({0}.frame_a[i].r) + {0}.t[i]*der({0}.frame_a[i].phi) for i in 1:{0}.n)",
    "Contacts.CurveCurveContact": "-{0}.f_n*der({0}.gap) - {0}.f_t*{0}.slip",
    "Contacts.ClearanceRevolute": "-{0}.touch.f_n*der({0}.gap) - {0}.touch.f_t*{0}.slip",
    "Contacts.GearPair": "-{0}.f*der({0}.play) - {0}.press*der({0}.apart)",
    "Contacts.Rack": "-{0}.f*der({0}.play) - {0}.press*der({0}.apart)",
    "Contacts.RevoluteStops": "-{0}.tau*der({0}.phi)",
    "Forces.Spring": LINE,
    "Forces.SpringDamperParallel": LINE,
    "Forces.SpringDamperSeries": LINE,
    "Forces.QuadraticDrag": "{0}.d*sqrt({0}.v*{0}.v)*({0}.v*{0}.v)",
    "Forces.WorldForce": "-{0}.force*der({0}.frame_b.r)",
    "Forces.LineForceWithTwoMasses": " + ".join(
        (
            "-{0}.flange_b.f*der({0}.s)",
            MASS.replace("{1}", "a"),
            MASS.replace("{1}", "b"),
        )
    ),
}


def frames_of(program: Any) -> dict[str, list[str]]:
    """The frames of each component of a model, not of what is inside of components."""
    found: dict[str, list[str]] = {}
    for column in program.columns:
        match = re.fullmatch(
            r"(\w+(?:\[\d+\])?)\.((?:frame_|bearing)\w*(?:\[\d+\])?)\.f\[1\]", column.name
        )
        if match:
            found.setdefault(match[1], []).append(match[2])
    return found


@pytest.mark.parametrize("name", NAMES)
def test_power_goes_nowhere_but_where_it_is_taken(name: str) -> None:
    from planarc.compiler import compile_model, run
    from planarc.core.options import RunOptions
    from planarc.request.request import Request

    example = f"PlanarMultiBody.Examples.{name}"
    program = compile_model(Request(class_name=example)).program
    frames = frames_of(program)
    classes = {
        part.name: part.class_name.removeprefix("PlanarMultiBody.") for part in program.parts
    }
    lines = []
    for i, (component, its) in enumerate(frames.items()):
        powers = (
            f"{component}.{f}.f*der({component}.{f}.r) + {component}.{f}.t*der({component}.{f}.phi)"
            for f in its
        )
        lines.append(f"  Real flow_{i} = {' + '.join(powers)};")
        lines.append(f"  Real taken_{i} = {TAKEN[classes[component]].format(component)};")
    text = f"model Balance\n  extends {example};\n" + "\n".join(lines) + "\nend Balance;\n"
    options = RunOptions(stop=program.experiment.stop, intervals=200)
    result = run(compile_model(Request(text=text)), options)
    assert result.ended is None

    def column(variable: str) -> Any:
        return np.broadcast_to(result[variable], result.time.shape)

    flows = [column(f"flow_{i}") for i in range(len(frames))]
    scale = max(1e-3, float(np.max(np.abs(flows))))
    for i, component in enumerate(frames):
        np.testing.assert_allclose(
            flows[i], column(f"taken_{i}"), atol=1e-6 * scale, err_msg=component
        )
    assert len(frames) > 1
    np.testing.assert_allclose(sum(flows), 0, atol=1e-6 * scale, err_msg="all together")
