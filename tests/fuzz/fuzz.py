"""Mutated models must end in a diagnostic: soon, in bounded memory, without a traceback.

    python tests/fuzz/fuzz.py --count 20000 [--seed 1] [--workers 1] [--keep FOLDER]
    python tests/fuzz/fuzz.py --show 17 [--seed 1]        prints input 17
    python tests/fuzz/fuzz.py --extremes                  only the inputs of extremes.py

Each input is a model of the examples, the library or the tests with a few changes
(`mutations.py`). It goes through parse, flatten, lower and structure. The run fails when
one input takes more than 10 s of CPU or its process 1 GiB, dies, never ends, or makes
planarc raise anything but its own errors.
"""

from __future__ import annotations

import argparse
import os
import re
import resource
import sys
import tempfile
import traceback
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from random import Random
from time import process_time

sys.path.insert(0, str(Path(__file__).parent))

from extremes import EXTREMES
from mutations import mutate

from planarc.core.diagnostic import PlanarcError
from planarc.core.processes import Crew, Lost
from planarc.core.render import render_all
from planarc.core.resources import stdlib
from planarc.core.source import Source, decode
from planarc.flatten.library.library import Library
from planarc.ir import syntax
from planarc.parse.parser import parse_annotation, parse_file, parse_text
from planarc.request.request import MODELS, Reader, Target
from planarc.stages import flatten, to_dae, to_sorted

LIMIT = 10.0  # CPU seconds of an input
PATIENCE = 600.0  # wall seconds after which it is held to never end, on a busy machine too
MEMORY = 1024**3  # bytes of a process at its largest
ADDRESSES = 2 * MEMORY
CLASSES = 3  # classes of one file that are compiled

REPOSITORY = Path(__file__).parents[2]

#: The model of a case of tests/language, which ends where the expected answer begins.
_CASE = re.compile(rb"^\[case [^\n]*\]\n(.*?)(?=^\[)", re.S | re.M)


@dataclass(frozen=True)
class Outcome:
    """Codes of the first diagnostics, or the traceback of what should not have happened."""

    codes: tuple[str, ...] = ()
    trouble: str | None = None


@cache
def corpus() -> tuple[bytes, ...]:
    """Valid files, in a fixed order."""
    tests = REPOSITORY / "tests"
    friction = stdlib() / "Modelica" / "Mechanics" / "Rotational"
    folders = (REPOSITORY / "examples", tests / "cases", stdlib() / "PlanarMultiBody", friction)
    files = [f for folder in folders for f in sorted(folder.rglob("*.*mo")) if f.stem != "package"]
    models = [f.read_bytes() for f in files]
    for file in sorted((tests / "language").rglob("*.case")):
        models += _CASE.findall(file.read_bytes())
    return tuple(m for m in models if len(m) < 20_000)


def mutated(seed: int, number: int) -> bytes:
    rng = Random(f"{seed}/{number}")
    return mutate(rng.choice(corpus()), corpus(), rng)


# In a process of the crew -----------------------------------------------------------------------


@lru_cache(maxsize=1000)
def _read_library(path: Path) -> syntax.StoredDefinition:
    return parse_file(path)


def judge(data: bytes) -> Outcome:
    """What planarc says of a file."""
    codes: list[str] = []
    begin = process_time()
    try:
        for name in _classes(data, codes):
            _compile(*name, codes)
    except Exception:
        return Outcome(tuple(codes), traceback.format_exc(limit=-6))
    return Outcome(tuple(codes), _excess(process_time() - begin))


def _excess(seconds: float) -> str | None:
    largest = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    if seconds > LIMIT:
        return f"it took {seconds:.1f} s of CPU"
    return f"its process took {largest / 1024**2:.0f} MiB" if largest > MEMORY else None


def _classes(data: bytes, codes: list[str]) -> Iterator[tuple[Library, str]]:
    library = Library((stdlib(),), _read_library, parse_annotation)
    try:
        names = library.add_file(parse_text(Source("fuzz.pmo", decode(data))))
    except PlanarcError as error:
        _note(error, codes)
        return
    models = [name for name in names if _is_model(library, name)]
    inner = (f"{name}.{n}" for name in names[:CLASSES] for n in library.class_names(name))
    models += [name for name in inner if _is_model(library, name)]
    yield from ((library, name) for name in models[-CLASSES:])


def _is_model(library: Library, name: str) -> bool:
    definition = library.lookup(name)
    return definition is not None and definition.kind.value in MODELS and not definition.partial


def _compile(library: Library, name: str, codes: list[str]) -> None:
    try:
        to_sorted(to_dae(flatten(Target(library, name, Reader()))))
    except PlanarcError as error:
        _note(error, codes)


def _note(error: PlanarcError, codes: list[str]) -> None:
    if not error.diagnostics:
        raise AssertionError("an error without a diagnostic")
    text = render_all(error.diagnostics)
    if "Traceback" in text or "\0" in text or "\x1b" in text:
        raise AssertionError(f"a message that is none: {text!r}")
    codes += [d.code for d in error.diagnostics]


def _judge_number(job: tuple[int, int]) -> Outcome:
    return judge(mutated(*job))


def _judge_extreme(name: str) -> Outcome:
    return judge(EXTREMES[name])


# The run ----------------------------------------------------------------------------------------


def run(seed: int, numbers: Iterable[int], workers: int) -> Iterator[tuple[int, Outcome | Lost]]:
    crew: Crew[tuple[int, int], Outcome] = Crew(_judge_number, workers, PATIENCE, ADDRESSES)
    crew.add((seed, number) for number in numbers)
    for (_, number), outcome in crew:
        yield number, outcome


def run_extremes(names: Iterable[str], workers: int) -> Iterator[tuple[str, Outcome | Lost]]:
    crew: Crew[str, Outcome] = Crew(_judge_extreme, workers, PATIENCE, ADDRESSES)
    crew.add(names)
    yield from crew


def trouble_of(outcome: Outcome | Lost) -> str | None:
    """What is wrong with planarc, None if it answered as it should."""
    if isinstance(outcome, Lost):
        return f"the process {'died' if outcome is Lost.DIED else 'never ends'}"
    return outcome.trouble


def main() -> int:
    parser = argparse.ArgumentParser(description="Feed planarc with mutated models.")
    parser.add_argument("--count", type=int, default=20_000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="a folder for the inputs that make trouble")
    parser.add_argument("--show", type=int, metavar="NUMBER", help="print one input and stop")
    parser.add_argument("--extremes", action="store_true", help="only the extreme inputs")
    given = parser.parse_args()
    if given.show is not None:
        sys.stdout.buffer.write(mutated(given.seed, given.show))
        return 0
    with tempfile.TemporaryDirectory() as folder:
        os.environ["PLANARC_CACHE_DIR"] = folder
        if given.extremes:
            return _report(run_extremes(EXTREMES, given.workers), given.keep, given.seed)
        numbers = range(given.first, given.first + given.count)
        return _report(run(given.seed, numbers, given.workers), given.keep, given.seed)


def _report(
    outcomes: Iterable[tuple[int | str, Outcome | Lost]], keep: Path | None, seed: int
) -> int:
    codes: Counter[str] = Counter()
    count = bad = 0
    for number, outcome in outcomes:
        count += 1
        if count % 1000 == 0:
            print(f"{count} inputs, {bad} in trouble", flush=True)
        trouble = trouble_of(outcome)
        if trouble is not None:
            bad += 1
            print(f"-- {number}: {trouble}", flush=True)
            if keep is not None:
                keep.mkdir(parents=True, exist_ok=True)
                data = EXTREMES[number] if isinstance(number, str) else mutated(seed, number)
                (keep / f"{number}.pmo").write_bytes(data)
        elif isinstance(outcome, Outcome):
            codes.update(sorted(set(outcome.codes)) or ["clean"])
    print(f"{count} inputs, {bad} in trouble;", *(f"{c}:{n}" for c, n in codes.most_common()))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
