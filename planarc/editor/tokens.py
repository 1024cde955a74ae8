"""The names of a text with what they are, for colours: types, variables, parameters, functions.

Told from the text alone, so that a file of any length is coloured at once: a variable is what the
class around declares, everything behind a dot a property.
"""

from __future__ import annotations

from collections.abc import Iterator

from planarc.core.data import Data
from planarc.core.source import Span
from planarc.editor.mentions import Kind, Mention, Walk
from planarc.editor.texts import Text
from planarc.flatten.tree import predefined
from planarc.ir import syntax

TYPES = (
    "namespace", "type", "class", "enum", "enumMember", "parameter", "variable", "property",
    "function",
)  # fmt: skip
MODIFIERS = ("declaration", "readonly", "defaultLibrary")

_FIXED = (syntax.Variability.PARAMETER, syntax.Variability.CONSTANT)


class Token(Data):
    span: Span
    type: str
    modifiers: tuple[str, ...] = ()


def tokens_of(text: Text) -> list[Token]:
    """The tokens in the order of the text."""
    found: dict[int, Token] = {}
    declared = {tuple(name.split(".")): _components(node) for name, node in text.classes.items()}
    prefix = len(text.tree.within or ())
    by_owner = {key[prefix:]: known for key, known in declared.items()}
    for mention in Walk(text, word="\0").mentions():
        if mention.name:
            found.setdefault(mention.span.start, _token(mention, by_owner.get(mention.owner, {})))
    _mark_functions(text, found)
    return [found[at] for at in sorted(found)]


def _components(node: syntax.ClassDef) -> dict[str, syntax.Component]:
    composition = node.composition
    elements = () if composition is None else composition.elements
    return {e.name: e for e in elements if isinstance(e, syntax.Component)}


def _token(mention: Mention, known: dict[str, syntax.Component]) -> Token:
    node = mention.declared
    match mention.kind:
        case Kind.DECLARATION if isinstance(node, syntax.ClassDef):
            kind = "namespace" if node.kind is syntax.ClassKind.PACKAGE else "class"
            if node.kind is syntax.ClassKind.FUNCTION:
                kind = "function"
            return Token(mention.span, kind, ("declaration",))
        case Kind.DECLARATION if isinstance(node, syntax.Component):
            return Token(mention.span, *_variable(node, ("declaration",)))
        case Kind.LITERAL:
            return Token(mention.span, "enumMember", ("declaration", "readonly"))
        case Kind.ITERATOR:
            return Token(mention.span, "variable", ("declaration",))
        case Kind.MODIFIER:
            return Token(mention.span, "property")
        case Kind.IMPORT:
            return Token(mention.span, "namespace")
    if mention.is_type:
        if mention.name in predefined.NAMES and len(mention.path) == 1:
            return Token(mention.span, "type", ("defaultLibrary",))
        return Token(mention.span, "class")
    if len(mention.path) > 1:
        return Token(mention.span, "property")
    component = known.get(mention.name)
    return Token(
        mention.span, *(("variable", ()) if component is None else _variable(component, ()))
    )


def _variable(node: syntax.Component, more: tuple[str, ...]) -> tuple[str, tuple[str, ...]]:
    if node.variability in _FIXED:
        return "parameter", (*more, "readonly")
    return "variable", more


def _mark_functions(text: Text, found: dict[int, Token]) -> None:
    """Calls look like references to the walk; a bracket behind the name tells them apart."""
    whole = text.source.text
    for at, token in list(found.items()):
        if token.type in ("variable", "property") and not token.modifiers:
            rest = whole[token.span.end : token.span.end + 1]
            if rest == "(" and token.type == "variable":
                found[at] = Token(token.span, "function", _library(token.span.text))


def _library(name: str) -> tuple[str, ...]:
    from planarc.flatten.typing import builtins

    return ("defaultLibrary",) if builtins.is_name(name) else ()


def encoded(tokens: Iterator[tuple[int, int, int, Token]]) -> list[int]:
    """The numbers of the protocol: line, column and length in units, each after the one before."""
    data: list[int] = []
    line = column = 0
    for at_line, at_column, length, token in tokens:
        step = at_line - line
        mark = sum(1 << MODIFIERS.index(m) for m in token.modifiers)
        data += [step, at_column if step else at_column - column, length]
        data += [TYPES.index(token.type), mark]
        line, column = at_line, at_column
    return data
