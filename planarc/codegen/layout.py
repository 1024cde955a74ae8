"""The workspace: which slot holds which value.

    time | parameters | start values | candidates | unknowns | discrete values | events

A slot is known by the text of its symbol (`rev.phi`, `der(rev.phi)`, `pre(n)`,
`event[3]`); start values by `start(rev.phi)`, nominal values by `nominal(rev.phi)`.
Unknowns stand in the order in which they are computed.
"""

from __future__ import annotations

from planarc.ir.expr import Expr, text

TIME = "time"


class Layout:
    """Gives out slots, one after the other."""

    def __init__(self) -> None:
        self.slots: dict[str, int] = {TIME: 0}

    @property
    def size(self) -> int:
        return len(self.slots)

    def add(self, *keys: Expr | str) -> None:
        for key in keys:
            name = key if isinstance(key, str) else text(key)
            self.slots.setdefault(name, len(self.slots))

    def __getitem__(self, key: Expr | str) -> int:
        return self.slots[key if isinstance(key, str) else text(key)]
