"""The values that loops leave behind, and the functions that nodes call, on Python's numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

from planarc.evaluate.operations import safe
from planarc.evaluate.written import NAMES, Call, loop_text
from planarc.ir.expr import Expr, Op
from planarc.ir.loop import Loop
from planarc.runtime import elementary, external


def value_behind(loop: Loop, output: int, arguments: Sequence[float]) -> float:
    """One of the values behind the last turn; nan where there are none."""
    return values_behind(loop, arguments)[output]


def values_behind(loop: Loop, arguments: Sequence[float]) -> tuple[float, ...]:
    """All values behind the last turn, and whether there is one."""
    return _values(loop, tuple(map(float, arguments)))


@lru_cache(maxsize=256)
def _values(loop: Loop, arguments: tuple[float, ...]) -> tuple[float, ...]:
    """They are asked for one by one."""
    return tuple(map(float, _function(loop)(*arguments)))


@lru_cache(maxsize=256)
def _function(loop: Loop) -> Callable[..., Sequence[float]]:
    names: dict[str, Any] = {"__builtins__": {}, **NAMES}
    text = loop_text(loop, "loop", caller(names, function_of))
    exec(compile(text, "<planarc loop>", "exec"), names)
    found: Callable[..., Sequence[float]] = names["loop"]
    return found


def function_of(e: Expr) -> Callable[..., Any]:
    """What a node calls."""
    if e.op is Op.CALL:
        return elementary.TABLE[e.data].value
    if e.op is Op.LOOP:
        loop, place = e.data
        return lambda *args: value_behind(loop, place, args)
    function, output, _ = e.data
    return lambda *args: external.number(function, output, [*args])


def caller(names: dict[str, Any], function: Callable[[Expr], Callable[..., Any]]) -> Call:
    """The texts of calls, which put the functions into `names`."""

    def call(e: Expr, a: Sequence[str]) -> str:
        name = f"f_{e.data}" if e.op is Op.CALL else f"f{e.id}"
        names[name] = safe(function(e))
        return f"{name}({', '.join(a)})"

    return call
