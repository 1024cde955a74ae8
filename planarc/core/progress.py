"""The progress of a long work, drawn by rich on standard error: on a terminal or in a notebook.

Elsewhere only the last state is written, by those who ask to keep it. No thread draws: the
processes of a study are copies of this one.
"""

from __future__ import annotations

from importlib import import_module
from time import monotonic
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.progress import Progress as Bars

PATIENCE = 1.0  # s before the first drawing
PERIOD = 0.1  # s between two


class Progress:
    """A context, in which `show` tells how far the work is.

    `keep`: the last state stays to be read; else what was drawn goes away at the end.
    """

    def __init__(self, keep: bool = False) -> None:
        self._keep = keep
        self._due = monotonic() + (0.0 if keep else PATIENCE)
        self._bars: Bars | None = None
        self._notebook: Any = None  # what it shows

    def __enter__(self) -> Progress:
        return self

    def show(self, text: str, done: int | None = None, total: int | None = None) -> None:
        """Draw a text, and a bar where the total is known, unless the last one is quite new."""
        now = monotonic()
        if now < self._due and not (self._keep and done == total):
            return
        self._due = now + PERIOD
        if self._bars is None:
            self._open(with_bar=total is not None)
        assert self._bars is not None
        self._bars.update(self._bars.task_ids[0], description=text, completed=done, total=total)
        self._draw()

    def __exit__(self, *_: object) -> None:
        if self._bars is None:
            return
        if self._notebook is None:
            self._bars.stop()
        elif not self._keep:
            self._notebook.update({"text/plain": ""}, raw=True)

    def _open(self, with_bar: bool) -> None:
        from rich import progress
        from rich.console import Console

        columns: list[progress.ProgressColumn] = [progress.TextColumn("{task.description}")]
        columns[0].markup = False  # type: ignore[attr-defined]
        if with_bar:
            remaining = progress.TimeRemainingColumn(elapsed_when_finished=True)
            columns = [progress.BarColumn(), progress.MofNCompleteColumn(), remaining, *columns]
        console = Console(stderr=True)
        self._bars = progress.Progress(
            *columns,
            console=console,
            auto_refresh=False,
            transient=not self._keep,
            redirect_stdout=False,
            redirect_stderr=False,
        )
        self._bars.add_task("", total=None)
        if console.is_jupyter:
            shown = import_module("IPython.display")
            self._notebook = shown.display({"text/plain": ""}, raw=True, display_id=True)
        else:
            self._bars.start()

    def _draw(self) -> None:
        """rich itself needs ipywidgets in a notebook; every notebook can show a changing text."""
        assert self._bars is not None
        if self._notebook is None:
            self._bars.refresh()
            return
        from io import StringIO

        from rich.console import Console

        text = StringIO()
        Console(file=text, force_jupyter=False, width=80).print(self._bars)
        self._notebook.update({"text/plain": text.getvalue().rstrip()}, raw=True)
