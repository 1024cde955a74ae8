"""The objects of an exported model: its texts (`module`) as machine code.

What many models share passes through LLVM's optimiser, and is kept.

Systems that call functions in the same way share their objects (`emission.SYSTEMS`): an object
knows neither where its functions come from nor the form of its file. Windows, which calls in
another way, shares with Linux what is called inside (`parted`).

Needs:     llvmlite
Promises:  the same texts give the same objects.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Set
from enum import Enum
from functools import cache, cached_property
from importlib.metadata import version
from typing import TYPE_CHECKING

from msgspec import Raw, msgpack

from planarc.core import cache as store
from planarc.core.processes import Aside
from planarc.export.emission import (
    OWN_PASSES,
    SYSTEMS,
    WASM,
    emitted,
    finished,
    shared_object,
    shared_text,
)  # fmt: skip
from planarc.export.link.bridge import called_inside, ways
from planarc.export.module import Written, write_whole
from planarc.export.parted import divide, names_in
from planarc.export.pruned import NONE, asked_in, calls_in, numbers_of, without
from planarc.export.units import Text
from planarc.instance.plan import Table
from planarc.runtime.link.objects import Object, read_object

if TYPE_CHECKING:
    from planarc.export.fmi.entries import Entries
    from planarc.export.image import Image
    from planarc.ir.program import Program

#: Kinds of models whose functions are looked through for those of a new one.
_LOOKED_AT = 64
_UNITS = msgpack.Decoder(list[tuple[str, Object]])
_RAW = msgpack.Decoder(list[tuple[str, Raw]])
_OBJECT = msgpack.Decoder(Object)


def compile_library(
    program: Program, image: Image, entries: Entries, token: str, tolerance: float, triple: str
) -> tuple[Object, ...]:
    """The objects of an exported model without derivatives, for a system and its processor."""
    return compile_for(write_whole(program, image, entries, token, tolerance, None, False), triple)


def compile_for(written: Written, triple: str) -> tuple[Object, ...]:
    """The objects of a model for a system."""
    return compile_all(written, (triple,))[triple]


def compile_all(written: Written, triples: Collection[str]) -> dict[str, tuple[Object, ...]]:
    """Its objects for several systems; those of shared texts are kept. The model's own are made
    once for those that call alike inside; systems that share nothing are made beside the others."""
    others = (written.own, written.derivatives)
    shared = _Shared(written)
    shared_by = {system.inside for system in SYSTEMS.values()}

    @cache
    def own(triple: str) -> tuple[Object, ...]:
        return tuple(read_object(emitted(text, triple, OWN_PASSES)) for text in others)

    @cache
    def inner(triple: str) -> tuple[Object, ...]:
        return (
            *shared.compiled(Part.INNER, triple),
            *shared.compiled(Part.SOLVER, triple),
            *own(triple),
        )

    def all_of(triple: str) -> Iterator[Object]:
        inside = SYSTEMS[triple].inside
        if not inside and triple not in shared_by:
            yield from shared.compiled(Part.WHOLE, triple)
            yield from shared.compiled(Part.SOLVER, triple)
            yield from own(triple)
            return
        outer = Part.OUTER_CALLED if inside else Part.OUTER
        made = [*shared.compiled(outer, triple), *inner(inside or triple)]
        yield from made
        if inside:
            yield read_object(emitted(ways(made), triple))

    def made(some: Iterable[str]) -> dict[str, tuple[Object, ...]]:
        return {triple: tuple(all_of(triple)) for triple in some}

    together = [t for t in triples if SYSTEMS[t].inside or t in shared_by]
    alone = [t for t in triples if t not in together]
    if not together or not alone:
        return made(triples)
    with Aside(lambda: iter((made(alone),))) as aside:
        found = made(together)
        return found | next(aside)


def compile_wasm(written: Written) -> tuple[bytes, ...]:
    """The objects of a model for a page, in a form of their own."""
    others = (written.own, written.derivatives)
    shared = _Shared(written)
    return (
        shared.whole(Part.WHOLE, WASM),
        shared.whole(Part.SOLVER, WASM),
        *(emitted(text, WASM, OWN_PASSES) for text in others),
    )


class Part(Enum):
    """Of what models share."""

    SOLVER = "solver"
    WHOLE = "whole"
    INNER = "inner"
    OUTER = "outer"
    OUTER_CALLED = "outer, called in another way"


class _Shared:
    """The objects of what models share. They are known by what their text hangs on, with the
    numbers of the model's plan and what its own modules ask for: it is written where that is new.
    Models of other kinds had most of their functions: these are known one by one (`units`)."""

    def __init__(self, written: Written) -> None:
        self._shared, self._solver = written.shared, written.solver
        self._numbers = numbers_of(written.own, "px_plan")[: Table.POINTERS]
        others = (written.solver, written.own, written.derivatives)
        self._asked = {name for text in others for name in asked_in(text)}

    def compiled(self, part: Part, triple: str) -> tuple[Object, ...]:
        name = self._name(part, triple)
        kept = store.load("native", name)
        if kept is not None:
            return tuple(code for _, code in _UNITS.decode(kept))
        kinds = _Kinds(triple)
        text = Text(shared_text(self._text(part), triple, self._called(part)))
        known = kinds.known(set(text.keys.values()))
        units = tuple(text.units(known, lambda made: finished(made, triple)))
        store.store("native", name, msgpack.encode([(u.key, u.code) for u in units]))
        kinds.add(name)
        return tuple(unit.code for unit in units)

    def whole(self, part: Part, triple: str) -> bytes:
        name = self._name(part, triple)
        found = store.load("native", name)
        if found is None:
            found = shared_object(self._text(part), triple, self._called(part))
            store.store("native", name, found)
        return found

    def _name(self, part: Part, triple: str) -> str:
        if part is Part.SOLVER:
            return _name(part.value, triple, self._text(part))
        none = "".join(str(n) if n in NONE else "." for n in self._numbers)
        asked = ("", *sorted(self._asked), "")
        return _name(part.value, triple, none, *asked, *self._shared.key)

    def _text(self, part: Part) -> str:
        match part:
            case Part.SOLVER:
                return without(self._solver, "px_plan", self._numbers)
            case Part.WHOLE:
                return self._all
            case Part.INNER:
                return self._divided[0]
            case Part.OUTER:
                return self._divided[1]
            case Part.OUTER_CALLED:
                return called_inside(self._divided[1])

    def _called(self, part: Part) -> Set[str]:
        """What is called of it from elsewhere."""
        text = self._text(part)
        match part:
            case Part.SOLVER:
                others = names_in(text)
            case Part.WHOLE:
                others = self._asked
            case Part.INNER:
                others = self._asked | names_in(self._divided[1])
            case Part.OUTER | Part.OUTER_CALLED:
                others = self._asked | names_in(self._divided[0])
        return others & calls_in(text)

    @cached_property
    def _all(self) -> str:
        return without(self._shared.text, "px_plan", self._numbers)

    @cached_property
    def _divided(self) -> tuple[str, str]:
        return divide(self._all)


class _Kinds:
    """The names under which the functions of several kinds of models are kept, the last first."""

    def __init__(self, triple: str) -> None:
        self._name = _name("kinds", triple)
        self._kept = (store.load("native", self._name) or b"").decode().split()

    def known(self, wanted: Set[str]) -> dict[str, Object]:
        """Which of these functions one of them has."""
        found: dict[str, Object] = {}
        for name in self._kept:
            if len(found) < len(wanted) and (kept := store.load("native", name)) is not None:
                for key, code in _RAW.decode(kept):
                    if key in wanted and key not in found:
                        found[key] = _OBJECT.decode(code)
        return found

    def add(self, name: str) -> None:
        names = [name, *self._kept][:_LOOKED_AT]
        store.store("native", self._name, " ".join(names).encode())


def _name(*parts: str) -> str:
    return store.key("exported", version("llvmlite"), *parts)
