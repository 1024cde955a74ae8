"""Bytecode of planarc's modules, kept in the cache where Python keeps none.

Python writes what it compiled beside a module, unless it may not: in a folder that belongs
to somebody else, or where PYTHONDONTWRITEBYTECODE is set, as in many containers. Then each
command would compile planarc's text anew, which is half of a command's time.

All modules are in one entry of the cache, which counts for planarc's files as they are now.
"""

from __future__ import annotations

import atexit
import marshal
import os
import sys
from importlib.machinery import FileFinder, SourceFileLoader
from pathlib import Path
from types import CodeType

from planarc.core import cache


def keep_bytecode() -> None:
    """From here on planarc's modules come from the cache; those that it lacks are added to it
    when the process ends. Does nothing where Python keeps bytecode, or there is no cache."""
    if __spec__ is None or __spec__.cached is None or Path(__spec__.cached).exists():
        return
    if cache.folder() is None:
        return
    package = str(Path(__file__).parent.parent)
    key = cache.key("bytecode", package, str(sys.flags.optimize))
    stored = cache.load("bytecode", key)
    known: dict[str, bytes] = {} if stored is None else marshal.loads(stored)
    count = len(known)

    class Loader(SourceFileLoader):
        def get_code(self, fullname: str) -> CodeType | None:
            if fullname in known:
                found: CodeType = marshal.loads(known[fullname])
                return found
            made = super().get_code(fullname)
            known[fullname] = marshal.dumps(made)
            return made

    def finder(folder: str) -> FileFinder:
        if folder != package and not folder.startswith(package + os.sep):
            raise ImportError
        return FileFinder(folder, (Loader, [".py"]))

    def store() -> None:
        if len(known) > count:
            cache.store("bytecode", key, marshal.dumps(known))

    sys.path_hooks.insert(0, finder)
    for folder in [f for f in sys.path_importer_cache if f.startswith(package)]:
        del sys.path_importer_cache[folder]
    atexit.register(store)
