"""A value that waits for a switch is told, unless the switch is on or its user turned it off."""

from __future__ import annotations

import pytest

import planarc

PART = """type Law = enumeration(Rigid, Soft);
model Part
  parameter Law law=Law.Rigid annotation(Evaluate=true);
  parameter Boolean deep=false annotation(Evaluate=true);
  parameter Real play=0;
  parameter Real c=1 annotation(Dialog(enable=law == Law.Soft));
  parameter Real d=1 annotation(Dialog(enable=deep and law == Law.Rigid));
  parameter Real e=1 annotation(Dialog(enable=play > 0));
  Real x=(if law == Law.Soft then c else 0) + (if deep then d else 0) + e*time;
end Part;
"""


def told(part: str) -> list[tuple[str, str | None]]:
    text = f"{PART}model M\n  {part}\nend M;\n"
    found = planarc.load(text, "M").warnings
    return [(w.message, w.hint) for w in found if w.code == "F338"]


def test_the_value_of_the_switch_is_named() -> None:
    ((message, hint),) = told("Part p(c=2);")
    assert message == "`p.c` has no effect: it counts only with `law == Law.Soft`"
    assert hint == "write `law=Law.Soft`, too, or leave `c` out"


def test_all_switches_are_named() -> None:
    ((message, hint),) = told("Part p[2](each d=2);")
    assert message.startswith("`p[1].d` has no effect: it counts only with `deep and law")
    assert hint == "give `deep`, `law`, too, or leave `d` out"


@pytest.mark.parametrize(
    "part",
    [
        "Part p;",
        "Part p(law=Law.Soft, c=2);",
        "Part p(law=Law.Rigid, c=2);",  # turned off by who knows of it
        "parameter Law law=Law.Rigid; Part p(law=law, c=2);",
        "Part p(e=2);",  # `play` may be set for each run
    ],
)
def test_what_counts_or_may_count_is_not_told(part: str) -> None:
    assert told(part) == []
