"""The engine against its bars: two families of mechanisms, and where the time goes.

    python tests/benchmarks/engine_bench.py [--only WORD] [--families]

`chain` is N rods of 1 m on revolute joints, a body at each tip, released horizontally; it
runs for 2 s. `ladder` is the N-four-bar of tests/cases/h1_nfourbar_N2, 10 s. Both are written
with array components and connect loops; tolerance 1e-6, 501 rows. Times are CPU seconds of
fresh processes with empty caches, where nothing else is said. `--families` prints, for each
N, the phases of the compilation and the work of the integrator, so that the next bottleneck
is seen. The growth of a step is that of a second run: the first one imports what it needs.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from time import process_time
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

import bench
from bench import Bar, planarc, table

LADDER = Path(__file__).parent.parent / "cases" / "h1_nfourbar_N2" / "n_four_bar.pmo"
SIZES = {"chain": (5, 10, 20, 40, 80, 160), "ladder": (1, 2, 5, 10, 20, 40)}
STOP = {"chain": 2.0, "ladder": 10.0}
REPEATS = 3

_CHAIN = """model Chain "N rods with bodies at their tips, released horizontally"
  import PlanarMultiBody.Joints.Revolute;
  import PlanarMultiBody.Parts.FixedTranslation;
  import PlanarMultiBody.Parts.Body;
  parameter Integer N = {n};
  inner PlanarMultiBody.World world;
  Revolute rev[N](phi(each start=0, each fixed=true), w(each start=0, each fixed=true));
  FixedTranslation rod[N](each r={{1, 0}});
  Body tip[N](each m=1, each I=0.1);
equation
  connect(world.frame_b, rev[1].frame_a);
  for i in 1:N loop
    connect(rev[i].frame_b, rod[i].frame_a);
    connect(rod[i].frame_b, tip[i].frame_a);
  end for;
  for i in 1:N - 1 loop
    connect(rod[i].frame_b, rev[i + 1].frame_a);
  end for;
end Chain;
"""


def model(family: str, n: int) -> str:
    """The text of a member of a family."""
    if family == "chain":
        return _CHAIN.format(n=n)
    return LADDER.read_text(encoding="utf-8").replace("N(min=1)=2", f"N(min=1)={n}")


# Measured in a process of its own -----------------------------------------------------------


def compile_and_run(family: str, n: int) -> dict[str, Any]:
    """CPU seconds by phase, and the work of the integrator."""
    from planarc.compiler import compile_model, run
    from planarc.core.clock import Clock
    from planarc.core.options import RunOptions
    from planarc.request.request import Request

    clock = Clock()
    begin = process_time()
    compiled = compile_model(Request(text=model(family, n)), clock=clock)
    compiling = process_time() - begin
    options = RunOptions(stop=STOP[family], intervals=500, tolerance=1e-6)
    runs = []
    for _ in range(1 + REPEATS):
        begin = process_time()
        result = run(compiled, options)
        runs.append(process_time() - begin)
        if result.ended is not None or len(result.time) != 501:
            raise RuntimeError(f"{family} {n} ended early: {result.ended}")
    work = result.statistics
    return {
        "compile": compiling,
        "phases": clock.seconds,
        "simulate": runs[0],
        "again": statistics.median(runs[1:]),
        "solver": work.solver,
        "states": compiled.program.state_count,
        "steps": work.steps,
        "rhs": work.rhs_calls,
        "jacobians": work.jacobians,
    }


@cache
def member(family: str, n: int) -> dict[str, Any]:
    """`compile_and_run` with empty caches; the quickest of some processes."""
    found = []
    for _ in range(REPEATS if n <= 40 else 1):
        with tempfile.TemporaryDirectory() as folder:
            command = [sys.executable, __file__, "--task", family, str(n)]
            # As in the command: OpenBLAS's threads wait by spinning, which counts as CPU time.
            env = bench.environment(OPENBLAS_NUM_THREADS="1", PLANARC_CACHE_DIR=folder)
            done = subprocess.run(command, check=True, capture_output=True, text=True, env=env)
            found.append(json.loads(done.stdout))
    best: dict[str, Any] = min(found, key=lambda f: f["compile"])
    return best


@cache
def process(family: str, n: int) -> bench.Usage:
    """From the start of `planarc simulate` to its result, with empty caches."""
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        file = here / "model.pmo"
        file.write_text(model(family, n), encoding="utf-8")
        run = ("--stop", str(STOP[family]), "--intervals", "500", "--tolerance", "1e-6")
        return planarc(
            ["simulate", str(file), *run, "--no-report", "--output", "run.mat"],
            here / "cache",
            here,
        )


def compile_growth(family: str, n: int) -> float:
    return float(member(family, 2 * n)["compile"]) / float(member(family, n)["compile"])


def step_cost(family: str, n: int) -> float:
    found = member(family, n)
    return float(found["again"]) / int(found["steps"])


# Four-bar -----------------------------------------------------------------------------------


def lsoda() -> float:
    """CPU seconds of one more run of the four-bar, NumPy back end."""
    return _runs_again("numpy", "lsoda", lambda i: {"starts": {"revA.phi": 1.0 + 1e-4 * i}}, 5)


def hand_written() -> float:
    """CPU seconds of the same run with one equation, written by hand, on the same CVODE: what
    the integrator itself takes here. The bar of the row above is 2.27 times what that took
    on the machine that it was set for."""
    import hand_written as by_hand

    return by_hand.seconds(bench._starts, REPEATS)


def parameters() -> float:
    """CPU seconds of a run with another parameter, of 100 in one process."""
    return _runs_again("native", "auto", lambda i: {"values": {"crankBody.m": 1.0 + 0.01 * i}}, 100)


def _runs_again(backend: str, solver: str, change: Any, count: int) -> float:
    from planarc.compiler import compile_model, run
    from planarc.core.options import Backend, RunOptions, Solver
    from planarc.request.request import Request

    compiled = compile_model(Request(bench.MODEL), Backend(backend))
    times = []
    for i in range(count + 1):
        options = RunOptions(
            stop=10.0,
            intervals=500,
            tolerance=1e-6,
            backend=Backend(backend),
            solver=Solver(solver),
            **change(i),
        )
        begin = process_time()
        result = run(compiled, options)
        times.append(process_time() - begin)
        if result.ended is not None:
            raise RuntimeError(f"the run ended early: {result.ended}")
        if i == 0:
            bench.sleep(0.3)
    return statistics.median(times[1:])


def _commented(text: str, i: int) -> str:
    return f"{text}\n// edited {i} times\n"


def _with_another_mass(text: str, i: int) -> str:
    mass = "crankBody(m=1,"
    assert mass in text
    return text.replace(mass, f"crankBody(m={1 + 0.01 * i},")


def _with_another_body(text: str, i: int) -> str:
    """One more than before."""
    first, second = text.split("\nequation\n")
    names = [f"added{k}" for k in range(i + 1)]
    declared = "".join(f"  Body {n}(m=0.1, I=0.01);\n" for n in names)
    connected = "".join(f"  connect({n}.frame_a, crank.frame_b);\n" for n in names)
    return f"{first}\n{declared}\nequation\n{connected}{second}"


def edited(change: Callable[[str, int], str]) -> float:
    """CPU seconds of `planarc simulate` after the model's text was changed."""
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        file, text = here / "four_bar.pmo", bench.MODEL.read_text(encoding="utf-8")
        found = []
        for i in range(1 + REPEATS):
            file.write_text(change(text, i), encoding="utf-8")
            found.append(planarc(four_bar(file), here / "cache", here).seconds)
        return statistics.median(found[1:])


def unchanged() -> float:
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        found = [planarc(four_bar(bench.MODEL), here / "cache", here) for _ in range(1 + REPEATS)]
        return statistics.median(u.seconds for u in found[1:])


def four_bar(file: Path) -> list[str]:
    return ["simulate", str(file), *bench.RUN, "--no-report"]


# The tables -----------------------------------------------------------------------------------


def bars() -> Iterator[Bar]:
    yield Bar("four-bar again, native", "ms", 5.0, lambda: 1e3 * bench.again("native"))
    yield Bar("four-bar, hand-written equation", "ms", None, lambda: 1e3 * hand_written())
    yield Bar("four-bar again, numpy with lsoda", "ms", 120.0, lambda: 1e3 * lsoda())
    yield Bar("four-bar, 100 parameter changes, each", "ms", 12.0, lambda: 1e3 * parameters())
    yield Bar("four-bar, another comment", "s", 0.8, lambda: edited(_commented))
    yield Bar("four-bar, another mass", "s", 0.8, lambda: edited(_with_another_mass))
    yield Bar("four-bar, another body", "s", 0.8, lambda: edited(_with_another_body))
    yield Bar("four-bar, unchanged", "s", 0.35, unchanged)
    yield Bar("chain 80, process", "s", 4.0, lambda: process("chain", 80).seconds)
    yield Bar("chain 80, simulation", "s", 0.6, lambda: member("chain", 80)["simulate"])
    yield Bar("ladder 20, process", "s", 4.0, lambda: process("ladder", 20).seconds)
    yield Bar("ladder 20, simulation", "s", 0.3, lambda: member("ladder", 20)["simulate"])
    for family, sizes in SIZES.items():
        for n in sizes:
            if n >= 20 and 2 * n in sizes:
                name = f"compile {family} {2 * n} to {n}"
                yield Bar(name, "", 2.3, lambda f=family, n=n: compile_growth(f, n))  # type: ignore[misc]
    yield Bar(
        "step of chain 160 to 80", "", 2.6, lambda: step_cost("chain", 160) / step_cost("chain", 80)
    )
    yield Bar("chain 160, memory", "MB", 500.0, lambda: process("chain", 160).megabytes)


def families() -> Iterator[str]:
    """For each member: CPU seconds by phase, then the integrator's work."""
    names = ("recall", "parse", "flatten", "lower", "structure", "codegen")
    yield f"{'':11}{''.join(f'{n:>10}' for n in names)}{'compile':>9}{'run':>8}{'again':>8}" + (
        f"{'states':>8}{'steps':>7}{'f(t, y)':>9}{'J':>5}{'us/step':>9}  solver"
    )
    for family, sizes in SIZES.items():
        for n in sizes:
            m = member(family, n)
            phases = "".join(f"{m['phases'].get(p, 0.0):10.3f}" for p in names)
            yield (
                f"{family:7}{n:4}{phases}{m['compile']:9.2f}{m['simulate']:8.3f}{m['again']:8.3f}"
                f"{m['states']:8}{m['steps']:7}{m['rhs']:9}{m['jacobians']:5}"
                f"{1e6 * m['again'] / m['steps']:9.1f}  {m['solver']}"
            )


def main() -> None:
    parser = argparse.ArgumentParser(description="Measure the engine against its bars.")
    parser.add_argument("--only", default="", metavar="WORD", help="bars whose name holds WORD")
    parser.add_argument("--families", action="store_true", help="each member, by phases")
    parser.add_argument("--task", nargs=2, metavar=("FAMILY", "N"), help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.task:
        print(json.dumps(compile_and_run(asked.task[0], int(asked.task[1]))))
        return
    for line in table([bar for bar in bars() if asked.only in bar.name]):
        print(line, flush=True)
    if asked.families:
        print()
        for line in families():
            print(line, flush=True)


if __name__ == "__main__":
    main()
