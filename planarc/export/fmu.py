"""A compiled model as an FMU: a file that other simulators run, without planarc.

In:   Compiled, Wishes
Out:  bytes of the archive

    modelDescription.xml            names, units, start values
    documentation/index.html        the same for people, with a picture
    extra/planarc/                  the model's text
    binaries/PLATFORM/NAME.so       the model as machine code; .dll, .dylib
    resources/numbers.bin           what large models hold once for all of these
    sources/                        the same in C99, where it is wished

Needs:     llvmlite
Promises:  the same model and wishes give the same bytes.
Raises:    PlanarcError C300 for what cannot be exported, and what a start may raise; UsageError
           C302, V505 and UnknownName for wishes that cannot be met.
"""

from __future__ import annotations

import re
from collections import ChainMap
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from hashlib import sha256
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from planarc.core.data import Data, without_collection
from planarc.core.diagnostic import usage_error
from planarc.core.processes import Aside
from planarc.core.prose import ticked
from planarc.core.unknown import refuse_unknown
from planarc.core.version import __version__
from planarc.export.archive import write_archive
from planarc.export.refusal import refuse
from planarc.export.wishes import Wishes, derivatives, restricted, tolerance_of
from planarc.view.storage import no_match

if TYPE_CHECKING:
    from planarc.compiled import Compiled
    from planarc.export.fmi.entries import Entries
    from planarc.export.fmi.variables import Dependencies, Interface
    from planarc.export.image import Image
    from planarc.export.module import Written
    from planarc.instance.plan import Lags
    from planarc.ir.program import Program
    from planarc.runtime.link.objects import Object


class Platform(Data):
    """A system and its processor: LLVM's name of what its objects are made for (`objects`), the
    ending of its libraries, and what FMI 2.0 calls it, which knows no ARM64."""

    triple: str
    ending: str
    older: str = ""


#: Platforms as FMI 3.0 calls them.
PLATFORMS = {
    "x86_64-linux": Platform("x86_64-unknown-linux-gnu", "so", "linux64"),
    "aarch64-linux": Platform("aarch64-unknown-linux-gnu", "so"),
    "x86_64-windows": Platform("x86_64-pc-windows-msvc-elf", "dll", "win64"),
    "x86_64-darwin": Platform("x86_64-unknown-linux-gnu", "dylib", "darwin64"),
    "aarch64-darwin": Platform("aarch64-unknown-linux-gnu", "dylib"),
}


class Fmu(Data):
    """The archive, and what a summary tells."""

    data: bytes
    inputs: int
    outputs: int
    parameters: int
    states: int
    exchange: bool  # whether it is for model exchange, too


def make_fmu(compiled: Compiled, wishes: Wishes) -> Fmu:
    """The archive of a model."""
    with without_collection():
        return _made(compiled, wishes)


def _made(compiled: Compiled, wishes: Wishes) -> Fmu:
    from planarc.export.fmi.variables import interface
    from planarc.export.idle import without_idle
    from planarc.export.image import take_image

    folders = _folders(wishes)
    program = restricted(without_idle(compiled.program), wishes.parameters)
    refuse(program, wishes.stiff)
    # Derivatives wait for the start only where they have to know how long the past is.
    image = take_image(compiled) if program.delays else None
    lags = None if image is None else image.lags
    entries = _entries(program, wishes)
    with Aside(lambda: _besides(program, wishes, lags, entries, _triples(folders))) as aside:
        image = replace(image or take_image(compiled), stiff=wishes.stiff)
        shown = interface(program, image.w, image.held, image.selection, wishes.outputs,
                          image.timed, wishes.stiff, image.step)  # fmt: skip
        files, written = _described(compiled, program, image, shown, wishes, entries, aside)
        files |= _libraries(program, written, folders, entries.names, aside)
    causes = [v.causality for v in shown.variables]
    return Fmu(
        write_archive(files),
        causes.count("input"),
        causes.count("output"),
        causes.count("parameter") - 1,  # that of the integrator is planarc's own
        program.state_count,
        image.step is None,
    )


def _besides(
    program: Program, wishes: Wishes, lags: Lags | None, entries: Entries, triples: Sequence[str]
) -> Iterator[Any]:
    """What depends on what, where there are derivatives; these; and texts that models share, which
    are not known yet."""
    from planarc.export.fmi.variables import dependencies, output_slots
    from planarc.export.module import derived, is_large, solver_text
    from planarc.export.objects import begin_texts
    from planarc.export.shared import Shared, traits_of
    from planarc.instance.plan import crowd_names

    slots = output_slots(program, wishes.outputs)
    slopes = None if crowd_names(program) else derivatives(program, slots)
    yield None if slopes is None else dependencies(program, slopes, slots)
    yield derived(program, lags, slopes, _spelled(wishes))
    apart = not wishes.source and is_large(program)
    likely, other = (
        Shared(traits_of(program, slopes is not None, True, so), entries, frozenset())
        for so in (apart, not apart)
    )
    yield from begin_texts(likely, other, solver_text(program), triples)


def _spelled(wishes: Wishes) -> bool:
    """What people read is no list of numbers, nor what implicit steps ask for again and again."""
    return not (wishes.source or wishes.stiff)


def _libraries(
    program: Program, written: Written, folders: Mapping[str, Platform], public: Sequence[str],
    aside: Aside[Any],
) -> dict[str, bytes]:  # fmt: skip
    """The model as machine code, in the order of the folders."""
    from planarc.export.objects import compile_all

    identifier = _identifier(program.name)
    names = {folder: f"{identifier}.{kind.ending}" for folder, kind in folders.items()}

    def link(triple: str, objects: Sequence[Object]) -> dict[str, bytes]:
        return {
            folder: make_library(kind, objects, names[folder], public)
            for folder, kind in folders.items()
            if kind.triple == triple
        }

    found = compile_all(written, _triples(folders), link, lambda: next(aside))
    made = ChainMap(*found.values())
    return {f"binaries/{folder}/{name}": made[folder] for folder, name in names.items()}


def _entries(program: Program, wishes: Wishes) -> Entries:
    """The functions of the interface."""
    from planarc.export.fmi import three, two
    from planarc.export.fmi.variables import shown_columns
    from planarc.instance.plan import crowd_names
    from planarc.ir.dae import Kind

    kinds = {c.kind for c in shown_columns(program, wishes.outputs)}
    version: Any = three if wishes.version == 3 else two
    enumerations = Kind.ENUMERATION in kinds
    integers = enumerations or Kind.INTEGER in kinds
    crowded = bool(crowd_names(program))
    found: Entries = version.functions(bool(program.delays), crowded, enumerations, integers)
    return found


def _described(
    compiled: Compiled, program: Program, image: Image, shown: Interface, wishes: Wishes,
    entries: Entries, aside: Aside[Any],
) -> tuple[dict[str, bytes], Written]:  # fmt: skip
    """All files but the libraries, and what these are made of."""
    from planarc.export.documentation import documents
    from planarc.export.fmi.description import Told, describe
    from planarc.export.fmi.terminals import describe_terminals
    from planarc.export.fmi.variables import by_reference
    from planarc.export.module import write
    from planarc.instance.stored import FILE

    if wishes.source:
        from planarc.export.c.library import COMPILED, describe_build, library_sources

    seen = [v.name for v in shown.variables if v.causality == "output"]
    if wishes.outputs is not None and not any(map(wishes.outputs.search, seen)):
        raise no_match("variable that changes", wishes.outputs)
    identifier = _identifier(program.name)

    @cache
    def draft() -> str:
        """The description without its token."""
        known: Dependencies | None = next(aside)
        told = Told(wishes.version, identifier, "", _tool(), known is not None,
                    COMPILED if wishes.source else (), image.step is None)  # fmt: skip
        by_names = by_reference(program, shown, known or {})
        return describe(program, replace(shown, dependencies=by_names), told)

    def token() -> str:
        return "{" + sha256(draft().encode() + image.w.tobytes()).hexdigest()[:32] + "}"

    files = documents(compiled, shown)
    written = write(program, image, entries, token, tolerance_of(program), lambda: next(aside),
                    spelled=_spelled(wishes), apart=not wishes.source)  # fmt: skip
    if wishes.version == 3 and (terminals := describe_terminals(program, shown)):
        files["terminalsAndIcons/terminalsAndIcons.xml"] = terminals.encode()
    key = "instantiationToken" if wishes.version == 3 else "guid"
    text = draft().replace(f'{key}=""', f'{key}="{token()}"', 1)
    files = {"modelDescription.xml": text.encode(), **files}
    if written.stored:
        files[f"resources/{FILE}"] = written.stored
    if wishes.source:
        sources = library_sources(program, written.texts, entries, wishes.version)
        if wishes.version == 3:
            sources["buildDescription.xml"] = describe_build(identifier)
        files |= {f"sources/{name}": source.encode() for name, source in sources.items()}
    return files, written


def _folders(wishes: Wishes) -> dict[str, Platform]:
    """The folders of the libraries. Raises UsageError C302, UnknownName."""
    if wishes.version not in (2, 3):
        raise usage_error("C302", f"there is no version {wishes.version} of FMI to export",
                          hint="choose 3 or 2")  # fmt: skip
    of_version = {p: k for p, k in PLATFORMS.items() if wishes.version == 3 or k.older}
    wanted = tuple(of_version) if wishes.platforms is None else wishes.platforms
    refuse_unknown("platform", wanted, PLATFORMS)
    lacking = [p for p in wanted if p not in of_version]
    if lacking or not wanted:
        what = f"FMI 2.0 knows no {ticked(lacking)}" if lacking else "an FMU needs a platform"
        raise usage_error("C302", what, hint=f"choose among {ticked(of_version)}")
    return {p if wishes.version == 3 else of_version[p].older: of_version[p] for p in wanted}


def _triples(folders: Mapping[str, Platform]) -> tuple[str, ...]:
    """What objects are made for, each once."""
    return tuple(dict.fromkeys(kind.triple for kind in folders.values()))


def make_library(kind: Platform, code: Sequence[Object], name: str, public: Sequence[str]) -> bytes:
    """A shared library; elementary functions are those of the system."""
    from planarc.export.link import elf, macho, pe
    from planarc.export.link.bridge import by_ways
    from planarc.export.units import constants_once, reached
    from planarc.runtime.link.objects import put_together

    found = constants_once(reached(put_together(by_ways(code)), public))
    lacking = {i: s.name for i, s in enumerate(found.symbols)
               if s.section is None and s.name.startswith(("pc_", "px_"))}  # fmt: skip
    used = {lacking[r.symbol] for s in found.sections for r in s.relocations if r.symbol in lacking}
    assert not used, f"no system has {', '.join(sorted(used))}"
    if kind.ending == "dll":
        return pe.write_library(found, name, public, "ucrtbase.dll")
    if kind.ending == "dylib":
        return macho.write_library(found, name, public, "/usr/lib/libSystem.B.dylib")
    return elf.write_library(found, name, public, ("libm.so.6", "libc.so.6"))


def _identifier(name: str) -> str:
    """A name that C accepts."""
    last = re.findall(r"'(?:[^'\\]|\\.)*'|[^.]+", name)[-1].strip("'")
    return re.sub(r"^(?=\d)|\W", "_", last, flags=re.ASCII)


def _tool() -> str:
    return f"planarc {__version__}"
