"""The table of a study: a row for each point, with what was set and what came out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planarc.api.htmltable import html_table
from planarc.core.arrays import Vector
from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic
from planarc.core.extras import need
from planarc.core.prose import counted
from planarc.core.unknown import refuse_unknown, telling_keywords
from planarc.view.storage import write_rows

if TYPE_CHECKING:
    import pandas


class Failure(Data):
    """A point that has no metrics: its `index` in the study, its values (`point`), the `reason`."""

    index: int
    point: Mapping[str, Any]
    reason: str


class Study(Data):
    """The table of a study; `study["max(w)"]` is a column.

    `rows` are points with their metrics (None where the point failed), `failures` the points that
    have none; `units` are those of columns that have one; `warnings` those of the request and of
    the runs, each once. Going through a study gives its rows as
    dicts, and `len` is the number of points.
    """

    model: str
    parameters: tuple[str, ...]
    metrics: tuple[str, ...]
    rows: tuple[tuple[Mapping[str, Any], Mapping[str, float] | None], ...]
    failures: tuple[Failure, ...] = ()
    units: Mapping[str, str] = {}
    warnings: tuple[Diagnostic, ...] = ()

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of the parameters that vary, then those of the metrics."""
        return (*self.parameters, *self.metrics)

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        """The rows, each by the names of its columns."""
        nan = float("nan")
        for point, values in self.rows:
            found = {n: point.get(n) for n in self.parameters}
            yield found | {n: nan if values is None else values.get(n, nan) for n in self.metrics}

    def __getitem__(self, name: str) -> Vector:
        """The column of a name, of the shape (points,), NaN where a point failed.

        Raises UnknownName.
        """
        refuse_unknown("column", (name,), self.columns)
        return np.array([row[name] for row in self])

    def __repr__(self) -> str:
        shown = ", ".join(self.columns)
        return f"<Study of {self.model}: {counted(len(self), 'point')}{self._failed()}; {shown}>"

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.columns)

    @telling_keywords
    def plot(self, *metrics: str, x: str | None = None, axes: Any = None) -> Any:
        """The metrics (all, or those that are named) over a parameter, by matplotlib; gives the
        axes.

        `x` is the parameter along x, by default the first one; points that differ in others lie
        on curves of their own. Each metric has a panel. Needs `pip install planarc[plot]`.
        """
        from planarc.study.plot import plot_study

        return plot_study(self, metrics, x, axes)

    def to_pandas(self) -> pandas.DataFrame:
        """A DataFrame with a row for each point. Needs pandas (`pip install planarc[tables]`)."""
        module = need("pandas", "tables")
        frame: pandas.DataFrame = module.DataFrame(list(self), columns=list(self.columns))
        return frame

    @telling_keywords
    def to_csv(self, path: str | Path) -> Path:
        """Write a row for each point, with all digits. Gives the path. Raises UsageError (V501)."""
        write_rows(Path(path), self.columns, (row.values() for row in self))
        return Path(path)

    def _repr_html_(self) -> str:
        rows = (row.values() for row in self)
        return html_table(
            self.columns, rows, f"{counted(len(self), 'point')}{self._failed()}", most=20
        )

    def _failed(self) -> str:
        return f", {len(self.failures)} failed" if self.failures else ""
