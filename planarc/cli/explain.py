"""`planarc explain`: what the code of a message means, why it comes and what cures it."""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Iterable, Iterator, Sequence
from textwrap import indent, wrap
from typing import TYPE_CHECKING, Annotated, Any

from planarc.cli import console
from planarc.cli.arguments import AsJson
from planarc.cli.line import Argument
from planarc.core.diagnostic import usage_error

if TYPE_CHECKING:
    from planarc.catalog.explanations import Code, Explanation

_WIDEST = 88
_BOLD, _LABEL, _RESET = "\033[1m", "\033[1;36m", "\033[0m"


def _completed(begun: str) -> list[str]:
    """The codes that a shell offers."""
    from planarc.catalog.explanations import Code

    return [code for code in Code.__members__ if code.startswith(begun.upper())]


def explain(
    codes: Annotated[
        list[str] | None,
        Argument(
            metavar="[CODE]...",
            help="Codes such as F320, or letters of stages; without, all codes are listed.",
            autocompletion=_completed,
        ),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Explain messages by their codes: cause, example and cure."""
    from planarc.catalog.explanations import explain as explanation_of

    asked = [a.upper() for a in codes or ()]
    explained = [explanation_of(code) for a in asked for code in _meant(a) if len(a) > 1]
    listed = [code for a in asked or [""] for code in _meant(a) if len(a) < 2]
    if as_json:
        found = [*map(_as_json, explained), *({"code": c.name, "title": c.value} for c in listed)]
        console.say(json.dumps({"codes": found}, indent=2, ensure_ascii=False))
        return 0
    width = min(shutil.get_terminal_size((_WIDEST, 24)).columns, _WIDEST)
    texts = ["\n".join(_shown(e, width)) for e in explained]
    texts += ["\n".join(_list(listed))] if listed else []
    console.say("\n\n".join(texts))
    return 0


def _meant(asked: str) -> Sequence[Code]:
    """One code, those of a stage, or all. Raises UsageError C294 for what is none."""
    from planarc.catalog.explanations import STAGES, Code

    if asked in Code.__members__:
        return (Code[asked],)
    if not asked or asked in STAGES:
        return [code for code in Code if code.name.startswith(asked)]
    from planarc.core.nearest import did_you_mean

    hint = did_you_mean(asked, Code.__members__) or "`planarc explain` lists all codes"
    raise usage_error("C294", f"there is no code `{asked}`", hint=hint)


def _list(codes: Iterable[Code]) -> Iterator[str]:
    """All codes with their lines, below the names of their stages."""
    from planarc.catalog.explanations import STAGES

    stage = ""
    for code in codes:
        if code.name[0] != stage:
            yield from [""] if stage else []
            stage = code.name[0]
            yield _painted(f"{stage}: {STAGES[stage]}", _LABEL)
        yield f"  {_painted(code.name, _BOLD)}  {code.value}"


def _shown(found: Explanation, width: int) -> Iterator[str]:
    yield _painted(f"{found.code.name}: {found.code.value}", _BOLD)
    for paragraph in found.cause:
        yield ""
        yield from _wrapped(paragraph, width)
    for kind, text in found.example:
        yield ""
        yield _painted("Run" if kind == "sh" else "Example", _LABEL)
        yield indent(text.rstrip("\n"), "    ")
    yield ""
    yield _painted("Cure", _LABEL)
    yield from _wrapped(found.cure, width)


def _wrapped(text: str, width: int) -> Iterator[str]:
    lines = wrap(text, width - 2, break_long_words=False, break_on_hyphens=False)
    return (f"  {line}" for line in lines)


def _painted(text: str, paint: str) -> str:
    return f"{paint}{text}{_RESET}" if console.may_colour(sys.stdout) else text


def _as_json(found: Explanation) -> dict[str, Any]:
    return {
        "code": found.code.name,
        "title": found.code.value,
        "cause": "\n\n".join(found.cause),
        "example": [{"kind": kind, "text": text} for kind, text in found.example],
        "cure": found.cure,
    }
