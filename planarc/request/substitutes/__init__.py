"""Classes of planarc's own in the place of those that a standard library does not write itself.

In:   StoredDefinition   a file of a library that a user gives
Out:  StoredDefinition   the same, some of its classes replaced and a few added

A user's copy of the Modelica Standard Library takes the place of the embedded one.
Its tables are external objects, which planarc does not run; here a table is a record
of its data, and the functions that look into it are the embedded library's. Its linear
algebra is LAPACK's, written in Fortran; here that of SciPy.

Example: `Modelica.Blocks.Tables.CombiTable1Ds` of the user's library stays and calls
`Internal.getTable1DValue(tableID, 1, u)`; that function comes from `library.pmo`, and
`tableID` is a record.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from msgspec.structs import replace

from planarc.core.resources import stdlib
from planarc.ir import syntax

Read = Callable[[Path], syntax.StoredDefinition]

_OWN = Path(__file__).parent / "library.pmo"
_LAPACK = Path(__file__).parent / "lapack.pmo"
_BLOCKS = stdlib() / "Modelica" / "Blocks"

#: Package -> file, and the names of the classes in it that are put into the package; without
#: names all that are inside of its class.
_SOURCES: tuple[tuple[str, Path, tuple[str, ...]], ...] = (
    ("Modelica.Blocks.Types", _OWN, ("ExternalCombiTable1D", "ExternalCombiTable2D")),
    (
        "Modelica.Blocks.Tables.Internal",
        _OWN,
        (
            *("contents", "getTable1DValue", "getTable1DValueNoDer", "getTable1DValueNoDer2"),
            *("getTable1DAbscissaUmin", "getTable1DAbscissaUmax"),
            *("getTable2DValue", "getTable2DValueNoDer", "getTable2DValueNoDer2"),
            *("getTable2DAbscissaUmin", "getTable2DAbscissaUmax"),
        ),
    ),
    ("Modelica.Blocks.Tables.Internal", _BLOCKS / "Tables" / "Internal.pmo", ()),
    ("Modelica.Blocks.Sources", _BLOCKS / "Sources" / "CombiTimeTable.pmo", ("CombiTimeTable",)),
    ("Modelica.Utilities.Streams", _OWN, ("error",)),
    ("Modelica.Math.Matrices.LAPACK", _LAPACK, ()),
    ("Modelica.Math.Matrices", _OWN, ("LU", "inv", "det")),
    ("Modelica.Math.Random.Utilities", _OWN, ("initializeImpureRandom",)),
    ("ModelicaServices.ExternalReferences", _OWN, ("loadResource",)),
)
_LIBRARIES = frozenset(package.partition(".")[0] for package, _, _ in _SOURCES)


def substitute(stored: syntax.StoredDefinition, read: Read) -> syntax.StoredDefinition:
    """Replace classes of a file; `read` parses planarc's own files."""
    within = ".".join(stored.within or ())
    tops = {within.partition(".")[0]} if within else {c.name for c in stored.classes}
    if tops.isdisjoint(_LIBRARIES):
        return stored
    for package, file, names in _SOURCES:
        for i, definition in enumerate(stored.classes):
            path = _path_below(f"{within}.{definition.name}".lstrip("."), package)
            if path is not None and _holds(definition, path):
                own = _classes_of(read(file), names)
                classes = list(stored.classes)
                classes[i] = _with_classes(definition, path, own)
                stored = replace(stored, classes=tuple(classes))
    return stored


def _holds(definition: syntax.ClassDef, path: tuple[str, ...]) -> bool:
    """Whether the package to which `path` leads stands in the text of a class."""
    if not path:
        return True
    inner = [e for e in _elements(definition) if isinstance(e, syntax.ClassDef)]
    return any(_holds(e, path[1:]) for e in inner if e.name == path[0])


def _path_below(outer: str, package: str) -> tuple[str, ...] | None:
    """The names that lead from a class to a package in it."""
    if package == outer:
        return ()
    return tuple(package[len(outer) + 1 :].split(".")) if package.startswith(outer + ".") else None


def _classes_of(
    stored: syntax.StoredDefinition, names: tuple[str, ...]
) -> dict[str, syntax.ClassDef]:
    """Classes of a file, by name: its outermost ones, or those in them."""
    inside = [e for c in stored.classes for e in _elements(c) if isinstance(e, syntax.ClassDef)]
    if not names:
        return {element.name: element for element in inside}
    found = {element.name: element for element in (*stored.classes, *inside)}
    return {name: found[name] for name in names}


def _with_classes(
    definition: syntax.ClassDef, path: tuple[str, ...], own: dict[str, syntax.ClassDef]
) -> syntax.ClassDef:
    """A package with classes replaced or added, in the package to which `path` leads."""
    body = definition.body
    if not isinstance(body, syntax.Composition):
        return definition
    elements: list[syntax.Element] = []
    added = dict(own)
    for element in body.elements:
        if not isinstance(element, syntax.ClassDef):
            elements.append(element)
        elif path:
            matches = element.name == path[0]
            elements.append(_with_classes(element, path[1:], own) if matches else element)
        else:
            elements.append(added.pop(element.name, element))
    if not path:
        elements += added.values()
    return replace(definition, body=replace(body, elements=tuple(elements)))


def _elements(definition: syntax.ClassDef) -> tuple[syntax.Element, ...]:
    body = definition.body
    return body.elements if isinstance(body, syntax.Composition) else ()
