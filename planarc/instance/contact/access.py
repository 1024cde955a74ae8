"""Ways to the memory of contacts, in LLVM."""

from __future__ import annotations

from planarc.codegen.native.assembly import INT, POINTER, REAL, Code, Value
from planarc.instance.contact.area import Area, Kept, Seen
from planarc.instance.plan import Own, Table, Touch


def arrays(m: Value, *which: Area) -> list[Value]:
    at = m.load(POINTER, Own.CONTACT)
    return [at.load(POINTER, w) for w in which]


def touches(c: Code) -> Value:
    """How many a model has."""
    return Value(c, POINTER, "@px_plan").load(INT, int(Table.TOUCHES))


def seen(c: Code, m: Value, which: Seen) -> Value:
    """The place of a number."""
    return m.load(POINTER, Own.TOUCHES).at(touches(c) * int(Kept.NUMBERS) + int(which))


def kept(c: Code, m: Value, which: Kept) -> Value:
    """An array with a number for each touch."""
    return m.load(POINTER, Own.TOUCHES).at(touches(c) * int(which))


def slot(c: Code, i: Value, which: Touch) -> Value:
    """The place in the workspace of what the operator sets at touch i."""
    return Value(c, POINTER, "@px_touches").load(INT, i * len(Touch) + int(which))


def zero(c: Code) -> Value:
    return c.constant(0.0, REAL)
