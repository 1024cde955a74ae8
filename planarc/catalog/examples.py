"""All examples of a package, a folder or a file, run one after the other.

In:   names of packages, folders, files
Out:  Shown, one a model that says how it is to be run (its `experiment` annotation)

A model that fails is shown, too: with its message in place of the motion.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from msgspec.structs import replace

from planarc import compiler
from planarc.api.restore import compile_request
from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, PlanarcError, usage_error
from planarc.core.options import RunOptions
from planarc.core.source import model_files
from planarc.ir.kernel import Kernel
from planarc.ir.result import Result
from planarc.request.request import Request, is_example, open_library


class Example(Data):
    request: Request
    name: str
    description: str


class Shown(Data):
    """An example that was run. `result` and `kernel` are None where the run gave nothing: then
    there is a `problem`."""

    example: Example
    result: Result | None
    kernel: Kernel | None
    problem: Diagnostic | None = None


def find_examples(targets: Sequence[str], libraries: Sequence[Path] = ()) -> tuple[Example, ...]:
    """Complete models with an experiment, in the order of their packages."""
    found: list[Example] = []
    for target in targets:
        path = Path(target)
        if path.is_dir() and not (path / "package.mo").exists():
            for file in model_files(path):
                found += _of_request(Request(file, None, tuple(libraries)))
        elif path.is_file():
            found += _of_request(Request(path, None, tuple(libraries)))
        else:
            found += _of_request(Request(None, target, tuple(libraries)))
    return tuple(dict.fromkeys(found))


def _of_request(request: Request) -> Iterator[Example]:
    library, _, declared = open_library(replace(request, class_name=None))
    names = declared if request.file is not None else (request.class_name or "",)
    stack = [library.entry(name) for name in reversed(names)]
    if None in stack:
        hint = "name a package, a folder or a file; see `planarc list` for the names"
        raise usage_error("C103", f"there is no class `{names[0]}`", hint=hint)
    while stack:
        entry = stack.pop()
        if entry is None:
            continue
        if is_example(entry):
            own = replace(request, class_name=entry.full_name)
            yield Example(own, entry.full_name, entry.definition.comment)
        stack += [entry.child(name) for name in reversed(entry.child_names())]


def run_examples(
    examples: Sequence[Example], progress: Callable[[int, int, str], None] | None = None
) -> Iterator[Shown]:
    """Run each example as its experiment says."""
    for i, example in enumerate(examples):
        if progress is not None:
            progress(i, len(examples), example.name)
        yield _run(example)


def _run(example: Example) -> Shown:
    try:
        compiled = compile_request(example.request)
        kernel = compiled.load()
        options = RunOptions(backend=compiled.backend)
        result = compiler.run(compiled, options, kernel=kernel)
    except PlanarcError as problem:
        return Shown(example, None, None, problem.diagnostics[-1])
    if not len(result.time):
        return Shown(example, None, None, result.ended)
    return Shown(example, result, kernel, result.ended)
