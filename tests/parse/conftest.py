"""What the tests of the parser share."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.core.source import Source
from planarc.ir import syntax
from planarc.parse.parser import parse_text


@pytest.fixture(autouse=True, scope="session")
def _cache_of_the_tests(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The user's cache is neither read nor written."""
    folder = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PLANARC_CACHE_DIR", str(folder))
        yield folder


@pytest.fixture
def parse() -> Callable[[str], syntax.StoredDefinition]:
    return lambda text: parse_text(Source("test.pmo", text))


@pytest.fixture
def errors_of() -> Callable[[str], tuple[Diagnostic, ...]]:
    def errors_of(text: str) -> tuple[Diagnostic, ...]:
        with pytest.raises(PlanarcError) as caught:
            parse_text(Source("test.pmo", text))
        return caught.value.diagnostics

    return errors_of
