"""A program as Python text: the readable form, and the reference for the native one.

In:   Program
Out:  one module of six functions over the workspace `w` (a list of floats):

    parameters(t, w, blocks)   levels(...)   rest(...)   initial(...)   roots(...)   discrete(...)

Example, position and velocity of a slider in a loop:

    block = blocks[0]
    tears = block.start(t)
    while True:
        rev_phi, slide_s = tears
        if block.done:
            break
        tears = block.step((L*sin(rev_phi) - slide_s,), ((L*cos(rev_phi), -1.0),))
    t1 = 0.0
    der_rev_phi, der_slide_s = blocks[1].solve((t1,), ((L*cos(rev_phi), -1.0),))

`blocks[k]` holds the numbers of Newton's method (`solve.kernels.numpy.block`): `start`
gives the tears, `step` takes residuals and Jacobian and gives better tears, and after
the last step the unknowns are computed once more. A linear block is solved at once,
from its residuals where all tears are zero. The comment of a line names the unknown
and the equation (`e12`) that it came from, for people; a kernel finds the equations of
lines in a tuple.

Promises:  only names made by `names.Names` and numbers; no text of the user is code.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from planarc.codegen.certain import evaluated_always, is_part, used_always
from planarc.codegen.numpy.function import FunctionText, Line, Parts
from planarc.codegen.numpy.names import Names, comment
from planarc.codegen.refusal import NotDifferentiable
from planarc.evaluate.written import loop_text
from planarc.ir.expr import Expr, Op
from planarc.ir.program import Program

if TYPE_CHECKING:
    from planarc.ir.derivatives import Scope


def source(program: Program) -> str:
    """The Python text of a program, as people read it."""
    return _text(_lines(program))


def kernel_source(program: Program) -> str:
    """The text for a kernel: that of `source` with the tuple `equations` behind it: lines and the
    equations that they compute, ascending; -1 where a function begins. A line without an equation
    serves the next one."""
    lines = _lines(program)
    equations = [(n, line.equation) for n, line in enumerate(lines, 1) if isinstance(line, Line)]
    return _text([*lines, "", "", f"equations = {tuple(equations)}"])


def _text(lines: Sequence[str]) -> str:
    return "\n".join(lines) + "\n"


def _lines(program: Program) -> list[str]:
    names = Names()
    always = evaluated_always(program)
    lines = [
        f"# {comment(program.name)}: {program.state_count} states, {program.size} values in w.",
        "# Made by planarc. Angles in rad, all other quantities in SI units.",
    ]
    top = len(program.levels) - 1
    levels = [
        (f"level {top - i}" if i < top else "top level", statements)
        for i, statements in enumerate(program.levels)
    ]
    zeros = [r.zero for r in program.relations]
    sections: tuple[tuple[str, str, Parts, Sequence[Expr]], ...] = (
        ("parameters", "Dependent parameters and start values.", [("", program.parameters)], ()),
        ("levels", "From the states to their derivatives.", levels, ()),
        ("rest", "What only results need.", [("", program.rest)], ()),
        (
            "initial",
            "Residuals of the initial equations.",
            [("", program.initial)],
            program.initial_residuals,
        ),
        ("roots", "Zero functions of the relations.", [("", program.roots)], zeros),
        ("discrete", "One pass of the discrete equations.", [("", program.discrete)], ()),
    )
    for name, title, parts, results in sections:
        lines += ["", "", Line(f"def {name}(t, w, blocks):"), f'    """{title}"""']
        lines += FunctionText(program, names, always, parts).lines(results)
    return [*lines, *_loops(names)]


def _loops(names: Names) -> Iterator[str]:
    """The functions of the loops that have names, and of those that stand in these."""

    def call(e: Expr, a: Sequence[str]) -> str:
        given = ", ".join(a)
        match e.op:
            case Op.LOOP:
                return f"{names.of_loop(e.data[0])}({given})[{e.data[1]}]"
            case Op.APPLY:
                function, output, wrt = e.data
                if wrt:
                    raise NotDifferentiable(function)
                return f"external({function!r}, {output}, ({given},))"
        return f"safe({e.data}, {given})"

    written = 0
    while written < len(names.loops):
        loop, name = list(names.loops.items())[written]
        head, *body = loop_text(loop, name, call).splitlines()
        yield from (
            "",
            "",
            Line(head),
            f'    """A loop in {comment(loop.name)}, and whether it ended."""',
            *body,
        )
        written += 1


def slopes_source(program: Program, scope: Scope) -> str | None:
    """The text of the function `slopes`, which computes the coefficients of derivatives, and
    of the `tape` (`planarc.ir.derivatives`); None where there are none."""
    from planarc.codegen.slopes import derive_slopes

    slopes = derive_slopes(program, scope)
    if slopes is None:
        return None
    values = slopes.coefficients
    always = used_always(slopes.body, values, lambda e: is_part(program, e))
    names = Names()
    text = FunctionText(program, names, always, [("", slopes.body)])
    lines = [
        "def slopes(t, w, blocks):",
        '    """Coefficients of derivatives, in the order of the tape."""',
        *text.lines_of(values),
        *_loops(names),
        "",
        "",
        f"tape = {tuple(slopes.tape())}",
    ]
    return _text(lines)
