"""What may be written at a place of a text, told by the tokens before it.

In:   Text, a character
Out:  Context   what surrounds the place, and the dotted name that stands just before it

Example: behind `Body b(m = k.` the context is a value, of the modifier `m` in the class `Body`,
and the names before the dot are `k`.
"""

from __future__ import annotations

from enum import Enum

from msgspec import Struct

from planarc.core.data import Data
from planarc.editor.texts import Text
from planarc.parse.grammar.lexer import Token, scan
from planarc.parse.grammar.unreadable import Unclosed
from planarc.parse.language import load_language


class Where(Enum):
    NOWHERE = "nowhere"  # in a string or a comment
    DECLARATION = "declaration"  # where a declaration begins: a type, or a prefix
    TYPE = "type"  # a class is to be named
    NAME = "name"  # something new is to be named
    MODIFIER = "modifier"  # a member of a class
    CALL = "call"  # an argument of a function
    CONNECT = "connect"  # a connector
    EQUATION = "equation"  # where an equation or statement begins
    VALUE = "value"  # an expression
    ANNOTATION = "annotation"


class Context(Data):
    """The surroundings of a place. `head` is the class, function or component that brackets belong
    to, or the class of what is to be named; `path` the modifiers around inside of it; `argument`
    the name of what a value is for; `position` counts commas."""

    where: Where
    prefix: str = ""
    before: tuple[str, ...] = ()  # names before a dot
    head: tuple[str, ...] = ()
    path: tuple[str, ...] = ()
    argument: str = ""
    position: int = 0
    first: tuple[str, ...] = ()  # of connect: its first argument
    start: int = 0  # of the prefix


_KINDS = frozenset(
    ("MODEL", "CLASS", "BLOCK", "TYPE", "PACKAGE", "RECORD", "CONNECTOR", "FUNCTION", "OPERATOR")
)
_SECTIONS = {"EQUATION": "equation", "ALGORITHM": "equation", "PUBLIC": "", "PROTECTED": ""}
_OPENING = {"LPAR": "(", "LSQB": "[", "LBRACE": "{"}
_CLOSING = ("RPAR", "RSQB", "RBRACE")
_BEGINS = ("THEN", "ELSE", "LOOP")
_PREFIXES = frozenset(
    [
        "REDECLARE",
        "FINAL",
        "INNER",
        "OUTER",
        "REPLACEABLE",
        "FLOW",
        "STREAM",
        "DISCRETE",
        "PARAMETER",
        "CONSTANT",
        "INPUT",
        "OUTPUT",
        "EACH",
    ]
)


class _Frame(Struct):
    where: Where
    head: tuple[str, ...] = ()
    path: tuple[str, ...] = ()
    valued: bool = False  # behind its `=`
    argument: str = ""
    position: int = 0
    begin: int = 0  # the token after its opening or its last comma


def context_at(text: Text, offset: int) -> Context:
    """The context of a place."""
    _, chain = text.chain(offset)
    start = chain[-1].span.start if chain else 0
    terminals = load_language().terminals
    tokens, errors = scan(text.source, terminals, start, offset)
    tokens.pop()
    where = tokens[-1] if tokens else None
    opened = next((e for e in errors if isinstance(e, Unclosed)), None)
    if opened is not None:
        if opened.span is None or opened.span.text != "annotation" or opened.related:
            return Context(Where.NOWHERE)
        return _in_annotation(text, opened.span.end, offset)
    gap = text.source.text[(where.span.end if where else start) : offset]
    if "//" in gap.rpartition("\n")[2]:
        return Context(Where.NOWHERE)
    return _of_tokens(tokens, offset)


def _in_annotation(text: Text, start: int, offset: int) -> Context:
    tokens, _ = scan(text.source, load_language().terminals, start, offset)
    tokens.pop()
    prefix, start = _prefix(tokens, offset)
    before = _dotted(tokens)
    path: list[str] = []
    valued = False
    for at, token in enumerate(tokens):
        if token.type == "LPAR":
            path.append(tokens[at - 1].text if at and tokens[at - 1].type == "IDENT" else "")
            valued = False
        elif token.type in _CLOSING and path:
            path.pop()
        elif token.type in ("COMMA", "EQUAL"):
            valued = token.type == "EQUAL"
    where = Where.VALUE if valued or before else Where.ANNOTATION
    return Context(where, prefix, before, path=tuple(path[1:]), start=start)


def _prefix(tokens: list[Token], offset: int) -> tuple[str, int]:
    """The word that is being written, taken off the tokens."""
    last = tokens[-1] if tokens else None
    if (
        last is None
        or last.span.end != offset
        or not (last.text[:1].isalpha() or last.text[:1] == "_")
    ):
        return "", offset
    tokens.pop()
    return last.text, last.span.start


def _dotted(tokens: list[Token]) -> tuple[str, ...]:
    """The names before a dot at the end of the tokens, which are taken off."""
    names: list[str] = []
    while tokens and tokens[-1].type == "DOT":
        tokens.pop()
        depth = 0
        while tokens and (depth or tokens[-1].type == "RSQB"):
            depth += {"RSQB": 1, "LSQB": -1}.get(tokens.pop().type, 0)
        if not tokens or tokens[-1].type != "IDENT":
            break
        names.append(tokens.pop().text)
    return tuple(reversed(names))


def _of_tokens(tokens: list[Token], offset: int) -> Context:
    prefix, start = _prefix(tokens, offset)
    before = _dotted(tokens)
    section, begin = _statement(tokens)
    frames = _frames(tokens, section, begin)
    frame = frames[-1]
    where = Where.VALUE if frame.valued and frame.where is not Where.CONNECT else frame.where
    first: tuple[str, ...] = ()
    if where is Where.CONNECT and frame.position == 1:
        comma = max(i for i, t in enumerate(tokens) if t.type == "COMMA")
        first = _names_back(tokens, comma)
    head = _class_before(tokens, begin) if where is Where.NAME else frame.head
    return Context(
        where, prefix, before, head, frame.path, frame.argument, frame.position, first, start
    )


def _class_before(tokens: list[Token], begin: int) -> tuple[str, ...]:
    """The class behind which a component is to be named; () where something else stands there."""
    written = [t for t in tokens[begin:] if t.type not in _PREFIXES]
    names = _names_back(written, len(written))
    return names if len(written) == 2 * len(names) - 1 else ()


def _statement(tokens: list[Token]) -> tuple[str, int]:
    """The kind of section at the end of the tokens, and where its last statement begins."""
    sections = [""]
    begin = 0
    depth = 0
    for at, token in enumerate(tokens):
        kind = token.type
        if kind in _OPENING:
            depth += 1
        elif kind in _CLOSING:
            depth = max(depth - 1, 0)
        if kind == "SEMICOLON" or kind in _BEGINS:
            begin, depth = at + 1, 0
        elif kind in _SECTIONS or kind == "INITIAL_SECTION":
            sections[-1] = _SECTIONS.get(kind, "equation")
            begin, depth = at + 1, 0
        elif kind in _KINDS and not depth and (at == 0 or tokens[at - 1].type != "END"):
            following = [t.type for t in tokens[at + 1 : at + 3]]
            if following and following[-1] not in ("EQUAL", "LPAR"):
                sections.append("")
                begin = at + 2 + (following[0] == "EXTENDS" or following[-1] == "STRING")
        elif kind == "IDENT" and at and tokens[at - 1].type == "END" and len(sections) > 1:
            sections.pop()
    return sections[-1], min(begin, len(tokens))


def _frames(tokens: list[Token], section: str, begin: int) -> list[_Frame]:
    """The brackets that are open at the end of the tokens, around each other."""
    first = tokens[begin].type if begin < len(tokens) else ""
    frames = [_Frame(_outermost(tokens, section, begin, first), begin=begin)]
    for at in range(begin, len(tokens)):
        kind = tokens[at].type
        frame = frames[-1]
        if kind in _OPENING:
            frames.append(_opened(tokens, at, frame, section, begin, first))
        elif kind in _CLOSING:
            if len(frames) > 1:
                frames.pop()
        elif kind == "COMMA":
            frame.position += 1
            frame.valued, frame.argument, frame.begin = False, "", at + 1
        elif kind in ("EQUAL", "ASSIGN"):
            named = frame.where in (Where.MODIFIER, Where.CALL)
            frame.argument = tokens[at - 1].text if named else ""
            frame.valued = True
    return frames


def _outermost(tokens: list[Token], section: str, begin: int, first: str) -> Where:
    """What may stand outside of all brackets."""
    written = [t for t in tokens[begin:] if t.type not in _PREFIXES]
    if section:
        return Where.VALUE if written else Where.EQUATION
    if not written:
        return Where.DECLARATION
    if first in ("IMPORT", "EXTENDS") or written[-1].type == "CONSTRAINEDBY":
        return Where.TYPE
    kinds = [t.type for t in written]
    if kinds[-1] in _KINDS or ("IDENT" in kinds and "EQUAL" not in kinds):
        return Where.NAME
    return Where.VALUE


def _opened(
    tokens: list[Token], at: int, around: _Frame, section: str, begin: int, first: str
) -> _Frame:
    """The frame of a bracket that opens."""
    head = _names_back(tokens, at)
    inside = at + 1
    if tokens[at].type != "LPAR" or (not head and tokens[at - 1].type != "CONNECT"):
        return _Frame(Where.VALUE, begin=inside)
    if tokens[at - 1].type == "CONNECT":
        return _Frame(Where.CONNECT, begin=inside)
    if around.where is Where.MODIFIER and not around.valued:
        redeclared = _type_before(tokens, around.begin, at)
        if redeclared:
            return _Frame(Where.MODIFIER, redeclared, begin=inside)
        return _Frame(Where.MODIFIER, around.head, (*around.path, *head), begin=inside)
    if section or around.where in (Where.CALL, Where.CONNECT) or around.valued:
        is_class = not section and tokens[begin].type in _KINDS and around.begin == begin
        return _Frame(Where.MODIFIER if is_class else Where.CALL, head, begin=inside)
    if first == "EXTENDS" or tokens[max(at - len(head) * 2, 0)].type == "CONSTRAINEDBY":
        return _Frame(Where.MODIFIER, head, begin=inside)
    declared = _type_before(tokens, begin, at)
    return _Frame(Where.MODIFIER if declared else Where.CALL, declared or head, begin=inside)


def _names_back(tokens: list[Token], at: int) -> tuple[str, ...]:
    """The dotted name that ends before a token."""
    names: list[str] = []
    at -= 1
    while at >= 0:
        depth = 0
        while at >= 0 and (depth or tokens[at].type == "RSQB"):
            depth += {"RSQB": 1, "LSQB": -1}.get(tokens[at].type, 0)
            at -= 1
        if at < 0 or tokens[at].type != "IDENT":
            break
        names.append(tokens[at].text)
        if at < 2 or tokens[at - 1].type != "DOT":
            break
        at -= 2
    return tuple(reversed(names))


def _type_before(tokens: list[Token], begin: int, at: int) -> tuple[str, ...]:
    """The type of a declaration `type name(`, from its first token to its bracket."""
    names: list[str] = []
    i = begin
    while i < at and tokens[i].type in _PREFIXES:
        i += 1
    while i < at and tokens[i].type == "IDENT":
        names.append(tokens[i].text)
        if i + 1 < at and tokens[i + 1].type == "DOT":
            i += 2
            continue
        i += 1
        break
    rest = [t for t in tokens[i:at] if t.type == "IDENT"]
    return tuple(names) if rest else ()
