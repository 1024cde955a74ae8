"""What nothing hangs on is no parameter of an FMU."""

from __future__ import annotations

from planarc.compiler import compile_model
from planarc.export.idle import without_idle
from planarc.ir.program import Program
from planarc.request.request import Request
from tests.export.fmus import EXAMPLES

MODEL = """
model Known "Parameters that count and others"
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Revolute hinge(phi(start=start, fixed=true), w(fixed=true));
  PlanarMultiBody.Parts.BodyShape rod(r={1, 0}, r_CM={r, 0}, m=2, I=0.2, width=2*thin);
  parameter Real start = 1;
  parameter Real unread = 3;
  parameter Real r = half/2;
  parameter Real half = 1;
  parameter Real thin = 0.01;
  parameter Real most = 100;
equation
  assert(hinge.w < most, "over " + String(limits.told));
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, rod.frame_a);
protected
  Limits limits;
  model Limits
    parameter Real told = 2*said;
    parameter Real said = 50;
    parameter Real silent = 5;
  end Limits;
end Known;
"""


def names(program: Program) -> set[str]:
    return {p.name for p in program.parameter_slots}


def test_what_equations_and_messages_read_stays_and_so_does_what_the_model_has() -> None:
    program = compile_model(Request(text=MODEL)).program
    kept = without_idle(program)
    own = {"start", "unread", "r", "half", "thin", "most"}
    read = {"limits.told", "limits.said", "world.g", "world.n[1]", "rod.m", "rod.r_CM[1]"}
    assert own | read <= names(kept)
    gone = {"limits.silent", "rod.width", "rod.color[1]", "hinge.cylinderColor[1]"}
    assert gone <= names(program) and not gone & names(kept)
    assert {c.name for c in program.columns} - {c.name for c in kept.columns} <= names(program)


def test_values_keep_their_places_and_formulas() -> None:
    program = compile_model(Request(EXAMPLES / "cam_lift_off.pmo")).program
    kept = without_idle(program)
    assert kept.slots == program.slots and kept.levels == program.levels
    assert len(kept.columns) < len(program.columns)
    left = iter(program.parameters)
    assert all(any(s is other for other in left) for s in kept.parameters)
    assert without_idle(kept) == kept
