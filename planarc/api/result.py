"""The result of a run, as a user holds it: arrays by name, tables, curves, the moving picture.

The file is long because it is one class: the signatures and docstrings of all that a user may
ask.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Sequence
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

from planarc.api.values import count, elements_of, finite
from planarc.core.diagnostic import Diagnostic, RunError, usage_error
from planarc.core.extras import need
from planarc.core.prose import counted
from planarc.core.unknown import telling_keywords, unknown_attribute, unknown_name
from planarc.stages import study
from planarc.view.storage import CannotWrite, with_ending, write_text

if TYPE_CHECKING:
    import pandas
    import xarray

    from planarc.compiled import Compiled
    from planarc.core.arrays import Vector
    from planarc.ir.insight import Layer
    from planarc.ir.result import Result as Rows
    from planarc.request.request import Request


class RunStopped(RunError):
    """The run ended before its time; `result` holds what was computed until then."""

    def __init__(self, diagnostic: Diagnostic, result: Result) -> None:
        super().__init__(diagnostic)
        self.result = result


class Result:
    """The result of a run. `result["crank.phi"]` is an array over `result.time`.

    Values are in SI units, as `unit(name)` says. A variable that does not change has an
    array too. The name of an array, `result["body.r_0"]`, gives an array with one more axis
    for each of its subscripts, here of the shape (rows, 2). Going through a result gives the names
    of its variables; `len` is the number of rows.

    `time` (s) rises, and occurs twice at an event: before it and after it. `events` lists these
    instants with their causes, `states` what was integrated, and from when on; `start` tells what
    became of each start value, `statistics` the effort. `warnings` are messages of the run, and
    `ended` is the reason why it ended before its time, None if it did not.
    """

    def __init__(
        self, rows: Rows, compiled: Compiled | None = None, request: Request | None = None
    ) -> None:
        self.rows = rows
        self._request = request  # what its files say of the model
        self._compiled = compiled  # what made them: it tells how near dead points are
        self.name = rows.program.name
        self.time = rows.time
        self.statistics = rows.statistics
        self.events = rows.events
        self.states = rows.states  # the variables that were states, and from when on
        self.start = rows.held  # the use of each start value
        self.warnings = rows.warnings
        self.ended = rows.ended  # the reason why the run ended before its time, if it did

    @property
    def compiled(self) -> Compiled | None:
        """The model that made the rows, where it is at hand."""
        return self._compiled

    def __getitem__(self, name: str) -> Vector:
        """The values of a name over `time`, of the shape (rows,), or (rows, ...) of an array.

        Raises UnknownName, which is a UsageError and a KeyError.
        """
        if isinstance(name, str) and name in self.rows:
            return self.rows[name]
        import numpy as np

        names, shape = self._elements(name)
        return np.stack([self.rows[n] for n in names], axis=-1).reshape(len(self), *shape)

    def __getattr__(self, name: str) -> Any:
        """Raises AttributeError, with what to write for a variable of this name."""
        rows = self.__dict__.get("rows")
        found = () if rows is None or name[0] == "_" else rows.columns
        beneath = [c for c in found if c == name or c.startswith(f"{name}.")]
        inside = min(beneath, key=lambda c: c.count("."), default=None)
        if inside is None:
            raise unknown_attribute(self, name)
        message = f"`{type(self).__name__}` has no attribute `{name}`"
        raise AttributeError(f'{message}: write `result["{inside}"]`')

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and name in self.rows

    def __iter__(self) -> Iterator[str]:
        return iter(self.rows.columns)

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.rows.columns)

    def _elements(self, name: Any) -> tuple[list[str], tuple[int, ...]]:
        """The scalars of an array, the last subscript fastest, and its sizes."""
        found = elements_of(name, self.rows.columns) if isinstance(name, str) else {}
        shape = tuple(max(at) for at in zip(*found, strict=True))
        if not isinstance(name, str):
            raise usage_error(
                "C202",
                f"the name of a variable is a text, not {type(name).__name__}",
                hint='write `result["x"][0]` for a value of `x`, `result.at("x", 0.5)` for a time',
            )
        if not found or prod(shape) != len(found):
            raise unknown_name("variable", name, self.rows.columns)
        return [found[at] for at in sorted(found)], shape

    def _scalars(self, names: Iterable[str]) -> list[str]:
        """The names with those of the elements in the place of arrays."""
        scalars: list[str] = []
        for name in names:
            known = name == "time" or name in self.rows.columns
            scalars += [name] if known else self._elements(name)[0]
        return scalars

    def __len__(self) -> int:
        """The number of rows."""
        return len(self.rows.time)

    def __repr__(self) -> str:
        time = self.time
        span = f"{time[0]:g} to {time[-1]:g} s" if len(time) else "no time"
        rows = counted(len(self), "row")
        return f"<Result of {self.name}: {rows}, {span}, {self.statistics.solver}>"

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all variables and parameters."""
        return tuple(self.rows.columns)

    @property
    def parameters(self) -> dict[str, float]:
        """The values that the run used, by the names of the parameters, in SI units."""
        known = {p.name for p in self.rows.program.parameter_slots}
        return {
            n: c.sign * float(self.rows.constants[c.slot])
            for n, c in self.rows.columns.items()
            if n in known and c.slot in self.rows.constants
        }

    @property
    def units(self) -> dict[str, str]:
        """The unit of each variable by its name."""
        return {n: c.unit for n, c in self.rows.columns.items()}

    @telling_keywords
    def unit(self, name: str) -> str:
        """The unit of a variable, empty where it has none. Raises UnknownName."""
        return "s" if name == "time" else self.rows.columns[self._scalars([name])[0]].unit

    @telling_keywords
    def description(self, name: str) -> str:
        """The text behind the declaration of a variable. Raises UnknownName."""
        return self.rows.columns[self._scalars([name])[0]].description

    @telling_keywords
    def at(self, name: str, times: float | Sequence[float] | Vector) -> Any:
        """Values at other times (s) within the run, on straight lines between the rows.

        A number for one time, an array of the shape of `times` for several. Raises UnknownName, and
        UsageError (C214) for a time before the first row or after the last one.
        """
        import numpy as np

        values, times = self[name], self._within(times)
        if values.ndim == 1:
            return np.interp(times, self.time, values)
        columns = [np.interp(times, self.time, c) for c in values.reshape(len(self), -1).T]
        return np.stack(columns, axis=-1).reshape(*np.shape(times), *values.shape[1:])

    def _within(self, times: Any) -> Vector:
        """Times as numbers; those that rounding alone puts outside count as the ends."""
        import numpy as np

        try:
            asked = np.asarray(times, dtype=float)
        except (TypeError, ValueError, OverflowError):
            raise usage_error("C202", f"times are numbers, not `{times!r:.60}`") from None
        first, last = float(self.time[0]), float(self.time[-1])
        slack = 1e-9 * (last - first)
        outside = ~((asked >= first - slack) & (asked <= last + slack))
        if outside.any():
            raise usage_error(
                "C214",
                f"the run knows nothing of t = {asked[outside].flat[0]:g} s: it goes from "
                f"{first:g} to {last:g} s",
            )
        return asked

    @telling_keywords
    def select(self, variables: str | Iterable[str] | None = None) -> list[str]:
        """Names: all variables that change, those of a list, or those that match a regex.

        Raises UnknownName for a name of a list, UsageError C220 for a text that is no regex.
        """
        columns = self.rows.columns
        if variables is None:
            return [n for n, c in columns.items() if not c.constant]
        if isinstance(variables, str):
            if variables in columns:
                return [variables]
            try:
                pattern = re.compile(variables)
            except re.error as problem:
                raise usage_error(
                    "C220", f"`{variables}` is no regular expression: {problem}"
                ) from None
            found = [n for n in columns if pattern.search(n)]
            if not found:
                raise unknown_name("variable", variables, columns)
            return found
        return self._scalars(variables)

    # Tables

    @telling_keywords
    def to_pandas(
        self, variables: str | Iterable[str] | None = None, *, once: bool = False
    ) -> pandas.DataFrame:
        """A DataFrame over `time` (s), a column for each variable that `select` gives.

        `.attrs["units"]` holds its units. `once`: each time once, as `reindex` needs it; of the
        rows at an event the last. Needs pandas (`pip install planarc[tables]`).
        """
        module = need("pandas", "tables")
        names, rows = self.select(variables), self._rows(once)
        index = module.Index(self.time[rows], name="time")
        frame: pandas.DataFrame = module.DataFrame({n: self[n][rows] for n in names}, index=index)
        frame.attrs["units"] = {n: self.unit(n) for n in names}
        return frame

    @telling_keywords
    def to_xarray(
        self, variables: str | Iterable[str] | None = None, *, once: bool = False
    ) -> xarray.Dataset:
        """A Dataset over `time` (s): what `select` gives, each with `units` and `long_name`.

        `once`: each time once, as `sel` and `interp` need it; of the rows at an event the last.
        Needs xarray (`pip install planarc[tables]`).
        """
        module, rows = need("xarray", "tables"), self._rows(once)
        columns = {
            n: ("time", self[n][rows], {"units": self.unit(n), "long_name": self.description(n)})
            for n in self.select(variables)
        }
        coordinate = {"time": ("time", self.time[rows], {"units": "s"})}
        dataset: xarray.Dataset = module.Dataset(columns, coordinate, {"model": self.name})
        return dataset

    def _rows(self, once: bool) -> Any:
        """The rows of a table in memory: all, or the last of each time."""
        import numpy as np

        if not once:
            return slice(None)
        return np.append(np.diff(self.time) > 0, True)

    @telling_keywords
    def to_csv(
        self,
        path: str | Path,
        variables: str | Iterable[str] | None = None,
        *,
        units: bool = False,
    ) -> Path:
        """Write a table: all variables, or some; with `units` in the head of each column.

        The first column is the time, values are in SI units, with all their digits. Gives the path.
        Raises UnknownName, and UsageError where the file cannot be written.
        """
        return self._write(path, ".csv", variables, units)

    @telling_keywords
    def to_mat(self, path: str | Path, variables: str | Iterable[str] | None = None) -> Path:
        """Write MATLAB level 4, as Modelica tools share it; it holds constants, too.

        Gives the path. Raises UnknownName, and UsageError where the file cannot be written.
        """
        return self._write(path, ".mat", variables, False)

    def _write(
        self, where: str | Path, suffix: str, variables: str | Iterable[str] | None, units: bool
    ) -> Path:
        from planarc.view.table.files import write_table
        from planarc.view.table.origin import UNKNOWN, Origin

        asked = self._request
        known = asked is not None and asked.text is None
        origin = Origin("", asked.file, asked.libraries) if asked and known else UNKNOWN
        path = _path(where, "run.csv")
        only = None
        if variables is not None:
            names = "|".join(re.escape(n) for n in self.select(variables))
            only = re.compile(rf"\A(?:{names})\Z")
        if os.path.isdir(path):  # noqa: PTH112 (a name that no file can have is no folder)
            raise CannotWrite(
                Diagnostic("V501", f"cannot write `{path}`: it is a folder", hint="name a file")
            )
        path = with_ending(path, suffix)
        write_table(path, self.rows, only, units, origin)
        return path

    # Pictures

    @telling_keywords
    def plot(self, *names: str | Sequence[str], x: str = "time", axes: Any = None) -> Any:
        """Curves against time or another variable, by matplotlib; gives the axes.

        Variables of one unit share a panel; of several units come several axes, one below
        the other, as an array. `axes` takes all of them. Without names, the coordinates of
        the joints. Needs `pip install planarc[plot]`. Raises UnknownName.
        """
        from planarc.view.picture import chart

        asked = tuple(
            name
            for given in names
            for name in (given if isinstance(given, list | tuple) else (given,))
        )
        if not asked:
            from planarc.view.page.figures import shown_names

            asked = shown_names(self.rows)
        table = chart.table_of(self.rows)
        asked = tuple(self._scalars(asked))
        table.refuse_unknown((*asked, x))
        panels = chart.panels_of(table, asked) if axes is None else [asked]
        if axes is None:
            pyplot = need("matplotlib.pyplot", chart.EXTRA)
            size = (6.4, 1.2 + 3.0 * len(panels))
            axes = pyplot.subplots(len(panels), sharex=True, figsize=size, layout="constrained")[1]
        chart.draw_panels(axes if len(panels) > 1 else [axes], table, panels, x)
        return axes

    @overload
    def animate(self, *, curves: Sequence[str] | None = None) -> Page: ...

    @overload
    def animate(
        self,
        path: str | Path,
        *,
        begin: float | None = None,
        end: float | None = None,
        at: float | None = None,
        speed: float | None = None,
        rate: float = 25.0,
        width: int = 640,
        dark: bool | None = None,
        traces: str | Sequence[str] = (),
        layers: str | Sequence[str] = (),
    ) -> Path: ...

    @telling_keywords
    def animate(
        self,
        path: str | Path | None = None,
        *,
        curves: Sequence[str] | None = None,
        begin: float | None = None,
        end: float | None = None,
        at: float | None = None,
        speed: float | None = None,
        rate: float = 25.0,
        width: int = 640,
        dark: bool | None = None,
        traces: str | Sequence[str] = (),
        layers: str | Sequence[str] = (),
    ) -> Page | Path:
        """The moving mechanism: beside curves on a page that a notebook shows, or as a file.

        The ending of `path` says what: `.svg`, which moves by itself in a browser, `.gif`,
        `.mp4`, or `.png` (one instant). Shown is the run from `begin` to `end` (s), `speed`
        seconds of it in one, with `rate` frames a second, or the one instant `at`. `width`
        is in pixels; `traces` names points whose paths are drawn, `layers` what the page
        lays over the mechanism (`forces`, `velocities`, `accelerations`, `paths`). All but `.svg`
        needs `pip install planarc[pictures]`. Gives the page, or the path. Raises UnknownName for a
        point or a layer, UsageError for an ending (V701) or a time (V703) that cannot be.
        """
        if path is None:
            moved = {"begin": begin, "end": end, "at": at, "speed": speed, "dark": dark}
            drawn = {"traces": traces, "layers": layers}
            for name in (n for n, v in (moved | drawn).items() if v not in (None, (), "")):
                hint = f'name one, as `animate("run.svg", {name}=...)`'
                raise usage_error("C202", f"`{name}` belongs to a picture in a file", hint=hint)
            return Page(self._page(curves))
        from planarc.view.picture.make import PictureOptions, write_picture
        from planarc.view.picture.motion import When

        begin, end, speed, at = (
            None if value is None else finite(name, value)
            for name, value in (("begin", begin), ("end", end), ("speed", speed), ("at", at))
        )
        when, width = When(begin, end, speed, finite("rate", rate)), count("width", width) or width
        options = PictureOptions(when, at, width, dark, _several(traces), _several(layers))
        found: Sequence[Layer] = ()
        if layers:
            found = study(self.rows).layers
        file = _path(path, "run.svg")
        write_picture(file, self.rows, options, found)
        return file

    def _page(self, curves: Sequence[str] | None) -> str:
        from planarc.view.page.report import render_page
        from planarc.view.scene import make_scene

        shown = None if curves is None else tuple(self._scalars(curves))
        insight = study(self.rows, None if self._compiled is None else self._compiled.load())
        return render_page(self.rows, make_scene(self.rows), self._summary(), shown, insight)

    @telling_keywords
    def report(self, path: str | Path, curves: Sequence[str] | None = None) -> Path:
        """Write the page with the moving mechanism, curves and energy, which needs no network.

        `curves` names what the first figure shows. Gives the path. Raises UnknownName, and
        UsageError (V506) for an ending that is not `.html`.
        """
        return Page(self._page(curves)).save(with_ending(_path(path, "run.html"), ".html", ".htm"))

    def _summary(self) -> tuple[tuple[str, str], ...]:
        s = self.statistics
        states = ", ".join(self.states[-1].states) if self.states else ""
        return (
            ("model", self.name),
            ("states", states or "none"),
            ("solver", f"{s.solver}, {s.backend} back end"),
            ("steps", s.effort),
        )

    def _repr_html_(self) -> str:
        return self.animate()._repr_html_()


def _path(where: object, example: str) -> Path:
    if not isinstance(where, str | os.PathLike):
        raise usage_error("C202", f"a file has a path, not {where!r}", hint=f'give "{example}"')
    return Path(where)


def _several(names: str | Sequence[str]) -> tuple[str, ...]:
    """One name or several."""
    return (names,) if isinstance(names, str) else tuple(names)


class Page:
    """An HTML page; notebooks show it in place."""

    def __init__(self, text: str) -> None:
        self.text = text

    @telling_keywords
    def save(self, path: str | Path) -> Path:
        write_text(Path(path), self.text)
        return Path(path)

    def _repr_html_(self) -> str:
        import html

        inside = html.escape(self.text, quote=True)
        return (
            f'<iframe srcdoc="{inside}" style="width:100%;height:640px;border:0" '
            'sandbox="allow-scripts"></iframe>'
        )
