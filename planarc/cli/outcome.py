"""What a command found out, with the keys of `--json`."""

from __future__ import annotations

import json
from collections.abc import Mapping

from msgspec import field

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic
from planarc.core.render import in_order, to_json


class Outcome(Data):
    """The findings of a command; None where it stopped before it knew."""

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
        equations = self.equations and dict(zip(("before", "after"), self.equations, strict=True))
        return json.dumps(
            {
                "ok": self.ok,
                "model": self.model,
                "equations": equations,
                "states": None if self.states is None else list(self.states),
                "solver": self.solver,
                "backend": self.backend,
                "seconds": {phase: round(s, 6) for phase, s in self.seconds.items()},
                "steps": self.steps,
                "events": self.events,
                "rows": self.rows,
                "output": self.output,
                "report": self.report,
                "mechanism": None if self.mechanism is None else dict(self.mechanism),
                "diagnostics": [to_json(d) for d in in_order(self.diagnostics)],
            },
        )
