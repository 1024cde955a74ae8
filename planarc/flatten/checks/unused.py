"""Parameters of a model that nothing uses, and connections that are there twice.

In:   the root instance, the connections
Out:  notes F338, warnings F228

A parameter that is declared and never read is a number that was written twice, once where it
should have been read: changing it changes nothing. It is looked for in the whole text of the file,
since what it sizes or switches is gone in the flat model. Only the model's own are told, of files
that the user gave, and where there are parts: a model of numbers alone is an exercise.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic, Related, Severity
from planarc.flatten.connect.connect import Connection
from planarc.flatten.tree.nodes import Instance, Session
from planarc.ir import syntax

_PARTS = (syntax.ClassKind.MODEL, syntax.ClassKind.BLOCK)
_NUMBERS = r"[-+*/\d.eE(){}\[\],;\s]+"
_WORD = re.compile(r"\w+")
_SAID = re.compile(r'"(?:\\.|[^"\\])*"|//[^\n]*|/\*.*?\*/', re.DOTALL)


def check_unused(root: Instance, connections: Sequence[Connection], session: Session) -> None:
    _check_parameters(root, session)
    _check_connections(root, connections, session)


def _check_parameters(root: Instance, session: Session) -> None:
    source = root.cls.definition.span.source
    inside = (element.node for element in root.elements.values())
    parts = (isinstance(n, Instance) and n.layout.kind in _PARTS for n in inside)
    if source.name not in session.library.user_files() or not any(parts):
        return
    words = Counter(_WORD.findall(_SAID.sub(" ", source.text)))
    for declared in root.scope().part.own.values():
        if not isinstance(declared, syntax.Component) or declared.span.source is not source:
            continue
        if declared.variability is not syntax.Variability.PARAMETER or declared.prefixes.final:
            continue
        value = declared.modification.binding if declared.modification else None
        if value is None or not re.fullmatch(_NUMBERS, value.span.text):
            continue  # what follows from others may be there to be read by a user
        if words[declared.name] == 1:
            session.warnings.append(
                Diagnostic(
                    "F338",
                    f"nothing uses the parameter `{declared.name}`",
                    declared.span,
                    Severity.NOTE,
                    hint="write its name where its value is meant, or leave it out",
                )
            )


def _check_connections(root: Instance, connections: Sequence[Connection], session: Session) -> None:
    """The second of two equal connections of the model itself; mostly another part was meant."""
    seen: dict[frozenset[str], Connection] = {}
    for connection in connections:
        pair = frozenset((connection.left.name, connection.right.name))
        if connection.component != root.name or len(pair) != 2:
            continue
        if (first := seen.setdefault(pair, connection)) is not connection:
            message = f"`{connection.left.name}` and `{connection.right.name}` are connected twice"
            hint = "leave one out, or connect another part"
            session.warn("F228", message, connection.span, hint)
            if first.span.line != connection.span.line:
                note = Related("the first time is here", first.span)
                session.warnings[-1] = replace(session.warnings[-1], related=(note,))
