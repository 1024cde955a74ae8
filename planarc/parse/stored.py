"""Syntax trees in the cache, so that a file is parsed once.

A tree is kept as a pickle in which each node is a plain call of its class: read
back a dozen times faster than parsed. Nothing but nodes can come out, whatever
the bytes say.
"""

from __future__ import annotations

import io
import pickle
from enum import Enum
from typing import Any

from planarc.core import cache
from planarc.core.data import Data
from planarc.core.source import Source, Span
from planarc.ir import syntax

_CLASSES = {
    name: value
    for name, value in vars(syntax).items()
    if isinstance(value, type) and issubclass(value, Data | Enum)
}


def load_tree(source: Source, key: str) -> Any | None:
    """The tree stored under a key, its spans pointing into `source`; else None."""
    data = cache.load("syntax", key)
    if data is None:
        return None
    try:
        return _Reader(data, source).load()
    except Exception:  # bytes of another origin: parse again
        return None


def store_tree(key: str, tree: Any) -> None:
    if cache.folder() is None:
        return
    buffer = io.BytesIO()
    try:
        _Writer(buffer, protocol=5).dump(tree)
    except RecursionError:  # a very long chain of operators: it is parsed each time
        return
    cache.store("syntax", key, buffer.getvalue())


class _Writer(pickle.Pickler):
    def reducer_override(self, obj: Any) -> Any:
        if isinstance(obj, Span):
            return Span, tuple(obj)
        if isinstance(obj, Source):
            return Source, ()
        return NotImplemented


class _Reader(pickle.Unpickler):
    def __init__(self, data: bytes, source: Source) -> None:
        super().__init__(io.BytesIO(data))
        self._source = source

    def find_class(self, module: str, name: str) -> Any:
        if module == "planarc.ir.syntax" and name in _CLASSES:
            return _CLASSES[name]
        if module == "planarc.core.source" and name == "Span":
            return Span
        if module == "planarc.core.source" and name == "Source":
            source = self._source
            return lambda: source  # which the reader keeps: it holds no reader
        raise pickle.UnpicklingError(f"{module}.{name} is no part of a syntax tree")
