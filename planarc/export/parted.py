"""A text in two: what is the same on systems that call functions in another way, and the rest.

In:   text of LLVM
Out:  its inner part, and its outer one: the interface, and what calls functions of the host

    define i32 @px_step(ptr %m)      inner; called as on Linux, wherever it runs
    define i32 @fmi3DoStep(ptr %m)   outer; called as the system does
    define void @px_log(ptr %m)      outer: it calls the host's logger

What one part calls of the other is declared there; a constant stands in one part. Nothing is left
out, so that a name that is hidden from all others has to be told to both (`names_in`).
"""

from __future__ import annotations

import re

from planarc.export.pruned import FUNCTION

_NAME = re.compile(r"@([\w.]+)")
_OURS = re.compile(r"p[cx]_")
#: A call by an address that gives nothing: of the host.
_OF_HOST = re.compile(r"call void (?:\(.*?\) )?%")
_HEAD = re.compile(r"define (\S+) @(\w+)\((.*?)\)")
_CONSTANT = re.compile(r"^@(\w+) = (?:external )?constant (\[\d+ x \w+\]).*$")


def divide(text: str) -> tuple[str, str]:
    """The inner part, the outer part."""
    functions = {f[1]: f[0] for f in FUNCTION.finditer(text)}
    outer = {n for n, body in functions.items() if not _OURS.match(n) or _OF_HOST.search(body)}
    rest = FUNCTION.sub("", text).splitlines()
    bodies = ["".join(b for n, b in functions.items() if (n in outer) is out)
              for out in (False, True)]  # fmt: skip
    mentioned = [names_in(body) for body in bodies]
    lines: tuple[list[str], list[str]] = ([], [])
    for line in rest:
        constant = _CONSTANT.match(line)
        for there, here, names in zip((1, 0), lines, mentioned, strict=True):
            if constant is None:
                here.append(line)
            elif constant[1] in names:
                other = there == 1 and constant[1] in mentioned[1]
                here.append(f"@{constant[1]} = external constant {constant[2]}" if other else line)
    for out, here in enumerate(lines):
        for name in sorted(mentioned[out] & functions.keys()):
            if (name in outer) is not bool(out):
                head = _HEAD.match(functions[name][functions[name].index("define ") :])
                assert head is not None
                types = re.sub(r" %\w+", "", head[3])
                here.append(f"declare {head[1]} @{name}({types})")
    inner, outside = ("\n".join((*here, body)) for here, body in zip(lines, bodies, strict=True))
    return inner, outside


def names_in(text: str) -> set[str]:
    """Every name that a text mentions."""
    return set(_NAME.findall(text))
