"""One mechanism, written in many ways: order, names, ends, states and tears do not matter.

Tears and states are chosen by structure, then by names and order, so that other names and
orders tear the loops at other joints and take other coordinates as states.
"""

from __future__ import annotations

import random
from typing import Any

import numpy as np
import pytest

import planarc
from planarc.compiler import compile_model
from planarc.core.options import Backend, RunOptions
from planarc.request.request import Request
from planarc.solve.opened import open_program
from planarc.solve.start.solve import solve_start

#: A four-bar with a second dyad on its coupler: two loops. `%` stands before names.
PARTS = {
    "crank": "Parts.FixedTranslation %crank(r={0.4, 0})",
    "coupler": "Parts.FixedTranslation %coupler(r={0.9, 0})",
    "rocker": "Parts.FixedTranslation %rocker(r={0.8, 0})",
    "arm": "Parts.FixedTranslation %arm(r={0.5, 0.3})",
    "link": "Parts.FixedTranslation %link(r={0.7, 0})",
    "lever": "Parts.FixedTranslation %lever(r={0.6, 0})",
    "ground": "Parts.Fixed %ground(r={1, 0})",
    "post": "Parts.Fixed %post(r={1.3, 0.9})",
    "wheel": "Parts.Body %wheel(m=1, I=0.2, r_CM={0.1, 0})",
    "bob": "Parts.Body %bob(m=0.7, I=0.05, r_CM={0.3, 0.1})",
    "load": "Parts.Body %load(m=0.5, I=0.02, r_CM={0.2, 0})",
    "A": "Joints.Revolute %A(phi(start=1, fixed=true), w(start=2, fixed=true))",
    "B": "Joints.Revolute %B(phi(start=-0.5))",
    "C": "Joints.Revolute %C",
    "D": "Joints.Revolute %D(phi(start=1.6))",
    "E": "Joints.Revolute %E(phi(start=0.3))",
    "F": "Joints.Revolute %F",
    "G": "Joints.Revolute %G(phi(start=-2))",
}
CONNECTIONS = [
    ("world.frame_b", "%A.frame_a"),
    ("%A.frame_b", "%crank.frame_a"),
    ("%crank.frame_a", "%wheel.frame_a"),
    ("%crank.frame_b", "%B.frame_a"),
    ("%B.frame_b", "%coupler.frame_a"),
    ("%coupler.frame_a", "%bob.frame_a"),
    ("%coupler.frame_b", "%C.frame_a"),
    ("%C.frame_b", "%rocker.frame_b"),
    ("%ground.frame_b", "%D.frame_a"),
    ("%D.frame_b", "%rocker.frame_a"),
    ("%coupler.frame_a", "%arm.frame_a"),
    ("%arm.frame_b", "%E.frame_a"),
    ("%E.frame_b", "%link.frame_a"),
    ("%link.frame_b", "%F.frame_a"),
    ("%F.frame_b", "%lever.frame_b"),
    ("%post.frame_b", "%G.frame_a"),
    ("%G.frame_b", "%lever.frame_a"),
    ("%lever.frame_a", "%load.frame_a"),
]
ANGLES = ["A", "B", "C", "D", "E", "F", "G"]
STEP = 0.05


def write(
    names: dict[str, str], order: random.Random | None = None, select: dict[str, str] | None = None
) -> str:
    """`names`: of each part; `order` shuffles parts, connections and their ends; `select`:
    StateSelect of a joint's angle."""

    def named(text: str) -> str:
        for part in sorted(PARTS, key=len, reverse=True):
            text = text.replace(f"%{part}", names[part])
        return text

    parts = []
    for key, part in PARTS.items():
        if key in (select or {}):
            wanted = f"stateSelect=StateSelect.{(select or {})[key]}"
            if "phi(" in part:
                part = part.replace("phi(", f"phi({wanted}, ", 1)
            else:
                part += f"(phi({wanted}))"
        parts.append(f"  PlanarMultiBody.{named(part)};")
    connections = [(named(a), named(b)) for a, b in CONNECTIONS]
    if order is not None:
        order.shuffle(parts)
        order.shuffle(connections)
        connections = [pair[:: order.choice((1, -1))] for pair in connections]
    lines = [f"  connect({a}, {b});" for a, b in connections]
    return "\n".join(
        ["model M", "  inner PlanarMultiBody.World world;", *parts, "equation", *lines, "end M;"]
    )


def simulate(text: str, names: dict[str, str], backend: str = "native") -> dict[str, Any]:
    if backend == "native":
        pytest.importorskip("llvmlite")
    result = planarc.load(text, backend=backend).simulate(1.0, interval=STEP, tolerance=1e-9)
    at = np.searchsorted(result.time, np.arange(0, 1 + STEP / 2, STEP) - 1e-9)
    motion = {f"{k}.phi": result[f"{names[k]}.phi"][at] for k in ANGLES}
    motion |= {f"{k}.f": result[f"{names[k]}.frame_a.f[1]"][at] for k in "ADG"}
    return {"states": result.states[0].states, **motion}


def agree(found: dict[str, Any], plain: dict[str, Any]) -> None:
    for key in plain:
        if key != "states":
            assert found[key] == pytest.approx(plain[key], rel=2e-6, abs=2e-6), key


SAME = {part: part for part in PARTS}


@pytest.fixture(scope="module")
def plain() -> dict[str, Any]:
    return simulate(write(SAME), SAME)


def test_the_loops_are_closed_and_energy_is_kept() -> None:
    """So that those below agree with what is right."""
    pytest.importorskip("llvmlite")
    run = planarc.load(write(SAME), backend="native").simulate(1.0, tolerance=1e-9)
    tip = run["coupler.frame_b.r[1]"], run["coupler.frame_b.r[2]"]
    assert tip[0] == pytest.approx(run["rocker.frame_b.r[1]"], abs=1e-9)
    assert tip[1] == pytest.approx(run["rocker.frame_b.r[2]"], abs=1e-9)
    energy = np.zeros(len(run.time))
    for body, m, inertia in (("wheel", 1, 0.2), ("bob", 0.7, 0.05), ("load", 0.5, 0.02)):
        v = run[f"{body}.v_CM[1]"], run[f"{body}.v_CM[2]"]
        energy += 0.5 * m * (v[0] ** 2 + v[1] ** 2) + 0.5 * inertia * run[f"{body}.w"] ** 2
        energy += 9.81 * m * run[f"{body}.r_0CM[2]"]
    assert np.ptp(energy) < 1e-6


@pytest.mark.parametrize("seed", range(6))
def test_other_orders_and_ends(seed: int, plain: dict[str, Any]) -> None:
    agree(simulate(write(SAME, random.Random(seed)), SAME), plain)


@pytest.mark.parametrize("seed", range(6))
def test_other_names_and_so_other_tears(seed: int, plain: dict[str, Any]) -> None:
    order = random.Random(100 + seed)
    letters = [f"{chr(97 + i)}{i}" for i in range(len(PARTS))]
    order.shuffle(letters)
    names = dict(zip(PARTS, letters, strict=True))
    agree(simulate(write(names, order), names), plain)


@pytest.mark.parametrize("backend", ["numpy", "native"])
@pytest.mark.parametrize("joint", ANGLES)
def test_other_states(joint: str, backend: str, plain: dict[str, Any]) -> None:
    others = dict.fromkeys(ANGLES, "avoid")
    agree(simulate(write(SAME, select={**others, joint: "prefer"}), SAME, backend), plain)


@pytest.mark.parametrize("joint", ["D", "G"])
def test_states_that_were_asked_for(joint: str, plain: dict[str, Any]) -> None:
    found = simulate(write(SAME, select={joint: "always"}), SAME)
    assert f"{joint}.phi" in found["states"]
    assert f"{joint}.phi" not in plain["states"]
    agree(found, plain)


def test_both_keep_the_same_points_to_start_from() -> None:
    """Those of nonlinear blocks; linear ones are solved from nowhere."""
    pytest.importorskip("llvmlite")
    origins = []
    for backend in Backend.NATIVE, Backend.NUMPY:
        compiled = compile_model(Request(text=write(SAME)), backend)
        program, kernel = compiled.program, compiled.load()
        open_program(program, kernel, RunOptions())
        solve_start(program, kernel, 0.0)
        kernel.accept(0.0)
        origins.append([kernel.origin(i) for i in range(len(program.blocks))])
    linear = [i for i, b in enumerate(program.blocks) if b.linear and not b.modal]
    assert linear and len(linear) < len(program.blocks)
    for native, reference in zip(*origins, strict=True):
        np.testing.assert_allclose(native, reference, rtol=0, atol=1e-9)
