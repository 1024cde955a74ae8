"""What is looked for in the package itself, and stands elsewhere."""

from __future__ import annotations

import pytest

import planarc


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("simulate", 'write `planarc.load("model.pmo").simulate(...)`'),
        ("run", 'write `planarc.load("model.pmo").simulate(...)`'),
        ("to_csv", 'write `planarc.load("model.pmo").simulate().to_csv(...)`'),
        ("read_csv", "did you mean `read`?"),
        ("compare", "`planarc compare ...`"),
        ("sweeps", "did you mean `sweep`?"),
        ("open", "did you mean `load`?"),
    ],
)
def test_what_stands_elsewhere_is_named(name: str, told: str) -> None:
    with pytest.raises(AttributeError) as raised:
        getattr(planarc, name)
    assert told in str(raised.value)


def test_what_nothing_is_near_to_is_only_refused() -> None:
    with pytest.raises(AttributeError, match=r"no attribute `qqqqq`$"):
        planarc.qqqqq  # noqa: B018
