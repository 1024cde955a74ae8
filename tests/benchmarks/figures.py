"""The tables of the pages `accuracy` and `speed` of the site, measured and written again.

    python tests/benchmarks/figures.py [--output FILE]

`accuracy`: the reference cases of `tests/cases`, whose references were computed without planarc;
the greatest error of the first signal that is not driven, at two tolerances. `speed`: CPU
milliseconds to compile an example of the library, files parsed before and nothing else remembered,
and to simulate it once. The figures go to `docs/measured.json`, which the site shows with the
command that made them; what other commands made stays there.
"""

from __future__ import annotations

import argparse
import json
import platform
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(Path(__file__).parent), str(ROOT / "tests" / "cases")]

from accuracy import MODELS, TOLERANCES, case_of, errors  # noqa: E402
from paper_claims import EXAMPLES, measure  # noqa: E402

DATA = ROOT / "docs" / "measured.json"
COMMAND = "python tests/benchmarks/figures.py"
TIMED = (
    "Elementary.Pendulum",
    "Elementary.DoublePendulum",
    "Loops.CrankSlider",
    "Loops.FourBar",
    "Loops.TwoLoops",
    "Loops.AndrewsSqueezer",
    "CurveCurveJoint.CamFollower",
    "CurveCurveJoint.SplineCam",
    "Systems.QuickReturn",
    "Systems.Excavator",
)


def accuracy() -> Iterator[list[str]]:
    """A row for each case: what it is, what is compared, the error at each tolerance."""
    for folder in dict.fromkeys(model.parent for model in MODELS):
        case = case_of(folder)
        model = folder / case["models"][0]
        parts = {t: errors(model, t, "native", "auto") for t in TOLERANCES}
        # What is driven from outside has no error of its own.
        names = list(case["signals"])
        signal = next((n for n in names if parts["1e-6"][n] > 1e-9), names[0])
        expected = case["signals"][signal]
        text = model.read_text("utf-8").partition('"')[2].partition('"')[0]
        found = (f"{parts[t][signal] * expected[t]:.0e}" for t in TOLERANCES)
        yield [text, f"`{expected['variable']}`", f"{case['stop']:g} s", *found]


def speed() -> Iterator[list[str]]:
    """A row for each example: its size, and milliseconds to compile and to simulate."""
    from planarc.request.request import Request

    for name in TIMED:
        (before, after, compiling, simulating), result = measure(
            Request(class_name=EXAMPLES + name)
        )
        last = f"{result.time[-1]:g} s, {len(result.time)} rows"
        yield [f"`{name}`", str(before), str(after), f"{compiling:.0f}", f"{simulating:.0f}", last]


def machine() -> str:
    """The processor, as far as the system tells."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text("utf-8").splitlines() if info.exists() else []
    named = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return f"{named[0] if named else platform.processor()}, Python {platform.python_version()}"


def tables() -> dict[str, Any]:
    where = {"machine": machine(), "command": COMMAND}
    errors_at = [f"error at {tolerance}" for tolerance in TOLERANCES]
    timed = ["example", "equations", "reduced", "compile ms", "simulate ms", "simulated"]
    return {
        "accuracy": {
            "head": ["mechanism", "compared", "until", *errors_at],
            "rows": list(accuracy()),
            **where,
        },
        "speed": {"head": timed, "rows": list(speed()), **where},
    }


def main() -> None:
    parser = argparse.ArgumentParser(description="Measure the tables of the site.")
    parser.add_argument("--output", type=Path, default=DATA, metavar="FILE")
    output = parser.parse_args().output
    known = json.loads(DATA.read_text("utf-8"))
    text = json.dumps({**known, **tables()}, indent=1, ensure_ascii=False) + "\n"
    output.write_text(text, encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
