"""The table of commands: their examples, and where their functions are."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

#: The commands with the examples of their help, in its order. Each is a function in a file of its
#: name, and imported when it is asked for: all of them together would take half of a check's time.
COMMANDS = {
    name: examples
    for block in Path(__file__).with_name("examples.txt").read_text("utf-8").split("\n\n")
    for name, *examples in [block.splitlines()]
}
#: The functions that cannot be called as their commands, since Python calls its own things so; the
#: file of one is called like its function.
_RENAMED = {"compile": "compile_model", "list": "list_classes", "import": "import_outline"}
_FILES = {"import": "import_outline"}


def function_of(command: str) -> Callable[..., int]:
    """The function of a command."""
    module = import_module(f"planarc.cli.{_FILES.get(command, command)}")
    function: Any = getattr(module, _RENAMED.get(command, command))
    found: Callable[..., int] = function
    return found
