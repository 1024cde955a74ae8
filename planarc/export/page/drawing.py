"""The picture and the curves of a run, as a page makes them again from the rows of another one.

In:   Program, Result of a run
Out:  Drawing   scene and curves for `json`, with holes; the steps that fill these

The functions that draw a run and look into it are handed columns that remember what is made of
them (`evaluate.record`). What they find to be chosen, such as the width of links, which curves
are shown and which forces are more than round-off, stays as in the run at export.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
from msgspec.structs import replace

from planarc.core.arrays import Vector
from planarc.core.data import Data
from planarc.evaluate.record import Number, Rows, Tape
from planarc.evaluate.rows import RowValues
from planarc.export.endings import ends, values_of
from planarc.export.page.told import touch_slots, warnings
from planarc.insight.happenings import KIND
from planarc.insight.values import Values
from planarc.instance.actions import errors
from planarc.ir.expr import Expr, Op, symbol_text
from planarc.ir.insight import Layer, Track
from planarc.ir.result import Result
from planarc.solve.events import asserts
from planarc.stages import study
from planarc.view.marks.shapes import forget_shapes
from planarc.view.page.columns import Columns
from planarc.view.page.data import curve_data, scene_data
from planarc.view.page.figures import choose_figures
from planarc.view.page.report import PEAKS
from planarc.view.page.shapes import shape_data
from planarc.view.scene import make_scene


class Drawing(Data):
    """`data` holds the scene, the curves, the peaks, and what else is told of a run: the numbers
    in messages, the conditions of warnings, and those that name events.
    `holes` are pairs of a path (keys and places, from `data` inwards) and the number of a step;
    `slots` are those whose columns the steps need. `facts` and `notes` are told as they are."""

    data: dict[str, Any]
    steps: list[list[Any]]
    holes: list[tuple[list[str | int], int]]
    slots: list[int]
    facts: tuple[tuple[str, str], ...]
    notes: tuple[str, ...]


class _Remembering(Result, kw_only=True):
    """A result whose columns remember."""

    tape: Tape

    def of_slot(self, slot: int) -> Track:
        if slot in self.stored:
            return self.tape.rows(self.data[:, self.stored[slot]], "column", slot)
        return self.tape.number(float(self.constants[slot]), "fixed", slot)

    def __getitem__(self, name: str) -> Vector:
        if name == "time":
            return self.time
        values = self.track(name)
        return values + 0.0 * self.time if isinstance(values, float) else values


class _Columns(Columns):
    """Columns that are not here yet; those of one step are one."""

    def __init__(self) -> None:
        super().__init__(slice(None))

    def add(self, values: Track) -> int:
        key = values.step if isinstance(values, (Rows, Number)) else (values,)
        if key not in self._known:
            self._known[key] = len(self.all)
            self.all.append(values)  # type: ignore[arg-type]
            self.size += 3
        return self._known[key]


def _forget() -> None:
    """Make shapes afresh: numbers that remember are taken for no others."""
    forget_shapes()
    shape_data.cache_clear()


def draw(result: Result) -> Drawing:
    """The drawing of a model, by a run of it."""
    tape = Tape()
    given = {name: getattr(result, name) for name in result.__struct_fields__}
    own = _Remembering(**given | {"time": tape.rows(result.time, "time"), "tape": tape})
    _forget()
    try:
        with np.errstate(all="ignore"):
            scene, insight = make_scene(own), study(own)
            items = tuple(item for item in scene.items if _is_known(item.tracks))
            layers = tuple(filter(None, map(_kept, insight.layers)))
            series = tuple(s for s in insight.series if _is_known((s.values,)))
            figures = choose_figures(own, None, replace(insight, series=series))
            motion = scene_data(replace(scene, items=items), None, (), layers, _Columns())
            curves = curve_data(own, figures, None, series, columns=_Columns())
            peaks = [[p.name, p.unit, p.value, p.time, p.rms] for p in insight.peaks[:PEAKS]]
            told = _told(own)
    finally:
        _forget()
    for part in (motion, curves):
        part["time"] = None
    data: dict[str, Any] = {"scene": motion, "curves": curves, "peaks": peaks, **told}
    found = list(_holes(data, []))
    steps, places = tape.recipe([step for _, step in found])
    used = {step[1] for step in steps if step[0] in ("column", "fixed")}
    slots = sorted(used.union(*touch_slots(result.program)))
    lost = [
        f"`{i.component}` is not drawn in this page" for i in scene.items if not _is_known(i.tracks)
    ]
    return Drawing(
        _emptied(data), steps, [(p, n) for (p, _), n in zip(found, places, strict=True)], slots,
        insight.facts, (*scene.notes, *lost),
    )  # fmt: skip


def _told(result: _Remembering) -> dict[str, Any]:
    """The numbers in the messages that may end a run; of each assertion that warns its condition
    and its numbers; conditions of components by which their events have names."""
    program = result.program
    value = partial(_value, RowValues(partial(_leaf, result)))
    of_parameters = [program.assertions[i] for i in asserts.of_parameters(program)]
    declared = Values(result).declared(KIND)
    return {
        "ends": [list(map(value, values_of(message))) for message in ends(program)],
        "impossible": [
            [i, value(a.condition)] for i, a in enumerate(errors(program)) if a in of_parameters
        ],
        "warned": [
            [value(a.condition), *map(value, values_of(a.message))] for a in warnings(program)
        ],
        "happens": {c: own for c, own in declared.items() if _is_known(tuple(own.values()))},
    }


def _leaf(result: _Remembering, e: Expr) -> Any:
    """A variable; its left limit, which is that of the row before; else what a slot holds."""
    if e.op is Op.TIME:
        return result.time
    name = symbol_text(*e.data) if e.op is Op.SYMBOL else e.data
    if name in result:
        values = result.track(name)
        return result.tape.result(values, "before", values) if e.op is Op.PRE else values
    slot = result.program.slots[repr(e)]
    return result.tape.rows(np.ones(len(result.time)), "column", slot)


def _value(values: RowValues, e: Expr) -> Any:
    """A number of a message; None where it cannot be made again."""
    try:
        found = values(e)
    except (KeyError, TypeError):  # what only a function of Python knows
        return None
    if not _is_known((found,)):
        return None
    return found if isinstance(found, (Rows, Number)) else float(found)


def _is_known(values: Sequence[Any]) -> bool:
    """Whether all of them can be made again."""
    return not any(isinstance(v, np.ndarray) and getattr(v, "step", None) is None for v in values)


def _kept(layer: Layer) -> Layer | None:
    """The layer with those of its members that can be made again."""
    members = tuple(m for m in layer.members if _is_known((m.x, m.y, m.u, m.v)))
    return replace(layer, members=members) if members else None


def _holes(value: Any, path: list[str | int]) -> Iterator[tuple[list[str | int], int]]:
    """Where in nested data something remembers, and the step that it is."""
    if isinstance(value, (Rows, Number)):
        assert value.step is not None
        yield path, value.step
    elif isinstance(value, dict):
        for key, inner in value.items():
            yield from _holes(inner, [*path, key])
    elif isinstance(value, (list, tuple)):
        for i, inner in enumerate(value):
            yield from _holes(inner, [*path, i])


def _emptied(value: Any) -> Any:
    """The data with nothing where a hole is."""
    if isinstance(value, (Rows, Number)):
        return None
    if isinstance(value, dict):
        return {key: _emptied(inner) for key, inner in value.items()}
    return list(map(_emptied, value)) if isinstance(value, (list, tuple)) else value
