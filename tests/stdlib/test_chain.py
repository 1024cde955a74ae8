"""A chain that runs over a smooth peg, by the law of a limp one."""

from __future__ import annotations

from math import cosh, pi, sqrt, tan

import numpy as np
import pytest

import planarc
from tests.stdlib.small import G, both_backends

N, LEFT, BENDS, LINK, THICK, MASS = 14, 3, 5, 0.04, 0.004, 0.02
PEG = LINK / 2 / tan(pi / 2 / BENDS) - THICK / 2
CHAIN = f"""
model Chain
  import PlanarMultiBody.*;
  inner World world;
  Parts.Body link[{N}](each m={MASS}, each r_CM={{{LINK / 2}, 0}}, each I={MASS * LINK**2 / 12!r});
  Parts.FixedTranslation rod[{N}](each r={{{LINK}, 0}});
  Joints.FreeMotion start(r_rel_a(start={{{-PEG - THICK / 2!r}, {-(LEFT + 0.5) * LINK!r}}},
    each fixed=true), phi_rel(start={pi / 2!r}, fixed=true), v_rel_a(each fixed=true),
    w_rel(fixed=true));
  Joints.Revolute hinge[{N - 1}](each w(fixed=true), phi(start=
    {{if i > {LEFT} and i <= {LEFT + BENDS} then {-pi / BENDS!r} else 0 for i in 1:{N - 1}}},
    each fixed=true));
  Contacts.Contact contact[{N}](redeclare each Contacts.Circle contour1(R={PEG!r}),
    redeclare each Contacts.Segment contour2(a={{0, 0}}, b={{{LINK}, 0}}, R={THICK / 2}));
equation
  connect(world.frame_b, start.frame_a);
  connect(start.frame_b, rod[1].frame_a);
  for i in 1:{N} loop
    connect(rod[i].frame_a, link[i].frame_a);
    connect(world.frame_b, contact[i].frame_a);
    connect(rod[i].frame_a, contact[i].frame_b);
  end for;
  for i in 1:{N - 1} loop
    connect(rod[i].frame_b, hinge[i].frame_a);
    connect(hinge[i].frame_b, rod[i + 1].frame_a);
  end for;
end Chain;
"""


@both_backends
def test_a_chain_runs_over_a_peg_and_gains_no_energy(backend: str) -> None:
    """x'' = 2*g/L*x for half of what one side is longer. Links that land on the peg while others
    leave it come with overlaps of errors of the run, which are no mistakes of a start."""
    model = planarc.load(CHAIN, backend=backend)
    r = model.simulate(0.3 if backend == "native" else 0.05, tolerance=1e-6, intervals=60)
    energy = 0.0 * r.time
    for i in range(1, N + 1):
        v2 = r[f"link[{i}].v_CM[1]"] ** 2 + r[f"link[{i}].v_CM[2]"] ** 2
        energy = energy + MASS * (v2 / 2 + LINK**2 / 24 * r[f"link[{i}].w"] ** 2)
        energy = energy + MASS * G * r[f"link[{i}].r_0CM[2]"]
    assert np.diff(energy).max() < 2e-5
    longer = (N - 2 * LEFT - BENDS - 1) * LINK / 2
    rises = r["link[1].r[2]"][-1] - r["link[1].r[2]"][0]
    law = longer * (cosh(sqrt(2 * G / (N * LINK)) * r.time[-1]) - 1)
    assert rises == pytest.approx(law, rel=0.03)
    assert len(r.events) > 5
