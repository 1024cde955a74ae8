"""The objects of an exported model: its texts (`module`) as machine code.

What many models share passes through LLVM's optimiser, and is kept.

Systems that call functions in the same way share their objects (`emission.SYSTEMS`): an object
knows neither where its functions come from nor the form of its file. Windows, which calls in
another way, shares with Linux what is called inside (`parted`).

Needs:     llvmlite
Promises:  the same texts give the same objects.
"""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Collection, Iterable, Mapping, Set
from contextlib import nullcontext
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
    on_system,
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
    """Its objects for several systems; those of shared texts are kept. Those of systems that have
    nothing in common are made side by side, and the model's own beside new shared ones."""
    shared = _Shared(written)
    others = (written.own, written.derivatives)
    families: dict[str, list[str]] = {}
    for triple in triples:
        families.setdefault(SYSTEMS[triple].inside or triple, []).append(triple)

    @cache
    def own(inner: str) -> tuple[Object, ...]:
        return tuple(read_object(emitted(text, inner, OWN_PASSES)) for text in others)

    def family(inner: str) -> dict[str, tuple[Object, ...]]:
        inside = (
            *shared.compiled(Part.INNER, inner),
            *shared.compiled(Part.SOLVER, inner),
            *own(inner),
        )
        return {triple: with_outside(triple, inside) for triple in families[inner]}

    def with_outside(triple: str, inside: Iterable[Object]) -> tuple[Object, ...]:
        if not SYSTEMS[triple].inside:
            return (*shared.compiled(Part.OUTER, triple), *inside)
        made = (*shared.compiled(Part.OUTER_CALLED, triple), *inside)
        return (*made, read_object(emitted(ways(made), triple)))

    wanted = {(part, SYSTEMS[t].inside or t) for t in triples for part in (Part.INNER, Part.SOLVER)}
    wanted |= {(Part.OUTER_CALLED if SYSTEMS[t].inside else Part.OUTER, t) for t in triples}
    if new := shared.new(wanted):
        with Aside(lambda: iter((shared.texts(new),))) as aside:
            for inner in families:
                own(inner)
            shared.know(next(aside))
    first, *rest = families
    with Aside(lambda: map(family, rest)) if rest else nullcontext(iter(())) as others_made:
        return dict(ChainMap(family(first), *(next(others_made) for _ in rest)))


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
        self._texts: dict[Part, str] = {}

    def new(self, wanted: Iterable[tuple[Part, str]]) -> set[Part]:
        """Which of these are not kept for one of these systems."""
        return {p for p, t in wanted if store.load("native", self._name(p, t)) is None}

    def texts(self, parts: Iterable[Part]) -> dict[Part, str]:
        """Their texts as LLVM leaves them."""
        return {part: shared_text(self._text(part), self._called(part)) for part in parts}

    def know(self, texts: Mapping[Part, str]) -> None:
        self._texts.update(texts)

    def compiled(self, part: Part, triple: str) -> tuple[Object, ...]:
        name = self._name(part, triple)
        kept = store.load("native", name)
        if kept is not None:
            return tuple(code for _, code in _UNITS.decode(kept))
        if part not in self._texts:
            self.know(self.texts((part,)))
        kinds = _Kinds(triple)
        text = Text(on_system(self._texts[part], triple))
        known = kinds.known(set(text.keys.values()))
        units = tuple(text.units(known, lambda made, small: finished(made, triple, small)))
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
