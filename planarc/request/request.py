"""The request to compile something, and the class that it means.

A file with one model, or with a model named like the file (`four_bar.pmo` holds
`FourBar`), needs no class name. Libraries are looked for in the roots that the
user gives, then in those of MODELICAPATH, then in planarc's own.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import (
    Diagnostic,
    PlanarcError,
    Severity,
    UsageError,
    usage_error,
)
from planarc.core.mend import Meant
from planarc.core.options import Redundant, Units
from planarc.core.prose import be, shortened, ticked
from planarc.core.resources import stdlib
from planarc.core.source import SUFFIXES, Source
from planarc.request.reader import Reader

if TYPE_CHECKING:
    from planarc.flatten.library.library import Entry, Library

#: What classes of the standard library declare that planarc's part of it does not hold.
DECLARED = Path(__file__).parent / "substitutes" / "declared.pmo"
#: Kinds of classes that can be simulated.
MODELS = ("model", "block", "class")
#: Models of packages that a message names.
_MOST_NAMES = 6
#: What is written behind a time, and read as a class where a space is between.
_OF_TIME = ("s", "sec", "second", "seconds", "ms", "us", "min", "h")
_DOTTED_NAME = r"\.?(?:\w+|'[^']*')(?:\.(?:\w+|'[^']*'))*"


class Request(Data):
    """A file, a class of a library, or a class of a file.

    `text` takes the place of the file's content (a model that is no file). `inputs` names
    variables of the model that become inputs. A `placed` model begins where its states are given,
    without its initial equations.
    """

    file: Path | None = None
    class_name: str | None = None
    libraries: tuple[Path, ...] = ()
    text: str | None = None
    units: Units = Units.WARN
    redundant: Redundant = Redundant.REFUSE
    inputs: tuple[str, ...] = ()
    placed: bool = False


class Target(Data):
    """A class to compile, with the libraries around it."""

    library: Library
    class_name: str
    reader: Reader
    warnings: tuple[Diagnostic, ...] = ()  # of the request, such as versions of libraries
    units: Units = Units.WARN


def names_class(text: str) -> bool:
    """True for a text that can be the name of a class; any other is that of a file."""
    return not text.endswith(SUFFIXES) and re.fullmatch(_DOTTED_NAME, text) is not None


def roots_of(request: Request) -> tuple[Path, ...]:
    """The folders in which libraries are looked for, in order."""
    named = request.libraries
    path = [Path(p) for p in os.environ.get("MODELICAPATH", "").split(os.pathsep) if p]
    for root in named:
        if not os.path.exists(root):  # noqa: PTH110 (so is a name that is too long)
            raise _usage("C104", f"there is no library `{root}`", _path_near(root))
        if not (root.is_dir() or root.is_file()):
            raise _usage("C104", f"`{root}` is no library", "give a folder, or an ordinary file")
    own = None if request.file is None else _own_package(request.file)
    found = (p for p in path if os.path.exists(p))  # noqa: PTH110
    return (*named, *([own] if own else ()), *found, stdlib())


def _path_near(path: Path) -> str:
    """What to do about a path that leads nowhere."""
    from planarc.core.nearest import nearest

    beside = sorted(p.name for p in path.parent.iterdir()) if path.parent.is_dir() else []
    near = nearest(path.name, beside, most=1)
    hint = "check the path after `--library`"
    return f"did you mean `{path.with_name(near[0])}`?" if near else hint


def _own_package(file: Path) -> Path | None:
    """The outermost package that a file is in by its place."""
    found, folder = None, file.absolute().parent
    while folder != found and any((folder / f"package{s}").is_file() for s in SUFFIXES):
        found, folder = folder, folder.parent
    return found


def open_library(request: Request) -> tuple[Library, Reader, tuple[str, ...]]:
    """The libraries with the user's file in them, and the names that the file declares."""
    from planarc.flatten.library.library import Library, misnamed
    from planarc.parse.parser import parse_annotation

    reader = Reader()
    library = Library(roots_of(request), reader, parse_annotation, [DECLARED])
    names: tuple[str, ...] = ()
    if request.text is not None:
        name = str(request.file or "<text>")
        names = library.add_file(reader.parse(Source(name, request.text)))
    elif request.file is not None:
        stored = reader(request.file)
        if not stored.classes:
            raise _usage(
                "C105",
                f"`{request.file}` holds no class",
                "write a model: `model Name ... end Name;`",
            )
        package = _own_package(request.file)
        whole = ".".join((*(stored.within or ()), stored.classes[0].name))
        if package is not None and request.file.stem == "package" and library.entry(whole):
            return library, reader, (whole,)
        names = library.add_file(stored)
        if package is not None and all(c.name != request.file.stem for c in stored.classes):
            wrong = misnamed(request.file, stored, request.file.stem)
            library.remarks.append(replace(wrong, severity=Severity.WARNING))
    return library, reader, names


def open_target(request: Request) -> Target:
    """The class that a request means. Raises UsageError when it is not one."""
    from planarc.request.uses import check_versions

    library, reader, names = open_library(request)
    name = _class_of(request, library, names)
    return Target(library, name, reader, tuple(check_versions(library, name)), units=request.units)


def _class_of(request: Request, library: Library, names: Sequence[str]) -> str:
    wanted = request.class_name
    if wanted is not None:
        for name in (wanted, *(f"{n}.{wanted}" for n in names)):
            if library.entry(name) is not None:
                return name
        raise _unknown(wanted, library, names)
    models = [n for n in names if _is_model(library, n)]
    stem = _plain(request.file.stem) if request.file else ""
    like_file = [n for n in models if _plain(n.rpartition(".")[2]) == stem]
    if len(like_file) == 1:
        return like_file[0]
    if len(models) == 1:
        return models[0]
    inside = () if models else tuple(models_inside(library, names))
    examples = [entry.full_name for entry in inside if is_example(entry)]
    if len(examples) == 1:
        return examples[0]
    raise _several(request, models, names, examples or [entry.full_name for entry in inside])


def _is_model(library: Library, name: str) -> bool:
    entry = library.entry(name)
    return entry is not None and _is_complete(entry)


def _is_complete(entry: Entry) -> bool:
    return entry.definition.kind.value in MODELS and not entry.definition.partial


def is_example(entry: Entry) -> bool:
    """True for a model that says how it is to be run."""
    definition = entry.definition
    annotation = definition.annotation
    return (
        definition.kind.value == "model"
        and not definition.partial
        and annotation is not None
        and "experiment" in annotation.span.text
    )


def models_inside(library: Library, names: Sequence[str]) -> Iterator[Entry]:
    """The models of packages, in their order."""
    stack = [library.entry(name) for name in reversed(names)]
    while stack:
        entry = stack.pop()
        if entry is None:
            continue
        if entry.definition.kind.value == "package":
            stack += [entry.child(name) for name in reversed(entry.child_names())]
        elif _is_complete(entry):
            yield entry


def _plain(name: str) -> str:
    return name.replace("_", "").replace("-", "").lower()


def _several(
    request: Request, models: Sequence[str], names: Sequence[str], inside: Sequence[str]
) -> UsageError:
    """The refusal to choose: among several models, or among those `inside` of packages."""
    if models:
        return _usage(
            "C106",
            f"`{request.file}` holds several models: {ticked(models)}",
            f"name one of them behind the file: `{request.file} {models[0]}`",
        )
    if not inside:
        hint = "name a model inside of it, as in `Package.Model`"
        message = f"`{request.file}` holds no model to simulate, only {ticked(names)}"
        return _usage("C107", message, hint)
    shown = shortened([f"`{name}`" for name in inside], _MOST_NAMES)
    return _usage(
        "C107",
        f"`{request.file}` holds no model by itself; in its packages {be(len(inside))} {shown}",
        f"name one of them behind the file: `{request.file} {inside[0]}`",
    )


def _is_unit(text: str) -> bool:
    from planarc.core.unit import parse

    return text != "1" and parse(text) is not None


def _unknown(wanted: str, library: Library, names: Sequence[str]) -> UsageError:
    from planarc.core.nearest import MOST, did_you_mean

    package, _, last = wanted.rpartition(".")
    inside = (f"{package}.{n}" if package else n for n in library.class_names(package))
    known = list(dict.fromkeys((*names, *inside)))
    alike = tuple(n for n in known if n.rpartition(".")[2].lower() == last.lower())
    near = did_you_mean(wanted, known) or (Meant(wanted, alike) if alike else None)
    with suppress(PlanarcError):  # a package that cannot be read is no help
        if not names and (deeper := tuple(islice(_deeper(wanted, library), MOST))):
            near = Meant(wanted, deeper)
    if re.fullmatch(r"[\d.]+\w*", wanted):
        hint = f"a number belongs to an option, such as `--stop {wanted}`"
        return _usage("C103", f"there is no class `{wanted}`", hint)
    if wanted in _OF_TIME:
        hint = "times are in seconds without a unit, as in `--stop 10`; a unit stands in one word "
        hint += "with its number, as in `--stop 10s`"
        return _usage("C103", f"there is no class `{wanted}`", hint)
    if wanted.endswith(tuple(SUFFIXES)):
        hint = "a command takes one file: run it once for each"
        return _usage("C103", f"there is no class `{wanted}`", hint)
    if "=" in wanted:
        hint = f'an option takes this: `--set "{wanted}"`, or of a sweep `--vary "{wanted}"`'
        return _usage("C103", f"there is no class `{wanted}`", hint)
    files = _models_named(wanted)
    if files:
        hint = f"name its file: `{files[0]}`"
        return _usage("C103", f"there is no class `{wanted}`", hint)
    if len(names) and _is_unit(wanted):
        hint = f'a value and its unit are one word: `2{wanted}`, or in quotes `"x=2 {wanted}"`'
        return _usage("C103", f"there is no class `{wanted}`", hint)
    hint = str(near or "see `planarc list` for the names")
    return _usage("C103", f"there is no class `{wanted}`", hint)


def _deeper(wanted: str, library: Library) -> Iterator[str]:
    """Classes of the wanted one's last name in packages of the package that is there, or of any;
    what stands inside of a file is found where the file was read."""
    package, _, last = wanted.rpartition(".")
    while package and library.entry(package) is None:
        package = package.rpartition(".")[0]
    stack = [library.entry(n) for n in ((package,) if package else library.top_names())]
    for entry in stack:
        for child in () if entry is None else map(entry.child, entry.child_names()):
            if child is not None and child.name.lower() == last.lower():
                yield child.full_name
            elif child is not None and (child.folder is not None or child.is_read):
                stack.append(child)


def _models_named(name: str) -> list[Path]:
    """Files of models here of a name, in small or capital letters."""
    with suppress(OSError):
        here = [f for f in Path().iterdir() if f.suffix in SUFFIXES and f.is_file()]
        return sorted(f for f in here if f.stem.lower() == name.lower())
    return []


def _usage(code: str, message: str, hint: str | None) -> UsageError:
    return usage_error(code, message, hint=hint)
