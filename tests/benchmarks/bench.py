"""How long planarc takes: a table of CPU seconds and of their ratios to what is allowed.

    python tests/benchmarks/bench.py [--only WORD]

"four-bar" is the mechanism of tests/cases/b2_fourbar_gravity: 10 s at a tolerance of 1e-6,
all variables stored, 501 rows, result file included, the page only where said. Results are
never cached, and each timed run has another start value. "cam follower" is the library's example
of that name, run as it stands (4 s, 201 rows). Times are CPU seconds (user and
system) of the whole process with its children, the median of some runs, with OMP_NUM_THREADS=1.
Processes keep the bytecode of planarc's modules, as an installed planarc does:
PYTHONDONTWRITEBYTECODE, with which each would compile them anew, is not handed on.

The pace is how long the four-bar written by hand takes, before and after each row, in parts of what
it took where the bars were set: machines differ, and what else runs there slows them down. A row
holds its bar where the ratio is at most the pace. A core is slower while others work: for what runs
on several of them the pace is that of one with a busy neighbour. A core changes its speed from one
millisecond to the next, and `model.simulate` takes twice as long as the equation by hand. So each
run of it stands between two of those, and of 1,000 such groups the hundred count that took least:
their medians are the row's.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from time import perf_counter, process_time, sleep
from typing import TYPE_CHECKING

from msgspec.structs import replace

if TYPE_CHECKING:
    from planarc.core.options import RunOptions
    from planarc.request.request import Request

MODEL = Path(__file__).parent.parent / "cases" / "b2_fourbar_gravity" / "four_bar.pmo"
EXAMPLES = Path(__file__).parents[2] / "examples"
RUN = ("--stop", "10", "--intervals", "500", "--tolerance", "1e-6")
CAM = "PlanarMultiBody.Examples.CurveCurveJoint.CamFollower"
REPEATS = 5
#: Runs by hand of which the least tells the pace; groups of runs, and those of them that count.
BY_HAND_RUNS, GROUPS, COUNTED = 20, 1000, 100
#: Of the four-bar by hand, where the bars were set.
BY_HAND = 0.82e-3

#: Start angles of the crank, another one for each run.
_starts: Iterator[float] = (1.0 + 1e-4 * i for i in count())


@dataclass(frozen=True)
class Usage:
    seconds: float
    megabytes: float


@dataclass(frozen=True)
class Paced:
    """What was measured in turn with its pace."""

    value: float
    pace: float


@dataclass(frozen=True)
class Bar:
    """What is measured, in which unit, and how much is allowed."""

    name: str
    unit: str
    allowed: float | None  # None: nothing is promised
    measure: Callable[[], float | Paced]
    several: bool = False  # whether it is wall time of several processes


def environment(**more: str) -> dict[str, str]:
    """What measured processes find in their environment."""
    kept = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    return {**kept, **more}


def planarc(arguments: Sequence[str], cache: Path, folder: Path) -> Usage:
    """CPU and memory of one command in a process of its own."""
    process = subprocess.Popen(
        [sys.executable, "-m", "planarc", *arguments],
        cwd=folder,
        env=environment(PLANARC_CACHE_DIR=str(cache)),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    )
    assert process.stderr is not None
    errors = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise RuntimeError(f"planarc {' '.join(arguments)}: {errors.decode()}")
    kilobytes = usage.ru_maxrss / (1024 if sys.platform == "darwin" else 1)
    return Usage(usage.ru_utime + usage.ru_stime, kilobytes / 1024)


def four_bar(*options: str) -> list[str]:
    start = f"revA.phi.start={next(_starts)!r}"
    return ["simulate", str(MODEL), *RUN, "--set", start, *options]


def cam_follower(*options: str) -> list[str]:
    # Near the example's own start of 0.8 rad.
    return ["simulate", CAM, "--set", f"hinge.phi.start={next(_starts) - 0.2!r}", *options]


Command = Callable[..., list[str]]


def fresh(*options: str, command: Command = four_bar) -> list[Usage]:
    """Runs with empty caches."""
    found = []
    for _ in range(REPEATS):
        with tempfile.TemporaryDirectory() as folder:
            here = Path(folder)
            found.append(planarc(command(*options), here / "cache", here))
    return found


def warm(*options: str, command: Command = four_bar) -> list[Usage]:
    """Runs after a first one that filled the caches."""
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        planarc(command(*options), here / "cache", here)
        return [planarc(command(*options), here / "cache", here) for _ in range(REPEATS)]


def checks(changed: bool) -> list[Usage]:
    """Checks of the four-bar after a first one; `changed`: it was edited in between."""
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        file, found = here / MODEL.name, []
        for i in range(REPEATS + 1):
            remark = f"// edited {i} times\n" if changed else ""
            file.write_text(MODEL.read_text(encoding="utf-8") + remark, encoding="utf-8")
            found.append(planarc(["check", str(file)], here / "cache", here))
        return found[1:]


def help_page() -> list[Usage]:
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        return [planarc(["--help"], here / "cache", here) for _ in range(REPEATS)]


def again(backend: str) -> float:
    """CPU seconds of one more run in this process, results stored in memory."""
    from planarc.core.options import RunOptions
    from planarc.request.request import Request

    options = RunOptions(stop=10.0, intervals=500, tolerance=1e-6)
    return _again(Request(MODEL), backend, options, "revA.phi", 0.0)


def cam_again(backend: str) -> float:
    """The same of the cam follower."""
    from planarc.core.options import RunOptions
    from planarc.request.request import Request

    return _again(Request(class_name=CAM), backend, RunOptions(), "hinge.phi", -0.2)


def _again(request: Request, backend: str, given: RunOptions, start: str, shift: float) -> float:
    from planarc.compiler import compile_model, run
    from planarc.core.options import Backend

    chosen = Backend(backend)
    compiled = compile_model(request, chosen)
    times = []
    for _ in range(REPEATS + 1):
        options = replace(given, backend=chosen, starts={start: next(_starts) + shift})
        begin = process_time()
        result = run(compiled, options)
        times.append(process_time() - begin)
        if len(times) == 1:
            sleep(0.3)  # threads that importing numpy started spin on for a moment
        if result.ended is not None:
            raise RuntimeError(f"{backend}: the run ended early: {result.ended}")
    return statistics.median(times[1:])  # the first one imports what it needs


def gif() -> list[Usage]:
    """A moving picture of 120 frames, 480 pixels wide, from warm caches."""
    pace = ("--from", "0", "--to", "4.76", "--fps", "25", "--width", "480")

    def command() -> list[str]:
        start = f"revA.phi.start={next(_starts)!r}"
        return ["animate", str(MODEL), "--set", start, *pace, "-o", "a.gif"]

    return warm(command=command)


def moved() -> float:
    """CPU seconds of an answer to the live page after a slider was moved, as text."""
    import json

    from planarc.core.options import Backend
    from planarc.live.session import Order, Session
    from planarc.request.request import Request

    session = Session(Request(MODEL), Backend.NATIVE)
    known = session.answer(Order())["key"]
    times = []
    for _ in range(REPEATS + 1):
        begin = process_time()
        json.dumps(session.answer(Order(known=known, starts={"revA.phi": next(_starts)})))
        times.append(process_time() - begin)
    return statistics.median(times[1:])


#: Runs a page's model with another value, some times; gives the median of milliseconds.
AGAIN = """async ([kind, name, first]) => {
  const found = [];
  for (let i = 0; i < 25; i++) {
    const order = { values: {}, starts: {}, stop: null, changed: "" };
    order[kind][name] = first * (1 + 1e-3 * i);
    found.push(1000 * (await planarc.source.run(order, { aborted: false })).seconds);
  }
  return found.sort((a, b) => a - b)[12];
}"""


def page_again(request: Request, *value: object) -> float:
    """Wall milliseconds of another run in an exported page, its motion and curves included, in
    chromium; nan where there is none."""
    import shutil

    from planarc.compiler import compile_model, run
    from planarc.core.options import RunOptions
    from planarc.export.page.page import make_page

    program = shutil.which("chromium") or shutil.which("google-chrome")
    if program is None:
        return float("nan")
    from playwright.sync_api import sync_playwright

    compiled = compile_model(request)
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as driver:
        path = Path(folder) / "page.html"
        path.write_text(make_page(compiled, run(compiled, RunOptions())).text, "utf-8")
        browser = driver.chromium.launch(executable_path=program, args=["--no-sandbox"])
        page = browser.new_page()
        page.goto(path.as_uri())
        found = float(page.evaluate(AGAIN, list(value)))
        browser.close()
    return found


def four_bar_in_page() -> float:
    from planarc.request.request import Request

    return page_again(Request(EXAMPLES / "four_bar.pmo"), "starts", "revA.phi", 1.0)


def cam_in_page() -> float:
    from planarc.request.request import Request

    return page_again(Request(class_name=CAM), "values", "follower.m", 1.0)


def exported(example: str) -> float:
    """Wall seconds that an FMU takes beyond the compile of its model, where one of its kind was
    written before."""
    from planarc.compiler import compile_model
    from planarc.export.fmu import make_fmu
    from planarc.export.wishes import Wishes
    from planarc.request.request import Request

    times = []
    for _ in range(REPEATS + 1):
        compiled = compile_model(Request(EXAMPLES / f"{example}.pmo"))
        begin = perf_counter()
        make_fmu(compiled, Wishes())
        times.append(perf_counter() - begin)
    return statistics.median(times[1:])


#: The last of these examples as an FMU, the others written before: wall seconds beyond its compile.
_FIRST = """
import sys
from pathlib import Path
from time import perf_counter
from planarc.compiler import compile_model
from planarc.export.fmu import make_fmu
from planarc.export.wishes import Wishes
from planarc.request.request import Request
for name in sys.argv[2:]:
    compiled = compile_model(Request(Path(sys.argv[1]) / f"{name}.pmo"))
    begin = perf_counter()
    make_fmu(compiled, Wishes())
print(perf_counter() - begin)
"""


def first_exported(*examples: str) -> float:
    """The same for the first FMU of its kind, from an empty cache."""
    times = []
    for _ in range(REPEATS):
        with tempfile.TemporaryDirectory() as cache:
            done = subprocess.run(
                [sys.executable, "-c", _FIRST, str(EXAMPLES), *examples],
                check=True, capture_output=True, text=True,
                env=environment(PLANARC_CACHE_DIR=cache),
            )  # fmt: skip
        times.append(float(done.stdout))
    return statistics.median(times)


def from_python() -> Paced:
    """CPU milliseconds of one more `model.simulate` from Python, start included, and the pace of
    the four-bar by hand right before and behind it."""
    from hand_written import simulate as by_hand

    import planarc as package

    model = package.load(MODEL)

    def from_start(phi: float) -> None:
        model.simulate(10.0, intervals=500, tolerance=1e-6, start={"revA.phi": phi})

    before, groups = seconds_of(by_hand), list[tuple[float, float]]()
    for _ in range(GROUPS):
        own, behind = seconds_of(from_start), seconds_of(by_hand)
        groups.append((own, (before + behind) / 2))
        before = behind
    quickest = sorted(groups, key=lambda group: group[0] + 2 * group[1])[:COUNTED]
    own, hand = map(statistics.median, zip(*quickest, strict=True))
    return Paced(1e3 * own, hand / BY_HAND)


def seconds_of(run: Callable[[float], object]) -> float:
    """CPU seconds of a run from another start angle."""
    phi = next(_starts)
    begin = process_time()
    run(phi)
    return process_time() - begin


def study() -> float:
    """Wall seconds of 1,000 runs on all cores."""
    import planarc as package

    model = package.load(MODEL)
    points = package.latin_hypercube({"crankBody.m": (0.5, 2), "revA.phi.start": (0.5, 1.5)}, 1000)
    begin = perf_counter()
    found = package.sweep(
        model, points, "max(revA.w)", stop_time=10.0, intervals=500, tolerance=1e-6
    )
    if found.failures:
        raise RuntimeError(f"a run failed: {found.failures[0].reason}")
    return perf_counter() - begin


def seconds(usages: Sequence[Usage]) -> float:
    return statistics.median(u.seconds for u in usages)


def megabytes(usages: Sequence[Usage]) -> float:
    return max(u.megabytes for u in usages)


BARS = (
    # First of all: the system reckons a process to have had what the one had that began it.
    Bar("memory, four-bar, empty caches, with page", "MB", 250.0, lambda: megabytes(fresh())),
    Bar("help", "s", 0.2, lambda: seconds(help_page())),
    Bar("check of the four-bar, warm caches", "s", 0.4, lambda: seconds(checks(False))),
    Bar("check of the four-bar, edited", "s", None, lambda: seconds(checks(True))),
    Bar("four-bar, empty caches", "s", 2.5, lambda: seconds(fresh("--no-report"))),
    Bar("four-bar, warm caches", "s", 0.6, lambda: seconds(warm("--no-report"))),
    Bar("four-bar, warm caches, with page", "s", 1.0, lambda: seconds(warm())),
    Bar("four-bar again in one process, native", "ms", 10.0, lambda: 1e3 * again("native")),
    Bar("four-bar again in one process, numpy", "ms", None, lambda: 1e3 * again("numpy")),
    Bar("four-bar again, model.simulate", "ms", 1.5, from_python),
    Bar("four-bar as a gif of 120 frames", "s", 6.0, lambda: seconds(gif())),
    Bar("four-bar moved on the live page, answer", "ms", 50.0, lambda: 1e3 * moved()),
    Bar("four-bar again in an exported page, wall", "ms", 20.0, four_bar_in_page),
    Bar("cam follower again in an exported page", "ms", 60.0, cam_in_page),
    Bar("cam follower, warm caches", "s", 1.0, lambda: seconds(warm(command=cam_follower))),
    Bar("cam follower again in one process, native", "ms", 15.0, lambda: 1e3 * cam_again("native")),
    Bar("cam follower again in one process, numpy", "ms", None, lambda: 1e3 * cam_again("numpy")),
    Bar("gripper as an FMU, beyond its compile", "s", 1.0, lambda: exported("gripper"), True),
    Bar("chain over a peg as an FMU, likewise", "s", 1.0, lambda: exported("chain_over_peg"), True),
    Bar(
        "double pendulum as an FMU behind a four-bar",
        "s",
        1.0,
        lambda: first_exported("four_bar", "double_pendulum"),
        True,
    ),
    Bar(
        "four-bar as the first FMU of a machine", "s", 1.0, lambda: first_exported("four_bar"), True
    ),
    Bar("gripper as the first FMU of a machine", "s", 1.0, lambda: first_exported("gripper"), True),
    Bar("sweep of 1,000 four-bars, wall", "s", 15.0, study, True),
)


def pace(several: bool = False) -> float:
    """How many times as long work takes here and now as where the bars were set; `several`: on a
    core beside a busy one."""
    from hand_written import seconds as by_hand

    with neighbour() if several else nullcontext():
        return by_hand(_starts, BY_HAND_RUNS) / BY_HAND


@contextmanager
def neighbour() -> Iterator[None]:
    """A process that has enough to do."""
    busy = subprocess.Popen([sys.executable, "-c", "while True: pass"])
    try:
        sleep(0.2)  # until it runs
        yield
    finally:
        busy.kill()
        busy.wait()


def table(bars: Sequence[Bar]) -> Iterator[str]:
    """The lines of the table, each as soon as it is measured."""
    yield f"{'':42} {'measured':>12} {'allowed':>12} {'ratio':>6} {'pace':>6}"
    for bar in bars:
        before = pace(bar.several)
        found = bar.measure()
        value = found.value if isinstance(found, Paced) else found
        row = f"{bar.name:42} {f'{value:.4g} {bar.unit}':>12}"
        if bar.allowed is not None:
            if isinstance(found, Paced):
                there = found.pace
            else:
                there = 1.0 if bar.unit == "MB" else (before + pace(bar.several)) / 2
            ratio = value / bar.allowed
            late = "" if ratio <= there else "  too much"
            row += f" {f'{bar.allowed:g} {bar.unit}':>12} {ratio:6.2f} {there:6.2f}{late}"
        yield row


def main() -> None:
    parser = argparse.ArgumentParser(description="Measure planarc against its bars.")
    parser.add_argument("--only", default="", metavar="WORD", help="bars whose name holds WORD")
    only = parser.parse_args().only
    for line in table([bar for bar in BARS if only in bar.name]):
        print(line, flush=True)


if __name__ == "__main__":
    main()
