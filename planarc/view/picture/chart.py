"""Curves over time, or over another variable, by matplotlib: `.png`, `.svg`, `.pdf`.

Variables of one unit share a panel, below each other are those of other units. Units are in
the labels where they are known.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from planarc.core.extras import need
from planarc.ir.result import Result
from planarc.view.page.data import thin_rows
from planarc.view.storage import known_ending, replacing
from planarc.view.table.table import Columns, Table

SUFFIXES = (".png", ".svg", ".pdf")
EXTRA = "plot"
#: Points of a curve in a file; of more, those that are lowest and highest in their stretch.
_POINTS = 20_000
_INCHES = (7.2, 3.0)  # of a panel
#: Nothing in a file tells when it was written: equal results give equal files.
_METADATA: Mapping[str, Mapping[str, None]] = {
    ".svg": {"Date": None},
    ".pdf": {"CreationDate": None},
}


def table_of(result: Result) -> Table:
    """A result as a table, like those that are read from files."""
    columns = Columns({n: n for n in result.columns}, result.__getitem__)
    return Table(result.time, columns, {n: c.unit for n, c in result.columns.items()})


def write_chart(
    path: Path, table: Table, names: Sequence[str], x: str = "time", title: str = ""
) -> None:
    """Write curves as a picture. Raises UsageError V706 (ending), C201 (no such variable), C221
    (no matplotlib)."""
    suffix = known_ending(path, SUFFIXES, "V706", "of a plot")
    table.refuse_unknown((*names, x))
    figure = need("matplotlib.figure", EXTRA).Figure(layout="constrained")
    panels = panels_of(table, names)
    figure.set_size_inches(_INCHES[0], 0.6 + _INCHES[1] * len(panels))
    draw_panels(figure.subplots(len(panels), sharex=True, squeeze=False)[:, 0], table, panels, x)
    if title:
        figure.suptitle(title, fontsize="medium")
    rc = need("matplotlib", EXTRA).rc_context
    with replacing(path) as file, rc({"svg.hashsalt": "planarc", "svg.fonttype": "none"}):
        figure.savefig(file, format=suffix[1:], dpi=150, metadata=_METADATA.get(suffix))


def panels_of(table: Table, names: Sequence[str]) -> list[tuple[str, ...]]:
    """The names in panels, those of one unit together."""
    units: dict[str, list[str]] = {}
    for name in names:
        units.setdefault(_unit(table, name), []).append(name)
    return [tuple(group) for group in units.values()]


def draw_panels(axes: Sequence[Any], table: Table, panels: Sequence[Sequence[str]], x: str) -> None:
    """Draw one panel in each of `axes`, which share their x-axis."""
    names = [n for panel in panels for n in panel]
    rows = thin_rows(len(table.time), [table[n] for n in (*names, x)], _POINTS)
    color = 0
    for panel, ax in zip(panels, axes, strict=True):
        for name in panel:
            ax.plot(table[x][rows], table[name][rows], label=name, color=f"C{color}", lw=1.4)
            color += 1
        only = panel[0] if len(panel) == 1 else ""
        ax.set_ylabel(with_unit(only, _unit(table, panel[0])))
        if not only:
            ax.legend(fontsize="small", framealpha=0.9)
        ax.grid(True, alpha=0.3)
        ax.spines[["top", "right"]].set_visible(False)
    axes[-1].set_xlabel(with_unit(x, _unit(table, x)))


def with_unit(name: str, unit: str) -> str:
    return f"{name} [{unit}]".lstrip() if unit else name


def _unit(table: Table, name: str) -> str:
    return "s" if name == "time" else table.units.get(name, "")
