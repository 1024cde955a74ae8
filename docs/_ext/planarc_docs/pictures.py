"""Pictures of mechanisms and curves of their runs, drawn while the site is built.

    ```{motion} four_bar.pmo
    :trace: couplerBody
    :to: 2.3
    The coupler point draws a closed curve.
    ```

    ```{curves} four_bar.pmo
    :show: revA.phi revD.phi
    ```

A model is a file of the page, one of `examples/` or of the handbook, or a class of a library. A
picture is drawn again when its model, its options or planarc changed.
"""

from __future__ import annotations

import hashlib
import tempfile
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.util.docutils import SphinxDirective

from planarc.catalog.handbook.shown import MODELS
from planarc_docs.blocks import write_files

if TYPE_CHECKING:
    from planarc import Result

ROOT = Path(__file__).parents[3]
MADE = "made"
_TIMES = {"from": "begin", "to": "end", "at": "at", "speed": "speed"}


class _Picture(SphinxDirective):
    """A picture of a run, with the text below it."""

    required_arguments = 1
    optional_arguments = 1
    has_content = True
    option_spec: ClassVar[dict[str, Any]] = {
        "set": directives.unchanged,
        "to": float,
        "width": int,
        "alt": directives.unchanged,
    }

    def run(self) -> list[nodes.Node]:
        figure = nodes.figure("", *self._pictures(), align="center")
        if self.content:
            figure += nodes.caption("", "", *self.parse_inline(" ".join(self.content))[0])
        self.set_source_info(figure)
        return [figure]

    def _pictures(self) -> list[nodes.Node]:
        page = Path(self.env.doc2path(self.env.docname))
        with tempfile.TemporaryDirectory() as scratch:
            own = write_files(page.read_text("utf-8"), Path(scratch))
            model = own.get(self.arguments[0]) or find_model(self.arguments[0])
            text = model.read_text("utf-8") if isinstance(model, Path) else model
            name = _name(type(self).__name__, text, *self.arguments[1:], str(self.options))
            path = Path(self.env.srcdir) / MADE / name
            if not path.exists() or path.stat().st_mtime < newest_source():
                path.parent.mkdir(exist_ok=True)
                result = run_model(model, self.arguments[1:], self.options)
                self.draw(path, result)
        alt = self.options.get("alt") or f"{Path(self.arguments[0]).stem}, drawn by planarc"
        return [nodes.image(uri=f"/{MADE}/{name}", alt=alt)]

    def draw(self, path: Path, result: Result) -> None:
        raise NotImplementedError


class Motion(_Picture):
    """The moving mechanism, or one instant of it with `:at:`."""

    option_spec: ClassVar[dict[str, Any]] = {
        **_Picture.option_spec,
        "from": float,
        "at": float,
        "speed": float,
        "trace": directives.unchanged,
        "layer": directives.unchanged,
    }

    def draw(self, path: Path, result: Result) -> None:
        draw_motion(path, result, self.options)


class Curves(_Picture):
    """Variables over time, or over `:x:`."""

    option_spec: ClassVar[dict[str, Any]] = {
        **_Picture.option_spec,
        "show": directives.unchanged_required,
        "x": directives.unchanged,
    }

    def draw(self, path: Path, result: Result) -> None:
        import matplotlib

        matplotlib.use("Agg")
        matplotlib.rcParams["svg.hashsalt"] = "planarc"
        names = self.options["show"].split()
        axes = result.plot(*names, x=self.options.get("x", "time"))
        figure = getattr(axes, "figure", None) or axes[0].figure
        figure.savefig(path, metadata={"Date": None})
        matplotlib.pyplot.close(figure)


def draw_motion(path: Path, result: Result, options: dict[str, Any]) -> None:
    """Draw a run with the options of the directive."""
    times = {_TIMES[k]: v for k, v in options.items() if k in _TIMES}
    result.animate(
        path,
        width=options.get("width", 480),
        traces=options.get("trace", "").split(),
        layers=options.get("layer", "").split(),
        **times,
    )


def find_model(name: str) -> Path | str:
    """A file of the repository, or the name of a class."""
    for folder in (ROOT, MODELS):
        if (folder / name).is_file():
            return folder / name
    return name


def run_model(model: Path | str, classes: list[str], options: dict[str, Any]) -> Result:
    """Run a model with the values of `:set:`, until `:to:` where that is given."""
    import planarc

    given = dict(part.split("=", 1) for part in options.get("set", "").split())
    values = {name: float(text) for name, text in given.items()}
    starts = {n.removesuffix(".start"): v for n, v in values.items() if n.endswith(".start")}
    parameters = {n: v for n, v in values.items() if not n.endswith(".start")}
    loaded = planarc.load(model, classes[0] if classes else None)
    return loaded.simulate(options.get("to"), parameters=parameters, start=starts)


@cache
def newest_source() -> float:
    """When planarc, its libraries or this extension changed last."""
    folders = (ROOT / "planarc", ROOT / "stdlib", Path(__file__).parent)
    files = (f for folder in folders for f in folder.rglob("*") if f.suffix != ".pyc")
    return max(file.stat().st_mtime for file in files if file.is_file())


def _name(kind: str, *parts: str) -> str:
    digest = hashlib.sha256("\0".join(parts).encode()).hexdigest()[:16]
    return f"{kind.lower()}-{digest}.svg"
