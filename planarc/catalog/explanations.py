"""Every code of a diagnostic, and what it means: its cause, an example that raises it, its cure.

In:   planarc/catalog/explain/*.md   a file for each stage, a section for each code
Out:  Code                           all codes, each with its title
      Explanation                    of one code

A code is a letter for the stage and three digits; no code means two things. Where a diagnostic is
made, its code is written as text, so that a run needs nothing of this list.

A section has a title, which says in one line what the code means; then come the cause, example
blocks between fences, and the cure:

    ## F320: more or fewer equations than unknowns

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
from enum import Enum, unique
from functools import cache
from pathlib import Path

from planarc.core.data import Data

FOLDER = Path(__file__).with_name("explain")
_CURE = "Cure: "
_FENCE = re.compile(r"^```(\w+)\n(.*?)^```\n", re.MULTILINE | re.DOTALL)
_TITLE = re.compile(r"^## (\w+): (.*)$", re.MULTILINE)

#: The files, in the order in which a model passes the stages.
_FILES = {stage: (FOLDER / f"{stage}.md").read_text(encoding="utf-8") for stage in "CPFLSGRVX"}
#: What the letters of the codes stand for: the headings of the files.
STAGES = {stage: text[2].lower() + text[3 : text.index("\n")] for stage, text in _FILES.items()}


@unique
class Code(Enum):
    """Every code, with its title: `Code["F320"].value`."""

    _ignore_ = "codes name title"
    codes = vars()
    for name, title in _TITLE.findall("\n".join(_FILES.values())):
        codes[name] = title


class Explanation(Data):
    code: Code
    cause: tuple[str, ...]  # paragraphs, each on one line
    example: tuple[tuple[str, str], ...]  # blocks: (`modelica`, `python` or `sh`; its text)
    cure: str


def explain(code: Code) -> Explanation:
    return _explanations(code.name[0])[code.name]


@cache
def _explanations(stage: str) -> dict[str, Explanation]:
    sections = _FILES[stage].split("\n## ")[1:]
    return {s[:4]: _read(Code[s[:4]], s.partition("\n")[2] + "\n") for s in sections}


def _read(code: Code, text: str) -> Explanation:
    said = [" ".join(p.split()) for p in _FENCE.sub("\n", text).split("\n\n") if p.strip()]
    cause = tuple(p for p in said if not p.startswith(_CURE))
    cure = " ".join(p.removeprefix(_CURE) for p in said if p.startswith(_CURE))
    example = tuple((m[1], m[2]) for m in _FENCE.finditer(text))
    return Explanation(code, cause, example, cure[:1].upper() + cure[1:])
