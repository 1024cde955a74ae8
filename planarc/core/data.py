"""The data that stages hand on: immutable values with named fields.

    class Point(Data):              Point(1.0, y=2.0), Point(1.0, 2.0) == Point(1.0, 2.0),
        x: float                    replace(point, x=3.0), case Point(x, y): ...
        y: float = 0.0

A `Data` is a frozen `msgspec.Struct`: construction, comparison, hash and pickling are
written in C once for all classes. A frozen dataclass writes and compiles Python text for
each class instead, ten times as long per class and seven times per object, and planarc
has some 300 classes, half of which every start of the command needs.

`Located` is for what stands somewhere in a text: two are equal when they say the same
thing, wherever they say it. Values that change are plain `msgspec.Struct`s.
`without_collection` is for whoever makes trees of many, `nested_deeply` is for walks through them.
"""

from __future__ import annotations

import gc
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from itertools import count
from operator import attrgetter
from typing import Any, dataclass_transform

from msgspec import Struct, field


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
class Data(Struct, frozen=True):
    """An immutable value with named fields, equal to another one of equal fields."""


class Located(Data):
    """`Data` whose spans (fields named `span` or `..._span`) say where it stands: they take
    no part in comparison, hash and `repr`."""

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if type(self) is not type(other):
            return NotImplemented
        content = _content(type(self))
        return bool(content(self) == content(other))

    def __hash__(self) -> int:
        return hash(_content(type(self))(self))

    def __repr__(self) -> str:
        kind = type(self)
        shown = ", ".join(f"{name}={getattr(self, name)!r}" for name in _told(kind))
        return f"{kind.__qualname__}({shown})"


def _told(kind: type[Located]) -> tuple[str, ...]:
    """The names of the fields that count."""
    return tuple(name for name in kind.__struct_fields__ if not name.endswith("span"))


@cache
def _content(kind: type[Located]) -> Callable[[Located], Any]:
    """A function that gives the fields that count, as one value."""
    names = _told(kind)
    return attrgetter(*names) if names else lambda _: ()


#: So many objects are worth sparing Python a search; once in so many times it searches through
#: everything, for the few cycles there are.
MANY, EVERY = 100_000, 4

NESTING = 12_000  # calls of Python inside each other, which does not take all of its stack
_turns = count(1)


@contextmanager
def nested_deeply() -> Iterator[None]:
    """A while in which recursion may go as deep as expressions and classes that are handled."""
    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(max(limit, NESTING))
    try:
        yield
    finally:
        sys.setrecursionlimit(limit)


@contextmanager
def without_collection() -> Iterator[None]:
    """A while without Python's search for cycles: trees have few, and it takes a third of it.

    Where much was made in the while and is there still, it counts as old behind it: it is looked
    through when Python looks through everything, and not three times at once.
    """
    collecting = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collecting:
            if gc.get_count()[0] > MANY and not gc.get_freeze_count():
                if next(_turns) % EVERY:  # what a caller has frozen would not stay so
                    gc.freeze()
                    gc.unfreeze()
                else:
                    gc.collect()
            gc.enable()
