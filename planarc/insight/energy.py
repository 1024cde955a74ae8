"""Energy of a run: kinetic, potential, dissipated, supplied, and whether they balance.

In:   Result, what its components declare (`annotation(__planarc(energy(...)))`), Mechanism
Out:  Energies, each over the rows; None where no component declares kinetic energy

    kinetic, potential           in J, added up; a potential that is told by its rate is integrated
    lossPower, suppliedPower     in W, integrated
    not told                     what flows through the connectors of components that declare
                                 nothing and are no joints, by component

Example: of `annotation(__planarc(energy(potential = c*(s - s0)^2/2, lossPower = d*v^2)))` the
first is added to `potential`, the integral of the second to `dissipated`.

Promises:  mechanical(t) + dissipated(t) = mechanical(start) + supplied(t) + untold(t), up to the
           errors of the run and of integrals over its rows; `balance` is the difference of what
           is told, without `untold`.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

from planarc.core.arrays import Vector
from planarc.core.data import Data
from planarc.insight.connectors import find_connectors, grouped, owner
from planarc.insight.values import Values, integral, jumps
from planarc.ir.insight import Track
from planarc.ir.mechanism import GROUND, Mechanism
from planarc.ir.result import Result

#: The least difference of a potential from the integral of its rate, as a share of its range,
#: and as a multiple of the error that integrals over these rows have.
_DIFFERENT = 1e-4
_ERRORS = 10
#: The least share of all energy exchanged that makes a silent component worth telling of.
_NOTABLE = 1e-3


class Energies(Data):
    """Energies in joule over the rows; `dissipated`, `supplied`, `strangers` since the start."""

    kinetic: Vector
    potential: Vector
    dissipated: Vector
    supplied: Vector
    strangers: Mapping[str, Vector]  # what components put in that declare nothing

    @property
    def mechanical(self) -> Vector:
        return self.kinetic + self.potential

    @property
    def untold(self) -> Vector:
        """The energy that all components put in that declare nothing."""
        total: Vector = sum(self.strangers.values(), 0 * self.supplied)
        return total

    @property
    def balance(self) -> Vector:
        """The energy that is missing: errors of the run, and whatever no component declares."""
        total = self.mechanical
        difference: Vector = total - total[0] + self.dissipated - self.supplied
        return difference

    @property
    def exchanged(self) -> float:
        """The energy that moved from one kind to another: the measure of `balance`."""
        kinds = (self.kinetic, self.potential, self.dissipated, self.supplied, self.untold)
        return max(float(np.ptp(kind)) for kind in kinds)


def find_energies(
    result: Result, mechanism: Mechanism | None, values: Values | None = None
) -> Energies | None:
    """The energies of a run; None without two rows, or where nothing has kinetic energy."""
    if len(result.time) < 2:
        return None
    values = values or Values(result)
    with np.errstate(all="ignore"):
        declared = values.declared("energy")
    kinetic, potential = (_stored(values, declared, kind) for kind in ("kinetic", "potential"))
    if kinetic is None:
        return None
    full = values.full
    stored = full(kinetic), full(0.0 if potential is None else potential)
    lost, given = (_given(values, declared, kind) for kind in ("lossPower", "suppliedPower"))
    # What jumps at an instant was lost in an impact, or put in by one.
    steps = jumps(values.time, stored[0] + stored[1])
    if steps.any():
        lost = lost + np.cumsum(np.maximum(-steps, 0.0))
        given = given + np.cumsum(np.maximum(steps, 0.0))
    powers = _strangers(values, mechanism, declared)
    found = Energies(
        *stored, lost, given, {n: integral(values.time, full(p)) for n, p in powers.items()}
    )
    least = _NOTABLE * found.exchanged
    notable = {n: v for n, v in found.strangers.items() if np.ptp(v) > least}
    return Energies(*stored, lost, given, notable)


_Declared = Mapping[str, Mapping[str, Any]]


def _stored(values: Values, declared: _Declared, kind: str) -> Track | None:
    """The sum of what components store, told by itself or by its rate."""
    found: Track | None = None
    for own in declared.values():
        rate = own.get(f"{kind}.rate")
        if kind in own or rate is not None:
            energy = own[kind] if rate is None else _checked(values, own.get(kind), rate)
            found = energy if found is None else found + energy
    return found


def _checked(values: Values, energy: Track | None, rate: Track) -> Track:
    """An energy if it changes by its rate, else the integral of that rate.

    The integral of the energy's own differences tells how exact integrals over these rows are.
    """
    full = values.full
    work = integral(values.time, full(rate))
    if energy is None:
        return work
    change = full(energy) - full(energy)[0]
    own = integral(values.time, full(values.slope(energy)))
    error, allowed = np.abs(change - work).max(), np.abs(change - own).max()
    size = max(np.ptp(change), np.ptp(work))
    return work if error > _ERRORS * allowed + _DIFFERENT * size else energy


def _given(values: Values, declared: _Declared, kind: str) -> Vector:
    """The integral of all powers of a kind."""
    power = sum((own[kind] for own in declared.values() if kind in own), 0.0)
    return integral(values.time, values.full(power))


def _strangers(
    values: Values, mechanism: Mechanism | None, declared: _Declared
) -> dict[str, Track]:
    """The powers of components that declare nothing, by component."""
    connectors = find_connectors(values.result.columns)
    inside = grouped(connectors, owner)
    known = {*declared, *_ideal(mechanism, connectors)}
    powers: dict[str, Track] = {}
    for name, own in inside.items():
        # A component made of others is the sum of these.
        made = any(o.startswith(f"{name}.") for o in inside) if name else True
        if made or any(name == k or name.startswith(f"{k}.") for k in known):
            continue
        power: Track = 0.0
        for connector in own:
            for flow, position in connectors[connector]:
                speed = values.rate(f"{connector}.{position}")
                power = power - values.get(f"{connector}.{flow}") * speed
        powers[name] = power
    return powers


def _ideal(mechanism: Mechanism | None, connectors: Collection[str]) -> set[str]:
    """Components whose forces do no work in all: joints, and what is rigid or fixed."""
    if mechanism is None:
        return set()
    link_of = {frame: i for i, link in enumerate(mechanism.links) for frame in link.frames}
    rigid = set()
    for component, own in grouped(connectors, owner).items():
        on = [link_of.get(connector) for connector in own]
        if None not in on and len(set(on)) == 1 and (len(on) > 1 or on[0] == GROUND):
            rigid.add(component)
    return rigid | {joint.name for joint in mechanism.joints}
