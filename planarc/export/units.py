"""Functions that many models share, each as machine code that is kept by itself.

In:   text of LLVM, optimised; what makes an object of such a text; units that are known
Out:  Unit      a function as an object of its own, and what it is known by

A model of another kind has most functions of those before: only the others are made, in one
object, which is cut into functions thereafter. A function is known by its text and by the heads of
those that it calls, which tell what they give; its code hangs on nothing else. So the code is the
same whatever was known.

    define i32 @px_step(...)    a section of its own, and the constants that it loads
    @px_text_3 = constant       one object of all constants with names

Reference: System V Application Binary Interface, chapter 4, "Object Files".
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from hashlib import blake2b

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.runtime.link.objects import Object, Section, Symbol, read_object

_CODE, _CONSTANTS = ".text.", ".rodata.cst"
_FUNCTION = re.compile(r"^define ([^\n]*@(\w+)\([^\n]*) \{\n(?:[^\n]*\n)+?\}\n", re.MULTILINE)
_GROUP = re.compile(r"^attributes (#\d+) = (.*)$", re.MULTILINE)
_CONSTANT = re.compile(r"^@(\w+) = (internal|hidden) constant (\[.*\n)", re.MULTILINE)
_MENTIONED, _NUMBER = re.compile(r"@(\w+)"), re.compile(r"#\d+")


class Unit(Data):
    """What a function, or all constants of a text, is known by, and its code."""

    key: str
    code: Object


class Text:
    """A module of LLVM whose functions are emitted one by one."""

    def __init__(self, text: str) -> None:
        groups = dict(_GROUP.findall(text))
        text = _by_content(text).replace("define internal ", "define hidden ")
        self._functions = {f[2]: f for f in _FUNCTION.finditer(text)}
        constants = {c[1]: c[0] for c in _CONSTANT.finditer(text)}
        self._constants = "".join(constants.values())
        declared = (f"@{c} = external hidden constant [0 x i8]\n" for c in constants)
        self._rest = "".join((_CONSTANT.sub("", _FUNCTION.sub("", text)), *declared))
        heads = {name: _NUMBER.sub("", f[1]) for name, f in self._functions.items()}
        self.keys = {"": _digest((self._constants,))} if constants else {}
        self._small: set[str] = set()
        for name, f in self._functions.items():
            called = sorted({*_MENTIONED.findall(f[0])} & heads.keys())
            whole = _NUMBER.sub(lambda n: groups.get(n[0], n[0]), f[0])
            self.keys[name] = _digest((whole, *(heads[n] for n in called)))
            if " minsize " in whole:
                self._small.add(name)

    def units(
        self, known: Mapping[str, Object], emit: Callable[[str, bool], bytes]
    ) -> Iterator[Unit]:
        """All of them, as they stand in the text. `emit` is told whether what it makes is small
        rather than quick."""
        new = {name for name, key in self.keys.items() if key not in known}
        made: dict[str, Object] = {}
        for small, some in ((True, new & self._small), (False, new - self._small - {""})):
            if some:
                made |= _cut(read_object(emit(self._with(some), small)))
        if "" in new:
            made[""] = read_object(emit(self._constants, True))
        for name, key in self.keys.items():
            yield Unit(key, made[name] if name in new else known[key])

    def _with(self, wanted: Iterable[str]) -> str:
        """The text, where others are declared alone."""
        wanted = set(wanted)
        parts = [self._rest]
        for name, f in self._functions.items():
            if name in wanted:
                head = f"define {f[1]}"
                parts.append(f[0].replace(head, f'{head} section "{_CODE}{name}"', 1))
            else:
                parts.append(f"declare {f[1]}\n")
        return "\n".join(parts)


def _by_content(text: str) -> str:
    """The text, where a constant that it has for itself is called by what it holds: its number
    hangs on which others there are."""
    names = {c[1]: f"px_{_digest((c[3],))}" for c in _CONSTANT.finditer(text)
             if c[2] == "internal"}  # fmt: skip
    text = _MENTIONED.sub(lambda m: f"@{names.get(m[1], m[1])}", text)
    return _CONSTANT.sub(r"@\1 = hidden constant \3", text)


def _digest(parts: Iterable[str]) -> str:
    digest = blake2b(digest_size=16)
    for part in parts:
        digest.update(f"{len(part)}\n{part}".encode())
    return digest.hexdigest()


def _cut(found: Object) -> Iterator[tuple[str, Object]]:
    """Each function of an object by its name, with the constants that it loads."""
    for section in found.sections:
        assert section.name.startswith((_CODE, _CONSTANTS)), f"{section.name} is no function's"
        if section.name.startswith(_CODE):
            name = section.name.removeprefix(_CODE)
            yield name, _alone(found, name, section)


def _alone(found: Object, name: str, code: Section) -> Object:
    sections, symbols = [replace(code, name=_CODE.rstrip("."))], [Symbol(name, 0, 0, True)]
    places: dict[Symbol, int] = {symbols[0]: 0}

    def place(symbol: Symbol) -> int:
        if symbol not in places:
            places[symbol] = len(symbols)
            symbols.append(symbol)
        return places[symbol]

    relocations = []
    for r in code.relocations:
        symbol, addend = found.symbols[r.symbol], r.addend
        home = None if symbol.section is None else found.sections[symbol.section]
        if home is None or home.name.startswith(_CODE):
            wanted = Symbol(symbol.name, 0 if symbol.name == name else None, 0, True)
        else:
            at, addend = (symbol.value, addend) if symbol.name else (addend, 0)
            constant = _entry(home, at)
            if constant not in sections:
                sections.append(constant)
            wanted = Symbol("", sections.index(constant), 0, False)
        relocations.append(replace(r, symbol=place(wanted), addend=addend))
    sections[0] = replace(sections[0], relocations=tuple(relocations))
    return Object(found.processor, tuple(sections), tuple(symbols))


def _entry(home: Section, at: int) -> Section:
    """A constant of those of one length."""
    length = int(home.name.removeprefix(_CONSTANTS))
    assert at % length == 0 and not home.relocations, f"{home.name} has no entry at {at}"
    return replace(home, data=home.data[at : at + length])


def constants_once(found: Object) -> Object:
    """The object, where no constant of a unit stands twice."""
    first: dict[Section, int] = {}
    places: list[int] = []
    sections: list[Section] = []
    for s in found.sections:
        single = s.name == f"{_CONSTANTS}{len(s.data)}"
        if single and s in first:
            places.append(first[s])
            continue
        if single:
            first[s] = len(sections)
        places.append(len(sections))
        sections.append(s)
    symbols = (replace(s, section=None if s.section is None else places[s.section])
               for s in found.symbols)  # fmt: skip
    return replace(found, sections=tuple(sections), symbols=tuple(symbols))


def reached(found: Object, public: Iterable[str]) -> Object:
    """The object, where sections are empty that none of these functions needs: what models share
    serves others, too."""
    wanted = set(public)
    todo = [s.section for s in found.symbols if s.public and s.name in wanted]
    kept: set[int] = set()
    while todo:
        home = todo.pop()
        if home is not None and home not in kept:
            kept.add(home)
            todo += [found.symbols[r.symbol].section for r in found.sections[home].relocations]
    sections = (
        s if i in kept else replace(s, data=b"", align=1, relocations=())
        for i, s in enumerate(found.sections)
    )
    return replace(found, sections=tuple(sections))
