"""A function of LLVM as one of C99.

In:   Function
Out:  its text

A jump forward over a piece becomes `if`, counting becomes `for`; what is left of jumps is `goto`.
"""

from __future__ import annotations

import re

from planarc.export.c.formulas import Formula, contrary
from planarc.export.c.listing import Function
from planarc.export.c.rows import lay_out
from planarc.export.c.statements import Naming, Statements


def write_body(function: Function, naming: Naming) -> str:
    """The whole function."""
    return _Body(function, naming).text()


class _Body(Statements):
    def text(self) -> str:
        for line in self._lines:
            if line.text.startswith("set "):
                self._known[line.target] = Formula("v" + line.target[2:])
                self._scalars["v" + line.target[2:]] = line.text.split()[1]
        self._region(0, len(self._lines))
        return lay_out(self._function, self._rows, self._scalars, self._arrays, self._names)

    def _enter(self) -> None:
        self._scopes += 1
        self._scope = (*self._scope, self._scopes)

    def _leave(self) -> None:
        self._scope = self._scope[:-1]
        self._say("}")

    def _region(self, i: int, end: int) -> None:
        """The lines of [i, end); a jump to the label at `end` falls out of it."""
        while i < end:
            line = self._lines[i]
            if line.label:
                self._flush()
                self._block += 1
                self._say(f"{line.label}:")
                i += 1
            elif line.text.startswith("br i1"):
                i = self._branch(i, end)
            elif line.text.startswith("br "):
                i = self._jump(i, end)
            elif line.text.startswith("ret"):
                _, type, *value = line.text.split()
                given = f" {self._value(value[0], type).text}" if value else ""
                self._pending.clear()
                self._say(f"return{given};")
                i += 1
            else:
                self._prepare_loop(i)
                self._instruct(line)
                i += 1

    def _jump(self, i: int, end: int) -> int:
        label = self._lines[i].text.split("%")[1]
        self._flush()
        loop = self._loop(i)
        if loop is not None:
            return self._write_loop(i, *loop)
        if self._labels[label] != i + 1:
            self._say(f"goto {label};")
        return i + 1

    def _branch(self, i: int, end: int) -> int:
        match = re.match(r"br i1 (\S+), label %(\w+), label %(\w+)$", self._lines[i].text)
        assert match is not None
        condition = self._value(match[1], "i1")
        self._flush()
        then, otherwise = match[2], match[3]
        following = self._lines[i + 1].label
        if then == following:
            behind = self._labels[otherwise]
            if i + 1 < behind <= end:
                self._block += 1
                self._say(f"if ({condition.text}) {{")
                self._enter()
                self._say(f"{then}:")
                self._region(i + 2, behind)
                self._leave()
                return behind
            self._say(f"if ({contrary(condition).text}) goto {otherwise};")
        elif otherwise == following:
            self._say(f"if ({condition.text}) goto {then};")
        else:
            self._say(f"if ({condition.text}) goto {then};")
            self._say(f"goto {otherwise};")
        return i + 1

    def _loop(self, i: int) -> tuple[str, int] | None:
        """The variable of a counting loop that the jump at `i` enters, and where it ends."""
        head = self._lines[i + 1 : i + 5]
        if len(head) < 4 or self._lines[i].text != f"br label %{head[0].label}":
            return None
        put, get, test, branch = self._lines[i - 1].text, head[1].text, head[2].text, head[3].text
        if not (put.startswith("put ") and get.startswith("get i64 ")):
            return None
        variable = get.split()[2]
        ways = re.match(r"br i1 (\S+), label %(\w+), label %(\w+)$", branch)
        if ways is None or ways[1] != head[2].target or put.split()[1] != variable:
            return None
        if not test.startswith(f"icmp slt i64 {head[1].target}, "):
            return None
        behind = self._labels[ways[3]]
        last = [line.text for line in self._lines[behind - 3 : behind]]
        changes = [
            n for n, line in enumerate(self._lines) if line.text.startswith(f"put {variable} ")
        ]
        reads = [line for line in self._lines if line.text == get]
        counted = (
            last[0] == f"add i64 {head[1].target}, 1" and last[2] == f"br label %{head[0].label}"
        )
        if not counted or changes != [i - 1, behind - 2] or len(reads) != 1:
            return None
        return variable, behind

    def _prepare_loop(self, i: int) -> None:
        """Know the counter before its first value is put."""
        line = self._lines[i]
        if line.text.startswith("put ") and (loop := self._loop(i + 1)) is not None:
            self._counters[loop[0]] = Formula("0")
            del self._scalars[loop[0]]

    def _write_loop(self, i: int, variable: str, behind: int) -> int:
        head = self._lines[i + 2]
        first = self._counters[variable].text
        stop = self._value(self._lines[i + 3].text.split()[-1], "i64")
        name = "i" + variable[1:]
        self._counters[variable] = Formula(name)
        self._say(f"for (int64_t {name} = {first}; {name} < {stop.text}; {name}++) {{")
        self._enter()
        self._known[head.target] = Formula(name)
        self._block += 2
        self._say(f"{self._lines[i + 5].label}:")
        self._region(i + 6, behind - 3)
        self._flush()
        self._leave()
        return behind
