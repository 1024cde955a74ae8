"""All codes of diagnostics are listed, raised, and each means one thing."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import planarc
from planarc.catalog.explanations import STAGES, Code

HOUSE = Path(planarc.__file__).parent
_CODE = re.compile(r"[A-Z]\d{3}")
#: Where the codes of a stage may be made: what a code means belongs to one stage.
ROOMS = {
    "C": {"editor", "api", "catalog", "cli", "core", "export", "live", "request", "study"},
    "P": {"parse"},
    "F": {"flatten"},
    "L": {"lower"},
    "S": {"structure", "probe", "insight"},
    "G": {"codegen"},
    "R": {"solve", "probe", "api", "insight", "export"},  # exported models run, too
    "V": {"api", "catalog", "view"},
    "X": {"catalog", "core"},
}


def literals() -> Iterator[tuple[str, str]]:
    """The texts in planarc's modules that are a code, each with its room."""
    for file in HOUSE.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_bytes())):
            text = node.value if isinstance(node, ast.Constant) else None
            if isinstance(text, str) and _CODE.fullmatch(text):
                yield text, file.relative_to(HOUSE).parts[0]


def test_every_code_is_listed_and_every_listed_one_is_used() -> None:
    assert {code for code, _ in literals()} == set(Code.__members__)


def test_a_code_is_made_in_the_rooms_of_its_stage() -> None:
    """The language server makes its own, and reads those of all stages."""
    made = ((c, room) for c, room in literals() if room != "editor" or c[0] == "C")
    assert [(c, room) for c, room in made if room not in ROOMS[c[0]]] == []


def test_codes_stand_in_the_order_of_stages_and_numbers() -> None:
    order = list(STAGES)
    listed = list(Code.__members__)
    assert listed == sorted(listed, key=lambda code: (order.index(code[0]), code))


def test_every_line_is_one_phrase_as_in_messages() -> None:
    for code in Code:
        assert code.value == code.value.strip().rstrip("."), code
        assert not code.value[0].isupper(), code
        assert len(code.name + code.value) < 90, code
