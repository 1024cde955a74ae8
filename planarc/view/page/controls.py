"""The parameters and start values that can be moved on a live page, and their limits.

In:   Program, its workspace with the values of parameters
Out:  Group      the fields of a component (or of the model itself), in the order of the model

A field is a parameter that a run may replace (a structural one compiles the model again) or a
start value that the model writes. Bounds are the model's own `min` and `max`. A slider runs
from bound to bound where both are known and not far apart, else over a range around the value.
Zero has no size of its own: there the slider is as long as others of its unit.
What does not change the motion stands in a group of its own; colours are left out.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from planarc.core.data import Data
from planarc.ir.dae import Kind
from planarc.ir.expr import Expr, Op, postorder, symbol_text
from planarc.ir.program import Column, ParameterSlot, Program, literals_of, whole_name
from planarc.view.page.data import shown_unit

#: The least share of its length at which the value of a slider from bound to bound stands.
_NEAR = 0.02
REST = "Without effect on the motion"


class Field(Data):
    """A slider or a box. `value`, `minimum`, `maximum` and the slider's `low` and `high` are in
    SI units; the page shows value*factor in `unit`."""

    name: str
    label: str
    kind: str  # Real, Integer, Boolean, enumeration
    value: float
    unit: str
    factor: float
    minimum: float | None
    maximum: float | None
    low: float
    high: float
    description: str
    literals: tuple[str, ...] = ()
    structural: bool = False
    start: bool = False  # a start value of the variable `name`


class Group(Data):
    title: str  # "" for the model itself
    description: str
    fields: tuple[Field, ...]


#: Elements of a structural array that get a field each; a larger one is a table.
_MOST = 12


def groups_of(program: Program, w: Any) -> tuple[Group, ...]:
    """The fields of a model: its own first, then those of components; the drawing last."""
    known = {c.name: c for c in program.columns}
    moving = moves(program)
    sizes = Counter(whole_name(p.name) for p in program.parameter_slots)
    own: dict[str, list[Field]] = {}
    rest: list[Field] = []
    for p in program.parameter_slots:
        if p.final or not (p.settable or p.structural) or not _is_public(p.name, known):
            continue
        if _is_channel(p) or (p.structural and sizes[whole_name(p.name)] > _MOST):
            continue
        component = p.name.partition(".")[0] if "." in p.name else ""
        label = p.name.partition(".")[2] or p.name
        value = float(w[p.slot])
        if p.structural or p.name in moving:
            made = _parameter(p, known.get(p.name), label, value)
            own.setdefault(component, []).append(made)
        else:
            rest.append(_parameter(p, known.get(p.name), p.name, value))
    for field in _starts(program, known, w):
        component = field.name.partition(".")[0] if "." in field.name else ""
        own.setdefault(component, []).append(field)
    classes = {p.name: p.class_name.rpartition(".")[2] for p in program.parts}
    shared = {p.name for p in program.parts if p.inner}
    order = sorted(own, key=lambda c: (c != "", c in shared))
    found = [Group(c, classes.get(c, ""), tuple(own[c])) for c in order]
    if rest:
        found.append(Group(REST, "the picture at most", tuple(rest)))
    return _scaled(tuple(found))


def inputs_of(program: Program, values: Any, others: Sequence[str] = ()) -> tuple[Field, ...]:
    """Fields of the model's inputs, which a run holds at one value; `values` are the rows of a run
    by name. Derivatives of other inputs stay 0. `others` are inputs that are no Reals."""
    known = {c.name: c for c in program.columns}
    wanted = [known[n] for n in program.inputs if n in known and not n.startswith("der(")]
    wanted += [known[name] for name in others]
    literals = literals_of(program)
    limits = {told.name: told.numbers for told in program.limits}
    return tuple(
        _field(c.name, c.name, c.kind, float(values[c.name][0]), c.unit, c,
               limits.get(c.name, (None, None)), c.description, literals=literals.get(c.name, ()))
        for c in wanted
    )  # fmt: skip


def _is_channel(p: ParameterSlot) -> bool:
    """True for the red, green or blue of a colour."""
    return p.kind is Kind.INTEGER and (p.minimum, p.maximum) == (0.0, 255.0)


def _is_public(name: str, known: dict[str, Column]) -> bool:
    return not name.startswith("$") and not (name in known and known[name].protected)


def _parameter(p: ParameterSlot, column: Column | None, label: str, value: float) -> Field:
    bounds = p.minimum, p.maximum
    literals = tuple(n.rpartition(".")[2] for n in p.literals)
    told = {"literals": literals, "structural": p.structural}
    return _field(p.name, label, p.kind, value, p.unit, column, bounds, p.description, **told)


def _starts(program: Program, known: dict[str, Column], w: object) -> Iterator[Field]:
    """The start values that are written in the model, held ones and hints."""
    for c in program.candidates:
        column = known.get(c.display)
        if not (c.start_written or c.fixed) or column is None or column.slot != c.slot:
            continue
        value = column.sign * float(w[c.start])  # type: ignore[index]
        label = c.display.partition(".")[2] or c.display
        held = "held exactly" if c.fixed else "a hint"
        told = f"{column.description or c.display} at the start, {held}"
        own = c.display, label, Kind.REAL, value, column.unit, column
        yield _field(*own, (None, None), told, start=True)


def _field(
    name: str,
    label: str,
    kind: Kind,
    value: float,
    unit: str,
    column: Column | None,
    bounds: tuple[float | None, float | None],
    description: str,
    **more: Any,
) -> Field:
    """A field with its slider, as the page shows it: degrees where the library says so."""
    factor, shown = (1.0, unit) if column is None else shown_unit(column)
    if factor == 1.0:
        shown = "" if unit == "1" else unit
    ends = slider(kind, value, *bounds, unit)
    return Field(name, label, kind.value, value, shown, factor, *bounds, *ends, description, **more)


def _scaled(groups: tuple[Group, ...]) -> tuple[Group, ...]:
    """Groups whose sliders around zero are as long as those of neighbours or of the model."""
    everywhere: dict[str, list[float]] = {}
    for group in groups:
        for f in group.fields:
            if f.value and not f.start:
                everywhere.setdefault(f.unit, []).append(abs(f.value))
    return tuple(
        replace(group, fields=tuple(_around_zero(f, group, everywhere) for f in group.fields))
        for group in groups
    )


def _around_zero(f: Field, group: Group, everywhere: dict[str, list[float]]) -> Field:
    if f.value or (f.low, f.high) != (-1.0, 1.0) or f.kind != Kind.REAL.value or not f.unit:
        return f
    near = [abs(o.value) for o in group.fields if o.unit == f.unit and o.value and not o.start]
    far = sorted(everywhere.get(f.unit, ()))
    size = max(near) if near else far[len(far) // 2] if far else 1.0
    size = _round(size)
    low = -size if f.minimum is None else max(f.minimum, -size)
    high = size if f.maximum is None else min(f.maximum, size)
    return replace(f, low=low, high=high) if low < high else f


def slider(
    kind: Kind, value: float, minimum: float | None, maximum: float | None, unit: str
) -> tuple[float, float]:
    """Begin and end of a slider; the value is between."""
    if not math.isfinite(value):
        return 0.0, 1.0
    if minimum is not None and maximum is not None and minimum < maximum:
        near = max(abs(value), abs(minimum)) >= _NEAR * (maximum - minimum)
        if minimum <= value <= maximum and (near or value == minimum):
            return minimum, maximum
    if unit == "rad" and abs(value) <= math.pi:
        low, high = -math.pi, math.pi
    elif value == 0.0:
        low, high = -1.0, 1.0
    else:
        low, high = sorted((_round(0.2 * value), _round(2.5 * value)))
    if kind is Kind.INTEGER:
        low, high = min(math.floor(low), round(value) - 1), max(math.ceil(high), round(value) + 5)
    low = low if minimum is None else max(low, minimum)
    high = high if maximum is None else min(high, maximum)
    return (low, high) if low < high else (min(low, value), max(high, value) + 1.0)


def _round(value: float) -> float:
    """The number with two digits, for a slider of round ends."""
    return float(f"{value:.2g}")


def moves(program: Program) -> set[str]:
    """The parameters on which the motion depends, in equations or through other parameters."""
    needed = _symbols(
        (
            program.levels, program.rest, program.initial, program.initial_residuals,
            program.roots, program.discrete, program.blocks, program.relations,
            program.samplers, program.whens, program.assertions, program.delays,
        )
    )  # fmt: skip
    needed |= {f"start({symbol})" for symbol in needed}
    for statement in reversed(program.parameters):
        target = getattr(statement, "target", None)
        if target is None or _symbols((target,)) & needed:
            needed |= _symbols((statement,))
    return needed


def _symbols(values: Iterable[object]) -> set[str]:
    """The names of all symbols in nested data."""
    found: set[str] = set()
    seen: set[int] = set()
    stack: list[object] = list(values)
    while stack:
        value = stack.pop()
        if isinstance(value, Expr):
            if id(value) in seen:
                continue
            for e in postorder((value,)):
                seen.add(id(e))
                if e.op is Op.SYMBOL:
                    found.add(symbol_text(*e.data))
        elif isinstance(value, tuple | list):
            stack.extend(value)
        elif isinstance(value, Struct):
            stack.extend(getattr(value, name) for name in value.__struct_fields__)
    return found
