"""The examples of a library beside the results that its authors publish.

    python tests/benchmarks/standard_results.py FOLDER [--only PREFIX] [--limit SECONDS]

FOLDER holds a folder for each class, as the repository MAP-LIB_ReferenceResults of the Modelica
Association does for the Modelica Standard Library: `Modelica/Blocks/Examples/Filter/Filter.csv`
beside `comparisonSignals.txt`, the variables that are compared, and `creation.txt`, which tells the
times, the interval and the tolerance. MODELICAPATH names the folder of the library.

A line says of each class whether planarc's curves stay in tubes of 0.2 % around the published ones,
which leaves first and when, or why there are none; the last lines count. Curves of chaotic motions
part, and so do random numbers whose seed is the name that a tool gives an instance.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from bench import environment

TUBE = 0.002
#: Lines of `creation.txt` and what they are to the command.
OPTIONS = {
    "StartTime": "--start",
    "StopTime": "--stop",
    "Interval": "--interval",
    "Tolerance": "--tolerance",
}


def classes(folder: Path, prefix: str) -> Iterator[tuple[str, Path]]:
    """Names of classes, and their published results."""
    for file in sorted(folder.rglob("*.csv")):
        name = ".".join(file.parent.relative_to(folder).parts)
        if file.stem == file.parent.name and name.startswith(prefix):
            yield name, file


def settings(told: str) -> Iterator[str]:
    for word, option in OPTIONS.items():
        found = re.search(rf"^{word}=([-+.\deE]+)", told, re.MULTILINE)
        if found and not (word in ("StartTime", "Interval") and float(found[1]) == 0):
            yield from (option, found[1])


def judge(name: str, published: Path, limit: float) -> tuple[str, str]:
    """What became of a class, in a word, and more about it."""
    from planarc.view.table.compare import compare_tables
    from planarc.view.table.files import read_table

    def beside(other: str) -> str:
        file = published.with_name(other)
        return file.read_text(encoding="utf-8", errors="replace") if file.exists() else ""

    signals = [s.strip() for s in beside("comparisonSignals.txt").splitlines()]
    wanted = re.compile(f"^({'|'.join(re.escape(s) for s in signals if s and s != 'time')})$")
    with tempfile.TemporaryDirectory() as folder:
        own = Path(folder) / "own.csv"
        command = ["simulate", name, *settings(beside("creation.txt")), "--no-report", "--quiet"]
        command += ["--output", str(own), "--variables", wanted.pattern]
        try:
            done = subprocess.run(
                [sys.executable, "-m", "planarc", *command],
                capture_output=True,
                text=True,
                env=environment(),
                cwd=folder,
                timeout=limit,
            )
        except subprocess.TimeoutExpired:
            return "late", f"more than {limit:g} s"
        if done.returncode:
            return "refused", (done.stderr.splitlines() or [""])[0]
        found = compare_tables(
            read_table(published), read_table(own), TUBE, TUBE, wanted, absolute=1e-12
        )
    if not found.compared:
        return "nothing", "no variable in common"
    if found.parted:
        first = found.parted[0]
        return "parts", f"{first.name} at t = {first.time:.4g} s: {first.a:.6g}, {first.b:.6g}"
    return ("agrees", "") if found.ends is None else ("ends", "at {} s, {} s".format(*found.ends))


def main() -> None:
    parser = argparse.ArgumentParser(description="Compare examples with published results.")
    parser.add_argument("folder", type=Path, help="published results, a folder for each class")
    parser.add_argument("--only", default="", metavar="PREFIX", help="classes that begin so")
    parser.add_argument("--limit", type=float, default=300.0, metavar="SECONDS", help="for each")
    asked = parser.parse_args()
    counts: Counter[str] = Counter()
    for name, published in classes(asked.folder, asked.only):
        word, more = judge(name, published, asked.limit)
        counts[word] += 1
        print(f"{word:8} {name} {more}".rstrip(), flush=True)
    print(", ".join(f"{word}: {count}" for word, count in counts.most_common()))


if __name__ == "__main__":
    main()
