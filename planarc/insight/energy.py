"""Energy of a run: kinetic, potential, dissipated, supplied, and whether they balance.

In:   Values, the names of all components
Out:  Energies, each over the rows; None where nothing has mass

What a component stores is known by its variables, whatever its class is called:

    m, v_CM[2], I, w           kinetic m*v^2/2 + I*w^2/2      a body
    m, r_mass[2], v[2]         kinetic m*v^2/2                a rod with a mass on it
    m, r[2], v[2], frame_a     kinetic m*v^2/2                a point mass
    J, w                       kinetic J*w^2/2                an inertia of a drive train
    m, s, v                    kinetic m*v^2/2                a mass on a line
    c, s, s_unstretched        potential c*(s - s0)^2/2       a spring; likewise phi_rel, s_rel
    lossPower; f, speed, d     dissipated, integrated         dampers, friction; drag

Gravity's potential is that of the world's uniform or point field; where the forces on a body say
that the field is another one, its work is integrated. All other components with flanges or
frames (drives, applied forces) supply what flows out of them.

Promises:  mechanical(t) + dissipated(t) = mechanical(start) + supplied(t), up to the errors of
           the run and of integrals over its rows; `balance` is the difference.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import TYPE_CHECKING

from planarc.core.data import Data
from planarc.insight.values import Values, integral
from planarc.ir.mechanism import GROUND

if TYPE_CHECKING:
    from planarc.insight.values import Vector
    from planarc.ir.insight import Track
    from planarc.ir.mechanism import Mechanism
    from planarc.ir.result import Result

#: Two accelerations of gravity that differ by more, relative to the larger, differ.
_SAME = 1e-4


class Energies(Data):
    """In joule, over the rows; `dissipated` and `supplied` since the start."""

    kinetic: Vector
    potential: Vector
    dissipated: Vector
    supplied: Vector

    @property
    def mechanical(self) -> Vector:
        return self.kinetic + self.potential

    @property
    def balance(self) -> Vector:
        """Zero, but for the errors of the run."""
        total = self.mechanical
        difference: Vector = total - total[0] + self.dissipated - self.supplied
        return difference

    @property
    def exchanged(self) -> float:
        """How much energy moved from one kind to another: what `balance` is compared with."""
        import numpy as np

        kinds = (self.kinetic, self.potential, self.dissipated, self.supplied)
        return max(float(np.ptp(kind)) for kind in kinds)


class _Mass(Data):
    """A mass in the plane: where it is, how it moves; `body` if forces on it are known."""

    m: Track
    r: tuple[Track, Track]
    v: tuple[Track, Track]
    body: str = ""


def find_energies(result: Result, mechanism: Mechanism | None) -> Energies | None:
    """None for a run of fewer than two rows, or of a model without any mass."""
    import numpy as np

    if len(result.time) < 2:
        return None
    values = Values(result)
    kinetic: Track = 0.0
    potential: Track = 0.0
    losses: Track = 0.0
    masses: list[_Mass] = []
    known: set[str] = set()
    for part in result.program.parts:
        name, has = part.name, values.has
        found = list(_masses(values, name))
        masses += found
        for mass in found:
            kinetic = kinetic + mass.m * (_squared(mass.v)) / 2
        if found and has(name, "I", "w"):
            kinetic = kinetic + _half(values, name, "I", "w")
        elif not found and has(name, "J", "w"):
            kinetic = kinetic + _half(values, name, "J", "w")
        elif not found and has(name, "m", "s", "v") and not has(name, "frame_a.phi"):
            kinetic = kinetic + _half(values, name, "m", "v")
        elif not found and (stored := _spring(values, name)) is not None:
            potential = potential + stored
        elif not found and not has(name, "lossPower") and not has(name, "speed", "f", "d"):
            continue
        known.add(name)
        if has(name, "lossPower"):
            losses = losses + values.get(f"{name}.lossPower")
        elif has(name, "speed", "f", "d"):
            losses = losses + values.get(f"{name}.f") * values.get(f"{name}.speed")
    if not masses and isinstance(kinetic, float):
        return None
    potential = potential + _gravity(values, masses)
    supplied = _supplied(values, mechanism, known)
    full = values.full
    lost = integral(values.time, full(losses))
    given = integral(values.time, full(supplied))
    # What jumps at an instant was lost in an impact, or put in by one.
    steps = np.diff(full(kinetic) + full(potential), prepend=0.0)
    steps[np.diff(values.time, prepend=-np.inf) > 0] = 0.0
    lost += np.cumsum(np.maximum(-steps, 0.0))
    given += np.cumsum(np.maximum(steps, 0.0))
    return Energies(full(kinetic), full(potential), lost, given)


def _masses(values: Values, name: str) -> Iterator[_Mass]:
    get, pair, has = values.get, values.pair, values.has
    if has(name, "m", "v_CM[1]", "r_0CM[1]"):
        yield _Mass(get(f"{name}.m"), pair(name, "r_0CM"), pair(name, "v_CM"), name)
    elif has(name, "m", "r_mass[1]", "v[1]"):
        yield _Mass(get(f"{name}.m"), pair(name, "r_mass"), pair(name, "v"))
    elif has(name, "m", "r[1]", "v[1]", "frame_a.phi"):
        yield _Mass(get(f"{name}.m"), pair(name, "r"), pair(name, "v"), name)
    for half in ("a", "b"):
        if has(name, f"m_{half}", f"r_CM_{half}[1]", f"v_CM_{half}[1]"):
            m = get(f"{name}.m_{half}")
            yield _Mass(m, pair(name, f"r_CM_{half}"), pair(name, f"v_CM_{half}"))


def _half(values: Values, name: str, inertia: str, speed: str) -> Track:
    w = values.get(f"{name}.{speed}")
    return values.get(f"{name}.{inertia}") * w * w / 2


#: Stiffness acts on these, measured from those; less what a damper in series has taken.
_LENGTHS = (("s", "s_unstretched"), ("phi_rel", "phi_rel0"), ("s_rel", "s_rel0"))


def _spring(values: Values, name: str) -> Track | None:
    for length, unloaded in _LENGTHS:
        if values.has(name, "c", length, unloaded) and not values.has(name, "b"):
            x = values.get(f"{name}.{length}") - values.get(f"{name}.{unloaded}")
            if values.has(name, "s_damper"):
                x = x - values.get(f"{name}.s_damper")
            return values.get(f"{name}.c") * x * x / 2
    return None


def _gravity(values: Values, masses: list[_Mass]) -> Track:
    """The potential energy of gravity."""
    import numpy as np

    world = next(
        (p.name for p in values.result.program.parts if values.has(p.name, "g_0[1]", "mu")), None
    )
    if world is None or not masses:
        return 0.0
    kind = values.get(f"{world}.gravityType")
    field: list[tuple[Track, Track]]
    potential: list[Track]
    g_0 = values.pair(world, "g_0")
    mu = values.get(f"{world}.mu")
    with np.errstate(all="ignore"):
        if kind == 1.0:
            field = [(0.0, 0.0) for _ in masses]
            potential = [0.0 for _ in masses]
        elif kind == 3.0:
            far = [np.hypot(*mass.r) for mass in masses]
            field = [
                (-mu * m.r[0] / r**3, -mu * m.r[1] / r**3) for m, r in zip(masses, far, strict=True)
            ]
            potential = [-m.m * mu / r for m, r in zip(masses, far, strict=True)]
        else:
            field = [g_0 for _ in masses]
            potential = [-m.m * (g_0[0] * m.r[0] + g_0[1] * m.r[1]) for m in masses]
    total: Track = 0.0
    for mass, g, energy in zip(masses, field, potential, strict=True):
        felt = _felt(values, mass)
        if felt is None or _same(felt, g):
            total = total + energy
        else:  # a field of the user's own
            power = mass.m * (felt[0] * mass.v[0] + felt[1] * mass.v[1])
            total = total - integral(values.time, values.full(power))
    return total


def _felt(values: Values, mass: _Mass) -> tuple[Track, Track] | None:
    """The acceleration of gravity that the forces on a body tell: a - f/m."""
    if not mass.body or not isinstance(mass.m, float) or mass.m <= 0:
        return None
    a = values.pair(mass.body, "a_CM" if values.has(mass.body, "a_CM[1]") else "a")
    f = values.pair(mass.body, "frame_a.f")
    return a[0] - f[0] / mass.m, a[1] - f[1] / mass.m


def _same(one: tuple[Track, Track], other: tuple[Track, Track]) -> bool:
    import numpy as np

    far = np.hypot(one[0] - other[0], one[1] - other[1])
    size = np.maximum(np.hypot(*one), np.hypot(*other))
    return bool(np.max(far) <= _SAME * np.max(size) + 1e-9)


def _squared(v: tuple[Track, Track]) -> Track:
    return v[0] * v[0] + v[1] * v[1]


def _supplied(values: Values, mechanism: Mechanism | None, known: set[str]) -> Track:
    """The power that drives and applied forces put in."""
    parts = [p.name for p in values.result.program.parts]
    connectors = {p: c for p in parts if (c := _connector(values, p)) is not None}
    owners = {c.rpartition(".")[0] for c in connectors}
    ideal = known | _ideal(mechanism, connectors)
    power: Track = 0.0
    for owner in owners:
        # A component made of others is the sum of these.
        made = any(o.startswith(f"{owner}.") for o in owners) if owner else True
        if made or any(owner == i or owner.startswith(f"{i}.") for i in ideal):
            continue
        for connector in (c for c in connectors if c.rpartition(".")[0] == owner):
            for effort, position in connectors[connector]:
                power = power - values.get(f"{connector}.{effort}") * values.rate(
                    f"{connector}.{position}"
                )
    return power


def _ideal(mechanism: Mechanism | None, connectors: Collection[str]) -> set[str]:
    """Components whose forces do no work in all: joints, and what is rigid or fixed."""
    if mechanism is None:
        return set()
    link_of = {frame: i for i, link in enumerate(mechanism.links) for frame in link.frames}
    links: dict[str, list[int | None]] = {}
    for connector in connectors:
        links.setdefault(connector.rpartition(".")[0], []).append(link_of.get(connector))
    rigid = {
        owner
        for owner, on in links.items()
        if None not in on and len(set(on)) == 1 and (len(on) > 1 or on[0] == GROUND)
    }
    return rigid | {joint.name for joint in mechanism.joints}


_FRAME = (("f[1]", "r[1]"), ("f[2]", "r[2]"), ("t", "phi"))
_FLANGES = ((("tau", "phi"),), (("f", "s"),))


def _connector(values: Values, part: str) -> tuple[tuple[str, str], ...] | None:
    """Which efforts and positions a connector has; None for what is none.

    A connector holds nothing but these.
    """
    if values.has(part, *(name for both in _FRAME for name in both)):
        return _FRAME
    for flange in _FLANGES:
        if values.has(part, *flange[0]) and not values.has(part, "w"):
            return flange
    return None
