"""From text to motion: what whole processes cost, beside the last release and OpenModelica.

    python tests/benchmarks/speed.py [--only WORD]

CPU seconds (user and system) of whole processes, the least of some runs; libraries are parsed
before, compiled models are not: each run has a text of its own. `chain` and `ladder` are the
families of `engine_bench.py`, all their variables written to `.csv`. Growth is that of compiling
alone, in processes that compiled a small member before. Examples run as they stand, each in a
process of its own, from a cache that holds syntax only; a row is the sum over a package. Those of
the Modelica Standard Library are measured where MODELICAPATH names it, and those that planarc
refuses are left out. The columns of OpenModelica 1.26.9, of the release before and of the goal were
written down once, with the memory of that release; `-` is what was not measured.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from time import process_time

sys.path.insert(0, str(Path(__file__).parent))

import bench
from bench import Usage, planarc
from engine_bench import STOP, four_bar, model

REPEATS = 3
STANDARD = ("Mechanics.Rotational", "Mechanics.Translational", "Blocks")
SPATIAL = tuple(f"Mechanics.MultiBody.Examples.{part}" for part in ("Loops", "Elementary"))


@dataclass(frozen=True)
class Row:
    """What is measured, what others took for it, and what it is to take."""

    name: str
    measure: Callable[[], tuple[float, float | None]]  # seconds or a ratio, and megabytes
    modelica: float | None = None
    release: float | None = None
    goal: float | None = None
    megabytes: float | None = None  # of the last release


def least(usages: list[Usage]) -> tuple[float, float]:
    return min(u.seconds for u in usages), min(u.megabytes for u in usages)


def simulated(family: str, n: int) -> tuple[float, float]:
    """A member of a family from text to `.csv`."""
    run = ("--stop", str(STOP[family]), "--intervals", "500", "--tolerance", "1e-6")
    options = (*run, "--no-report", "--output", "run.csv")

    def command(here: Path, size: int, remark: str) -> list[str]:
        file = here / "model.pmo"
        file.write_text(f"{model(family, size)}// {remark}\n", encoding="utf-8")
        return ["simulate", str(file), *options]

    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        planarc(command(here, 1, "before"), here / "cache", here)
        repeats = REPEATS if n <= 80 and family == "chain" else 1
        return least(
            [planarc(command(here, n, str(i)), here / "cache", here) for i in range(repeats)]
        )


def compiling(family: str, n: int) -> float:
    """CPU seconds to compile a member, in this process, that compiled a small one before."""
    from planarc.compiler import compile_model
    from planarc.request.request import Request

    compile_model(Request(text=model(family, 2)))
    begin = process_time()
    compile_model(Request(text=model(family, n)))
    return process_time() - begin


def growth(family: str, n: int) -> tuple[float, None]:
    """How many times longer twice as many parts take to compile."""

    def seconds(size: int) -> float:
        with tempfile.TemporaryDirectory() as folder:
            command = [sys.executable, __file__, "--compile", family, str(size)]
            env = bench.environment(OPENBLAS_NUM_THREADS="1", PLANARC_CACHE_DIR=folder)
            done = subprocess.run(command, check=True, capture_output=True, text=True, env=env)
            return float(done.stdout)

    small, large = (min(seconds(size) for _ in range(REPEATS)) for size in (n, 2 * n))
    return large / small, None


def examples(*packages: str) -> tuple[float, float]:
    """The examples of packages, each in a process of its own, in all."""
    from planarc.catalog.examples import find_examples

    used: list[Usage] = []
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        for example in find_examples(packages):
            command = ["simulate", example.name, "--no-report", "--output", "run.csv"]
            try:
                planarc(command, here / "cache", here)
            except RuntimeError:
                continue
            for kind in ("models", "slopes"):
                shutil.rmtree(here / "cache" / "planarc" / kind, ignore_errors=True)
            used.append(planarc(command, here / "cache", here))
    return sum(u.seconds for u in used), max(u.megabytes for u in used)


def edited() -> tuple[float, float]:
    """The four-bar, a body more each time."""
    text = bench.MODEL.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        here, used = Path(folder), []
        for i in range(REPEATS + 2):
            text = with_another_body(text, i)
            (here / "four_bar.pmo").write_text(text, encoding="utf-8")
            used.append(planarc(four_bar(here / "four_bar.pmo"), here / "cache", here))
        return least(used[1:])


def with_another_body(text: str, i: int) -> str:
    head, _, equations = text.partition("\nequation\n")
    body = f"\n  Body added{i}(m=0.1, I=0.01);\nequation\n"
    return f"{head}{body}  connect(added{i}.frame_a, crank.frame_b);\n{equations}"


def unchanged() -> tuple[float, float]:
    return least(bench.warm("--no-report"))


def standard(*packages: str) -> tuple[float, float]:
    return examples(*(f"Modelica.{package}" for package in packages))


def rows() -> Iterator[Row]:
    yield Row("four-bar, unchanged", unchanged, None, 0.24, 0.15, 94.5)
    yield Row("four-bar, a body more", edited, None, 0.36, 0.2, 123)
    yield Row("chain 80, 2 s", lambda: simulated("chain", 80), 10.7, 2.7, 1.0, 162)
    yield Row("ladder 20, 10 s", lambda: simulated("ladder", 20), 11.8, 2.0, 0.8, 161)
    yield Row("chain 320, 2 s", lambda: simulated("chain", 320), None, 14.7, 4.0, 420)
    yield Row("ladder 80, 10 s", lambda: simulated("ladder", 80), None, 15.4, 5.0, 276)
    yield Row("growth of compile, chain 80 to 160", lambda: growth("chain", 80), 1.8, 2.2, 1.5)
    yield Row("our examples", lambda: examples("PlanarMultiBody.Examples"), None, 15.9, 5.3, 144)
    if os.environ.get("MODELICAPATH"):
        for package in STANDARD:
            name = f"{package}.Examples"
            yield Row(f"MSL {name}", lambda name=name: standard(name))  # type: ignore[misc]
        for name in SPATIAL:
            yield Row(f"MSL {name}", lambda name=name: standard(name))  # type: ignore[misc]


def table(chosen: list[Row]) -> Iterator[str]:
    """The lines of the table, each as soon as it is measured."""
    heads = ("OpenModelica", "release", "goal", "now", "now/goal", "MB", "MB before")
    yield f"{'':44}" + "".join(f"{h:>13}" for h in heads)
    for row in chosen:
        value, megabytes = row.measure()
        ratio = None if row.goal is None else value / row.goal
        numbers = (row.modelica, row.release, row.goal, value, ratio, megabytes, row.megabytes)
        cells = (f"{'-' if n is None else f'{n:.3g}':>13}" for n in numbers)
        yield f"{row.name:44}{''.join(cells)}"


def main() -> None:
    parser = argparse.ArgumentParser(description="Measure planarc from text to motion.")
    parser.add_argument("--only", default="", metavar="WORD", help="rows whose name holds WORD")
    parser.add_argument("--compile", nargs=2, metavar=("FAMILY", "N"), help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.compile:
        print(compiling(asked.compile[0], int(asked.compile[1])))
        return
    for line in table([row for row in rows() if asked.only in row.name]):
        print(line, flush=True)


if __name__ == "__main__":
    main()
