"""Look through many random mechanisms; keep what fails, made small.

    python tests/mechanisms/search.py --first 300 --count 2000 [--backend native]

A failure is shrunk and written to `cases/`, where `test_random.py` runs it from then on.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from agreement import disagreement, regular, usable
from mechanism import Mechanism, shrink

CASES = Path(__file__).parent / "cases"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--backend", default="numpy", choices=("numpy", "native"))
    given = parser.parse_args()

    def fails(m: Mechanism) -> bool:
        return usable(m) and bool(disagreement(m, given.backend))

    for seed in range(given.first, given.first + given.count):
        found = disagreement(regular(seed), given.backend)
        if found:
            print(f"{seed}: {found}", flush=True)
            small = shrink(regular(seed), fails)
            path = CASES / f"seed_{seed}.json"
            path.write_text(small.to_json() + "\n", encoding="utf-8")
            print(f"{path.name}: {disagreement(small, given.backend)}", flush=True)


if __name__ == "__main__":
    main()
