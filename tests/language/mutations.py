"""Mutated models must end in a flat model or in diagnostics, never in a traceback.

    python tests/language/mutations.py 20000

takes the inputs of all cases here, deletes, doubles, swaps and replaces tokens, and
flattens what comes out. A failure is printed with the text that caused it.
"""

from __future__ import annotations

import random
import re
import sys
import time
import traceback
from pathlib import Path

from planarc.core.diagnostic import PlanarcError
from planarc.core.render import render_all
from planarc.core.resources import stdlib
from planarc.core.source import Source
from planarc.flatten.library.library import Library
from planarc.flatten.pipeline import flatten
from planarc.ir.text.flat import print_model
from planarc.parse.parser import parse_annotation, parse_file, parse_text
from tests.ir.check.flat import check_model

TOKEN = re.compile(r"[A-Za-z_]\w*|\d+(?:\.\d+)?|\"[^\"]*\"|:=|<=|>=|<>|==|\.\*|\s+|.", re.DOTALL)
CASE = re.compile(r"^\[case .*\]$", re.MULTILINE)
OUTCOME = re.compile(r"^\[(?:flat|errors)\]$", re.MULTILINE)
SECONDS = 10.0  # longest time for one input


def inputs() -> list[str]:
    """The inputs of all cases."""
    found = []
    for path in sorted(Path(__file__).parent.rglob("*.case")):
        for body in CASE.split(path.read_text(encoding="utf-8"))[1:]:
            found.append(OUTCOME.split(body)[0])
    return found


def kind(token: str) -> str:
    """What may stand for each other: names, numbers, texts, operators."""
    first = token[0]
    if first.isalpha():
        return "name" if token not in KEYWORDS else token
    if first.isdigit():
        return "number"
    return "operator" if token in OPERATORS else first


KEYWORDS = frozenset(
    re.findall(
        r"\w+",
        """model end equation algorithm if then else elseif for in loop when elsewhen while
        function input output parameter constant package record connector extends import
        redeclare replaceable constrainedby final each inner outer protected flow""",
    )
)
OPERATORS = frozenset({"+", "-", "*", "/", "^", "<", ">", "<=", ">=", "==", "<>", ".*"})


def mutate(text: str, pool: list[str], rng: random.Random) -> str:
    tokens = TOKEN.findall(text)
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        solid = [i for i, t in enumerate(tokens) if not t.isspace()]
        if len(solid) < 2:
            break
        i, j = rng.choice(solid), rng.choice(solid)
        match rng.randrange(9):
            case 0:
                tokens[i] = " "
            case 1:
                tokens.insert(i, tokens[i] + " ")
            case 2:
                tokens[i], tokens[j] = tokens[j], tokens[i]
            case 3:
                tokens[i] = tokens[j]
            case 4:
                tokens[i] = rng.choice(pool)
            case _:  # of the same kind, so that most of these still parse
                source = pool if rng.random() < 0.5 else tokens
                tokens[i] = rng.choice([t for t in source if kind(t) == kind(tokens[i])])
    return "".join(tokens)


def survive(text: str, limit: float) -> str | None:
    """None when all is well, else what went wrong. `limit`: seconds of the processor."""
    start = time.process_time()
    try:
        library = Library([stdlib()], parse_file, parse_annotation)
        names = library.add_file(parse_text(Source("mutated.mo", text)))
        for name in names[-1:]:
            model = flatten(library, name)
            check_model(model)
            print_model(model)
    except PlanarcError as problem:
        if not problem.diagnostics:
            return "an error without a message"
        render_all(problem.diagnostics)
    except Exception:
        return traceback.format_exc()
    if time.process_time() - start > limit:
        return "took too long"
    return None


def run(count: int, seed: int, limit: float = SECONDS) -> list[tuple[str, str]]:
    """The inputs that failed, each with what went wrong."""
    rng = random.Random(seed)
    texts = inputs()
    pool = sorted({t for text in texts for t in TOKEN.findall(text) if not t.isspace()})
    failures = []
    for _ in range(count):
        text = mutate(rng.choice(texts), pool, rng)
        problem = survive(text, limit)
        if problem is not None:
            failures.append((text, problem))
    return failures


if __name__ == "__main__":
    number = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    found = run(number, first)
    for text, problem in found[:20]:
        print(text, problem, "-" * 80, sep="\n")
    print(f"{number} inputs, {len(found)} failures")
    sys.exit(bool(found))
