"""A ring of frames with redundant orientations: closed by `equalityConstraint`, and solved."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from planarc import load

RING = """
package P
  record Orientation
    Real e[2] "Unit vector";
    encapsulated function equalityConstraint
      import P.Orientation;
      input Orientation a;
      input Orientation b;
      output Real residue[1];
    algorithm
      residue := {a.e[1]*b.e[2] - a.e[2]*b.e[1]};
    end equalityConstraint;
  end Orientation;
  connector Frame
    Orientation R;
    flow Real t;
  end Frame;
  model Ground
    Frame f;
  equation
    Connections.root(f.R);
    f.R.e = {1, 0};
  end Ground;
  partial model Two
    Frame a;
    Frame b;
  equation
    Connections.branch(a.R, b.R);
    a.t + b.t = 0;
  end Two;
  model Bend "Turns by a given angle"
    extends Two;
    parameter Real angle = 0;
  equation
    b.R.e = {cos(angle)*a.R.e[1] - sin(angle)*a.R.e[2],
             sin(angle)*a.R.e[1] + cos(angle)*a.R.e[2]};
  end Bend;
  model Spring "Turns by the angle that the ring leaves it"
    extends Two;
    Real phi(start=0);
  equation
    b.R.e = {cos(phi)*a.R.e[1] - sin(phi)*a.R.e[2], sin(phi)*a.R.e[1] + cos(phi)*a.R.e[2]};
    b.t = 10*phi;
  end Spring;
  model Ring
    Ground ground;
    Bend first(angle=0.3);
    Bend second(angle=0.4);
    Spring spring;
  equation
    connect(ground.f, first.a);
    connect(first.b, second.a);
    connect(second.b, spring.a);
    connect(spring.b, first.a);
  end Ring;
end P;
"""


@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_ring_closes(tmp_path: Path, backend: str) -> None:
    file = tmp_path / "P.mo"
    file.write_text(RING)
    result = load(file, "P.Ring").simulate(1.0, intervals=2, backend=backend)
    assert result["spring.phi"] == pytest.approx(-0.7)
    assert result["second.b.R.e[1]"] == pytest.approx(math.cos(0.7))
    # The same torque all around the ring, and none into the ground.
    assert result["spring.b.t"] == pytest.approx(-7.0)
    assert result["first.a.t"] == pytest.approx(7.0)
    assert result["ground.f.t"] == pytest.approx(0.0)
