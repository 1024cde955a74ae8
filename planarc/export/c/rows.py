"""The lines of a function in C, and what is left to say of them when all are written.

A value that nothing reads is left out, one that is read outside of its braces is declared above
them, and only labels that something jumps to stay.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence

from planarc.export.c.formulas import TYPES
from planarc.export.c.listing import Function

#: Names that no variable can have.
RESERVED = frozenset(
    """
    auto break case char const continue default do double else enum extern float for goto if
    inline int long register restrict return short signed sizeof static struct switch typedef
    union unsigned void volatile while bool true false word lane asm linux unix i386
    sin cos tan asin acos atan atan2 sinh cosh tanh exp log log10 sqrt pow fabs floor ceil trunc
    rint copysign isnan isunordered calloc free NULL NAN INFINITY
""".split()  # noqa: SIM905
)
_INDENT = "    "
_REGISTER = re.compile(r"\b[vn]\d+\b")


class Row:
    """A line; `declares` is a type and a name, `scope` tells the braces around it, and `acts` is
    true where more happens than that a value is computed."""

    __slots__ = ("acts", "declares", "scope", "text")

    def __init__(
        self, text: str, scope: tuple[int, ...], declares: tuple[str, str] | None, acts: bool
    ) -> None:
        self.text, self.scope, self.declares, self.acts = text, scope, declares, acts


def declare(function: Function) -> str:
    """The head of a function."""
    listed = ", ".join(_declared(TYPES[t], n[1:]) for t, n in function.arguments)
    return f"{_declared(TYPES[function.result], function.name)}({listed or 'void'})"


def lay_out(
    function: Function, rows: Sequence[Row], variables: Mapping[str, str],
    arrays: Mapping[str, int], names: Mapping[str, str],
) -> str:  # fmt: skip
    """The whole function. `variables` are names and types, `names` are better ones."""
    wanted = {m for r in rows for m in re.findall(r"goto (\w+);", r.text)}
    rows = _used([r for r in rows if not r.text.endswith(":") or r.text[:-1] in wanted])
    rows, variables = _read(rows, variables)
    outside = _outside(rows)
    tops = [_variable(t, n) for n, t in variables.items()]
    tops += [f"word v{n[2:]}[{count}];" for n, count in arrays.items()]
    tops += [f"{_declared(t, n)};" for n, t in outside.items()]
    body = " ".join(r.text for r in rows)
    tops += [f"(void){n[1:]};" for _, n in function.arguments
             if not re.search(rf"\b{n[1:]}\b", body)]  # fmt: skip
    texts = [_INDENT + t for t in tops]
    for k, r in enumerate(rows):
        if r.text.endswith(":"):  # a label belongs to a statement, which no declaration is
            alone = k + 1 == len(rows) or rows[k + 1].text == "}" or rows[k + 1].declares
            texts.append(_INDENT * len(r.scope) + r.text + ";" * bool(alone))
        else:
            here = r.declares and r.declares[1] not in outside
            text = _declared(r.declares[0], r.text) if r.declares and here else r.text
            texts.append(_INDENT * (len(r.scope) + 1) + text)
    text = _REGISTER.sub(lambda m: names.get(m[0], m[0]), "\n".join(texts))
    told = f"/* {function.told} */\n" if function.told else ""
    return f"{told}{declare(function)}\n{{\n{text}\n}}\n"


def _used(rows: list[Row]) -> list[Row]:
    """Without values that nothing reads."""
    while True:
        read = Counter(name for r in rows for name in _REGISTER.findall(r.text))
        found = [r for r in rows if not r.declares or read[r.declares[1]] > 1 or r.acts]
        if len(found) == len(rows):
            return rows
        rows = found


def _read(rows: list[Row], variables: Mapping[str, str]) -> tuple[list[Row], Mapping[str, str]]:
    """Without variables that are set and never read."""
    sets = [re.match(r"(x\d+) = ", r.text) for r in rows]
    read = {
        name
        for r, s in zip(rows, sets, strict=True)
        for name in re.findall(r"\bx\d+\b", r.text[s.end() :] if s else r.text)
    }
    idle = {n for n in variables if n.startswith("x")} - read
    idle -= {s[1] for r, s in zip(rows, sets, strict=True) if s and r.acts}
    kept = [r for r, s in zip(rows, sets, strict=True) if s is None or s[1] not in idle]
    return kept, {n: t for n, t in variables.items() if n not in idle}


def _outside(rows: Sequence[Row]) -> dict[str, str]:
    """Values that are read outside of the braces in which they are set, with their types."""
    declared = {r.declares[1]: (r.declares[0], r.scope) for r in rows if r.declares}
    found: dict[str, str] = {}
    for r in rows:
        for name in _REGISTER.findall(r.text):
            type, scope = declared.get(name, ("", ()))
            if r.scope[: len(scope)] != scope:
                found[name] = type
    return found


def _declared(type: str, name: str) -> str:
    return f"{type}{name}" if type.endswith("*") else f"{type} {name}"


def _variable(type: str, name: str) -> str:
    if not type.startswith("<"):
        return f"{_declared(TYPES[type], name)};"
    count, _, one = type.strip("<>").split()
    return f"{TYPES[one]} {name}[{count}];"
