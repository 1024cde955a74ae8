"""The `uses` annotation of a model, held against the libraries that are found.

In:   Library, the name of a class
Out:  a warning for each library that has another version than the model was written for

Example: with Modelica 4.1.0 found, whose package says `conversion(noneFromVersion="4.0.0")`,

    annotation(uses(Modelica(version="3.2.3")))   is warned of
    annotation(uses(Modelica(version="4.0.0")))   is not: nothing has to be converted

Reference: Modelica Language Specification 3.6, section 18.8.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from planarc.core.diagnostic import Diagnostic, PlanarcError, Severity
from planarc.flatten.tree.annotation import binding_of, find_argument, inside
from planarc.ir import syntax

if TYPE_CHECKING:
    from planarc.flatten.library.library import Library

Arguments = tuple[syntax.Argument, ...]


def check_versions(library: Library, class_name: str) -> Iterator[Diagnostic]:
    """Warnings for the outermost class that holds `class_name`."""
    outermost = class_name.partition(".")[0]
    for used in _inside(_arguments(library, outermost, "uses"), "uses"):
        name = used.name[0]
        wanted = _text(find_argument(inside(used), "version"))
        arguments = _arguments(library, name, "version")
        found = _text(find_argument(arguments, "version"))
        if wanted and found and wanted != found and wanted not in _alike(arguments):
            yield Diagnostic(
                "C119",
                f"`{outermost}` is written for {name} {wanted}, but {name} {found} is found",
                used.span,
                Severity.WARNING,
                hint=f"give the folder of {name} {wanted} with `--library`, or change `uses`",
            )


def _alike(arguments: Arguments) -> tuple[str, ...]:
    """The older versions whose models need no conversion."""
    conversions = _inside(arguments, "conversion")
    return tuple(_text(c) for c in conversions if c.name == ("noneFromVersion",))


def _arguments(library: Library, name: str, word: str) -> Arguments:
    """The annotation of a class, if it mentions a word; () where it cannot be read."""
    try:
        definition = library.lookup(name)
        annotation = None if definition is None else definition.annotation
        if annotation is None or word not in annotation.span.text:
            return ()
        return library.parse_annotation(annotation)
    except PlanarcError:
        return ()  # who needs the class says what is wrong with it


def _inside(arguments: Arguments, name: str) -> Iterable[syntax.ElementModification]:
    inner = inside(find_argument(arguments, name))
    return (a for a in inner if isinstance(a, syntax.ElementModification))


def _text(argument: syntax.ElementModification | None) -> str:
    binding = binding_of(argument)
    return binding.value if isinstance(binding, syntax.String) else ""
