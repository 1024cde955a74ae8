"""The map: from a file to a result, every way that data takes.

    stage        takes               gives               in                        kept on disk
    open         Request             Target              request/request.py
    parse        source text         syntax tree         parse/parser.py           syntax, grammar
    flatten      Target              FlatModel           flatten/pipeline.py
    lower        FlatModel           Dae                 lower/pipeline.py
    mechanism    Dae                 Mechanism           insight/topology.py
    structure    Dae                 SortedDae           structure/pipeline.py
    codegen      SortedDae           Program             codegen/pipeline.py
    print        Program             code                codegen/, instance/       native
    load         Program, code       Kernel              solve/kernels/
    simulate     Kernel, options     Result              solve/simulate.py         driver
    explain      Result              Result              insight/happenings.py
    study        Result, Kernel      Insight             insight/study.py

    recall       Request             Compiled            remembered.py             models
    check        Request             Checked             probe/check.py            checks
    mobility     Compiled            Mobility            probe/check.py
    redundancy   Dae, Mechanism      Program             probe/redundancy.py
    slopes       Program             code                compiled.py               slopes
    lead         FlatModel           Compiled            compiled.py               models
    rehearse     Compiled, options   Result              export/rehearsal/         native
    handbook     library             HTML                catalog/handbook/         pages

`recall` takes the place of all up to `print` while no file has changed; `check` goes as far as
`structure`; `redundancy` makes programs until a start has nothing redundant in it; `lead` leads to
starts that `homotopy` simplifies. Stages stand in `stages.py`, and do not know each other.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec.structs import replace

from planarc import stages
from planarc.compiled import Compiled, find_lead
from planarc.core.clock import Clock
from planarc.core.data import without_collection
from planarc.core.diagnostic import Diagnostic, PlanarcError, in_one
from planarc.core.options import Backend, Redundant, RunOptions
from planarc.remembered import recall, remember
from planarc.request.request import Request, open_target

if TYPE_CHECKING:
    from planarc.ir.dae import Dae
    from planarc.ir.kernel import Kernel
    from planarc.ir.program import Program
    from planarc.ir.result import Result
    from planarc.solve.kept import Kept


def compile_model(
    request: Request, backend: Backend = Backend.NATIVE, clock: Clock | None = None
) -> Compiled:
    """All stages up to code for one back end, or what an earlier run remembered of them."""
    clock = clock or Clock()
    with clock.phase("recall"):
        if (known := recall(request, backend)) is not None:
            return Compiled.recalled(known, backend)
    with without_collection():
        target = open_target(request)
        model = stages.flatten(target, clock)
        warnings = model.warnings
        try:
            dae = stages.to_dae(model, clock, request.inputs, request.placed)
            warnings = dae.warnings
            program, notes = find_program(dae, request.redundant, clock)
        except PlanarcError as problem:
            raise problem.after(warnings) from None
        program = replace(program, figures=model.figures)
        lead = None if request.inputs or request.placed else find_lead(model, dae, backend, clock)
        del model, dae  # what follows takes their room
        compiled = Compiled.of(program, backend, clock, in_one((*warnings, *notes)), lead)
        remember(request, backend, target, compiled.as_remembered())
    return compiled


def find_program(
    dae: Dae, redundant: Redundant, clock: Clock
) -> tuple[Program, tuple[Diagnostic, ...]]:
    """The program of a scalar model, and notes about joints that it accepts."""
    mechanism = stages.find_mechanism(dae)
    if redundant is Redundant.ACCEPT and mechanism is not None:
        from planarc.probe.redundancy import accept_redundancy

        return accept_redundancy(dae, mechanism, clock)
    model = stages.to_sorted(dae, clock)
    held = stages.find_held(model, mechanism)
    program = replace(stages.to_program(model, clock), mechanism=mechanism, locked=held)
    return program, stages.attachment_warnings(dae, mechanism, held)


def run(
    compiled: Compiled,
    options: RunOptions,
    clock: Clock | None = None,
    progress: Callable[[float], None] | None = None,
    kernel: Kernel | Kept | None = None,
) -> Result:
    """The one door to a run. A `kernel` that was loaded before, or is driven, is used as it is."""
    clock = clock or Clock()
    if not options.solver.home:
        from planarc.export.rehearsal.run import rehearse

        return stages.explain(rehearse(compiled, options, clock, progress), options.tolerance)
    from planarc.solve.simulate import simulate

    with clock.phase("load"):
        kernel = kernel or compiled.load()
    with clock.phase("simulate"):
        result = simulate(compiled.program, kernel, options, progress=progress)
        return stages.explain(result, options.tolerance)


def simulate(
    file: Path | None = None,
    class_name: str | None = None,
    *,
    libraries: Sequence[Path] = (),
    options: RunOptions | None = None,
) -> Result:
    """Compile and run a file, or a class of a library."""
    options = options or RunOptions()
    redundant = options.redundant or Redundant.REFUSE
    request = Request(file, class_name, tuple(libraries), redundant=redundant)
    return run(compile_model(request, options.backend), options)
