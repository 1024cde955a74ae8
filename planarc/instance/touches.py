"""The touches of a model (`impact`): what they read, what they set, and why a run may end at them.

    px_feel(block, t, out)    what all touches read: arrays as of `instance.contact.area.Reads`

and the table `px_touches`, rows as of `plan.Touch`.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import POINTER, REAL, SELDOM, Code, table
from planarc.codegen.native.carried import Carrier
from planarc.codegen.native.formulas import formula, real
from planarc.core.diagnostic import Diagnostic
from planarc.instance.actions import carry_values
from planarc.instance.clauses import reader
from planarc.instance.contact.area import Reads
from planarc.instance.plan import Jam, Touch
from planarc.ir.frame import Frame
from planarc.ir.program import Program
from planarc.solve.contact import messages
from planarc.solve.contact.touches import Points


def touch_functions(program: Program, carrier: Carrier | None = None) -> str:
    """The function, by a `carrier` carried out, and the table."""
    points = Points(program)
    rows = [
        n
        for touch, joint in zip(points.all, points.bound, strict=True)
        for n in (*(touch.slots[w.name.lower()] for w in Touch if w is not Touch.JOINT), int(joint))
    ]
    c = Code("px_feel", "void", ((POINTER, "m"), (REAL, "t"), (POINTER, "out")))
    m, t, out = c.arguments
    read = [touch.read[which.name.lower()] for which in Reads for touch in points.all]
    if not carry_values(program, read, carrier, c, out):
        leaf = reader(program, m.load(POINTER, Frame.W), t)
        for i, e in enumerate(read):
            out.store(real(c, formula(c, e, leaf)), i)
    c.give()
    return c.text(SELDOM) + table("px_touches", rows)


def jams(program: Program, number: str = "...") -> list[Diagnostic]:
    """Why a run may end at each touch, at time 0, in the order of `Jam`; bodies overlap by
    `number`."""
    points = Points(program)
    found = []
    for i in range(len(points.all)):
        told = {
            Jam.OVERLAP: messages.overlap(points, i, number, 0.0),
            Jam.ONE_BODY: messages.one_body(points, i, 0.0),
            Jam.NO_IMPACT: messages.no_impact(points, [i], None, 0.0),
            Jam.NO_FORCES: messages.no_forces(points, [i], None, 0.0),
            Jam.UNSOLVED: messages.lost(points, i, 0.0),
        }
        found += [told[kind] for kind in Jam]
    return found
