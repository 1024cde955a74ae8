"""A WebAssembly module from LLVM's objects: one memory, its functions, what it wants of its host.

In:   objects for wasm32, the functions that the host may call
Out:  bytes; imported are the functions of `env` that no object has

    0         constants, one after the other
    ...       the stack, downwards
    heap      from the exported global `heap` on; the host hands it out

Functions that no exported one reaches are left out. Addresses stand in the code as numbers of
five bytes, so that nothing moves when they are filled in.

Reference: WebAssembly Core Specification 1.0, chapter 5, "Binary Format"; WebAssembly tool
           conventions, "Linking" (object files and their relocations).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from planarc.core.data import Data

_HEAD = b"\0asm\1\0\0\0"
_CUSTOM, _TYPE, _IMPORT, _FUNCTION, _TABLE, _MEMORY, _GLOBAL, _EXPORT = range(8)
_ELEMENT, _CODE, _DATA = 9, 10, 11
_FUNCTIONS, _DATAS = 0, 1  # kinds of symbols that carry more than an index
_LOCAL, _UNDEFINED, _NAMED = 0x02, 0x10, 0x40  # flags of a symbol
_SEGMENTS, _SYMBOLS = 5, 8  # parts of the section `linking`
#: R_WASM_*: what a place in the code or in constants wants to know.
_CALL, _SLOT_SIGNED, _SLOT, _AT, _AT_SIGNED, _AT_WORD, _SHAPE, _OF_GLOBAL = range(8)
_OF_TABLE = 20
_WITH_ADDEND = (_AT, _AT_SIGNED, _AT_WORD)
_STACK, _PAGE = 1 << 18, 1 << 16
_I32, _FUNCTION_REFERENCE, _END = 0x7F, 0x70, 0x0B
#: The first place of the table of functions, so that no function's address is null.
_FIRST = 1


class _Relocation(Data):
    offset: int
    kind: int
    index: int
    addend: int


class _Symbol(Data):
    kind: int
    name: str
    public: bool
    index: int | None  # of the function or segment; None: another object has it
    offset: int


class _Body(Data):
    """A function's code, or a segment of constants."""

    data: bytes
    relocations: tuple[_Relocation, ...]
    detail: int  # the number of its type, or its alignment


class _Object(Data):
    types: tuple[bytes, ...]
    imported: tuple[tuple[str, int], ...]  # functions, with their types
    functions: tuple[_Body, ...]
    constants: tuple[_Body, ...]
    symbols: tuple[_Symbol, ...]


def write_module(objects: Sequence[bytes], public: Sequence[str]) -> bytes:
    """The module."""
    return _Linker([_read(data) for data in objects], public).module()


class _Reader:
    def __init__(self, data: bytes, at: int = 0) -> None:
        self.data, self.at = data, at

    def byte(self) -> int:
        self.at += 1
        return self.data[self.at - 1]

    def number(self) -> int:
        """An unsigned number, LEB128."""
        value = shift = 0
        while True:
            byte = self.byte()
            value |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                return value

    def signed(self) -> int:
        value = shift = 0
        while True:
            byte = self.byte()
            value |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                return value - (1 << shift if byte & 0x40 else 0)

    def take(self, count: int) -> bytes:
        self.at += count
        return self.data[self.at - count : self.at]

    def text(self) -> str:
        return self.take(self.number()).decode()

    def parts(self) -> Iterator[tuple[int, int, int]]:
        """Sections or parts of one: kind, first and last byte."""
        while self.at < len(self.data):
            kind, size = self.byte(), self.number()
            yield kind, self.at, self.at + size
            self.at += size


def _read(data: bytes) -> _Object:
    assert data[:8] == _HEAD, "no WebAssembly object"
    sections: dict[int, _Reader] = {}
    named: dict[str, _Reader] = {}
    order: list[int] = []
    for kind, begin, end in list(_Reader(data, 8).parts()):
        order.append(kind)
        own = _Reader(data[begin:end])
        if kind == _CUSTOM:
            name = own.text()
            named[name] = own
        else:
            sections[kind] = own
    relocations: dict[int, list[_Relocation]] = {}
    for name, own in named.items():
        if name.startswith("reloc."):
            section = order[own.number()]
            relocations[section] = list(_relocations(own))
    types = tuple(_types(sections[_TYPE]))
    imported = tuple(_imports(sections[_IMPORT]))
    kinds = sections[_FUNCTION]
    shapes = [kinds.number() for _ in range(kinds.number())]
    code, constants = sections[_CODE], sections.get(_DATA)
    aligns, symbols = _linking(named["linking"])
    functions = [
        _Body(body, tuple(_within(relocations.get(_CODE, []), at, len(body))), shape)
        for shape, (at, body) in zip(shapes, _sized(code), strict=True)
    ]
    segments = [] if constants is None else [
        _Body(body, tuple(_within(relocations.get(_DATA, []), at, len(body))), 1 << align)
        for align, (at, body) in zip(aligns, _segments(constants), strict=True)
    ]  # fmt: skip
    return _Object(types, imported, tuple(functions), tuple(segments), tuple(symbols))


def _relocations(own: _Reader) -> Iterator[_Relocation]:
    for _ in range(own.number()):
        kind, offset, index = own.byte(), own.number(), own.number()
        addend = own.signed() if kind in _WITH_ADDEND else 0
        yield _Relocation(offset, kind, index, addend)


def _within(known: Sequence[_Relocation], at: int, length: int) -> Iterator[_Relocation]:
    """The relocations of a part, reckoned from its own beginning."""
    for r in known:
        if at <= r.offset < at + length:
            yield _Relocation(r.offset - at, r.kind, r.index, r.addend)


def _types(own: _Reader) -> Iterator[bytes]:
    for _ in range(own.number()):
        begin = own.at
        assert own.byte() == 0x60
        for _ in range(2):  # what a function takes, what it gives
            own.take(own.number())
        yield own.data[begin : own.at]


def _imports(own: _Reader) -> Iterator[tuple[str, int]]:
    for _ in range(own.number()):
        own.text()
        name, kind = own.text(), own.byte()
        if kind == 0:
            yield name, own.number()
        elif kind == 1:
            own.byte()
        if kind in (1, 2):  # a table or a memory, with its limits
            for _ in range(1 + own.byte() % 2):
                own.number()
        elif kind == 3:
            own.take(2)


def _sized(own: _Reader) -> Iterator[tuple[int, bytes]]:
    for _ in range(own.number()):
        size = own.number()
        yield own.at, own.take(size)


def _segments(own: _Reader) -> Iterator[tuple[int, bytes]]:
    for _ in range(own.number()):
        own.number()
        assert own.byte() == 0x41  # at i32.const
        own.signed()
        assert own.byte() == _END
        size = own.number()
        yield own.at, own.take(size)


def _linking(own: _Reader) -> tuple[list[int], list[_Symbol]]:
    """The alignments of segments, and the symbols."""
    assert own.number() == 2, "linking of another version"
    aligns: list[int] = []
    symbols: list[_Symbol] = []
    for kind, begin, end in own.parts():
        part = _Reader(own.data[:end], begin)
        if kind == _SEGMENTS:
            for _ in range(part.number()):
                part.text()
                aligns.append(part.number())
                part.number()
        elif kind == _SYMBOLS:
            symbols = [_symbol(part) for _ in range(part.number())]
    return aligns, symbols


def _symbol(own: _Reader) -> _Symbol:
    kind, flags = own.byte(), own.number()
    public, outside = not flags & _LOCAL, bool(flags & _UNDEFINED)
    if kind == _DATAS:
        name = own.text()
        place = (None, 0) if outside else (own.number(), own.number())
        if not outside:
            own.number()
        return _Symbol(kind, name, public, *place)
    index = own.number()
    name = own.text() if not outside or flags & _NAMED else ""
    return _Symbol(kind, name, public, index, -1 if outside else 0)


class _Linker:
    """Functions are pairs (object, number), imported ones their names."""

    def __init__(self, objects: Sequence[_Object], public: Sequence[str]) -> None:
        self._objects, self._public = objects, public
        self._functions: dict[str, tuple[int, int]] = {}
        self._constants: dict[str, tuple[int, int, int]] = {}
        for k, found in enumerate(objects):
            for s in found.symbols:
                if s.public and s.kind == _FUNCTIONS and s.offset == 0 and s.index is not None:
                    self._functions[s.name] = k, s.index - len(found.imported)
                elif s.public and s.kind == _DATAS and s.index is not None:
                    self._constants[s.name] = k, s.index, s.offset
        self._kept, self._wanted = self._reached([self._functions[name] for name in public])
        self._types: dict[bytes, int] = {}
        self._numbers: dict[tuple[int, int] | str, int] = {}
        for name in self._wanted:
            self._numbers[name] = len(self._numbers)
        for place in self._kept:
            self._numbers[place] = len(self._numbers)
        self._slots: dict[tuple[int, int] | str, int] = {}
        self._starts, self._length = self._laid()

    def _target(self, k: int, index: int) -> tuple[int, int] | str:
        """The function that a symbol of an object names."""
        found = self._objects[k]
        symbol = found.symbols[index]
        assert symbol.index is not None
        if symbol.index >= len(found.imported):
            return k, symbol.index - len(found.imported)
        name = found.imported[symbol.index][0]
        return self._functions.get(name, name)

    def _reached(
        self, first: Sequence[tuple[int, int]]
    ) -> tuple[list[tuple[int, int]], dict[str, bytes]]:
        """The functions to keep, and the imported ones with their types."""
        kept, wanted = dict.fromkeys(first), dict[str, bytes]()
        waiting = list(kept)
        while waiting:
            k, number = waiting.pop()
            found = self._objects[k]
            for r in found.functions[number].relocations:
                if r.kind in (_CALL, _SLOT, _SLOT_SIGNED):
                    place = self._target(k, r.index)
                    if isinstance(place, str):
                        index = found.symbols[r.index].index
                        assert index is not None
                        wanted[place] = found.types[found.imported[index][1]]
                    elif place not in kept:
                        kept[place] = None
                        waiting.append(place)
        return sorted(kept), dict(sorted(wanted.items()))

    def _laid(self) -> tuple[dict[tuple[int, int], int], int]:
        """Where the segments of constants begin, behind a first word that nothing has."""
        starts, at = {}, 16
        for k, found in enumerate(self._objects):
            for i, segment in enumerate(found.constants):
                starts[k, i] = at = -(-at // segment.detail) * segment.detail
                at += len(segment.data)
        return starts, -(-at // 16) * 16

    def _value(self, k: int, r: _Relocation) -> int:
        found = self._objects[k]
        if r.kind == _SHAPE:
            return self._type(found.types[r.index])
        if r.kind in (_OF_GLOBAL, _OF_TABLE):  # there is one of each
            return 0
        if r.kind in _WITH_ADDEND:
            symbol = found.symbols[r.index]
            own = symbol.index
            place = self._constants[symbol.name] if own is None else (k, own, symbol.offset)
            return self._starts[place[:2]] + place[2] + r.addend
        target = self._target(k, r.index)
        if r.kind == _CALL:
            return self._numbers[target]
        return self._slots.setdefault(target, _FIRST + len(self._slots))

    def _type(self, shape: bytes) -> int:
        return self._types.setdefault(shape, len(self._types))

    def _filled(self, k: int, body: _Body) -> bytes:
        data = bytearray(body.data)
        for r in body.relocations:
            value = self._value(k, r)
            if r.kind in (_AT_WORD, _SLOT):
                data[r.offset : r.offset + 4] = value.to_bytes(4, "little")
            else:
                data[r.offset : r.offset + 5] = _wide(value)
        return bytes(data)

    def module(self) -> bytes:
        constants = bytearray(self._length)
        for (k, i), at in self._starts.items():
            filled = self._filled(k, self._objects[k].constants[i])
            constants[at : at + len(filled)] = filled
        bodies = [self._filled(k, self._objects[k].functions[i]) for k, i in self._kept]
        shapes = [self._objects[k].types[self._objects[k].functions[i].detail]
                  for k, i in self._kept]  # fmt: skip
        imports = [_text("env") + _text(name) + b"\0" + _leb(self._type(shape))
                   for name, shape in self._wanted.items()]  # fmt: skip
        top = self._length + _STACK
        exports = [_text("memory") + b"\2\0", _text("heap") + b"\3\1"]
        exports += [_text(name) + b"\0" + _leb(self._numbers[self._functions[name]])
                    for name in self._public]  # fmt: skip
        functions = [_leb(self._type(shape)) for shape in shapes]
        types = list(self._types)
        slots = [_leb(self._numbers[place]) for place in self._slots]
        globals_ = [bytes((_I32, changes, 0x41)) + _leb_signed(top) + bytes((_END,))
                    for changes in (1, 0)]  # fmt: skip
        table = bytes((_FUNCTION_REFERENCE, 0)) + _leb(_FIRST + len(slots))
        memory = b"\0" + _leb(-(-top // _PAGE))
        start = b"\0\x41" + _leb_signed(_FIRST) + bytes((_END,))
        parts = (
            (_TYPE, _row(types)),
            (_IMPORT, _row(imports)),
            (_FUNCTION, _row(functions)),
            (_TABLE, _row([table])),
            (_MEMORY, _row([memory])),
            (_GLOBAL, _row(globals_)),
            (_EXPORT, _row(exports)),
            (_ELEMENT, _row([start + _row(slots)])),
            (_CODE, _row([_leb(len(body)) + body for body in bodies])),
            (_DATA, _row([b"\0\x41\0" + bytes((_END,)) + _leb(len(constants)) + constants])),
        )
        return _HEAD + b"".join(bytes((kind,)) + _leb(len(p)) + p for kind, p in parts)


def _row(items: Sequence[bytes]) -> bytes:
    return _leb(len(items)) + b"".join(items)


def _text(text: str) -> bytes:
    data = text.encode()
    return _leb(len(data)) + data


def _leb(value: int) -> bytes:
    out = bytearray()
    while value >= 0x80:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)


def _leb_signed(value: int) -> bytes:
    """A positive number whose sign is written, too."""
    out = bytearray()
    while value >= 0x40:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)


def _wide(value: int) -> bytes:
    """A number in five bytes, below 2**31: its sign makes no difference."""
    return bytes((value >> 7 * i & 0x7F) | (0x80 if i < 4 else 0) for i in range(5))
