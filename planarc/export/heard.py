"""Events of an instance, told to a function of the one who runs it.

    f(time, behind, w, crossing, fired, samples)

with pointers to the workspace, to flags of the relations and samplers that switch (64 bits each),
and to the starts of all samplers, then their intervals. It is called before an event, when all
values are there, and `behind` it.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, SELDOM, Code
from planarc.codegen.native.newton import open_frame
from planarc.export.fmi.entries import Entries
from planarc.instance.instants import samples
from planarc.instance.plan import Own, Relation, Sample
from planarc.instance.relations import numbers_of


def tell_events(e: Entries, name: str) -> None:
    """Let `name` be called before and behind each event."""
    c = Code("px_notice", "void", ((POINTER, "m"), (INT, "behind")))
    m, behind = c.arguments
    w, _, _, _ = open_frame(m)
    t = w.load(REAL)
    with c.when(behind.equals(0)):  # what results show need not be there
        c.call(FLAG, "pc_outputs", m, t, m.load(POINTER, Own.Y))
    told = (numbers_of(c, m, Relation.CROSSING), samples(c, m, Sample.FIRED),
            samples(c, m, Sample.START))  # fmt: skip
    c.run(name, t, c.flag(behind), w, *told)
    c.give()
    e.also(f"declare void @{name}(double, i32, ptr, ptr, ptr, ptr)\n" + c.text(SELDOM))
    e.tells = True
