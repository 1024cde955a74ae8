"""Components of the user's own whose account of energy does not fit their forces.

In:   Result
Out:  warnings R445, each at the component

What flows into a component through its frames and flanges, and what it supplies, is stored in it or
lost. That of the library fits; one of a user's own may forget a half, or a sign. What jumps at an
instant, by `reinit` or by that of a part which is fixed to it, is an impact's: no power tells it.

Example: `energy(potential = c*x^2)` of a spring with `f = c*x`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.ir.once import once
from planarc.ir.places import is_own, own_part
from planarc.ir.program import Program

if TYPE_CHECKING:
    from planarc.insight.connectors import Pairs
    from planarc.insight.values import Values
    from planarc.ir.result import Result

#: Kinds of energy that are told as such, and as powers.
_STORED, _LOST, _SUPPLIED = ("kinetic", "potential"), "lossPower", "suppliedPower"
#: The least part of what is exchanged that is told, and the least multiple of what integrals over
#: every second row differ by from those over all: where powers jump, these err.
_OFF, _ERRORS = 0.02, 3.0
#: The part of the largest energy in the whole run below which none is looked at.
_NOTABLE = 1e-3


def judge_accounts(result: Result) -> Iterator[Diagnostic]:
    """A warning for each component whose energies do not add up to what its forces do."""
    own = own_accounts(result.program)
    if not own or len(result.time) < 2:
        return
    import numpy as np

    from planarc.insight.values import Values

    values = Values(result)
    with np.errstate(all="ignore"):
        declared = values.declared("energy")
        kept = (values.full(told[n]) for told in declared.values() for n in _STORED if n in told)
        least = _NOTABLE * max((float(np.ptp(e)) for e in kept), default=0.0)
        for component, connectors in own.items():
            if component in declared:
                off, size = _off(values, connectors, declared[component])
                if off > max(_OFF * size, least):
                    yield _unfit(result.program, component, off, size)


@once
def own_accounts(program: Program) -> dict[str, dict[str, Pairs]]:
    """The components of the user's own classes that declare all their energy by itself, with their
    connectors."""
    names: dict[str, set[str]] = {}
    foreign = {d.component for d in program.declared if d.foreign}
    for d in program.declared:
        if d.kind == "energy" and d.component not in foreign:
            names.setdefault(d.component, set()).add(d.name)
    known = {*_STORED, _LOST, _SUPPLIED}
    written = {e.component for e in program.equations if e.component and is_own(program, e.span)}
    own = [c for c, told in names.items() if c in written and told <= known]
    if not own:
        return {}
    from planarc.insight.connectors import find_connectors, grouped, owner

    connectors = find_connectors(c.name for c in program.columns)
    inside = grouped(connectors, owner)
    whole = (c for c in own if c in inside and not any(o.startswith(f"{c}.") for o in inside))
    return {c: {name: connectors[name] for name in inside[c]} for c in whole}


def _off(
    values: Values, connectors: Mapping[str, Pairs], told: Mapping[str, Any]
) -> tuple[float, float]:
    """The most in J by which an account is off, and the most that is exchanged."""
    import numpy as np

    from planarc.insight.values import integral, jumps

    power: Any = 0.0
    for connector, pairs in connectors.items():
        for flow, position in pairs:
            speed = values.rate(f"{connector}.{position}")
            power = power + values.get(f"{connector}.{flow}") * speed
    stored = sum((values.full(told[n]) for n in _STORED if n in told), 0.0 * values.time)
    flows = [power, told.get(_SUPPLIED, 0.0), told.get(_LOST, 0.0)]
    came, gave, lost = works = [integral(values.time, values.full(p)) for p in flows]
    seldom = (integral(values.time[::2], values.full(p)[::2]) for p in flows)
    errors = sum(float(np.abs(w[::2] - s).max()) for w, s in zip(works, seldom, strict=True))
    change = stored - stored[0] - np.cumsum(jumps(values.time, stored))
    off = float(np.abs(came + gave - change - lost).max())
    size = max(float(np.ptp(e)) for e in (*works, change))
    return off if off > _ERRORS * errors else 0.0, size


def _unfit(program: Program, component: str, off: float, size: float) -> Diagnostic:
    part = own_part(program, component)
    return Diagnostic(
        "R445",
        f"the energies that `{component}` declares do not fit its forces: they are off by "
        f"{off:.3g} J, where {size:.3g} J are exchanged",
        part.span if part else None,
        Severity.WARNING,
        hint="look at `annotation(__planarc(energy(...)))` of its class: what its forces take in, "
        "and what it supplies, is `potential` or `kinetic` then, or goes into `lossPower`",
    )
