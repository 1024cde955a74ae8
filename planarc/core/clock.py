"""Wall time by phase: what a command tells of where its seconds went."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter

from msgspec import Struct, field


class Clock(Struct):
    """Wall seconds spent in each phase, in the order in which they began."""

    seconds: dict[str, float] = field(default_factory=dict)
    #: called before each phase, and often in long ones; it raises where nobody waits any more
    watch: Callable[[], None] | None = None

    def phase(self, name: str) -> Phase:
        if self.watch is not None:
            self.watch()
        return Phase(self.seconds, name)


class Phase(Struct):
    """A context whose time is added to the others of its name."""

    seconds: dict[str, float]
    name: str
    begin: float = 0.0

    def __enter__(self) -> None:
        self.begin = perf_counter()

    def __exit__(self, *_: object) -> None:
        spent = perf_counter() - self.begin
        self.seconds[self.name] = self.seconds.get(self.name, 0.0) + spent
