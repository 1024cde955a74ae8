"""The sources of an FMU: its functions in C99, as a compiler makes a library of them.

In:   Program, texts of `export.module`, names of the standard's functions
Out:  texts by file

    model.h, model.c, runtime.h, runtime.c      as `c.source` writes them
    buildDescription.xml                        what to compile, for FMI 3.0

Models that are linked into one program need names of their own: `FMI3_FUNCTION_PREFIX`, or that
of FMI 2, stands before all of them.

Reference: FMI 3.0.2, section 2.5.1.3; FMI 2.0.4, sections 2.1.1 and 2.2.1.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING
from xml.etree import ElementTree as Xml

from planarc.export.c.listing import read
from planarc.export.c.rows import declare
from planarc.export.c.source import translate
from planarc.export.c.texts import LIBRARY
from planarc.export.fmi.description import write_xml
from planarc.export.module import SHARED

if TYPE_CHECKING:
    from planarc.export.fmi.entries import Entries
    from planarc.ir.program import Program

#: The files that a compiler is given.
COMPILED = ("model.c", "runtime.c")


def library_sources(
    program: Program, texts: Sequence[str], entries: Entries, version: int
) -> dict[str, str]:
    """All but the description of the build."""
    found, mine = read(texts[:SHARED]), read(texts[SHARED:])
    prefix = f"FMI{version}_FUNCTION_PREFIX"
    names = [n for code in (mine, found) for kind in (code.functions, code.numbers, code.strings)
             for n in kind]  # fmt: skip
    api = LIBRARY.format(
        prefix=prefix,
        renamed="\n".join(f"#define {n} PREFIXED({prefix}, {n})" for n in names),
        declared="\n".join(f"EXPORTED {declare(found.functions[n])};" for n in entries.names),
    )
    how = "`cc -std=c99 -O2 -shared -fPIC *.c -lm`"
    return translate(program, found, mine, entries.names, entries.names, api, how)


def describe_build(identifier: str) -> str:
    """buildDescription.xml."""
    root = Xml.Element("fmiBuildDescription", fmiVersion="3.0")
    build = Xml.SubElement(root, "BuildConfiguration", modelIdentifier=identifier)
    files = Xml.SubElement(build, "SourceFileSet", language="C99")
    for name in COMPILED:
        Xml.SubElement(files, "SourceFile", name=name)
    what = "C's library of elementary functions, where that is one of its own"
    Xml.SubElement(build, "Library", name="m", external="true", description=what)
    return write_xml(root)
