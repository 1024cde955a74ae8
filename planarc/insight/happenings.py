"""Events in words of the components at which they happen.

In:   Result, what its components declare (`annotation(__planarc(event('sticks' = locked)))`)
Out:  its events: "`bearing` sticks" where that became true, else the relation that switched

A declaration holds at an event where its condition is false in the row before and true in the row
behind; where it has a `from`, that is true in the row before. Relations of a component that says
what happened are left out; those of one that says nothing this time are told with its name.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import zip_longest
from typing import Any

import numpy as np
from msgspec.structs import replace

from planarc.insight.values import Values
from planarc.ir.result import EventRecord, Result

KIND, _FROM = "event", ".from"


def name_events(result: Result) -> tuple[EventRecord, ...]:
    """The events, with causes as a person tells them."""
    declared = Values(result).declared(KIND)
    known = {
        component: {
            name: np.broadcast_to(np.asarray(v), result.time.shape) for name, v in own.items()
        }
        for component, own in declared.items()
    }
    times = [e.time for e in result.events]
    first = np.searchsorted(result.time, times, "left").tolist()
    last = (np.searchsorted(result.time, times, "right") - 1).tolist()
    rows = zip(result.events, first, last, strict=True)
    return tuple(_named(event, known, a, b) for event, a, b in rows)


def _named(
    event: EventRecord, known: Mapping[str, Mapping[str, Any]], before: int, behind: int
) -> EventRecord:
    said: dict[str, list[str]] = {}
    if before < behind:
        for component, own in known.items():
            said[component] = [n for n in own if _happens(own, n, before, behind)]
    told = [f"`{component}` {name}" for component, names in said.items() for name in names]
    told += [
        f"`{owner}`: {text}" if owner in known else text
        for text, owner in zip_longest(event.causes, event.owners, fillvalue="")
        if not said.get(owner)
    ]
    return replace(event, causes=tuple(dict.fromkeys(told)))


def _happens(own: Mapping[str, Any], name: str, before: int, behind: int) -> bool:
    """Whether a condition becomes true, coming from where it says."""
    if name.endswith(_FROM) or not own[name][behind] or own[name][before]:
        return False
    origin = own.get(name + _FROM)
    return origin is None or bool(origin[before])
