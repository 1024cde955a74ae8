"""The objects of an exported model: its texts (`module`) as code of a processor that is small.

What many models share passes through LLVM's optimiser, and is kept. What counts is what an archive
makes of the code: it packs best where instructions stay in the order in which they are written, and
where a value is not moved between places. That are options of LLVM, which a whole process has; they
are set back behind each object.

Systems that call functions in the same way share their objects (`SYSTEMS`): an object knows neither
where its functions come from nor the form of its file. Windows, which calls in another way, shares
with Linux what is called inside (`parted`).

Needs:     llvmlite
Promises:  the same texts give the same bytes.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Sequence, Set
from contextlib import contextmanager
from enum import Enum
from functools import cache, cached_property
from importlib.metadata import version
from threading import Lock
from typing import TYPE_CHECKING

from planarc.codegen.native.assembly import SELDOM
from planarc.codegen.native.machine import emit_object
from planarc.core import cache as store
from planarc.core.data import Data
from planarc.core.processes import Aside
from planarc.export.link.bridge import called_inside, ways
from planarc.export.module import Written, write_whole
from planarc.export.parted import divide, names_in
from planarc.export.pruned import NONE, asked_in, calls_in, numbers_of, without
from planarc.instance.block import LARGER
from planarc.instance.plan import Table
from planarc.runtime.link.objects import read_object

if TYPE_CHECKING:
    from planarc.export.fmi.entries import Entries
    from planarc.export.image import Image
    from planarc.export.shared import Shared
    from planarc.ir.program import Program

#: What an instance does is marked, and what passes derivatives on: the time of a run goes into the
#: rest of the kernel. Code that LLVM would put into functions of its own packs better as it is.
_TIGHT = 'minsize optsize "nooutline" '
_INSTANCE = re.compile(
    r"^(define [^@]*@(?:px_\w+|pc_(?:eliminate|pass|ranges|rows|differences))\([^)]*\))"
    r" nounwind",
    re.MULTILINE,
)
#: What marks a seldom function in a library, which shall be small, and has no tables of addresses.
_SMALL = f'noinline {_TIGHT}"no-jump-tables"="true" '
#: What other processors have an instruction for.
_MAXIMUM = "llvm.maximum.f64"


class System(Data):
    """The least processor, what it shall do without, marks of all functions, and the system as on
    which functions of a library call each other, where that is another one."""

    cpu: str = ""
    features: str = ""
    marks: str = ""
    inside: str = ""


_LINUX, _WINDOWS = "x86_64-unknown-linux-gnu", "x86_64-pc-windows-msvc-elf"
#: By LLVM's names, each for all systems that call functions in the same way. macOS 11 runs on
#: nothing older than Penryn (2008), which has SSE4.1. Windows keeps nothing below the stack. On ARM
#: macOS has x18 for itself, and x29 for its chain of frames. LLVM moves nothing that is finished
#: where it is told of Cyclone.
SYSTEMS = {
    _LINUX: System("penryn", marks="noredzone"),
    _WINDOWS: System("penryn", marks="noredzone", inside=_LINUX),
    "aarch64-unknown-linux-gnu": System(
        "", "+reserve-x18", '"tune-cpu"="cyclone" "frame-pointer"="non-leaf"'
    ),
    "wasm32-unknown-unknown": System(),
}
#: Passes of LLVM over code that all models share; they take out, too, what a model has no use for.
#: Branches stay as they are written: what chooses between numbers without them is longer.
_PASSES = (
    *("ipsccp", "sroa", "ipsccp", "dead_arg_elimination", "instruction_combine"),
    *("global_dead_code_eliminate", "reassociate", "instruction_combine"),
)
#: The same over a model's own: its formulas have no more to be found, its loops have counters.
_OWN_PASSES = ("sroa", "loop_rotate")
#: Options of LLVM, their values here, and those that they have by themselves: nothing is scheduled,
#: nothing is moved out of loops or into branches, and values are not split to stay in registers.
_OPTIONS = (
    ("enable-misched", 0, 1),
    ("disable-machine-licm", 1, 0),
    ("disable-machine-sink", 1, 0),
    ("disable-lsr", 1, 0),
    ("disable-block-placement", 1, 0),
    ("grow-region-complexity-budget", 0, 10000),
)
#: Versions of LLVM that are known to have these: one without ends the process.
_TRIED = range(20, 23)
_LOCK = Lock()


def compile_library(
    program: Program, image: Image, entries: Entries, token: str, tolerance: float, triple: str
) -> tuple[bytes, ...]:
    """The objects of an exported model without derivatives, for a system and its processor."""
    return compile_for(write_whole(program, image, entries, token, tolerance, None, False), triple)


def compile_for(written: Written, triple: str) -> tuple[bytes, ...]:
    """The objects of a model for a system."""
    return compile_all(written, (triple,))[triple]


def compile_all(written: Written, triples: Collection[str]) -> dict[str, tuple[bytes, ...]]:
    """Its objects for several systems; those of shared texts are kept. The model's own are made
    once for those that call alike inside; systems that share nothing are made beside the others."""
    others = (written.own, written.derivatives)
    numbers = numbers_of(written.own, "px_plan")[: Table.POINTERS]
    asked = {n for text in (written.solver, *others) for n in asked_in(text)}
    shared = _Shared(written.shared, numbers, asked)
    shared_by = {system.inside for system in SYSTEMS.values()}

    def solver(triple: str) -> bytes:
        text = without(written.solver, "px_plan", numbers)
        return _kept(text, triple, names_in(text))[1]

    @cache
    def own(triple: str) -> tuple[bytes, ...]:
        return tuple(_compiled(text, triple, _OWN_PASSES) for text in others)

    @cache
    def inner(triple: str) -> tuple[bytes, ...]:
        return shared.compiled(Part.INNER, triple), solver(triple), *own(triple)

    def all_of(triple: str) -> Iterator[bytes]:
        inside = SYSTEMS[triple].inside
        if not inside and triple not in shared_by:
            yield from (shared.compiled(Part.WHOLE, triple), solver(triple), *own(triple))
            return
        outer = Part.OUTER_CALLED if inside else Part.OUTER
        made = [shared.compiled(outer, triple), *inner(inside or triple)]
        yield from made
        if inside:
            yield _compiled(ways(map(read_object, made)), triple)

    def made(some: Iterable[str]) -> dict[str, tuple[bytes, ...]]:
        return {triple: tuple(all_of(triple)) for triple in some}

    together = [t for t in triples if SYSTEMS[t].inside or t in shared_by]
    alone = [t for t in triples if t not in together]
    if not together or not alone:
        return made(triples)
    with Aside(lambda: iter((made(alone),))) as aside:
        found = made(together)
        return found | next(aside)


class Part(Enum):
    """Of what models share."""

    WHOLE = "whole"
    INNER = "inner"
    OUTER = "outer"
    OUTER_CALLED = "outer, called in another way"


class _Shared:
    """The objects of what models share. `numbers` are those of the model's plan, and `asked` is
    what its other modules ask for. Their names are known by what the text hangs on: it is written
    where that is new."""

    def __init__(self, shared: Shared, numbers: Sequence[int], asked: Set[str]) -> None:
        self._shared, self._numbers, self._asked = shared, numbers, asked

    def compiled(self, part: Part, triple: str) -> bytes:
        none = ("".join(str(n) if n in NONE else "." for n in self._numbers),)
        asked = ("", *sorted(self._asked), "")
        known = _name(part.value, triple, *none, *asked, *self._shared.key)
        name = (store.load("native", known) or b"").decode()
        found = store.load("native", name) if name else None
        if found is None:
            text, called = self._texts[part]
            name, found = _kept(text, triple, called)
            store.store("native", known, name.encode())
        return found

    @cached_property
    def _texts(self) -> dict[Part, tuple[str, Set[str]]]:
        """Each part, and what is called from elsewhere."""
        text = without(self._shared.text, "px_plan", self._numbers)
        inner, outer = divide(text)
        by_outer, by_inner = self._asked | names_in(outer), self._asked | names_in(inner)
        return {
            Part.WHOLE: (text, self._asked),
            Part.INNER: (inner, by_outer),
            Part.OUTER: (outer, by_inner),
            Part.OUTER_CALLED: (called_inside(outer), by_inner),
        }


def _name(*parts: str) -> str:
    return store.key("exported", version("llvmlite"), *parts)


def _kept(text: str, triple: str, called: Set[str]) -> tuple[str, bytes]:
    """The object, and the name by which it is kept."""
    called = called & calls_in(text)
    name = _name(triple, *sorted(called), text)
    known = store.load("native", name)
    if known is None:
        known = _compiled(text, triple, _PASSES, called)
        store.store("native", name, known)
    return name, known


def _compiled(
    text: str, triple: str, passes: Sequence[str] = (), called: Set[str] | None = None
) -> bytes:
    import llvmlite.binding as llvm

    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    system, fixed = SYSTEMS[triple], triple.startswith("wasm")
    machine = llvm.Target.from_triple(triple).create_target_machine(
        cpu=system.cpu,
        features=system.features,
        opt=1,
        reloc="static" if fixed else "pic",  # constants of wasm have addresses of their own
        codemodel="small",
    )
    text = _INSTANCE.sub(rf"\1 {_TIGHT}nounwind", text.replace(SELDOM, _SMALL))
    text = text.replace(' nounwind "', f' nounwind {system.marks} "')
    if not triple.startswith("x86"):
        text = text.replace(f"call double @{LARGER}(", f"call double @{_MAXIMUM}(")
    with _thrifty(not fixed):
        return emit_object(text, machine, ("pc_", "px_"), passes, called)


@contextmanager
def _thrifty(wanted: bool) -> Iterator[None]:
    """Code made here is small, where that is wanted."""
    import llvmlite.binding as llvm

    options = _OPTIONS if wanted and llvm.llvm_version_info[0] in _TRIED else ()
    with _LOCK:
        for name, here, _ in options:
            llvm.set_option("", f"-{name}={here}")
        try:
            yield
        finally:
            for name, _, usual in options:
                llvm.set_option("", f"-{name}={usual}")
