"""Code generation: a sorted model becomes a program of statements over a workspace.

In:   SortedDae
Out:  Program

Example, a pendulum: m*L^2*der(w) = -m*g*L*sin(phi), der(phi) = w

    parameters    start(phi), start(der(phi)); $p1 := m*g*L, $p2 := m*L^2
    level 1       states phi, der(phi)
    level 0       der(der(phi)) := -$p1*sin(phi)/$p2
    rest          what only results show

Needs:     the promises of `structure` (ir.sorted).
Promises:  `tests/ir/check/program.py` finds nothing to complain of; the same input gives the
           same program, number for number.
"""

from __future__ import annotations

from planarc.codegen.certain import mark_certain
from planarc.codegen.sections import write_sections
from planarc.codegen.tables import Tables
from planarc.ir.actions import rewrite_action
from planarc.ir.dae import Equation
from planarc.ir.program import EquationInfo, Program
from planarc.ir.sorted import SortedDae


def generate(sorted: SortedDae) -> Program:
    """The program of a sorted model."""
    sections = write_sections(sorted)
    tables = Tables(sorted, sections)
    dae = sorted.dae
    relations = tuple(r.text for r in dae.relations)
    written = (*(e.equation for e in sorted.equations), *sections.origins)
    equations = tuple(equation_info(e, relations) for e in written)
    return mark_certain(
        Program(
            name=dae.name,
            table=dae.table,
            size=sections.layout.size,
            slots=sections.layout.slots,
            columns=tables.columns(),
            parameter_slots=tables.parameters(),
            candidates=tables.candidates(),
            fixed=tables.fixed(),
            discretes=tables.discretes(),
            relations=tables.relations(),
            turning=tables.turning(),
            samplers=tables.samplers(),
            whens=tables.whens(),
            delays=tables.delays(),
            limits=tables.limits(),
            enumerations=tables.enumerations(),
            texts=dae.texts,
            assertions=tuple(
                rewrite_action(a, dae.table, sections.aliases) for a in dae.assertions
            ),
            blocks=sections.blocks,
            parameters=sections.parameters,
            levels=sections.levels,
            rest=sections.rest,
            initial=sections.initial,
            initial_residuals=sections.initial_residuals,
            roots=sections.roots,
            discrete=sections.discrete,
            equations=equations,
            initial_equations=tuple(equations[r.equation] for r in sorted.initial_residuals),
            guesses=tables.guesses(),
            visuals=dae.visuals,
            declared=dae.declared,
            parts=dae.parts,
            start_places=dae.start_places,
            experiment=dae.experiment,
            equations_before=sorted.equations_before,
            equations_after=sorted.equations_after,
            description=dae.description,
            span=dae.span,
            inputs=tuple(v.name for v in dae.inputs),
            outputs=tuple(
                v.name for v in (*dae.variables, *dae.discretes) if v.causality == "output"
            ),
        )
    )


def equation_info(equation: Equation, relations: tuple[str, ...] = ()) -> EquationInfo:
    sides = equation.left, equation.right
    ticks = equation.clock is not None
    return EquationInfo(sides, equation.span, equation.component, relations, ticks)
