"""An impact: touches that approach are struck until none does.

In:   the velocities of some touches, how impulses change them, restitution and friction
Out:  Blow    the impulses, and the velocities after them; None where there are none

Poisson's law with Coulomb's friction in two phases: impulses that end all approach, then, at each
touch, at least e times its normal impulse. Restitution is lowered to what energy permits.

Impacts at one instant follow each other: what approaches is struck together, and what rests
without restitution bears it; what approaches then is struck next. So a row of balls passes a blow
on. Touches that go on striking each other are at last struck together, without restitution.

Example: a ball with v = -2 m/s, e = 0.5, 1 kg: 2 N.s and 1 N.s, then v = 1 m/s.

Reference: F. Pfeiffer, C. Glocker, Multibody Dynamics with Unilateral Contacts, 1996, chapter 8.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from planarc.core.data import Data
from planarc.solve.contact.problem import IDLE, Spot, solve_contacts

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

#: Blows at one instant before all touches are struck together.
MOST_BLOWS = 200
#: Speeds below this part of the largest are none.
STILL = 1e-10
#: Halvings of the interval in which restitution is lowered.
HALVINGS = 50


class Blow(Data):
    x: Vector  # impulses: normal, then along slip
    u: Vector  # velocities after them
    fastest: Vector  # greatest speed of approach of each touch


def strike(a: Vector, u: Vector, e: Vector, mu: Vector, least: Vector) -> Blow | None:
    """The impulses of an impact, and the velocities after it; None where it does not end. Speeds
    of touches that are not above `least` are none."""
    k, x, fastest = len(e), np.zeros(len(u)), np.zeros(len(e))
    for blows in range(2 * MOST_BLOWS):
        v, still = u[:k], np.maximum(least, STILL * float(np.abs(u).max()))
        if not (v < -still).any():
            return Blow(x, u, fastest)
        fastest = np.maximum(fastest, -v)
        if blows < MOST_BLOWS:
            struck = np.flatnonzero((v < -still) | ((v <= still) & (e == 0)))
            own = e[struck]
        else:
            struck = np.flatnonzero((v <= still) | (x[:k] > 0))
            own = np.zeros(len(struck))
        rows = np.concatenate([struck, k + struck])
        found = _together(a[np.ix_(rows, rows)], u[rows], own, mu[struck], float(still.min()))
        if found is None:
            return None
        x[rows] += found
        u = u + a[:, rows] @ found
    return None


def _together(a: Vector, u: Vector, e: Vector, mu: Vector, noise: float) -> Vector | None:
    """The impulses of touches that are struck together; speeds below `noise` are rounding."""
    k = len(e)
    ways: Sequence[int | None] = [None if m > 0 else IDLE for m in mu]
    spots = [Spot(float(m), way) for m, way in zip(mu, ways, strict=True)]
    pressed = solve_contacts(a, u, spots, noise)
    if pressed is None or not e.any():
        return None if pressed is None else pressed.x

    def released(part: float) -> Vector | None:
        least = part * e * pressed.x[:k]
        floors = [Spot(s.mu, s.way, max(float(f), 0.0)) for s, f in zip(spots, least, strict=True)]
        found = solve_contacts(a, pressed.u, floors, noise)
        return None if found is None else pressed.x + found.x

    def gained(x: Vector) -> bool:
        work = x * (2 * u + a @ x)
        return float(work.sum()) > 1e-12 * float(np.abs(work).sum())

    whole = released(1.0)
    if whole is None or not gained(whole):
        return whole
    low, high, best = 0.0, 1.0, pressed.x
    for _ in range(HALVINGS):
        part = (low + high) / 2
        found = released(part)
        if found is None or gained(found):
            high = part
        else:
            low, best = part, found
    return best
