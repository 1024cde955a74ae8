"""The curves that a page offers, in figures.

First what drives the mechanism, and the figures of the model's documentation; without one the
coordinates of the joints, or of the bodies where there is no joint. Then what the model itself
declares, and what else insight gave. What does not change makes no curve, and of curves that are
equal there is one.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

from planarc.core.data import Data
from planarc.ir.insight import DRIVES, Insight
from planarc.ir.result import Result

#: The most curves of a figure that nobody chose: more cannot be told apart.
LIMIT = 6


class Figure(Data):
    """Curves in one plot; `on` shows it when the page opens."""

    title: str
    curves: tuple[str, ...]
    on: bool = False


def choose_figures(
    result: Result, names: Sequence[str] | None = None, insight: Insight | None = None
) -> tuple[Figure, ...]:
    """The figures of a page; `names` are shown instead of any other."""
    formulas = {s.name for s in insight.series} if insight is not None else set()
    own = _documented(result, formulas)
    mechanism = result.program.mechanism
    held = set() if mechanism is None else {joint.name for joint in mechanism.joints}
    joints = [part.name for part in result.program.parts if part.name in held]
    known = () if insight is None else insight.figures
    there = {name for figure in own if figure.on for name in figure.curves}
    driving = [n for title, curves, _ in known if title == DRIVES for n in curves]
    found = [Figure(DRIVES, _short([n for n in driving if n not in there]), True), *own]
    if joints:
        found.append(Figure("Joints", _changing(result, _names(joints, ("phi", "s"))), not own))
        found.append(Figure("Joint speeds", _changing(result, _names(joints, ("w", "v")))))
    else:
        moving = {d.component for d in result.program.declared if d.name == "kinetic"}
        bodies = [part.name for part in result.program.parts if part.name in moving]
        coordinates = _changing(result, _names(bodies, ("r[1]", "r[2]", "phi")))
        found.append(Figure("Bodies", coordinates, not own))
    top = [c.name for c in result.program.columns if "." not in c.name and not c.protected]
    model = _changing(result, top)
    found.append(Figure("Model", model, not any(f.on and f.curves for f in found)))
    if insight is not None:
        found += [Figure(*figure) for figure in known if figure[0] != DRIVES]
    if names is not None:
        found = [Figure("Curves", tuple(names), True), *(Figure(f.title, f.curves) for f in found)]
    return tuple(f for f in found if f.curves)


def shown_names(result: Result) -> tuple[str, ...]:
    """The variables that are drawn when nobody says which."""
    figures = choose_figures(result)
    return tuple(dict.fromkeys(n for f in figures if f.on for n in f.curves))


def _documented(result: Result, formulas: Collection[str]) -> list[Figure]:
    """The model's own figures: the preferred ones are shown, or else the first."""
    found = []
    for figure in result.program.figures:
        for i, plot in enumerate(figure.plots):
            title = plot.title or figure.title or f"Figure {i + 1}"
            computed = {f.text for f in plot.formulas}.intersection(formulas)
            known = (name for name in plot.curves if name in computed or name in result)
            curves = tuple(name for name in known if name != "time")
            found.append(Figure(title, curves, figure.preferred))
    found = [f for f in found if f.curves]
    if found and not any(f.on for f in found):
        found[0] = Figure(found[0].title, found[0].curves, True)
    return found


def _names(parts: Iterable[str], variables: Sequence[str]) -> list[str]:
    owners = list(parts)
    return [f"{owner}.{variable}" for variable in variables for owner in owners]


def _short(curves: Sequence[str]) -> tuple[str, ...]:
    return tuple(curves[:LIMIT])


def _changing(result: Result, names: Iterable[str]) -> tuple[str, ...]:
    found: dict[bytes, str] = {}
    for name in names:
        column = result.columns.get(name)
        if column is None or column.constant or column.slot not in result.stored:
            continue
        values = column.sign * result.data[:, result.stored[column.slot]]
        if len(values) and (values != values[0]).any():
            found.setdefault(values.tobytes(), name)
            if len(found) == LIMIT:
                break
    return _short(tuple(found.values()))
