"""Wall time by phase: what a command tells of where its seconds went."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter

from msgspec import Struct, field


class Clock(Struct):
    """Wall seconds spent in each phase, in the order in which they began."""

    seconds: dict[str, float] = field(default_factory=dict)
    #: called before each phase, and often in long ones; it raises where nobody waits any more
    watch: Callable[[], None] | None = None

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        if self.watch is not None:
            self.watch()
        begin = perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + perf_counter() - begin
