"""How flattening grows with the model, and how long `planarc check` takes.

    python tests/benchmarks/flatten_bench.py [--only WORD]

"chain" is a pendulum of N links, each with a joint, a rod and a body. Its flattening is CPU
time in one process whose library is read already, the least of some runs. The commands are
CPU seconds (user and system) of the whole process, the median of some runs. With
MODELICAPATH naming the Modelica Standard Library, a model of it is checked too.
"""

from __future__ import annotations

import argparse
import gc
import os
import statistics
import sys
import tempfile
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from time import process_time

sys.path.insert(0, str(Path(__file__).parent))

from bench import Bar, Usage, planarc, table

LINKS = (20, 40, 80, 160)
REPEATS = 5
REPOSITORY = Path(__file__).parents[2]
STANDARD_MODEL = "Modelica.Mechanics.Rotational.Examples.First"


def chain(links: int) -> str:
    """A pendulum of equal links under gravity; the first hangs on the world."""
    declarations, connections = [], []
    previous = "world.frame_b"
    for i in range(1, links + 1):
        declarations += [
            f"  PlanarMultiBody.Joints.Revolute joint{i}(phi(start={0.5 / i}));",
            f"  PlanarMultiBody.Parts.FixedTranslation rod{i}(r={{{1 / links}, 0}});",
            f"  PlanarMultiBody.Parts.Body bob{i}(m={1 / links}, I=0);",
        ]
        connections += [
            f"  connect({previous}, joint{i}.frame_a);",
            f"  connect(joint{i}.frame_b, rod{i}.frame_a);",
            f"  connect(rod{i}.frame_b, bob{i}.frame_a);",
        ]
        previous = f"rod{i}.frame_b"
    body = "\n".join([*declarations, "equation", *connections])
    return f"model Chain\n  inner PlanarMultiBody.World world;\n{body}\nend Chain;\n"


@cache
def flattening(links: int) -> float:
    """CPU seconds."""
    from planarc.request.request import Request, Target, open_library
    from planarc.stages import flatten

    library, reader, _ = open_library(Request(text=chain(links)))
    times = []
    for _ in range(REPEATS + 1):
        gc.collect()
        begin = process_time()
        flatten(Target(library, "Chain", reader))
        times.append(process_time() - begin)
    return min(times[1:])  # the first one reads the library


def ratio(links: int) -> float:
    return flattening(2 * links) / flattening(links)


def checks(arguments: Sequence[str], warm: bool) -> float:
    """CPU seconds of `planarc check`, with a cache of its own."""
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        used: list[Usage] = []
        for i in range(REPEATS + warm):
            place = here / ("cache" if warm else f"cache{i}")
            used.append(planarc(["check", *arguments], place, here))
        return statistics.median(u.seconds for u in used[warm:])


def bars() -> Iterator[Bar]:
    for n in LINKS:
        allowed = 1.0 if n == 80 else None
        yield Bar(f"flatten, {n} links", "s", allowed, lambda n=n: flattening(n))  # type: ignore[misc]
    for n in LINKS[:-1]:
        yield Bar(f"flatten, {2 * n} links to {n}", "", 2.3, lambda n=n: ratio(n))  # type: ignore[misc]
    pendulum = [str(REPOSITORY / "examples" / "pendulum.pmo")]
    yield Bar("check pendulum, warm caches", "s", 0.4, lambda: checks(pendulum, True))
    if os.environ.get("MODELICAPATH"):
        first = [STANDARD_MODEL]
        yield Bar("check Rotational First, no caches", "s", 3.0, lambda: checks(first, False))
        yield Bar("check Rotational First, warm caches", "s", 0.6, lambda: checks(first, True))


def main() -> None:
    parser = argparse.ArgumentParser(description="Measure flattening and checks.")
    parser.add_argument("--only", default="", metavar="WORD", help="bars whose name holds WORD")
    only = parser.parse_args().only
    for line in table([bar for bar in bars() if only in bar.name]):
        print(line, flush=True)


if __name__ == "__main__":
    main()
