"""The instructions of a function as statements of C, without jumps.

Registers that are read once stand where they are read, as long as nothing changes in between
what they hang on; the others become variables.

Example:

    %v4 = load double, ptr %v3        w[V_phi].d = h * d[2].d;
    %v5 = fmul double %h, %v4
    store double %v5, ptr %v6
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Collection

from planarc.core.data import Data
from planarc.export.c.formulas import (
    ATOM,
    MEMBERS,
    SUM,
    TYPES,
    UNARY,
    Formula,
    called,
    combine,
    compute,
    constant,
)
from planarc.export.c.listing import Function, Line
from planarc.export.c.rows import RESERVED, Row

_MEMORY = frozenset({"*"})
_LANE = "lane"
_CALL = re.compile(r"call (\S+)(?: \(([^)]*)\))? ([%@][\w.]+)\((.*)\)$")
_NAME = re.compile(r"[A-Za-z_]\w*$|\d+$")
#: What no register, counter or place is called.
_FREE = re.compile(r"(?![vxni]\d+$)[A-Za-z_]\w*$")


class Naming(Data):
    """What is told of names: functions that only compute, all functions, and what words are called
    by the array that they stand in and their places."""

    pure: Collection[str]
    functions: Collection[str]
    word: Callable[[str, str], str]


class Statements:
    """Those of one function."""

    def __init__(self, function: Function, naming: Naming) -> None:
        self._function, self._naming = function, naming
        self._lines = list(function.lines)
        self._scalars: dict[str, str] = {}  # names and types of variables
        self._arrays: dict[str, int] = {}
        self._places()
        self._uses = Counter(u for line in self._lines for u in line.uses())
        self._block_of_use: dict[str, int] = {}
        block = 0
        for line in self._lines:
            block += bool(line.label)
            for u in line.uses():
                self._block_of_use[u] = block
        self._labels = {line.label: i for i, line in enumerate(self._lines) if line.label}
        self._known = {n: Formula(n[1:]) for _, n in function.arguments}
        self._kinds = {n: "frame" for t, n in function.arguments if n in ("%m", "%frame")}
        self._pending: dict[str, tuple[Formula, str]] = {}
        self._addresses: dict[str, tuple[str, str, Formula, str]] = {}
        self._rows: list[Row] = []
        self._scope: tuple[int, ...] = ()
        self._scopes = 0
        self._block = 0
        self._counters: dict[str, Formula] = {}
        self._names: dict[str, str] = {}
        self._taken = {*RESERVED, *function.calls(), *(n[1:] for _, n in function.arguments)}
        self._bases = {
            m[1]
            for line in self._lines
            if (m := re.match(r"getelementptr .*, ptr (%\w+), i64 ", line.text))
        }
        self._assigned = {line.target for line in self._lines if line.text.startswith("set ")}

    # Variables

    def _places(self) -> None:
        """Tell variables from arrays."""
        places = {line.target: line.text for line in self._lines if line.text.startswith("alloca")}
        simple = dict.fromkeys(places)
        heads: dict[str, str] = {}
        for line in self._lines:
            match = re.match(r"getelementptr inbounds i64, ptr (%\w+), i64 0$", line.text)
            if match and match[1] in places:
                heads[line.target] = match[1]
        for line in self._lines:
            direct = re.match(r"(?:load|store) .*, ?ptr (%\w+), align 8$", line.text)
            for used in line.uses():
                if used in heads and not (direct and direct[1] == used and
                                          line.text.count(used) == 1):  # fmt: skip
                    simple.pop(heads[used], None)
                elif used in places and heads.get(line.target) != used:
                    simple.pop(used, None)
        for name, text in places.items():
            type = text.split()[1].rstrip(",") if "<" not in text else text[7:].split(",")[0]
            if name in simple:
                self._scalars["x" + name[2:]] = type
            else:
                count = re.search(r"i64 (\d+)", text.split(",", 1)[1])
                assert count is not None and "<" not in text, text
                self._arrays[name] = int(count[1])
        found = []
        for line in self._lines:
            if line.text.startswith("alloca") or heads.get(line.target) in simple:
                continue
            direct = re.match(r"(load|store) (.*), ?ptr (%\w+), align 8$", line.text)
            if direct and heads.get(direct[3]) in simple:
                variable = "x" + heads[direct[3]][2:]
                if direct[1] == "load":
                    line = Line(f"get {direct[2].rstrip(',')} {variable}", line.target)
                else:
                    type, value = direct[2].rsplit(" ", 1)
                    line = Line(f"put {variable} {type} {value}")
            found.append(line)
        self._lines = found

    # Values

    def _value(self, text: str, type: str) -> Formula:
        if text[0] == "%":
            if text in self._pending:
                return self._pending.pop(text)[0]
            if text in self._addresses:
                return self._pointer(text)
            if text in self._arrays:
                return Formula("v" + text[2:])
            return self._known[text]
        if text[0] == "@":
            between = "(intptr_t)" if text[1:] in self._naming.functions else ""
            return Formula(f"(word *){between}{text[1:]}", UNARY)
        return constant(text, type)

    def _pointer(self, text: str) -> Formula:
        element, base, index, kind = self._addresses[text]
        name = self._naming.word(kind, index.text)
        if element != "i64":
            return combine(
                f"(word *)(({TYPES[element]} *){base} + {index.within(SUM)})", UNARY, index
            )
        if index.text == "0":
            return Formula(base, UNARY if base.startswith("(") else ATOM)
        return combine(f"{base} + {name if name else index.within(SUM)}", SUM, index)

    def _memory(self, pointer: str, type: str) -> Formula:
        """What stands behind a pointer."""
        if pointer not in self._addresses:
            self._addresses[pointer] = ("i64", self._base(pointer), Formula("0"), "")
        element, base, index, kind = self._addresses[pointer]
        if element != "i64":
            return Formula(f"(({TYPES[element]} *){base})[{index.text}]", ATOM,
                           index.reads | _MEMORY)  # fmt: skip
        shown = self._naming.word(kind, index.text) or index.text
        if base.startswith("(word *)"):  # a table
            if base[8:].startswith("(") or type != "i64":
                base = f"({base})"
            else:
                return Formula(f"{base[8:]}[{shown}]", ATOM, index.reads)
        wide = type.startswith("<")
        member = MEMBERS[type.strip("<>").split()[-1] if wide else type]
        if wide:
            shown = _LANE if shown == "0" else f"{index.within(SUM)} + {_LANE}"
        return Formula(f"{base}[{shown}].{member}", ATOM, index.reads | _MEMORY)

    def _base(self, pointer: str) -> str:
        found = self._value(pointer, "ptr")
        if found.reads or found.acts:  # it stands for as long as addresses are made of it
            return self._keep(pointer, found, "ptr").text
        return found.text if found.binds <= ATOM or found.text.startswith("(word *)") else (
            f"({found.text})")  # fmt: skip

    # Statements

    def _say(self, text: str, declares: tuple[str, str] | None = None, acts: bool = False) -> None:
        self._rows.append(Row(text, self._scope, declares, acts))

    def _keep(self, register: str, value: Formula, type: str) -> Formula:
        """Put a value into a variable."""
        name = "v" + register[2:]
        if type.startswith("<"):
            self._scalars[name] = type
            self._each_lane(type, f"{name}[{_LANE}] = {value.text};")
            self._known[register] = Formula(f"{name}[{_LANE}]")
            return self._known[register]
        kind = TYPES[type]
        self._say(f"{name} = {value.text};", (kind, name), value.acts)
        self._known[register] = Formula(name)
        return self._known[register]

    def _each_lane(self, type: str, text: str) -> None:
        """Several numbers at once become a loop."""
        self._say(f"for (int {_LANE} = 0; {_LANE} < {type[1:].split()[0]}; {_LANE}++)")
        self._say("    " + text)

    def _flush(self, which: Callable[[Formula], bool] = lambda _: True) -> None:
        for register, (value, type) in list(self._pending.items()):
            if which(value):
                del self._pending[register]
                self._keep(register, value, type)

    def _define(self, register: str, value: Formula, type: str) -> None:
        if register in self._assigned:
            raise AssertionError(register)
        uses = self._uses[register]
        if not value.acts and (uses == 0 or (not value.reads and _NAME.match(value.text))):
            self._known[register] = value
        elif uses == 0:
            self._say(f"{value.text};")
        elif uses == 1 and self._block_of_use[register] == self._block:
            self._pending[register] = value, type
        else:
            self._keep(register, value, type)

    def _result_type(self, text: str) -> str:
        word, rest = text.split(None, 1)
        if word in ("fcmp", "icmp"):
            return "i1"
        if word in ("sitofp", "fptosi", "trunc", "sext", "zext", "uitofp", "ptrtoint"):
            return text.split()[-1]
        if word == "select":
            return rest.split(", ")[1].split()[0]
        if word in ("insertelement", "shufflevector"):  # the same number in each lane
            return "double"
        rest = rest.removeprefix("contract ")
        if rest.startswith("<"):
            return rest.split(">")[0] + ">"
        return rest.split()[0]

    def _instruct(self, line: Line) -> None:
        text = line.text
        word = text.split(None, 1)[0]
        if word == "getelementptr":
            self._address(line)
        elif word == "get":
            type, variable = text.removeprefix("get ").rsplit(" ", 1)
            if variable in self._counters:
                self._known[line.target] = Formula(self._counters[variable].text)
            else:
                shown = f"{variable}[{_LANE}]" if type.startswith("<") else variable
                self._define(line.target, Formula(shown, ATOM, frozenset({variable})), type)
        elif word == "put":
            self._put(text)
        elif word == "set":
            _, type, value = text.split()
            self._say(f"v{line.target[2:]} = {self._value(value, type).text};")
            self._known[line.target] = Formula("v" + line.target[2:])
            self._scalars["v" + line.target[2:]] = type
        elif word == "load":
            self._flush(lambda v: v.acts)
            match = re.match(r"load (<.*?>|\S+), ptr ([%@]\w+)", text)
            assert match is not None, text
            found = self._memory(match[2], match[1])
            self._name(line.target, match[2])
            self._define(line.target, found, match[1])
        elif word == "store":
            self._store(text)
        elif word == "call":
            self._call(line)
        else:
            if word == "select" or (word in ("and", "or") and " i1 " in text):
                self._flush(lambda v: v.acts)
            made = compute(text, self._value)
            assert made is not None, text
            self._define(line.target, made, self._result_type(text))

    def _name(self, register: str, pointer: str) -> None:
        """Remember which array a pointer of the frame leads to."""
        place = self._addresses.get(pointer)
        if place is not None and place[3] == "frame":
            self._kinds[register] = name = self._naming.word("frame", place[2].text)
            self._call_it("v" + register[2:], name.partition("_")[2].lower())

    def _call_it(self, variable: str, name: str) -> None:
        """Give a variable a name that people read, where it is free."""
        if variable not in self._names and name not in self._taken and _FREE.match(name):
            self._taken.add(name)
            self._names[variable] = name

    def _address(self, line: Line) -> None:
        match = re.match(r"getelementptr (?:inbounds )?(\w+), ptr (\S+), i64 (\S+)$", line.text)
        assert match is not None, line.text
        element, base, index = match.groups()
        kind = self._kinds.get(base, base if base[0] == "@" else "")
        if base[0] == "%" and not self._uses[line.target]:
            return
        place = self._value(index, "i64")
        base_text = self._base(base)
        once = self._uses[line.target] == 1 and self._block_of_use[line.target] == self._block
        if (not _NAME.match(place.text) and (place.acts or not once)) or place.reads:
            place = self._kept_index(line.target, place)
        self._addresses[line.target] = element, base_text, place, kind
        if line.target in self._bases:  # others are counted from it, wherever they stand
            value = self._pointer(line.target)
            del self._addresses[line.target]
            self._keep(line.target, value, "ptr")

    def _kept_index(self, register: str, index: Formula) -> Formula:
        name = "n" + register[2:]
        self._say(f"{name} = {index.text};", ("int64_t", name))
        return Formula(name)

    def _put(self, text: str) -> None:
        variable, given = text.removeprefix("put ").split(" ", 1)
        type, value = given.rsplit(" ", 1)
        found = self._value(value, type)
        if variable in self._counters:
            self._counters[variable] = found
            return
        self._flush(lambda v: v.acts or variable in v.reads)
        if type.startswith("<"):
            self._each_lane(type, f"{variable}[{_LANE}] = {found.text};")
        else:
            self._say(f"{variable} = {found.text};", acts=found.acts)

    def _store(self, text: str) -> None:
        match = re.match(r"store (<.*?>|\S+) (\S+), ptr ([%@]\w+)", text)
        assert match is not None, text
        type, value, pointer = match.groups()
        found, place = self._value(value, type), self._memory(pointer, type)
        self._flush(lambda v: v.acts or bool(v.reads & _MEMORY))
        if type.startswith("<"):
            self._each_lane(type, f"{place.text} = {found.text};")
        else:
            self._say(f"{place.text} = {found.text};")
            stored = re.match(r"\w+\[V_(\w+)\]\.d$", place.text)
            if stored and re.match(r"v\d+$", found.text):
                self._call_it(found.text, stored[1])

    def _call(self, line: Line) -> None:
        match = _CALL.match(line.text)
        assert match is not None, line.text
        type, signature, name, listed = match.groups()
        pairs = [a.split() for a in listed.split(", ")] if listed else []
        given = [self._value(v, t) for t, v in pairs]
        arguments = ", ".join(g.text for g in given)
        if name[0] == "%":
            address = self._value(name, "ptr")
            types = signature.split(", ") if signature else [t for t, _ in pairs]
            kinds = ", ".join(TYPES.get(t, t) for t in types)  # `...` is the same in both
            head = f"(({TYPES[type]} (*)({kinds}))(intptr_t){address.within(UNARY)})"
        else:
            head = called(name[1:])
        formula = combine(f"{head}({arguments})", ATOM, *given)
        if name[0] == "@" and name[1:] in self._naming.pure:
            self._define(line.target, formula, type)
            return
        self._flush(lambda v: v.acts or bool(v.reads & _MEMORY))
        if type == "void":
            self._say(f"{formula.text};")
        else:
            self._define(line.target, Formula(formula.text, ATOM, _MEMORY, True), type)
