"""`planarc compile`: the code that a model becomes."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer

from planarc.cli import console
from planarc.cli.arguments import ClassName, Libraries, Target, make_request


class Emit(StrEnum):
    NUMPY = "numpy"
    LLVM = "llvm"


def compile_model(
    target: Target,
    class_name: ClassName = None,
    emit: Annotated[Emit, typer.Option(help="The language of the code.")] = Emit.NUMPY,
    library: Libraries = None,
) -> int:
    """Print the generated code of a model."""
    from planarc import compiler
    from planarc.request import open_target

    flat = compiler.flatten(open_target(make_request(target, class_name, library)))
    console.complain(flat.warnings)
    program = compiler.to_program(compiler.to_sorted(compiler.to_dae(flat)))
    if emit is Emit.NUMPY:
        from planarc.codegen.numpy.printer import source as print_program
    else:
        from planarc.codegen.native.printer import source as print_program
    console.say(print_program(program))
    return 0
