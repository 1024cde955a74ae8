"""Values of expressions at the workspace's present values, and texts with values in them.

For what happens rarely: actions of when-clauses, messages, instants. Python's speed is
enough there.
"""

from __future__ import annotations

from typing import Any

from planarc.ir.dae import Message
from planarc.ir.expr import Expr, Op, evaluate
from planarc.ir.program import Kernel, Program


class Reader:
    """`read(expression)` gives a number or a truth value."""

    def __init__(self, program: Program, kernel: Kernel, t: float) -> None:
        self._slots, self._w, self._t = program.slots, kernel.w, t

    def __call__(self, e: Expr) -> Any:
        return evaluate(e, self.leaf)

    def leaf(self, e: Expr) -> float:
        if e.op is Op.TIME:
            return self._t
        if e.op is Op.PAST:
            raise AssertionError(f"`{e}` has a variable of its own")
        slot = self._slots.get(repr(e))
        if slot is None and e.op is Op.PRE:
            # The left limit of a continuous variable, before a reinit takes effect.
            slot = self._slots.get(e.data)
        if slot is None:
            raise KeyError(repr(e))
        return self._w[slot]


def text_of(message: Message, read: Reader) -> str:
    """A message with its values put in."""
    return "".join(
        part if isinstance(part, str) else formatted(read(part[0]), part[1])
        for part in message.parts
    )


def formatted(value: float, form: str) -> str:
    """A value as `String(value, format=...)` writes it (six digits without a format)."""
    if isinstance(value, bool):
        return "true" if value else "false"
    try:
        return ("%" + form.lstrip("%") if form else "%.6g") % value
    except (ValueError, TypeError):
        return f"{value:.6g}"
