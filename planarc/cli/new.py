"""`planarc new`: a small working model to start from."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

from planarc.cli import console
from planarc.cli.files import check_writable
from planarc.cli.line import Argument
from planarc.core.diagnostic import PlanarcError, usage_error
from planarc.core.source import SUFFIXES

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_TAKEN = frozenset({"PlanarMultiBody", "Modelica"})

#: A pendulum: small, and yet with all that a mechanism has.
TEMPLATE = Path(__file__).with_name("new.pmo")


def new(
    name: Annotated[
        str, Argument(metavar="NAME", help="The name of the model; the file is NAME.pmo.")
    ],
) -> int:
    """Write a small working model to start from."""
    path = Path(name) if name.endswith(SUFFIXES) else Path(f"{name}.pmo")
    class_name = path.stem
    _refuse_bad_name(class_name)
    check_writable(path, "NAME")
    try:
        with path.open("x", encoding="utf-8", newline="\n") as file:
            file.write(TEMPLATE.read_text("utf-8").replace("NAME", class_name))
    except FileExistsError:
        raise usage_error("C151", f"`{path}` exists already", hint="choose another name") from None
    console.say(f"wrote {path}")
    console.tell(f"run it with: planarc simulate {path}")
    return 0


def _refuse_bad_name(name: str) -> None:
    if not _NAME.fullmatch(name):
        raise usage_error(
            "C152",
            f"`{name}` cannot be the name of a model",
            hint="use letters, digits and `_`, beginning with a letter",
        )
    if name in _TAKEN or _is_word(name):
        what = "a library's name" if name in _TAKEN else "a word of the language"
        raise usage_error("C152", f"`{name}` is {what}", hint="choose another name for the model")


def _is_word(name: str) -> bool:
    from planarc.core.source import Source
    from planarc.parse.parser import parse_text

    try:
        parse_text(Source(name, f"model {name} end {name};"))
    except PlanarcError:
        return True
    return False
