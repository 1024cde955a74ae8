"""The flat model's pieces for another component: the same text, other names.

In:   equations, variables, ... of one component, the prefix of its names
Out:  a function from another prefix to the same pieces with it, or None where no name has it

Example: `rev[1].phi = rev[1].frame_b.phi - world.phi` of `rev[1]`, asked for `rev[2]`, is
`rev[2].phi = rev[2].frame_b.phi - world.phi`. What holds no such name is shared, not copied.

Only names of variables and of components are changed, never texts or descriptions.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias, TypeVar

from msgspec import Struct, field

from planarc.core.data import Data
from planarc.ir import flat

Renamed: TypeAlias = Callable[[str], Any]


T = TypeVar("T")


class Unrepeatable(Exception):
    """A piece belongs to one component only, as a call of a function that it declares itself."""


def renaming(piece: Any, prefix: str) -> Renamed | None:
    """What makes the same piece of another prefix. Raises Unrepeatable."""
    kind: type = type(piece)
    if kind is tuple:
        return _of_items(piece, [renaming(item, prefix) for item in piece])
    if not isinstance(piece, Data):
        return None
    if _own_class(piece, prefix):
        raise Unrepeatable
    changes: list[tuple[int, Renamed]] = []
    values = []
    for index, name in enumerate(piece.__struct_fields__):
        value = getattr(piece, name)
        values.append(value)
        if isinstance(value, str):
            change = _of_name(value, prefix) if name in _NAMES.get(kind, _COMPONENT) else None
        else:
            change = renaming(value, prefix)
        if change is not None:
            changes.append((index, change))
    if not changes:
        return None

    def make(new: str) -> Any:
        changed = values.copy()
        for index, change in changes:
            changed[index] = change(new)
        return kind(*changed)

    return make


class Repeater(Struct, eq=False):
    """Pieces for other components; how each is made is found once."""

    plans: dict[tuple[str, str], Renamed | None] = field(default_factory=dict)

    def __call__(self, name: str, piece: T, old: str, new: str) -> T:
        """The piece of that name, with another prefix. Raises Unrepeatable."""
        key = name, old
        if key not in self.plans:
            self.plans[key] = renaming(piece, old)
        plan = self.plans[key]
        return piece if plan is None else plan(new)


_COMPONENT = ("component",)
_NAMES: dict[type, tuple[str, ...]] = {
    flat.Reference: ("name",),
    flat.Variable: ("name", "component"),
}


def _own_class(piece: Data, prefix: str) -> bool:
    """A function or a type that the component declares itself, and has its name."""
    match piece:
        case flat.Type(name=name) | flat.Call(function=name) | flat.PartialCall(function=name):
            return _of_name(name, prefix) is not None
    return False


def _of_name(name: str, prefix: str) -> Renamed | None:
    """The names of a component and of what is in it."""
    if not name.startswith(prefix):
        return None
    rest = name[len(prefix) :]
    return None if rest and rest[0] != "." else lambda new: new + rest


def _of_items(items: tuple[Any, ...], changes: list[Renamed | None]) -> Renamed | None:
    if not any(changes):
        return None
    pairs = list(zip(items, changes, strict=True))
    return lambda new: tuple([item if f is None else f(new) for item, f in pairs])
