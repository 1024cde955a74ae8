"""The findings of a command, with the keys of `--json`."""

from __future__ import annotations

from collections.abc import Mapping

from msgspec import Struct, field
from msgspec.structs import asdict

from planarc.core.diagnostic import Diagnostic


class Outcome(Struct):
    """The findings of a command so far; None where it stopped before it knew."""

    ok: bool
    model: str | None = None
    equations: tuple[int, int] | None = None  # before and after reduction
    states: tuple[str, ...] | None = None
    solver: str | None = None
    backend: str | None = None
    seconds: Mapping[str, float] = field(default_factory=dict)  # by phase, and `total`
    steps: int | None = None
    events: int | None = None
    rows: int | None = None
    output: str | None = None
    report: str | None = None
    mechanism: Mapping[str, int | None] | None = None  # what `check` counts
    diagnostics: tuple[Diagnostic, ...] = ()

    def as_json(self) -> str:
        """One JSON object, on one line."""
        import json

        from planarc.core.render import in_order, to_json

        equations = self.equations and dict(zip(("before", "after"), self.equations, strict=True))
        told = {
            "equations": equations,
            "seconds": {phase: round(s, 6) for phase, s in self.seconds.items()},
            "diagnostics": [to_json(d) for d in in_order(self.diagnostics)],
        }
        return json.dumps({name: told.get(name, value) for name, value in asdict(self).items()})
