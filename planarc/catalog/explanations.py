"""What each code of a message means: its cause, an example that provokes it, and its cure.

In:   planarc/catalog/explain/*.md   a file for each stage, a section for each code
Out:  Explanation                    of one code

A section is the cause, example blocks between fences, and the cure:

    ## F320

    A model needs as many equations as it has unknowns ...

    ```modelica
    model Loose ...
    ```

    Cure: add the equation that is missing ...

The word behind a fence says what the block is: `modelica` the text of a file (the first one that
the commands name), `python` a script, `sh` commands. Without commands the last model of the text
is simulated.
"""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

from planarc.core.codes import Code
from planarc.core.data import Data

FOLDER = Path(__file__).with_name("explain")
_CURE = "Cure: "
_FENCE = re.compile(r"^```(\w+)\n(.*?)^```\n", re.MULTILINE | re.DOTALL)


class Explanation(Data):
    code: Code
    cause: tuple[str, ...]  # paragraphs, each on one line
    example: tuple[tuple[str, str], ...]  # blocks: (`modelica`, `python` or `sh`; its text)
    cure: str


def explain(code: Code) -> Explanation:
    return _explanations(code.name[0])[code.name]


@cache
def _explanations(stage: str) -> dict[str, Explanation]:
    file = FOLDER / f"{stage}.md"
    text = file.read_text(encoding="utf-8") if file.exists() else ""
    sections = ("\n" + text).split("\n## ")[1:]
    return {s[:4]: _read(Code[s[:4]], s[4:] + "\n") for s in sections}


def _read(code: Code, text: str) -> Explanation:
    said = [" ".join(p.split()) for p in _FENCE.sub("\n", text).split("\n\n") if p.strip()]
    cause = tuple(p for p in said if not p.startswith(_CURE))
    cure = " ".join(p.removeprefix(_CURE) for p in said if p.startswith(_CURE))
    example = tuple((m[1], m[2]) for m in _FENCE.finditer(text))
    return Explanation(code, cause, example, cure[:1].upper() + cure[1:])
