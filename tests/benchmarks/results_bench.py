"""How long results take to write and to read back, and how much memory: in proportion?

    python tests/benchmarks/results_bench.py [--variables 1000] [--rows 100000] [--folder DIR]

Each measurement runs in a process of its own, for the whole size and for a tenth of the rows:
in proportion means that ten times the rows take ten times as long, and that the memory beside
the result itself does not grow when writing. CPU seconds; memory is the greatest resident size.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import process_time
from typing import Any


def make_result(variables: int, rows: int) -> Any:
    """A result as of a run: real columns, every fourth one an alias of the one before."""
    import numpy as np

    from planarc.ir.dae import Kind
    from planarc.ir.expr import Exprs
    from planarc.ir.program import Column, Program
    from planarc.ir.result import Result, Statistics

    columns, slot = [], -1
    for i in range(variables):
        alias = i % 4 == 3
        slot += 0 if alias else 1
        columns.append(Column(f"body[{i}].x", slot, -1 if alias else 1, Kind.REAL, unit="m"))
    program = Program(
        "Large", Exprs(), slot + 1, {}, tuple(columns), (), (), (), (), (), (), (), (), (), (), (),
        (), (), (), (), (), (),
    )  # fmt: skip
    time = np.linspace(0, 10, rows)
    data = np.empty((rows, slot + 1))
    for k in range(slot + 1):
        data[:, k] = np.sin(time + k)
    stored = {k: k for k in range(slot + 1)}
    return Result(program, time, data, stored, {}, Statistics("none", "numpy"))


def write(path: Path, variables: int, rows: int) -> dict[str, float]:
    from planarc.view.table.files import write_table

    result = make_result(variables, rows)
    base = peak()
    return {**timed(lambda: write_table(path, result)), "base": base, "peak": peak()}


def read(path: Path, variables: int, rows: int) -> dict[str, float]:
    from planarc.view.table.files import read_table

    base = peak()

    def work() -> None:
        table = read_table(path)
        assert len(table.columns) == variables
        assert len(table["body[0].x"]) == rows

    return {**timed(work), "base": base, "peak": peak()}


def timed(work: Callable[[], object]) -> dict[str, float]:
    begin = process_time()
    work()
    return {"seconds": process_time() - begin}


def peak() -> float:
    """The greatest resident memory so far, in MB."""
    import resource

    size = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return size / (1e6 if sys.platform == "darwin" else 1e3)


def measure(task: str, path: Path, variables: int, rows: int) -> dict[str, float]:
    command = [sys.executable, __file__, "--task", task, "--path", str(path)]
    command += ["--variables", str(variables), "--rows", str(rows)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    found: dict[str, float] = json.loads(done.stdout)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--variables", type=int, default=1000)
    parser.add_argument("--rows", type=int, default=100_000)
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--task", choices=("write", "read"))
    parser.add_argument("--path", type=Path)
    options = parser.parse_args()
    if options.task:
        task = write if options.task == "write" else read
        print(json.dumps(task(options.path, options.variables, options.rows)))
        return
    print(f"{options.variables} variables; one number takes 8 bytes in memory")
    print(f"{'':12}{'rows':>8}  {'seconds':>8}  {'us/row':>8}  {'MB file':>8}  {'MB more':>8}")
    with tempfile.TemporaryDirectory(dir=options.folder) as folder:
        for suffix in (".mat", ".csv"):
            for rows in (options.rows // 10, options.rows):
                path = Path(folder) / f"large{suffix}"
                for task in ("write", "read"):
                    found = measure(task, path, options.variables, rows)
                    size = path.stat().st_size / 1e6
                    print(
                        f"{task + ' ' + suffix:12}{rows:8}  {found['seconds']:8.2f}  "
                        f"{1e6 * found['seconds'] / rows:8.1f}  {size:8.0f}  "
                        f"{found['peak'] - found['base']:8.0f}",
                        flush=True,
                    )
                path.unlink()


if __name__ == "__main__":
    main()
