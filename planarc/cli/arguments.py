"""The arguments that commands share, and the request that they make."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

from planarc.cli.line import Argument, Option
from planarc.core.diagnostic import usage_error
from planarc.core.options import Backend, Redundant, fastest_backend

if TYPE_CHECKING:
    from planarc.flatten.library.library import Library
    from planarc.request.request import Request


def offers(kind: str) -> Any:
    """What a shell offers for an argument (`cli/completion.py`), where it is a shell that asks."""
    if "_PLANARC_COMPLETE" not in os.environ:
        return None
    from planarc.cli import completion

    return getattr(completion, kind)


Target: TypeAlias = Annotated[
    str,
    Argument(
        metavar="FILE|CLASS",
        help="A .pmo or .mo file, or a class of a library.",
        autocompletion=offers("models"),
    ),
]
ClassName: TypeAlias = Annotated[
    str | None,
    Argument(
        metavar="CLASS",
        help="The class of FILE, when it is not the one named like the file.",
        autocompletion=offers("classes"),
    ),
]
Libraries: TypeAlias = Annotated[
    list[Path] | None,
    Option(
        "--library",
        metavar="DIR",
        help="A folder of libraries, a package's own folder, or a file. Repeatable.",
    ),
]
RedundantJoints: TypeAlias = Annotated[
    Redundant,
    Option(
        "--redundant",
        help="What becomes of joints that hold the same motion more than once: accepted, they "
        "share their forces with the smallest sum of squares.",
    ),
]
Undrawn: TypeAlias = Annotated[
    bool,
    Option("--no-drawing", help="Leave out colours and whatever else only the picture needs."),
]


def output_option(help: str) -> Any:
    """`--output`, with what it writes."""
    return Option("--output", "-o", metavar="FILE", help=help)


AsJson: TypeAlias = Annotated[bool, Option("--json", help="Print one JSON object instead of text.")]

Pattern: TypeAlias = Annotated[
    str | None,
    Option(
        "--variables",
        metavar="REGEX",
        help="Only variables whose names this regular expression matches anywhere.",
    ),
]

Settings: TypeAlias = Annotated[
    list[str] | None,
    Option(
        "--set",
        metavar="NAME=VALUE",
        help="Set a parameter, or a start value as x.start=1, or with a unit: x=20cm. Repeatable.",
        autocompletion=offers("settings"),
    ),
]


def seconds(text: str) -> float:
    """The number of `0.5` and of `500ms`. Raises ValueError."""
    try:
        return float(text)
    except ValueError:
        from planarc.core.quantity import in_unit

        found = in_unit("time", text, "s")
        if found is None:
            name, equals, value = text.partition("=")
            meant = (
                f", a start value is `--set {name.removesuffix('.start')}.start={value}`"
                if equals
                else ""
            )
            raise ValueError(f"`{text}` is no time{meant}") from None
        return found


def time_option(*names: str, help: str) -> Any:
    """An option that takes a time."""
    return Option(*names, metavar="TIME", parser=seconds, help=help)


Stop: TypeAlias = Annotated[
    float | None, time_option(help="Stop time in seconds, or with a unit: 500ms.")
]
Tolerance: TypeAlias = Annotated[float | None, Option(help="Relative error allowed in a step.")]
Intervals: TypeAlias = Annotated[int | None, Option(help="Number of intervals.")]


def make_request(
    target: str,
    class_name: str | None = None,
    libraries: Sequence[Path] | None = None,
    redundant: Redundant = Redundant.REFUSE,
) -> Request:
    """The request that the arguments make."""
    from planarc.request.request import Request

    folders = tuple(libraries or ())
    if names_file(target):
        return Request(Path(target), class_name, folders, redundant=redundant)
    if class_name is None:
        return Request(None, target, folders, redundant=redundant)
    raise usage_error(
        "C109",
        f"`{target}` is no file, so `{class_name}` cannot be a class in it",
        hint="give one class, or a file and a class",
    )


def open_classes(
    target: str | None, libraries: Sequence[Path] | None
) -> tuple[Library, tuple[str, ...]]:
    """The libraries, and the classes in them that an argument names; without one, all packages."""
    from planarc.request.request import Request, open_library, open_target

    folders = tuple(libraries or ())
    if target is not None and not names_file(target):
        named = open_target(Request(None, target, folders))
        return named.library, (named.class_name,)
    file = None if target is None else Path(target)
    classes, _, declared = open_library(Request(file, None, folders))
    return classes, classes.top_names() if file is None else declared


def names_file(target: str) -> bool:
    """True for an argument that means a file; any other is the name of a class."""
    from planarc.request.request import names_class

    return not names_class(target) or Path(target).exists()


def read_pattern(text: str | None, option: str = "--variables") -> re.Pattern[str] | None:
    """The regular expression of an option."""
    try:
        return None if text is None else re.compile(text)
    except re.error as problem:
        raise usage_error(
            "C114",
            f"`{option} {text}` is no regular expression: {problem}",
            hint=f"write e.g. `{option} 'crank|rod'`, and a backslash before `[` or `(`",
        ) from None


def choose_backend(asked: Backend | None) -> Backend:
    """The back end that was asked for, or the fastest one that is installed."""
    best = fastest_backend()
    if asked is not Backend.NATIVE or best is asked:
        return asked or best
    raise usage_error(
        "C113",
        "the native back end needs `llvmlite`, which is not installed",
        hint="use `--backend numpy`, or install llvmlite",
    )
