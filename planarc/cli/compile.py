"""`planarc compile`: the code that a model becomes."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

from planarc.cli import console
from planarc.cli.arguments import ClassName, Libraries, Target, Undrawn, make_request
from planarc.cli.line import Option

if TYPE_CHECKING:
    from planarc.ir.program import Program


class Emit(StrEnum):
    NUMPY = "numpy"
    LLVM = "llvm"


def compile_model(
    target: Target,
    class_name: ClassName = None,
    emit: Annotated[Emit, Option(help="The language of the code.")] = Emit.NUMPY,
    no_drawing: Undrawn = False,
    library: Libraries = None,
) -> int:
    """Print the generated code of a model."""
    from planarc import stages
    from planarc.ir.undrawn import without_drawing
    from planarc.request.request import open_target

    flat = stages.flatten(open_target(make_request(target, class_name, library)))
    console.complain(flat.warnings)
    dae = stages.to_dae(without_drawing(flat) if no_drawing else flat)
    program = stages.to_program(stages.to_sorted(dae))
    console.say(code_text(program, emit))
    return 0


def code_text(program: Program, emit: Emit) -> str:
    """The program in one of the languages."""
    if emit is Emit.NUMPY:
        from planarc.codegen.numpy.printer import source

        return source(program)
    from planarc.codegen.native.printer import ir

    return ir(program)
