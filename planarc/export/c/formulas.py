"""An instruction of LLVM as an expression of C, whose operands stand in it."""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Callable

from planarc.core.data import Data

TYPES = {"double": "double", "i64": "int64_t", "i32": "int32_t", "i8": "uint8_t", "i1": "bool",
         "ptr": "word *", "void": "void"}  # fmt: skip
#: Members of a word by the type of what it holds.
MEMBERS = {"double": "d", "i64": "i", "ptr": "p"}
#: How strongly operators bind, the strongest first.
ATOM, UNARY, PRODUCT, SUM, SHIFT, ORDER, EQUAL, BITS, AND, OR, CHOICE = range(11)
_ARITHMETIC = {"fadd": ("+", SUM), "add": ("+", SUM), "fsub": ("-", SUM), "sub": ("-", SUM),
               "fmul": ("*", PRODUCT), "mul": ("*", PRODUCT), "fdiv": ("/", PRODUCT),
               "sdiv": ("/", PRODUCT)}  # fmt: skip
_TESTS = {"olt": ("<", ORDER), "slt": ("<", ORDER), "ogt": (">", ORDER), "sgt": (">", ORDER),
          "ole": ("<=", ORDER), "sle": ("<=", ORDER), "oge": (">=", ORDER), "sge": (">=", ORDER),
          "oeq": ("==", EQUAL), "eq": ("==", EQUAL), "une": ("!=", EQUAL),
          "ne": ("!=", EQUAL)}  # fmt: skip
#: Tests whose contrary is another test, for all numbers and what is none.
_CONTRARY = {" == ": " != ", " != ": " == "}
_LLVM = {"llvm.fabs.f64": "fabs", "llvm.sqrt.f64": "sqrt", "llvm.trunc.f64": "trunc",
         "llvm.floor.f64": "floor", "llvm.ceil.f64": "ceil", "llvm.rint.f64": "rint",
         "llvm.copysign.f64": "copysign", "llvm.ctpop.i64": "count_bits"}  # fmt: skip
_TWO = re.compile(r"(\w+)(?: contract)? (<.*?>|\S+) (\S+), (\S+)$")


class Formula(Data):
    """`binds` says how strongly; `reads` names the variables that may change under it, `*` for
    memory; `acts` is true of a call that does something."""

    text: str
    binds: int = ATOM
    reads: frozenset[str] = frozenset()
    acts: bool = False

    def within(self, binds: int) -> str:
        """Its text as an operand."""
        return self.text if self.binds <= binds else f"({self.text})"


def combine(text: str, binds: int, *operands: Formula) -> Formula:
    reads: frozenset[str] = frozenset().union(*(o.reads for o in operands))
    return Formula(text, binds, reads, any(o.acts for o in operands))


def constant(text: str, type: str) -> Formula:
    if type == "double" or type.endswith("double>"):
        text = "0x0" if text == "zeroinitializer" else text
        if not text.startswith("0x"):
            return Formula(text)
        value = struct.unpack(">d", int(text, 16).to_bytes(8))[0]
        if math.isnan(value):
            return Formula("NAN")
        if math.isinf(value):
            return Formula("INFINITY") if value > 0 else Formula("-INFINITY", UNARY)
        return Formula(repr(value), UNARY if math.copysign(1.0, value) < 0 else ATOM)
    if type == "ptr":
        return Formula("NULL")
    if text in ("true", "false"):
        return Formula(text)
    if abs(int(text)) > 0x7FFF_FFFF:
        return Formula(f"INT64_C({text})")
    return Formula(text, UNARY if text.startswith("-") else ATOM)


def contrary(x: Formula) -> Formula:
    if x.binds == EQUAL:
        for sign, other in _CONTRARY.items():
            if x.text.count(sign) == 1:
                return Formula(x.text.replace(sign, other), EQUAL, x.reads, x.acts)
    if x.binds == UNARY and x.text.startswith("!"):
        return Formula(x.text[1:], UNARY, x.reads, x.acts)
    return combine(f"!{x.within(UNARY)}", UNARY, x)


def called(name: str) -> str:
    """A function's name in C."""
    return _LLVM.get(name, name)


def compute(text: str, value: Callable[[str, str], Formula]) -> Formula | None:
    """What an instruction computes of registers; None for one that does more. `value` gives an
    operand by its text and type."""
    word = text.split(None, 1)[0]
    if word in _ARITHMETIC or word in ("and", "or", "xor", "shl", "lshr"):
        return _two(text, value)
    if word in ("fcmp", "icmp"):
        return _test(text.split(None, 1)[1], value)
    if word == "fneg":
        x = value(text.split()[-1], "double")
        return combine(f"-{x.within(ATOM)}", UNARY, x)
    if word == "select":
        return _choice(text, value)
    if word in ("sitofp", "fptosi", "trunc", "sext", "zext", "uitofp", "ptrtoint"):
        return _changed(text, value)
    if word == "insertelement":
        factor = text.split("double> poison, double ")[1].split(",")[0]
        return value(factor, "double")
    if word == "shufflevector":
        return value(text.split("> ")[1].split(",")[0], "double")
    return None


def _two(text: str, value: Callable[[str, str], Formula]) -> Formula:
    match = _TWO.match(text)
    assert match is not None, text
    name, type, left, right = match.groups()
    if name == "xor" and type == "i1" and right == "true":
        return contrary(value(left, type))
    a, b = value(left, type), value(right, type)
    if name in _ARITHMETIC:
        sign, binds = _ARITHMETIC[name]
        if name == "mul" and "INT64_C" in a.text + b.text:  # a product that may wrap
            product = f"(uint64_t){a.within(UNARY)} * (uint64_t){b.within(UNARY)}"
            return combine(f"(int64_t)({product})", UNARY, a, b)
        return combine(f"{a.within(binds)} {sign} {b.within(binds - 1)}", binds, a, b)
    if type == "i1":
        sign, binds = {"and": ("&&", AND), "or": ("||", OR), "xor": ("!=", EQUAL)}[name]
        # Compilers warn of `a && b || c` without parentheses.
        inner = EQUAL if name != "xor" else SHIFT
        same = AND if name == "and" else OR if name == "or" else ATOM
        left, right = (o.text if o.binds == same else o.within(inner) for o in (a, b))
        return combine(f"{left} {sign} {right}", binds, a, b)
    if name in ("shl", "lshr"):
        sign = "<<" if name == "shl" else ">>"
        shifted = f"(uint64_t){a.within(UNARY)} {sign} {b.within(ATOM)}"
        return combine(f"(int64_t)({shifted})", UNARY, a, b)
    sign = {"and": "&", "or": "|", "xor": "^"}[name]
    return combine(f"{a.within(UNARY)} {sign} {b.within(UNARY)}", BITS, a, b)


def _test(text: str, value: Callable[[str, str], Formula]) -> Formula:
    kind, type, left, right = text.replace(",", "").split()
    a, b = value(left, type), value(right, type)
    if kind == "uno":
        if a.text == b.text:
            return combine(f"isnan({a.text})", ATOM, a)
        return combine(f"isunordered({a.text}, {b.text})", ATOM, a, b)
    sign, binds = _TESTS[kind]
    return combine(f"{a.within(SHIFT)} {sign} {b.within(SHIFT)}", binds, a, b)


def _choice(text: str, value: Callable[[str, str], Formula]) -> Formula:
    match = re.match(r"select i1 (\S+), (\S+) (\S+), \S+ (\S+)$", text)
    assert match is not None, text
    condition, type, then, otherwise = match.groups()
    c, a, b = value(condition, "i1"), value(then, type), value(otherwise, type)
    return combine(f"{c.within(OR)} ? {a.within(OR)} : {b.within(CHOICE)}", CHOICE, c, a, b)


def _changed(text: str, value: Callable[[str, str], Formula]) -> Formula:
    name, type, operand, _, to = text.split()
    x = value(operand, type)
    if name == "trunc" and to == "i1":
        return combine(f"({x.within(UNARY)} & 1) != 0", EQUAL, x)
    if type == "i1":
        kind = TYPES[to] if to != "double" else "double"
        return combine(f"({kind}){x.within(UNARY)}", UNARY, x)
    if name == "ptrtoint":
        return combine(f"(int64_t)(intptr_t){x.within(UNARY)}", UNARY, x)
    if name == "zext" and type == "i32":
        return combine(f"(int64_t)(uint32_t){x.within(UNARY)}", UNARY, x)
    return combine(f"({TYPES[to]}){x.within(UNARY)}", UNARY, x)
