"""Walks over the syntax tree, iterative and in the order of the text."""

from __future__ import annotations

from collections.abc import Iterator

from planarc.core.source import Span
from planarc.ir import syntax


def nodes_of(tree: object) -> Iterator[syntax.Node]:
    """A node, or nodes in tuples, with all their parts."""
    stack = [tree]
    while stack:
        part = stack.pop()
        if isinstance(part, syntax.Node):
            yield part
            fields = [getattr(part, name) for name in part.__struct_fields__]
            stack += reversed(fields)
        elif isinstance(part, tuple) and not isinstance(part, Span):
            stack += reversed(part)


def references_in(tree: object) -> Iterator[syntax.Ref]:
    return (node for node in nodes_of(tree) if isinstance(node, syntax.Ref))
