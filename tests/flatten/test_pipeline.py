"""The whole stage: as deep and as long as models are, and the same text each time."""

from __future__ import annotations

import gc
import subprocess
import sys
from collections.abc import Callable

import pytest

from planarc.core.diagnostic import PlanarcError
from planarc.flatten.tree.nodes import Element, Leaf
from planarc.ir import flat

Flatten = Callable[..., flat.FlatModel]

PIN = "connector Pin Real v; flow Real i; end Pin;"
RESISTOR = PIN + (
    "model R parameter Real R = 1; Pin p; Pin n; equation p.v - n.v = R*p.i; p.i + n.i = 0; end R;"
)


def test_deep_classes_end_in_a_message_or_a_model(flatten_text: Flatten) -> None:
    depth = 90
    text = "model M0 Real x = time; end M0;"
    for i in range(1, depth):
        text += f"model M{i} M{i - 1} m; end M{i};"
    assert len(flatten_text(text).variables) == 1
    for i in range(depth, 200):
        text += f"model M{i} M{i - 1} m; end M{i};"
    with pytest.raises(PlanarcError) as caught:
        flatten_text(text)
    assert {d.code for d in caught.value.diagnostics} == {"F251"}


def chain(links: int) -> str:
    lines = [RESISTOR, "model T", f"R r[{links}];", "equation"]
    lines += [f"connect(r[{k}].n, r[{k + 1}].p);" for k in range(1, links)]
    return "\n".join([*lines, "end T;"])


def test_the_cost_grows_with_the_number_of_components(
    flatten_text: Flatten, steps_of: Callable[[Callable[[], object]], int]
) -> None:
    def steps(links: int) -> int:
        text = chain(links)
        return steps_of(lambda: flatten_text(text))

    steps(2)
    assert steps(400) < 2.2 * steps(200)


PROGRAM = """
import sys
from pathlib import Path
from planarc.core.resources import stdlib
from planarc.core.source import Source
from planarc.flatten.library.library import Library
from planarc.flatten.pipeline import flatten
from planarc.ir.text.flat import print_model
from planarc.parse.parser import parse_annotation, parse_file, parse_text
library = Library([stdlib()], parse_file, parse_annotation)
names = library.add_file(parse_text(Source("t.mo", sys.stdin.read())))
sys.stdout.write(print_model(flatten(library, names[-1])))
"""


def test_the_result_does_not_depend_on_the_hash_seed() -> None:
    outputs = set()
    for seed in ("0", "1"):
        done = subprocess.run(
            [sys.executable, "-c", PROGRAM],
            input=chain(5),
            capture_output=True,
            text=True,
            check=True,
            env={"PYTHONHASHSEED": seed, "PYTHONDONTWRITEBYTECODE": "1"},
        )
        outputs.add(done.stdout)
    assert len(outputs) == 1


def test_components_are_gone_with_the_run(flatten_text: Flatten) -> None:
    """Nothing of them waits for Python's search for cycles, however many they are."""

    def left(links: int) -> int:
        gc.collect()
        flatten_text(chain(links))
        return sum(isinstance(o, Element | Leaf) for o in gc.get_objects())

    gc.disable()
    try:
        assert left(40) == left(4)
    finally:
        gc.enable()
