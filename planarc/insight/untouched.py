"""Contacts whose contours do not come near each other in a whole run.

In:   Result
Out:  notes R457, at the user's part

Nothing of such a contact acts. Mostly one of its frames is connected to the wrong end of a bar.

Example: the foot of a leg at its hip, which stays at its height over the ground.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.insight.connectors import grouped, owner
from planarc.ir.once import once
from planarc.ir.places import declared_part
from planarc.ir.program import Program

if TYPE_CHECKING:
    from planarc.ir.result import Result

#: The part of its gap at the start that a contact keeps which does not come near, and the gap of
#: what touches there, in m.
_KEPT, _NEAR = 0.5, 1e-9


def judge_untouched(result: Result) -> Iterator[Diagnostic]:
    import numpy as np

    if len(result.time) < 3 or result.ended is not None:
        return
    for name, slots in gaps_of_contacts(result.program):
        gaps = [result.of_slot(slot) for slot in slots]
        least = float(min(np.min(gap) for gap in gaps))
        first = float(min(np.ravel(gap)[0] for gap in gaps))
        part = declared_part(result.program, name)
        if part is not None and least > _KEPT * first > _KEPT * _NEAR:
            yield Diagnostic(
                "R457",
                f"the contours of `{name}` do not come near each other: their gap is {least:.3g} m "
                f"at least, and {first:.3g} m at the start",
                part.span,
                Severity.NOTE,
                hint=f"look at the ends that `{name}` is connected to, unless they are not to meet",
            )


@once
def gaps_of_contacts(program: Program) -> tuple[tuple[str, tuple[int, ...]], ...]:
    """The contacts of the user's model, with the slots of their gaps."""
    contacts = {p.name for p in program.parts if p.class_name.endswith(".Contacts.Contact")}
    contacts = {name for name in contacts if "[" not in name}  # some of many may meet nothing
    if not contacts:
        return ()
    columns = {c.name: c.slot for c in program.columns if ".gap[" in c.name}
    of_contact = grouped(columns, owner)
    known = sorted(contacts & of_contact.keys())
    return tuple((name, tuple(columns[gap] for gap in of_contact[name])) for name in known)
