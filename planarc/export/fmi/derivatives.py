"""Derivatives as functions of the standard, in LLVM: along a direction, and adjoint ones.

They are those of outputs and of the states' derivatives by states, inputs and the time
(`instance.slopes`).
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from planarc.codegen.native.assembly import FLAG, POINTER, REAL, Code, Value
from planarc.export.fmi.entries import DISCARD, EVALUABLE, NUMBER, Entries
from planarc.instance.block import is_null, load_narrow, whole
from planarc.instance.plan import Stale
from planarc.instance.slopes import UNKNOWN, has_slopes, node_of, slot_of
from planarc.ir.derivatives import CHUNK


def directional(e: Entries, name: str, arguments: str, lengths: int) -> None:
    """Derivatives along a direction: `lengths` more are told behind directions and results."""
    with _slopes(e, name, arguments) as (c, m, unknowns, given):
        count, knowns, number, seeds, *more = given
        results = more[lengths // 2]
        c.run("px_seed", m, whole(c, CHUNK))
        with c.loop(number) as k:
            _move(e, c, m, name, knowns, k, seeds.load(REAL, k))
        _pass(e, c, m)
        with c.loop(count) as i:
            results.store(_moved(e, c, m, name, unknowns, i), i)


def adjoint(e: Entries, name: str, arguments: str) -> None:
    """The sums of the unknowns' derivatives by each known, weighted by `seeds`."""
    with _slopes(e, name, arguments) as (c, m, unknowns, given):
        count, knowns, number, seeds, _, results, _ = given
        with c.loop(number) as k:
            c.run("px_seed", m, whole(c, CHUNK))
            _move(e, c, m, name, knowns, k, c.constant(1.0, REAL))
            _pass(e, c, m)
            total = c.variable(0.0)
            with c.loop(count) as i:
                slope = _moved(e, c, m, name, unknowns, i)
                total.set(total.get() + seeds.load(REAL, i) * slope)
            results.store(total.get(), k)


@contextmanager
def _slopes(
    e: Entries, name: str, arguments: str
) -> Iterator[tuple[Code, Value, Value, list[Value]]]:
    with e.entry(name, arguments, EVALUABLE) as (c, (m, unknowns, *given)):
        with c.when(~has_slopes(c), leaves=True):
            e.fail(c, m, f"{name}: the model calls functions without derivatives")
        e.refresh(c, m, Stale.NOTHING)
        yield c, m, unknowns, given


def _pass(e: Entries, c: Code, m: Value) -> None:
    with c.when(~c.call(FLAG, "px_pass", m).equals(0), leaves=True):
        e.fail(c, m, "the equations have no derivatives at this point", DISCARD)


def _placed(
    e: Entries, c: Code, m: Value, name: str, references: Value, k: Value
) -> tuple[Value, Value]:
    """The address of a number, and 1 or -1."""
    reference = load_narrow(c, "i32", references, k)
    place = c.call(POINTER, "px_place", m, reference, whole(c, NUMBER))
    with c.when(is_null(c, place), leaves=True):
        e.fail(c, m, f"{name}: there is no such variable")
    odd = (reference - reference / 2 * 2).equals(1)
    return place, c.select(odd, c.constant(-1.0, REAL), 1.0)


def _move(e: Entries, c: Code, m: Value, name: str, references: Value, k: Value, by: Value) -> None:
    place, sign = _placed(e, c, m, name, references, k)
    flag = c.call(FLAG, "px_move", m, place, whole(c, 0), sign * by)
    with c.when(~flag.equals(0), leaves=True):
        e.fail(c, m, f"{name}: derivatives are those by states, inputs and time")


def _moved(e: Entries, c: Code, m: Value, name: str, references: Value, i: Value) -> Value:
    place, sign = _placed(e, c, m, name, references, i)
    with c.when(node_of(m, slot_of(c, m, place)).equals(UNKNOWN), leaves=True):
        e.fail(c, m, f"{name}: derivatives are those of outputs and of derivatives of states")
    return sign * c.call(REAL, "px_moved", m, place, whole(c, 0))
