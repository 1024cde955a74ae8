"""Command lines that are right, read by the signatures of their functions.

    def check(target: Annotated[str, Argument()], every: Annotated[bool, Option("--all")] = False)

    read(check, ["a.pmo", "--all"])     {"target": "a.pmo", "every": True}
    read(check, ["a.pmo", "--al"])      None

Help, completion and messages about lines that are wrong are typer's (`cli/advice.py`), whose import
and tables take a fifth of a short run. So whatever is not plainly right is left to it, and what is
right means the same to both (tests/cli/test_line.py).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from enum import Enum
from math import inf
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, get_args, get_origin, get_type_hints


class Argument:
    """What a command says of an argument that is known by its place, in words of typer's."""

    def __init__(
        self,
        *names: str,
        help: str | None = None,
        metavar: str | None = None,
        parser: Callable[[str], Any] | None = None,
        min: float | None = None,
        max: float | None = None,
        show_default: bool = True,
        autocompletion: Callable[..., Any] | None = None,
    ) -> None:
        self.names, self.parser = names, parser
        self.range = (-inf if min is None else min, inf if max is None else max)
        self.told: dict[str, Any] = {
            "help": help,
            "metavar": metavar,
            "parser": parser,
            "min": min,
            "max": max,
            "show_default": show_default,
            "autocompletion": autocompletion,
        }


class Option(Argument):
    """The same of one that is known by its names, or else by the name of the parameter."""


class Parameter:
    """A parameter of a command's function; its default is `...` where it has none."""

    def __init__(self, name: str, hint: Any, default: Any) -> None:
        self.name, self.default = name, default
        self.type, self.said = get_args(hint)
        optional = get_origin(self.type) is UnionType
        kind = next(k for k in get_args(self.type) if k is not NoneType) if optional else self.type
        self.several = get_origin(kind) is list
        self.kind = get_args(kind)[0] if self.several else kind

    def words(self) -> dict[str, bool]:
        """The words of an option, and what each of a flag makes of it."""
        plain = self.name.replace("_", "-")
        usual = f"--{plain}/--no-{plain}" if self.kind is bool else f"--{plain}"
        found: dict[str, bool] = {}
        for written in self.said.names or (usual,):
            on, both, off = written.partition("/")
            found |= {on: True, off: False} if both else {on: not self.default}
        return found

    def value(self, text: str) -> Any:
        """The value that a text means. Raises what it likes where it means none."""
        if self.said.parser is not None:
            return self.said.parser(text)
        if issubclass(self.kind, Enum):
            return {str(each.value): each for each in self.kind}[text]
        if self.kind is Path and not os.access(text, os.R_OK) and Path(text).exists():
            raise PermissionError
        found = self.kind(text)
        least, greatest = self.said.range
        if self.kind in (int, float) and (found < least or found > greatest):
            raise ValueError
        return found


def parameters(function: Callable[..., int]) -> list[Parameter]:
    """The parameters of a command's function, in their order."""
    hints = get_type_hints(function, include_extras=True)
    names = function.__code__.co_varnames[: function.__code__.co_argcount]
    own = function.__defaults__ or ()
    defaults = (*[...] * (len(names) - len(own)), *own)
    return [Parameter(n, hints[n], d) for n, d in zip(names, defaults, strict=True)]


def read(function: Callable[..., int], line: Sequence[str]) -> dict[str, Any] | None:
    """The arguments that a line gives to a command's function, or None."""
    known = parameters(function)
    try:
        given = _sorted_out(known, line)
    except Exception:  # typer says what is wrong
        return None
    return None if ... in given.values() else given


def _sorted_out(known: Sequence[Parameter], line: Sequence[str]) -> dict[str, Any]:
    """The arguments, `...` for those that are missing. Raises what it likes where one is wrong."""
    given = {p.name: p.default for p in known}
    options = {
        word: (p, on) for p in known if isinstance(p.said, Option) for word, on in p.words().items()
    }
    placed: list[str] = []
    rest = iter(line)
    for word in rest:
        if word.startswith("="):
            raise ValueError(word)  # spaces around a `=`
        if word == "--":
            placed += rest
        elif not word.startswith("-") or word == "-":
            placed.append(word)
        else:
            name, equals, text = word.partition("=")
            parameter, on = options[name]
            if equals and (parameter.kind is bool or not name.startswith("--")):
                raise ValueError
            if parameter.kind is bool:
                given[parameter.name] = on
                continue
            value = parameter.value(text if equals else next(rest))
            before = given[parameter.name] if parameter.several else None
            given[parameter.name] = [*(before or ()), value] if parameter.several else value
    for parameter in (p for p in known if not isinstance(p.said, Option)):
        if parameter.several:
            found, placed = [parameter.value(text) for text in placed], []
            given[parameter.name] = found or parameter.default
        elif placed:
            given[parameter.name] = parameter.value(placed.pop(0))
    if placed:
        raise ValueError
    return given
