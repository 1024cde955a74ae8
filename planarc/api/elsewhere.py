"""Where that stands which a user looks for in the package `planarc` itself.

Example: `planarc.simulate` is a method of a model: `planarc.load("model.pmo").simulate(...)`.
"""

from __future__ import annotations

from collections.abc import Sequence

from planarc.core.nearest import did_you_mean, synonyms

_LOAD = 'planarc.load("model.pmo")'

#: What is no name of Python at all, and what to write instead.
_OTHERWISE = {
    "check": f"`{_LOAD}` raises what is wrong; `planarc check FILE` stands on the command line",
} | dict.fromkeys(
    ("compare", "doc", "equations", "explain", "flatten", "fmt", "gallery", "serve", "view"),
    "write it on the command line: `planarc {} ...`",
)


def where(name: str, known: Sequence[str]) -> str:
    """A clause that says what to write for `planarc.NAME`; "" where nothing is near."""
    from planarc.api.model import Model
    from planarc.api.result import Result

    homes = ((Model, _LOAD), (Result, f"{_LOAD}.simulate()"))
    names = (*dir(Model), *dir(Result), *known, *_OTHERWISE)
    for meant in (*synonyms(name, names), name):
        if meant in _OTHERWISE:
            return f": {_OTHERWISE[meant].format(meant)}"
        if meant in known:
            return f": did you mean `{meant}`?"
        for home, how in homes:
            if hasattr(home, meant):
                call = "(...)" if callable(getattr(home, meant)) else ""
                return f": write `{how}.{meant}{call}`"
    hint = did_you_mean(name, (*known, *(n for n in dir(Model) if n[0] != "_")))
    return f": {hint}" if hint else ""
