"""Values of expressions at the workspace's present values, and texts with values in them.

For what happens at events: actions of when-clauses, messages, instants. Expressions are
prepared when they are read often (`evaluate.tape`), so a reader should be kept.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from planarc.evaluate.value import evaluate
from planarc.ir.dae import Message
from planarc.ir.expr import Expr, Op, postorder
from planarc.ir.kernel import Kernel, Taker, taker
from planarc.ir.once import once
from planarc.ir.program import Program
from planarc.runtime.texts import formatted

if TYPE_CHECKING:
    from planarc.evaluate.tape import Prepared

#: Preparing an expression takes as long as reading it so many times.
OFTEN = 20


class Reader:
    """`read(expression)` gives a number or a truth value, at the time `t`.

    Raises ArithmeticError or ValueError where it has none.
    """

    def __init__(self, program: Program, kernel: Kernel, t: float) -> None:
        self.t = t
        self._slots, self._w = program.slots, kernel.w
        self._prepared, self._times = _read_before(program)

    def __call__(self, e: Expr) -> Any:
        prepared = self._prepared.get(e)
        if prepared is None:
            times = self._times[e] = self._times.get(e, 0) + 1
            if times < OFTEN:
                return evaluate(e, self.leaf)
            from planarc.evaluate.tape import prepare

            prepared = self._prepared[e] = prepare(e, self.slot)
        return prepared(self._w, self.t)

    def leaf(self, e: Expr) -> float:
        """The value of a leaf."""
        return self.t if e.op is Op.TIME else float(self._w[self.slot(e)])

    def slot(self, e: Expr) -> int:
        """Where the value of a leaf stands."""
        if e.op is Op.PAST:
            raise AssertionError(f"`{e}` has a variable of its own")
        slot = self._slots.get(repr(e))
        if slot is None and e.op is Op.PRE:
            # The left limit of a continuous variable, before a reinit takes effect.
            slot = self._slots.get(e.data)
        if slot is None:
            raise KeyError(repr(e))
        return slot


def taker_of(slots: Mapping[str, int], roots: Sequence[Expr]) -> Taker | None:
    """What takes the values that expressions ask; None where functions are called that may look at
    more, or something has no slot."""
    nodes = list(postorder(roots))
    leaves = [repr(e) for e in nodes if not e.args and e.op is not Op.CONST]
    if any(e.op is Op.APPLY for e in nodes) or any(leaf not in slots for leaf in leaves):
        return None
    return taker([slots[leaf] for leaf in leaves])


@once
def _read_before(program: Program) -> tuple[dict[Expr, Prepared], dict[Expr, int]]:
    """Expressions that are prepared, and how often others were read, in all runs."""
    return {}, {}


def text_of(message: Message, read: Reader) -> str:
    """A message with its values put in."""
    return "".join(
        part if isinstance(part, str) else formatted(read(part[0]), part[1])
        for part in message.parts
    )
