"""Classes in files and folders, found by name and read when asked for.

In:   roots (folders of libraries, a package's own folder, single files), in order
Out:  Entry   one class, its definition read from its file on first use

A package is a folder with `package.mo` (or `package.pmo`), whose other files and
folders hold one class each; or it is a class inside a file. The first root that
holds a top-level name owns it, so a user's library replaces the embedded one.

Example: with the root `lib/`, the name `Planar.Parts.Body` reads
    lib/Planar/package.pmo, lib/Planar/Parts/package.pmo, lib/Planar/Parts/Body.pmo

Reference: Modelica Language Specification 3.6, sections 13.4 and 18.8.

The file is long because an entry asks the library for its files, and the library entries.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from msgspec import Struct, field

from planarc.core.diagnostic import Diagnostic, PlanarcError, Severity, error
from planarc.core.files import read_plain
from planarc.core.looked import Looked
from planarc.flatten.library.beside import unknown_within
from planarc.ir import syntax

EXTENSIONS = (".pmo", ".mo")
_VERSIONED = r"^(\S+) (\d+(?:\.\d+)*)$"

ParseFile = Callable[[Path], syntax.StoredDefinition]
ParseAnnotation = Callable[[syntax.Annotation], tuple[syntax.Argument, ...]]


class Entry(Struct, eq=False):
    """One class of a library; `folder` is its directory when it is a package on disk."""

    library: Library
    full_name: str
    _definition: syntax.ClassDef | None
    _file: Path | None = None
    folder: Path | None = None
    user: bool = False
    _children: dict[str, Entry | None] = field(default_factory=dict)

    @property
    def name(self) -> str:
        return self.full_name.rpartition(".")[2]

    @property
    def file(self) -> Path | None:
        """The class's own file; None where it stands in that of another class, or was added."""
        return self._file

    @property
    def is_read(self) -> bool:
        return self._definition is not None

    @property
    def definition(self) -> syntax.ClassDef:
        if self._definition is None:
            assert self._file is not None
            self._definition = self.library.read_class(self._file, self.full_name)
        return self._definition

    def child(self, name: str) -> Entry | None:
        """The class `name` declared directly in this one."""
        if name not in self._children:
            self._children[name] = self._find_child(name)
        return self._children[name]

    def _find_child(self, name: str) -> Entry | None:
        full = f"{self.full_name}.{name}"
        added = self.library.added(full)
        if added is not None:
            return Entry(self.library, full, added, user=True)
        for nested in nested_classes(self.definition):
            if nested.name == name:
                return Entry(self.library, full, nested, user=self.user)
        if self.folder is None or not name:  # a name that is left out in a text names no file
            return None
        return self.library.open_path(self.folder, name, full)

    @property
    def open(self) -> bool:
        """True when there may be classes that the definition's own text does not hold."""
        return self.folder is not None or bool(self.library.added_names(self.full_name))

    def child_names(self) -> tuple[str, ...]:
        """The names of the classes in this one: declared, in `package.order`, then the rest."""
        names = [c.name for c in nested_classes(self.definition)]
        if self.folder is not None:
            order = self.folder / "package.order"
            listed = order.read_text("utf-8", "replace").split("\n") if order.is_file() else []
            on_disk = sorted(self.library.names_in(self.folder))
            known = set(on_disk)
            names += [n.strip() for n in listed if n.strip() in known]
            names += on_disk
        names += self.library.added_names(self.full_name)
        return tuple(dict.fromkeys(names))


def nested_classes(definition: syntax.ClassDef) -> Iterator[syntax.ClassDef]:
    """The classes declared in the body of a class."""
    composition = definition.composition
    elements = () if composition is None else composition.elements
    return (element for element in elements if isinstance(element, syntax.ClassDef))


class Misnamed(PlanarcError):
    """A file holds no class of its name."""


def misnamed(file: Path, stored: syntax.StoredDefinition, name: str) -> Diagnostic:
    """The error of a file that does not hold the class of its name."""
    message = f"the file `{file.name}` holds no class `{name}`"
    if not stored.classes:
        return Diagnostic("F206", message, stored.span)
    held = stored.classes[0]
    hint = f"name the class `{name}`, or the file `{held.name}{file.suffix}`"
    return Diagnostic("F206", f"{message}, but `{held.name}`", held.name_span, hint=hint)


class Library:
    """All classes that a model can name."""

    def __init__(
        self,
        roots: Sequence[Path],
        parse_file: ParseFile,
        parse_annotation: ParseAnnotation,
        declarations: Sequence[Path] = (),
    ) -> None:
        """`declarations` are files of classes that only declare, see `declaring`."""
        self.roots = tuple(roots)
        self.parse_file = parse_file
        self.parse_annotation = parse_annotation
        self.looked = Looked()
        self.remarks: list[Diagnostic] = []  # on the files of classes that were asked for
        self._declarations = tuple(declarations)
        self._top: dict[str, Entry | None] = {}
        self._hidden: dict[str, tuple[Entry, ...]] = {}
        self._listings: dict[Path, frozenset[str]] = {}
        self._added: dict[str, syntax.ClassDef] = {}
        self._files: dict[Path, syntax.StoredDefinition] = {}

    # Adding and asking ------------------------------------------------------------------

    def add_file(self, stored: syntax.StoredDefinition) -> tuple[str, ...]:
        """Take in a user's file; gives the full names of its classes."""
        within = ".".join(stored.within or ())
        names = []
        for definition in stored.classes:
            full = f"{within}.{definition.name}" if within else definition.name
            if full in self._added:
                raise error("F203", f"the class `{full}` is declared twice", definition.name_span)
            self._added[full] = definition
            names.append(full)
        if within and stored.classes and self.entry(within) is None:
            raise unknown_within(within, stored.span)
        self._top.clear()
        return tuple(names)

    def lookup(self, name: str) -> syntax.ClassDef | None:
        """The definition of a class by its full name, None when there is none."""
        entry = self.entry(name)
        return None if entry is None else entry.definition

    def entry(self, name: str) -> Entry | None:
        first, *rest = split_name(name)
        entry = self.top(first)
        for part in rest:
            if entry is None:
                return None
            entry = entry.child(part)
        return entry

    def top(self, name: str) -> Entry | None:
        """A top-level class."""
        if name not in self._top:
            self._top[name] = self._find_top(name)
        return self._top[name]

    def declaring(self, name: str) -> syntax.Annotation | None:
        """The annotation of a class that is hidden by one of its name in a library in front.

        It says of that one what only planarc asks: the standard library's own classes
        declare no energy, those of planarc's part of it do.
        """
        first, *rest = split_name(name)
        if first not in self._hidden:
            self._hidden[first] = self._find_hidden(first)
        for holder in self._hidden[first]:
            entry: Entry | None = holder
            for part in rest:
                entry = None if entry is None else entry.child(part)
            if entry is not None and entry.definition.annotation is not None:
                return entry.definition.annotation
        return None

    def _find_hidden(self, name: str) -> tuple[Entry, ...]:
        found = [e for root in self.roots if (e := self._find_in_root(root, name)) is not None]
        if name in self._added or len(found) < 2:
            return ()
        more = (self._find_in_root(file, name) for file in self._declarations)
        return (*found[1:], *(entry for entry in more if entry is not None))

    # The outermost scope is asked as a package is asked (see `Entry`).

    open = True

    def child(self, name: str) -> Entry | None:
        return self.top(name)

    def child_names(self) -> tuple[str, ...]:
        return self.top_names()

    def class_names(self, package: str = "") -> tuple[str, ...]:
        """The names of the classes in a package; without a name, the top-level ones."""
        if not package:
            return self.top_names()
        entry = self.entry(package)
        return () if entry is None else entry.child_names()

    def may_hold(self, package: str, name: str) -> bool:
        """False for a class whose file, not parsed yet, does not hold a name as text."""
        entry = self.entry(package)
        if entry is None or entry.folder is not None or entry.file is None or entry.is_read:
            return entry is not None
        try:
            return (
                re.search(rb"\b%s\b" % re.escape(name.encode()), read_plain(entry.file)) is not None
            )
        except OSError:
            return True  # who reads it says what is wrong

    def top_names(self) -> tuple[str, ...]:
        names = [n for n in self._added if "." not in n]
        for root in self.roots:
            names += sorted(self._root_names(root))
        return tuple(dict.fromkeys(names))

    def user_files(self) -> set[str]:
        """The names of the files that were added."""
        return {definition.span.source.name for definition in self._added.values()}

    def added(self, full_name: str) -> syntax.ClassDef | None:
        return self._added.get(full_name)

    def added_names(self, package: str) -> list[str]:
        start = package + "."
        return [
            n[len(start) :]
            for n in self._added
            if n.startswith(start) and "." not in n[len(start) :]
        ]

    # Files --------------------------------------------------------------------------------

    def read_class(self, file: Path, full_name: str) -> syntax.ClassDef:
        """The class that a file of a library holds."""
        stored = self._read(file)
        package, _, name = full_name.rpartition(".")
        if stored.within is not None and ".".join(stored.within) != package:
            raise error(
                "F205",
                f"this file holds `{full_name}` by its place, but says "
                f"`within {'.'.join(stored.within)}`",
                stored.span,
                hint=f"write `within {package};`",
            )
        for definition in stored.classes:
            if definition.name != name:
                continue
            if stored.within is None and package:
                message = f"this file holds `{full_name}` by its place, but does not say so"
                above = f"write `within {package};` above it"
                found = Diagnostic("F205", message, definition.name_span, Severity.WARNING, above)
                self.remarks.append(found)
            return definition
        raise Misnamed(misnamed(file, stored, name))

    def _read(self, file: Path) -> syntax.StoredDefinition:
        if file not in self._files:
            self._files[file] = self.parse_file(file)
        return self._files[file]

    def package_file(self, folder: Path) -> Path | None:
        """The file that makes a folder a package."""
        for extension in EXTENSIONS:
            file = folder / f"package{extension}"
            if file.is_file():
                return file
        if folder.is_dir():  # one may be added
            self.looked.folders.add(folder)
        return None

    def names_in(self, folder: Path) -> list[str]:
        """The names of the classes that a folder holds by its files and folders."""
        self.looked.folders.add(folder)
        names = []
        for path in folder.iterdir():
            if path.suffix in EXTENSIONS and path.stem != "package":
                names.append(_plain_name(path.stem))
            elif path.is_dir() and self.package_file(path) is not None:
                names.append(_plain_name(path.name))
        return names

    def open_path(self, folder: Path, name: str, full_name: str) -> Entry | None:
        """The class `name` as a folder or a file of `folder`."""
        self.looked.folders.add(folder)
        if not _is_file_name(name) or self._lacks(folder, name):
            return None
        if package := self.package_file(folder / name):
            return Entry(self, full_name, None, package, folder / name)
        for extension in EXTENSIONS:
            file = folder / (name + extension)
            if file.is_file() and name != "package":
                return Entry(self, full_name, None, file)
        return None

    def _lacks(self, folder: Path, name: str) -> bool:
        """True for most names that are looked for in a folder: one list of it saves many looks."""
        if folder not in self._listings:
            try:
                self._listings[folder] = frozenset(os.listdir(folder))  # noqa: PTH208
            except OSError:  # there may be files in it all the same
                return False
        return self._listings[folder].isdisjoint((name, *(name + e for e in EXTENSIONS)))

    def _find_top(self, name: str) -> Entry | None:
        if name in self._added:
            return Entry(self, name, self._added[name], user=True)
        for root in self.roots:
            entry = self._find_in_root(root, name)
            if entry is not None:
                return entry
        return None

    def _find_in_root(self, root: Path, name: str) -> Entry | None:
        if root.is_file():
            return self._entry_of_file(root, name)
        package = self.package_file(root)
        if package is not None:
            if _plain_name(root.resolve().name) == name or self._names_of_file(package) == [name]:
                return Entry(self, name, None, package, root)
            return None
        entry = self.open_path(root, name, name)
        if entry is not None:
            return entry
        for candidate in _versions(root, name):
            package = self.package_file(candidate)
            if package is not None:
                return Entry(self, name, None, package, candidate)
            if candidate.is_file():
                return Entry(self, name, None, candidate)
        return None

    def _entry_of_file(self, file: Path, name: str) -> Entry | None:
        if file.name in {"package.mo", "package.pmo"}:
            return self._find_in_root(file.parent, name)
        found = [c for c in self._read(file).classes if c.name == name]
        return Entry(self, name, found[0]) if found else None

    def _names_of_file(self, file: Path) -> list[str]:
        return [c.name for c in self._read(file).classes]

    def _root_names(self, root: Path) -> list[str]:
        if root.is_file():
            return self._names_of_file(root)
        package = self.package_file(root)
        if package is not None:
            return self._names_of_file(package)
        return self.names_in(root) if root.is_dir() else []


def split_name(name: str) -> list[str]:
    """The identifiers of a full name; a quoted one may hold dots."""
    return re.findall(r"'(?:[^'\\]|\\.)*'|[^.]+", name) or [""]


def _is_file_name(name: str) -> bool:
    return "/" not in name and "\\" not in name and "\0" not in name and len(name) < 200


def _plain_name(file_name: str) -> str:
    """A folder's or file's name without its version: `Modelica 4.0.0` is `Modelica`."""
    return re.sub(_VERSIONED, r"\1", file_name)


def _versions(root: Path, name: str) -> list[Path]:
    """`name 4.0.0` in a root, the highest version first."""
    if not root.is_dir() or not _is_file_name(name):
        return []
    found = []
    for path in root.glob("* *"):
        stem = path.name if path.is_dir() else path.stem if path.suffix in EXTENSIONS else ""
        match = re.match(_VERSIONED, stem)
        if match and match[1] == name:
            found.append((tuple(int(n) for n in match[2].split(".")), path))
    return [path for _, path in sorted(found, reverse=True)]
