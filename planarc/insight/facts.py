"""The findings of insight as labels with texts for people."""

from __future__ import annotations

from typing import TYPE_CHECKING

from planarc.core.prose import shortened

if TYPE_CHECKING:
    from planarc.insight.energy import Energies
    from planarc.insight.rank import Closeness
    from planarc.ir.mechanism import Mechanism
    from planarc.ir.result import Result

MOST_NAMES = 12
#: The part of the energy exchanged up to which a balance is said to hold.
_HOLDS = 0.02


def count_text(mechanism: Mechanism) -> str:
    """Bodies, joints, loops and mobility by count, on one line."""
    m = mechanism
    return (
        f"{_number(m.bodies, 'moving body', 'moving bodies')}, "
        f"{_number(m.pairs, 'joint', 'joints')}, "
        f"{_number(m.loops, 'independent loop', 'independent loops')}; "
        f"mobility {m.mobility} by count ({_sum(m)})"
    )


def _sum(m: Mechanism) -> str:
    """The terms of the count: 3*3 - 4*2."""
    points = sum(link.free == 2 for link in m.links)
    free = [f"3*{m.bodies - points}" if m.bodies - points else "", f"2*{points}" if points else ""]
    taken = []
    for conditions in (2, 1):
        count = sum(joint.conditions == conditions for joint in m.joints)
        taken += [f" - {count}*{conditions}"] if count else []
    taken += [f" - {joint.conditions}" for joint in m.joints if joint.conditions > 2]
    return (" + ".join(f for f in free if f) or "0") + "".join(taken)


def mechanism_facts(mechanism: Mechanism) -> list[tuple[str, str]]:
    names = [link.name for link in mechanism.links[1:]]
    joints = [joint.name for joint in mechanism.joints]
    return [
        ("moving bodies", f"{mechanism.bodies}: {_names(names)}" if names else "none"),
        ("joints", f"{mechanism.pairs}: {_names(joints)}" if joints else "none"),
        ("independent loops", str(mechanism.loops)),
        ("mobility by count", f"{mechanism.mobility} = {_sum(mechanism)}"),
    ]


def closeness_facts(
    result: Result, mechanism: Mechanism | None, found: Closeness | None
) -> list[tuple[str, str]]:
    import numpy as np

    if mechanism is None:
        return []
    sharing = result.program.sharing
    shared = sharing.open if sharing is not None and not sharing.everywhere else 0
    rank = mechanism.mobility + shared
    if found is None:
        return [("mobility by rank", f"{rank}, no loop is closed")]
    those = f"without {_number(shared, 'redundant one', 'redundant ones')} " if shared else ""
    rows = [
        (
            "mobility by rank",
            f"{rank} at the start: {those}the conditions of the loops are independent"
            f" (smallest singular value {found.loops[0]:.2g} of the largest)",
        )
    ]
    if not np.isfinite(found.held).any():
        return rows
    nearest = int(np.nanargmin(found.held))
    held = f" with {_names(found.states)} held" if found.states else ""
    rows.append(
        (
            "closest to a dead point",
            f"t = {result.time[nearest]:.4g} s{held}: smallest singular value"
            f" {found.held[nearest]:.2g} of the largest",
        )
    )
    return rows


def energy_facts(found: Energies | None) -> list[tuple[str, str]]:
    import numpy as np

    if found is None or not found.exchanged:
        return []
    dissipated, supplied = float(found.dissipated[-1]), float(found.supplied[-1])
    error = float(np.max(np.abs(found.balance - found.untold))) / found.exchanged
    parts = [f"kinetic up to {found.kinetic.max():.4g} J"]
    parts.append(f"potential over {np.ptp(found.potential):.4g} J")
    if abs(dissipated) > 1e-9 * found.exchanged:
        parts.append(f"dissipated {dissipated:.4g} J")
    if abs(supplied) > 1e-9 * found.exchanged:
        parts.append(f"supplied {supplied:.4g} J")
    rows = [("energy", ", ".join(parts))]
    if found.strangers:
        amount = float(np.max(np.abs(found.untold)))
        by = _names([f"`{name}`" for name in found.strangers])
        rows.append(("energy not told", f"up to {amount:.4g} J, exchanged by {by}"))
    how = "holds to" if error < _HOLDS else "is off by"
    return [*rows, ("energy balance", f"{how} {error:.1g} of the energy exchanged")]


def _number(count: int, one: str, many: str) -> str:
    return f"{count} {one if count == 1 else many}"


def _names(names: list[str] | tuple[str, ...]) -> str:
    return shortened(names, MOST_NAMES)
