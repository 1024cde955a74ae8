"""Parameters that are arrays: what a function gives them is computed once for all entries."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from planarc import stages
from planarc.core.source import Span
from planarc.lower import functions
from planarc.lower.scope import Scope
from planarc.lower.values import Value
from planarc.request.request import Request, open_target

TABLE = """model M
  Modelica.Blocks.Sources.CombiTimeTable t(table=[{rows}]);
end M;
"""


@pytest.mark.parametrize("rows", [5, 20])
def test_a_table_calls_as_many_functions_however_many_rows_it_has(
    rows: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[str] = []
    inline = functions.inline

    def counting(
        scope: Scope, name: str, arguments: Sequence[Value], span: Span
    ) -> tuple[Value, ...]:
        made.append(name)
        return inline(scope, name, arguments, span)

    monkeypatch.setattr("planarc.lower.pipeline.inline", counting)
    text = TABLE.format(rows="; ".join(f"{i}, {i % 7}" for i in range(rows)))
    stages.to_dae(stages.flatten(open_target(Request(text=text))))
    assert sum(name.endswith("Internal.slopes") for name in made) == 1
