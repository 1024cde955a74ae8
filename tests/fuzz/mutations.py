"""Valid files made wrong: each input follows from a seed and a number, so that it can be had again.

`mutate(data, others, rng)` changes a file in one to four small ways: tokens deleted,
doubled, swapped, or taken from other files; pieces cut off, moved or repeated; numbers made
huge; bytes that are no text; the marks and line ends of other systems.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from random import Random

_TOKEN = re.compile(
    rb"[A-Za-z_][A-Za-z_0-9]*|\d+(?:\.\d+)?(?:[eE][+-]?\d+)?|\"(?:[^\"\\]|\\.)*\"|\s+|//[^\n]*"
    rb"|/\*.*?\*/|:=|<=|>=|<>|==|\.\*|.",
    re.S,
)
_WORDS = (
    b"algorithm and annotation block break class connect connector constant constrainedby der"
    b" discrete each else elseif elsewhen encapsulated end enumeration equation expandable extends"
    b" external false final flow for function if import impure in initial inner input loop model"
    b" not operator or outer output package parameter partial protected public pure record"
    b" redeclare replaceable return stream then true type when while within time pre sample"
    b" reinit noEvent smooth delay cat size fill String Integer Real Boolean self start fixed"
).split()
_SIGNS = [
    *(bytes([c]) for c in b"()[]{};,.:=+-*/^<>'\"\\"),
    b":=", b"==", b"<>", b".+", b"/*", b"*/", b"//", b"\0", b"\xef\xbb\xbf", b"\xe9", b"\xff",
    b"\xc3", b"\xe2\x80\xae", b"\r", b"\x0c", b"\x1b[2J", "é".encode(), "∑".encode(),
]  # fmt: skip
_NUMBERS = (
    b"0", b"-1", b"1e999", b"1e-999", b"1e308", b"2147483648", b"9223372036854775808",
    b"1000000000", b"1" * 400, b"0.1", b"1.e", b"1e", b"00", b"1:0", b"{}", b"fill(0, 0)",
    b"(1/0)", b"time", b"end",
)  # fmt: skip

#: What stands where each of these may stand.
_ALIKE: dict[bytes, tuple[bytes, ...]] = {
    word: tuple(group)
    for group in (
        b"+ - * / ^ .* = == < and or".replace(b".*", b"<>").split(),
        b"sin cos exp log sqrt abs atan2 min max sum der pre noEvent not size cross fill".split(),
        b"Real Integer Boolean String Body World Revolute Prismatic Spring".split(),
        b"parameter constant discrete input output flow final each inner outer".split(),
        b"model block record function type package connector class".split(),
        b"equation algorithm protected public".split(),
        b"true false time 1 0 2.5 end".split(),
        b"start fixed min max unit stateSelect r phi w m I n".split(),
    )
    for word in group
}

Tokens = list[bytes]
Change = Callable[[Tokens, Sequence[bytes], Random], Tokens]


def mutate(data: bytes, others: Sequence[bytes], rng: Random) -> bytes:
    """`data` with one to four changes; `others` lend pieces."""
    tokens = _TOKEN.findall(data)
    for _ in range(rng.choice((1, 1, 1, 2, 3, 4))):
        tokens = rng.choice(_CHANGES)(tokens, others, rng) or [b""]
    return b"".join(tokens)


def _place(tokens: Tokens, rng: Random) -> int:
    """A token that is no white space, most times."""
    for _ in range(5):
        i = rng.randrange(len(tokens))
        if tokens[i].strip():
            return i
    return rng.randrange(len(tokens))


def _delete(tokens: Tokens, _: Sequence[bytes], rng: Random) -> Tokens:
    i = _place(tokens, rng)
    return tokens[:i] + tokens[i + rng.choice((1, 1, 1, 2, 5, 40)) :]


def _duplicate(tokens: Tokens, _: Sequence[bytes], rng: Random) -> Tokens:
    i, n = _place(tokens, rng), rng.choice((1, 1, 3, 12, 60))
    return [*tokens[: i + n], b" ", *tokens[i : i + n], *tokens[i + n :]]


def _swap(tokens: Tokens, _: Sequence[bytes], rng: Random) -> Tokens:
    i, j = _place(tokens, rng), _place(tokens, rng)
    changed = list(tokens)
    changed[i], changed[j] = changed[j], changed[i]
    return changed


def _rename(tokens: Tokens, _: Sequence[bytes], rng: Random) -> Tokens:
    """A name or number where another one of the file stands."""
    same = [i for i, t in enumerate(tokens) if t[:1].isalnum()]
    if len(same) < 2:
        return tokens
    i, j = rng.sample(same, 2)
    return [*tokens[:i], tokens[j], *tokens[i + 1 :]]


def _insert(tokens: Tokens, _: Sequence[bytes], rng: Random) -> Tokens:
    i = _place(tokens, rng)
    piece = rng.choice((rng.choice(_WORDS), rng.choice(_SIGNS), rng.choice(_NUMBERS)))
    return [*tokens[:i], b" ", piece, b" ", *tokens[i + rng.randrange(2) :]]


def _renumber(tokens: Tokens, _: Sequence[bytes], rng: Random) -> Tokens:
    numbers = [i for i, t in enumerate(tokens) if t[:1].isdigit()]
    if not numbers:
        return tokens
    i = rng.choice(numbers)
    return [*tokens[:i], rng.choice(_NUMBERS), *tokens[i + 1 :]]


def _borrow(tokens: Tokens, others: Sequence[bytes], rng: Random) -> Tokens:
    """A piece of another file in this one."""
    other = _TOKEN.findall(rng.choice(others))
    i, j = _place(tokens, rng), _place(other, rng)
    return [*tokens[:i], b" ", *other[j : j + rng.choice((1, 4, 20, 100))], b" ", *tokens[i:]]


def _statements(tokens: Tokens, others: Sequence[bytes], rng: Random) -> Tokens:
    """Statements deleted, doubled, swapped, or taken from another file: mostly still a tree."""
    parts = b"".join(tokens).split(b";")
    i, j = rng.randrange(len(parts)), rng.randrange(len(parts))
    match rng.randrange(4):
        case 0:
            del parts[i]
        case 1:
            parts.insert(j, parts[i])
        case 2:
            parts[i], parts[j] = parts[j], parts[i]
        case _:
            parts.insert(i, rng.choice(rng.choice(others).split(b";")))
    return _TOKEN.findall(b";".join(parts))


def _operator(tokens: Tokens, _: Sequence[bytes], rng: Random) -> Tokens:
    """Another operator, or another predefined function or type."""
    places = [i for i, t in enumerate(tokens) if t in _ALIKE]
    if not places:
        return tokens
    i = rng.choice(places)
    return [*tokens[:i], rng.choice(_ALIKE[tokens[i]]), *tokens[i + 1 :]]


def _move_lines(tokens: Tokens, _: Sequence[bytes], rng: Random) -> Tokens:
    lines = b"".join(tokens).split(b"\n")
    line = lines.pop(rng.randrange(len(lines)))
    lines.insert(rng.randrange(len(lines) + 1), line)
    return _TOKEN.findall(b"\n".join(lines))


def _truncate(tokens: Tokens, _: Sequence[bytes], rng: Random) -> Tokens:
    data = b"".join(tokens)
    at = rng.randrange(len(data) + 1)
    return _TOKEN.findall(data[:at] if rng.random() < 0.8 else data[at:])


def _bytes(tokens: Tokens, _: Sequence[bytes], rng: Random) -> Tokens:
    data = bytearray(b"".join(tokens))
    for _i in range(rng.choice((1, 1, 8, 100))):
        at = rng.randrange(len(data) + 1)
        data[at : at + rng.randrange(2)] = bytes([rng.randrange(256)])
    return _TOKEN.findall(bytes(data))


def _systems(tokens: Tokens, _: Sequence[bytes], rng: Random) -> Tokens:
    """As other systems write files."""
    data = b"".join(tokens)
    ends = rng.choice((b"\r\n", b"\r", b"\n\r", b"\xe2\x80\xa8"))
    mark = rng.choice((b"", b"\xef\xbb\xbf", b"\xff\xfe", b"\xfe\xff"))
    text = mark + data.replace(b"\n", ends)
    if rng.random() < 0.1:
        text = text.decode("utf-8", "replace").encode("utf-16")
    return _TOKEN.findall(text)


def _repeat(tokens: Tokens, _: Sequence[bytes], rng: Random) -> Tokens:
    """A token many times."""
    i = _place(tokens, rng)
    return [*tokens[:i], *[tokens[i], b" "] * rng.choice((3, 30, 600)), *tokens[i:]]


_CHANGES: tuple[Change, ...] = (
    *(_delete, _duplicate, _swap, _insert, _borrow),
    *(_rename, _renumber, _statements, _operator) * 8,
    _move_lines,
    _truncate,
    _bytes,
    _systems,
    _repeat,
)
