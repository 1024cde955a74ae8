"""All that a user may not have meant, though the equations fit.

In:   Dae, Mechanism (None where there are no frames), the warning about parts that are held
Out:  warnings, in the order in which they are told

    attachment    parts that float, and frames that are not connected
    open_ends     joints, rods and contacts with an end that is open
    massless      drives with nothing to move
    mounted       drives whose torque reacts twice
    copied        connections that were copied, of which not all was changed
    slipping      driven wheels without friction
    doubled       contacts that are twice there
    triangles     hinges of a loop that is rigid
    hung          loads on the ground, or on an axis
    unguided      followers that a contact alone holds
    unsprung      bodies on which nothing acts
    idle          springs, dampers and drives within one part
    signals       degrees for radian
    repelling     control laws of the wrong sign
    apart         mechanisms that do not act on each other
    proportions   bars whose numbers do not suit each other

One of them may be the reason of another: of copied connections to loads on an axis only the first
group that finds something is told.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from planarc.core.diagnostic import Diagnostic, Loose
from planarc.insight.apart import independent_mechanisms
from planarc.insight.attachment import attachment_warnings
from planarc.insight.copied import copied_connections
from planarc.insight.doubled import doubled_contacts
from planarc.insight.hung import loads_on_axes, loads_on_ground
from planarc.insight.idle import idle_between_flanges
from planarc.insight.massless import idle_drives, stopped_alone
from planarc.insight.mounted import twice_reacting_drives
from planarc.insight.open_ends import bare_contacts, bare_joints, bare_rods
from planarc.insight.proportions import odd_proportions
from planarc.insight.repelling import repelling_laws
from planarc.insight.signals import find_misread
from planarc.insight.slipping import slipping_wheels
from planarc.insight.triangles import rigid_triangles
from planarc.insight.unguided import unguided_followers
from planarc.insight.unsprung import unsprung_bodies
from planarc.ir.dae import Dae
from planarc.ir.mechanism import Mechanism

_Finder = Callable[[Dae, Mechanism], Iterable[Diagnostic]]


def find_suspicions(
    dae: Dae, mechanism: Mechanism | None, held: Diagnostic | None
) -> tuple[Diagnostic, ...]:
    told = (*idle_between_flanges(dae), *find_misread(dae), *repelling_laws(dae))
    told += (*odd_proportions(dae), *(() if held is None else (held,)))
    if mechanism is None:
        return told
    found = attachment_warnings(dae, mechanism)
    loose = any(isinstance(d, Loose) for d in found)  # what they are to hang on is no load
    drives = (
        ()
        if loose
        else _first(dae, mechanism, bare_contacts, bare_joints, idle_drives, stopped_alone)
    )
    doubts = (*copied_connections(dae), *slipping_wheels(dae, mechanism))
    doubts = doubts or tuple(doubled_contacts(dae))
    if held is None:
        doubts = doubts or _first(
            dae, mechanism, rigid_triangles, bare_rods, loads_on_ground, loads_on_axes
        )
    doubts = doubts or _first(dae, mechanism, unguided_followers, unsprung_bodies)
    doubts = (*doubts, *twice_reacting_drives(dae, mechanism))
    if not (found or drives or doubts or told):
        doubts = tuple(independent_mechanisms(dae, mechanism))
    return (*found, *drives, *doubts, *told)


def _first(dae: Dae, mechanism: Mechanism, *finders: _Finder) -> tuple[Diagnostic, ...]:
    """What the first of them finds that finds anything."""
    return next((told for find in finders if (told := tuple(find(dae, mechanism)))), ())
