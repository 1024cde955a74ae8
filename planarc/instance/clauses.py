"""What clauses of a model do, in order, the variables that they set, and those that they read."""

from __future__ import annotations

from collections.abc import Callable

from planarc.codegen.native.assembly import REAL, Value
from planarc.ir.dae import Action, Assertion, SetDiscrete
from planarc.ir.expr import Expr, Op
from planarc.ir.program import DiscreteSlot, Program
from planarc.solve.events.whens import own_slots


def actions(program: Program) -> list[Action]:
    return [a for when in program.whens for *_, found in when.branches for a in found]


def warnings(program: Program) -> tuple[Assertion, ...]:
    """The assertions that only warn: those that always stand, then those of clauses."""
    told = (a for a in actions(program) if isinstance(a, Assertion))
    return tuple(a for a in (*program.assertions, *told) if a.warning)


def keeps(action: Action) -> bool:
    """Whether it sets a variable to its left limit, as clauses do for what impacts set."""
    if not isinstance(action, SetDiscrete):
        return False
    return action.value.op is Op.PRE and action.value.data == action.name


def ordered_discretes(program: Program) -> tuple[tuple[DiscreteSlot, ...], int]:
    """The discrete variables, first those (so many) that no clause sets to anything else than
    their left limits."""
    changed = {a.name for a in actions(program) if isinstance(a, SetDiscrete) and not keeps(a)}
    own = own_slots(program)
    kept = tuple(d for d in program.discretes if d.slot in own and d.name not in changed)
    slots = {d.slot for d in kept}
    return kept + tuple(d for d in program.discretes if d.slot not in slots), len(kept)


def reader(program: Program, w: Value, t: Value) -> Callable[[Expr], Value]:
    """Leaves of a formula from the workspace."""

    def leaf(e: Expr) -> Value:
        return t if e.op is Op.TIME else w.load(REAL, slot_of(program, e))

    return leaf


def slot_of(program: Program, e: Expr) -> int:
    """Where a leaf stands in the workspace."""
    slot = program.slots.get(repr(e))
    if slot is None and e.op is Op.PRE:  # of a continuous variable: before a reinit
        slot = program.slots[e.data]
    assert slot is not None, f"`{e}` has no value here"
    return slot
