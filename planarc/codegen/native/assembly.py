"""LLVM's text, written with Python's operators.

A `Code` is one function; a `Value` is a register or constant of it. `a*b + c` on
values emits the instructions and gives the register of the result, so that loops
such as an elimination read like the formulas they are. Text is written directly:
for models of 10^4 statements this is five times faster than building objects.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TypeAlias

REAL, INT, BIT, POINTER, FLAG = "double", "i64", "i1", "ptr", "i32"

Operator: TypeAlias = "Callable[[Value, Value | float], Value]"


def real_text(value: float) -> str:
    """A constant exactly, as its bits."""
    return f"0x{struct.unpack('>Q', struct.pack('>d', value))[0]:016X}"


def _computed(real: str, whole: str) -> tuple[Operator, Operator]:
    """An operator by its instructions, and the same with its operands exchanged."""

    def direct(a: Value, other: Value | float) -> Value:
        b = a.code.constant(other, a.type)
        instruction = real if a.type == REAL else whole
        return a.code.emit(a.type, f"{instruction} {a.type} {a.text}, {b.text}")

    return direct, lambda a, other: direct(a.code.constant(other, a.type), a)


def _compared(real: str, whole: str) -> Operator:
    def compare(a: Value, other: Value | float) -> Value:
        b = a.code.constant(other, a.type)
        test = f"fcmp {real}" if a.type == REAL else f"icmp {whole}"
        return a.code.emit(BIT, f"{test} {a.type} {a.text}, {b.text}")

    return compare


class Value:
    """A register or a constant, with its type."""

    __slots__ = ("code", "text", "type")

    def __init__(self, code: Code, type: str, text: str) -> None:
        self.code, self.type, self.text = code, type, text

    def kept(self) -> Value:
        """The value in a register, or a constant."""
        return self

    __add__, __radd__ = _computed("fadd", "add")
    __sub__, __rsub__ = _computed("fsub", "sub")
    __mul__, __rmul__ = _computed("fmul", "mul")
    __truediv__, __rtruediv__ = _computed("fdiv", "sdiv")
    __lt__ = _compared("olt", "slt")
    __gt__ = _compared("ogt", "sgt")
    __ge__ = _compared("oge", "sge")
    __le__ = _compared("ole", "sle")
    equals = _compared("oeq", "eq")

    def __neg__(self) -> Value:
        return Negative(self).kept()

    def negative(self) -> Value:
        return 0 - self

    def is_nan(self) -> Value:
        return self.code.emit(BIT, f"fcmp uno {self.type} {self.text}, {self.text}")

    def __and__(self, other: Value) -> Value:
        return self.code.emit(BIT, f"and i1 {self.text}, {other.text}")

    def __or__(self, other: Value) -> Value:
        return self.code.emit(BIT, f"or i1 {self.text}, {other.text}")

    def __invert__(self) -> Value:
        return self.code.emit(BIT, f"xor i1 {self.text}, true")

    def call(self, type: str, *arguments: Value) -> Value:
        """What the function at this address gives."""
        return self.code.emit(type, f"call {type} {self.text}({_given(arguments)})")

    # Memory: a pointer to 8-byte elements

    def at(self, index: Value | int) -> Value:
        i = index if isinstance(index, int) else index.text
        return self.code.emit(POINTER, f"getelementptr inbounds i64, ptr {self.text}, i64 {i}")

    def load(self, type: str, index: Value | int = 0) -> Value:
        return self.code.emit(type, f"load {type}, ptr {self.at(index).text}, align 8")

    def store(self, value: Value | float, index: Value | int = 0) -> None:
        v = self.code.constant(value, REAL)
        place = self.at(index).text
        self.code.line(f"store {v.type} {v.text}, ptr {place}, align 8")


class Negative(Value):
    """The negative of a number, not computed yet: sums subtract the number instead."""

    __slots__ = ("number",)

    def __init__(self, number: Value) -> None:
        self.code, self.type, self.text = number.code, number.type, ""
        self.number = number

    def kept(self) -> Value:
        if not self.text:
            self.text = self.code.emit(self.type, f"fneg double {self.number.kept().text}").text
        return self


class Variable:
    """A value that changes; LLVM turns it into registers."""

    def __init__(self, code: Code, value: Value) -> None:
        self._place = code.place(value.type)
        self._type = value.type
        self.set(value)

    def get(self) -> Value:
        return self._place.load(self._type)

    def set(self, value: Value | float) -> None:
        self._place.store(value)


def table(name: str, values: Iterable[int]) -> str:
    """A constant array of whole numbers."""
    row = list(values) or [0]
    return f"@{name} = constant [{len(row)} x i64] [{', '.join(f'i64 {n}' for n in row)}]\n"


#: What a function is marked with that is called seldom: it is compiled in the quickest way.
SELDOM = "noinline optnone "


def function(
    signature: str, seldom: bool = False
) -> Callable[[Callable[..., None]], Callable[..., str]]:
    """Make what writes the body of a function, `i32 pc_f(ptr frame, double t)`, give its text,
    headed by what the writer says of it. What is called `seldom` is compiled in the quickest
    way; what more the writer must know is given when the text is asked for."""
    head, listed = signature.rstrip(")").split("(")
    result, name = head.split()
    arguments = [(t, n) for t, n in (a.split() for a in listed.split(", "))]

    def decorate(write: Callable[..., None]) -> Callable[..., str]:
        def text(*more: bool) -> str:
            c = Code(name, result, arguments)
            write(c, *c.arguments, *more)
            told = " ".join((write.__doc__ or "").split())
            comment = f"; {told}\n" if told else ""
            return comment + c.text(SELDOM if seldom else "")

        return text

    return decorate


class Code:
    """One function while it is written."""

    def __init__(self, name: str, result: str, arguments: Sequence[tuple[str, str]]) -> None:
        self._head = f"define {result} @{name}({', '.join(f'{t} %{n}' for t, n in arguments)})"
        self._arguments = arguments
        self._places: list[str] = []
        self.lines: list[str] = []
        self._count = 0

    @property
    def arguments(self) -> list[Value]:
        """The arguments; they know the function, so that it does not hold them."""
        return [Value(self, t, f"%{n}") for t, n in self._arguments]

    def text(self, attributes: str = "") -> str:
        body = "\n".join(f"  {line}" if line[-1] != ":" else line for line in self.lines)
        places = "".join(f"  {line}\n" for line in self._places)
        # On Windows large frames would call a function that no library has.
        attributes += 'nounwind "no-stack-arg-probe"'
        return f"{self._head} {attributes} {{\nentry:\n{places}{body}\n}}\n"

    # Instructions

    def line(self, text: str) -> None:
        self.lines.append(text)

    def register(self) -> str:
        """A name that may be in use before the line that gives it its value."""
        self._count = count = self._count + 1
        return f"%v{count}"

    def _number(self) -> str:
        """What the next line gives its value. Numbers, in the order of the lines, are found without
        a look into a table of names: LLVM reads a text in six tenths of the time."""
        self._count = count = self._count + 1
        return f"%{count}"

    def emit(self, type: str, instruction: str) -> Value:
        self._count = count = self._count + 1  # as `_number` does it
        name = f"%{count}"
        self.lines.append(f"{name} = {instruction}")
        return Value(self, type, name)

    def sum(self, terms: Sequence[Value]) -> Value:
        """a + b - c ...: what is negative is subtracted, which gives the same bits."""
        first, second, *rest = terms
        if isinstance(first, Negative):
            first, second = second, first
        total = first.kept().text
        for term in (second, *rest):
            operation = "fadd"
            if isinstance(term, Negative) and not term.text:
                operation, term = "fsub", term.number.kept()
            name = self._number()
            self.lines.append(f"{name} = {operation} double {total}, {term.text}")
            total = name
        return Value(self, REAL, total)

    def product(self, factors: Sequence[Value]) -> Value:
        first, *rest = factors
        total = first.text
        for factor in rest:
            name = self._number()
            self.lines.append(f"{name} = fmul double {total}, {factor.text}")
            total = name
        return Value(self, REAL, total)

    def constant(self, value: Value | float | int, type: str) -> Value:
        if isinstance(value, Value):
            return value
        return Value(self, type, real_text(value) if type == REAL else str(int(value)))

    def place(self, type: str, count: int = 1, name: str = "") -> Value:
        """Room for so many values, on the stack; a name may be in use before the count is known."""
        name = name or self.register()
        self._places.append(f"{name} = alloca {type}, i64 {count}, align 8")
        return Value(self, POINTER, name)

    def variable(self, value: Value | float | int, type: str = REAL) -> Variable:
        return Variable(self, self.constant(value, type))

    def call(self, type: str, function: str, *arguments: Value) -> Value:
        return self.emit(type, f"call {type} @{function}({_given(arguments)})")

    def run(self, function: str, *arguments: Value) -> None:
        """Call a function that gives nothing."""
        self.lines.append(f"call void @{function}({_given(arguments)})")

    def select(self, condition: Value, then: Value | float, otherwise: Value | float) -> Value:
        a = self.constant(then, REAL)
        b = self.constant(otherwise, a.type)
        return self.emit(
            a.type, f"select i1 {condition.text}, {a.type} {a.text}, {b.type} {b.text}"
        )

    def joined(self, *ways: tuple[Value, str]) -> Value:
        """The value by which way control comes: from which block. Stands first in its own."""
        kind = ways[0][0].type
        return self.emit(kind, f"phi {kind} " + ", ".join(f"[ {v.text}, %{b} ]" for v, b in ways))

    def real(self, x: Value) -> Value:
        """A whole number as a real one."""
        return self.emit(REAL, f"sitofp {x.type} {x.text} to double")

    def whole(self, x: Value) -> Value:
        """The whole number in a real one."""
        return self.emit(INT, f"fptosi {x.type} {x.text} to i64")

    def flag(self, x: Value) -> Value:
        """A whole number as a flag of C."""
        return self.emit(FLAG, f"trunc i64 {x.text} to i32")

    def wide(self, x: Value) -> Value:
        """A flag of C as a whole number."""
        return self.emit(INT, f"sext i32 {x.text} to i64")

    def absolute(self, x: Value) -> Value:
        return self.call(REAL, "llvm.fabs.f64", x)

    def largest(self, a: Value, b: Value | float) -> Value:
        """The larger one; not a number when one is none."""
        return self.select((a > b) | a.is_nan(), a, b)

    def subtract(self, a: Value, b: Value, factor: Value, count: Value) -> None:
        """a[i] -= factor*b[i], four numbers at a time."""
        wide = "<4 x double>"
        one = self.emit(wide, f"insertelement {wide} poison, double {factor.text}, i64 0")
        four = self.emit(
            wide, f"shufflevector {wide} {one.text}, {wide} poison, <4 x i32> zeroinitializer"
        )
        whole = count / 4
        with self.loop(whole) as group:
            at, by = a.at(group * 4), b.at(group * 4)
            x = self.emit(wide, f"load {wide}, ptr {at.text}, align 8")
            y = self.emit(wide, f"load {wide}, ptr {by.text}, align 8")
            product = self.emit(wide, f"fmul {wide} {four.text}, {y.text}")
            rest = self.emit(wide, f"fsub {wide} {x.text}, {product.text}")
            self.line(f"store {wide} {rest.text}, ptr {at.text}, align 8")
        with self.loop(count, whole * 4) as i:
            a.store(a.load(REAL, i) - factor * b.load(REAL, i), i)

    # Flow

    def label(self) -> str:
        self._count += 1
        return f"b{self._count}"

    def begin(self, label: str) -> None:
        self.lines.append(f"{label}:")

    def break_block(self) -> None:
        """Go on in a new basic block."""
        self.enter(self.label())

    def enter(self, label: str) -> None:
        """Go on at a label that others jump to, too."""
        self.jump(label)
        self.begin(label)

    def jump(self, label: str) -> None:
        self.lines.append(f"br label %{label}")

    def branch(self, condition: Value, then: str, otherwise: str) -> None:
        self.lines.append(f"br i1 {condition.text}, label %{then}, label %{otherwise}")

    def leave(self, condition: Value, label: str) -> None:
        """Go to a label where the condition holds, else on."""
        on = self.label()
        self.branch(condition, label, on)
        self.begin(on)

    def give(self, value: Value | float | None = None, type: str = FLAG) -> None:
        if value is None:
            self.lines.append("ret void")
        else:
            v = self.constant(value, type)
            self.lines.append(f"ret {v.type} {v.text}")

    @contextmanager
    def loop(self, stop: Value | int, start: Value | int = 0) -> Iterator[Value]:
        """`for i in range(start, stop)`."""
        counter = Variable(self, self.constant(start, INT))
        test, body, behind = self.label(), self.label(), self.label()
        self.enter(test)
        i = counter.get()
        self.branch(i < stop, body, behind)
        self.begin(body)
        yield i
        counter.set(i + 1)
        self.jump(test)
        self.begin(behind)

    @contextmanager
    def when(self, condition: Value, *, leaves: bool = False) -> Iterator[None]:
        """Do what stands inside when the condition holds; `leaves`: it returns."""
        then, behind = self.label(), self.label()
        self.branch(condition, then, behind)
        self.begin(then)
        yield
        if not leaves:
            self.jump(behind)
        self.begin(behind)


def _given(arguments: Sequence[Value]) -> str:
    return ", ".join(f"{a.type} {a.text}" for a in arguments)
