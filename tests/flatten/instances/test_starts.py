"""Which start values count as written by the user."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from planarc.ir import flat

Flatten = Callable[..., flat.FlatModel]

LIBRARY = """
package Lib
  model Joint
    parameter Real r_start = 0;
    Real phi(start=0);
    Real r(start=r_start);
    Real w;
  equation
    der(phi) = w;
    w = 1;
    der(r) = w;
  end Joint;
  model Pair
    parameter Real q_start = 0;
    Joint plain;
    Joint given(phi(start=1));
    Joint handed(r_start=q_start);
  end Pair;
end Lib;
"""


@pytest.fixture
def written(flatten_text: Flatten, tmp_path: Path) -> Callable[[str], set[str]]:
    (tmp_path / "Lib.mo").write_text(LIBRARY, encoding="utf-8")

    def run(text: str) -> set[str]:
        model = flatten_text(text, tmp_path)
        return {v.name for v in model.variables if v.attributes.start_written}

    return run


def test_a_librarys_own_default_is_not_written(written: Callable[[str], set[str]]) -> None:
    assert written("model T Lib.Joint j; end T;") == set()


def test_a_modifier_at_the_component_is_written(written: Callable[[str], set[str]]) -> None:
    assert written("model T Lib.Joint j(phi(start=1)); end T;") == {"j.phi"}


def test_the_same_value_as_the_default_is_still_written(
    written: Callable[[str], set[str]],
) -> None:
    assert written("model T Lib.Joint j(phi(start=0)); end T;") == {"j.phi"}


def test_a_modified_parameter_writes_what_it_starts(written: Callable[[str], set[str]]) -> None:
    assert written("model T Lib.Joint j(r_start=2); end T;") == {"j.r"}


def test_a_declaration_in_the_users_model_is_written(
    written: Callable[[str], set[str]],
) -> None:
    assert written("model T Real x(start=1); equation der(x) = 1; end T;") == {"x"}


def test_a_modifier_in_the_users_extends_is_written(written: Callable[[str], set[str]]) -> None:
    assert written("model T extends Lib.Joint(phi(start=3)); end T;") == {"phi"}


def test_inside_a_library_a_value_at_a_component_counts_but_a_default_does_not(
    written: Callable[[str], set[str]],
) -> None:
    assert written("model T Lib.Pair p; end T;") == {"p.given.phi"}


def test_a_value_handed_down_from_the_user_is_written(
    written: Callable[[str], set[str]],
) -> None:
    assert written("model T Lib.Pair p(q_start=2); end T;") == {"p.given.phi", "p.handed.r"}


def test_a_users_parameter_at_its_default_is_written(
    written: Callable[[str], set[str]],
) -> None:
    text = "model T parameter Real r0 = 2; Lib.Joint j(r_start=r0); end T;"
    assert written(text) == {"j.r"}
