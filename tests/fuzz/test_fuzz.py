"""A small sample of the fuzz run; `python tests/fuzz/fuzz.py --count 20000` is the whole one."""

from __future__ import annotations

import resource
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

import fuzz
from extremes import EXTREMES

from planarc.core.processes import Lost, cores
from planarc.flatten.instances import instantiate

SAMPLE = 200


@pytest.fixture(autouse=True)
def _own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PLANARC_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(fuzz, "LIMIT", 3600.0)  # CPU seconds differ from machine to machine, too
    monkeypatch.setattr(fuzz, "PATIENCE", 3600.0)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024  # of tests before these
    monkeypatch.setattr(fuzz, "MEMORY", fuzz.MEMORY + before)


def test_the_files_that_are_mutated_are_mostly_right() -> None:
    """Cases of refusals are among them."""
    models = fuzz.corpus()
    outcomes = [fuzz.judge(model) for model in models[::10]]
    assert len(models) > 300
    assert [o.trouble for o in outcomes if o.trouble] == []
    assert sum(not o.codes for o in outcomes) > 0.4 * len(outcomes)


def test_mutated_models_end_in_a_diagnostic() -> None:
    troubles = {}
    kinds = set()
    for number, outcome in fuzz.run(seed=2, numbers=range(SAMPLE), workers=cores()):
        trouble = fuzz.trouble_of(outcome)
        if trouble is not None:
            troubles[number] = trouble
        elif isinstance(outcome, fuzz.Outcome):
            kinds.update(code[0] for code in outcome.codes)
    assert troubles == {}
    assert kinds >= {"P", "F", "S"}  # the sample reaches all of these stages


@pytest.mark.parametrize(("limit", "told"), [("LIMIT", "s of CPU"), ("MEMORY", "MiB")])
def test_an_input_beyond_a_limit_is_trouble(
    limit: str, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = b"model M\n  Real x = time;\nend M;"
    assert fuzz.judge(model).trouble is None
    monkeypatch.setattr(fuzz, limit, 0)
    trouble = fuzz.judge(model).trouble
    assert trouble is not None
    assert told in trouble


def test_the_same_number_gives_the_same_input() -> None:
    assert fuzz.mutated(3, 17) == fuzz.mutated(3, 17)
    assert len({fuzz.mutated(3, number) for number in range(50)}) > 40


#: Left to `fuzz.py --extremes`: these take many seconds.
SLOW = {
    *("tree of components", "huge step", "nested for", "huge identity", "chain of bases"),
    *("endless while", "many errors", "long sum", "dots"),
}

#: Extreme inputs that are right: they compile.
RIGHT = {
    *("empty", "long sum in bounds", "nested classes in bounds", "deep annotation", "powers"),
    *("extends its inner class", "many components"),
    *("mod by zero", "root of a negative", "infinite exponent"),  # found when it runs
    "huge power of a matrix",  # its numbers are infinite
}


def test_extreme_inputs_end_in_a_diagnostic(monkeypatch: pytest.MonkeyPatch) -> None:
    """With a tenth of the components that are allowed, which takes a tenth of the time."""
    monkeypatch.setattr(instantiate, "MAX_COMPONENTS", instantiate.MAX_COMPONENTS // 10)
    names = [name for name in EXTREMES if name not in SLOW]
    outcomes = dict(fuzz.run_extremes(names, cores()))
    assert set(outcomes) == set(names)
    assert {n: t for n, o in outcomes.items() if (t := fuzz.trouble_of(o)) is not None} == {}
    silent = {n for n, o in outcomes.items() if not isinstance(o, Lost) and not o.codes}
    assert silent <= RIGHT
