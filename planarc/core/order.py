"""Names in the order of what they need.

Example: with a = 2*b, `in_order(("a", "b"), needs)` is ["b", "a"].
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator


class Circle(Exception):
    """Names that need each other, in their order."""

    def __init__(self, names: list[str]) -> None:
        super().__init__(names)
        self.names = names


def in_order(names: Iterable[str], needs: Callable[[str], Iterable[str]]) -> list[str]:
    """Each name after those that it needs, else as given. Raises Circle."""
    done: dict[str, None] = {}
    for first in names:
        path: dict[str, Iterator[str]] = {} if first in done else {first: iter(needs(first))}
        while path:
            name, rest = next(reversed(path.items()))
            for need in rest:
                if need in path:
                    around = list(path)
                    raise Circle(around[around.index(need) :])
                if need not in done:
                    path[need] = iter(needs(need))
                    break
            else:
                done[name] = None
                del path[name]
    return list(done)
