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
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Set
from contextlib import nullcontext
from enum import Enum
from functools import cache, cached_property
from typing import TYPE_CHECKING, TypeVar

from msgspec import Raw, msgpack
from msgspec.structs import replace

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
from planarc.export.pruned import asked_in, calls_in, without
from planarc.export.shared import CALLED, Shared
from planarc.export.units import Text
from planarc.runtime.link.objects import Object, read_object

if TYPE_CHECKING:
    from planarc.export.fmi.entries import Entries
    from planarc.export.image import Image
    from planarc.ir.program import Program

#: What a caller makes of the objects for a system.
Linked = TypeVar("Linked")

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
    return compile_all(written, (triple,), lambda _, objects: objects)[triple]


def begin_texts(
    likely: Shared, other: Shared, solver: str, triples: Collection[str]
) -> Iterator[Mapping[str, str]]:
    """What takes longest of what is to be known of models that share what is `likely`, in two
    steps, where nothing that they may share is kept for all of these systems: `compile_all` wants
    it."""
    common, unlikely = (_Common(shared, solver, CALLED) for shared in (likely, other))
    new = common.new(triples) if unlikely.new(triples) else set()
    yield common.written() if new else {}
    yield common.left(new & {Part.INNER})


def compile_all(
    written: Written,
    triples: Collection[str],
    link: Callable[[str, tuple[Object, ...]], Linked],
    begun: Callable[[], Mapping[str, str]] = dict,
) -> dict[str, Linked]:
    """What is made of its objects for several systems; those of shared texts are kept. Systems that
    have nothing in common are served side by side. `begun` gives what another process has of their
    texts, and is asked twice, where they are new (`begin_texts`)."""
    common = _common(written, CALLED)
    others = (written.own, written.derivatives)
    families: dict[str, list[str]] = {}
    for triple in triples:
        families.setdefault(SYSTEMS[triple].inside or triple, []).append(triple)

    @cache
    def own(inner: str) -> tuple[Object, ...]:
        return tuple(read_object(emitted(text, inner, OWN_PASSES)) for text in others)

    def family(inner: str) -> dict[str, Linked]:
        inside = (
            *common.compiled(Part.INNER, inner),
            *common.compiled(Part.SOLVER, inner),
            *own(inner),
        )
        return {triple: link(triple, with_outside(triple, inside)) for triple in families[inner]}

    def with_outside(triple: str, inside: Iterable[Object]) -> tuple[Object, ...]:
        made = (*common.compiled(_outer(triple), triple), *inside)
        if not SYSTEMS[triple].inside:
            return made
        return (*made, read_object(emitted(ways(made), triple)))

    first, *rest = families
    if new := common.new(triples):
        common.know(begun())
        own(first)  # the other process is busy with the largest part
        common.left(new - {Part.INNER})
        common.know(begun())
        common.left(new)
    with Aside(lambda: map(family, rest)) if rest else nullcontext(iter(())) as others_made:
        return dict(ChainMap(family(first), *(next(others_made) for _ in rest)))


def compile_wasm(written: Written) -> tuple[bytes, ...]:
    """The objects of a model for a page, in a form of their own."""
    common = _common(written)
    return (
        common.whole(Part.WHOLE, WASM),
        common.whole(Part.SOLVER, WASM),
        *(emitted(text, WASM, OWN_PASSES) for text in (written.own, written.derivatives)),
    )


class Part(Enum):
    """Of what models share."""

    SOLVER = "solver"
    WHOLE = "whole"
    INNER = "inner"
    OUTER = "outer"
    OUTER_CALLED = "outer, called in another way"


def _outer(triple: str) -> Part:
    return Part.OUTER_CALLED if SYSTEMS[triple].inside else Part.OUTER


def _common(written: Written, others: Set[str] = frozenset()) -> _Common:
    asked = asked_in(written.own) | asked_in(written.derivatives)
    return _Common(written.shared, written.solver, asked | others)


class _Common:
    """The objects of what models share. They are known by what their text hangs on: it is written
    where that is new. Models of other kinds had most of their functions: these are known one by one
    (`units`). What no model but others asks for goes when a library is linked."""

    def __init__(self, shared: Shared, solver: str, called: Set[str]) -> None:
        """What is `called` of it, besides what `shared` knows."""
        called = shared.called | asked_in(solver) | called
        self._shared, self._solver = replace(shared, called=called), solver
        self._none = dict(shared.traits.none)
        self._texts: dict[str, str] = {}

    def new(self, triples: Iterable[str]) -> set[Part]:
        """Which parts are not kept for one of these systems."""
        wanted = {(part, SYSTEMS[t].inside or t) for t in triples
                  for part in (Part.INNER, Part.SOLVER)}  # fmt: skip
        wanted |= {(_outer(t), t) for t in triples}
        return {part for part, triple in wanted if self._kept(part, triple) is None}

    def written(self) -> dict[str, str]:
        """Their text by its name."""
        return {self._name(Part.WHOLE): self._all}

    def left(self, parts: Iterable[Part]) -> dict[str, str]:
        """Texts as LLVM leaves them, by the names that they have for all systems."""
        return {self._name(part): self._left(part) for part in parts}

    def know(self, texts: Mapping[str, str]) -> None:
        """Texts of `written` or `left` of what may be another model's."""
        self._texts.update(texts)

    def compiled(self, part: Part, triple: str) -> tuple[Object, ...]:
        kept = self._kept(part, triple)
        if kept is not None:
            return tuple(code for _, code in _UNITS.decode(kept))
        name, kinds = self._name(part, triple), _Kinds(triple)
        text = Text(on_system(self._left(part), triple))
        known = kinds.known(set(text.keys.values()))
        units = tuple(text.units(known, lambda made, small: finished(made, triple, small)))
        store.store("native", name, msgpack.encode([(u.key, u.code) for u in units]))
        kinds.add(name)
        return tuple(unit.code for unit in units)

    def whole(self, part: Part, triple: str) -> bytes:
        found = self._kept(part, triple)
        if found is None:
            found = shared_object(self._text(part), triple, self._called(part))
            store.store("native", self._name(part, triple), found)
        return found

    def _kept(self, part: Part, triple: str) -> bytes | None:
        return store.load("native", self._name(part, triple))

    def _name(self, part: Part, triple: str = "") -> str:
        if part is Part.SOLVER:
            return _name(part.value, triple, self._text(part))
        return _name(part.value, triple, *self._key)

    @cached_property
    def _key(self) -> tuple[str, ...]:
        return self._shared.key

    def _left(self, part: Part) -> str:
        return self._once(
            self._name(part), lambda: shared_text(self._text(part), self._called(part))
        )

    def _once(self, name: str, make: Callable[[], str]) -> str:
        if name not in self._texts:
            self._texts[name] = make()
        return self._texts[name]

    def _text(self, part: Part) -> str:
        match part:
            case Part.SOLVER:
                return without(self._solver, "px_plan", self._none)
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
        text, asked = self._text(part), self._shared.called
        match part:
            case Part.SOLVER:
                others: Set[str] = names_in(text)
            case Part.WHOLE:
                others = asked
            case Part.INNER:
                others = asked | names_in(self._divided[1])
            case Part.OUTER | Part.OUTER_CALLED:
                others = asked | names_in(self._divided[0])
        return others & calls_in(text)

    @cached_property
    def _all(self) -> str:
        return self._once(
            self._name(Part.WHOLE), lambda: without(self._shared.text(), "px_plan", self._none)
        )

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
    import llvmlite

    return store.key("exported", llvmlite.__version__, *parts)
