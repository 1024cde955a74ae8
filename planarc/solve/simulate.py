"""A program simulated: its request, its workspace, its run, its result.

In:   Program, Kernel, RunOptions
Out:  Result

    request    times, tolerance, parameters and start values, checked
    workspace  parameters, what depends on them, and start values
    run        from the start to the end, or to where it cannot go on (`run`)

A run that cannot go on does not raise: it returns what it has, and says in
`Result.ended` why it ended. Only what fails before the first row raises.
"""

from __future__ import annotations

from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic, PlanarcError, Related, RigidLoop, Severity
from planarc.core.options import RunOptions
from planarc.ir.kernel import Kernel
from planarc.ir.program import Program
from planarc.ir.result import Interrupted, Result
from planarc.solve.doubts import doubts
from planarc.solve.events.asserts import impossible_parameters
from planarc.solve.kept import Kept
from planarc.solve.run import Progress, Run
from planarc.solve.settings import Request, resolve


def simulate(
    program: Program,
    kernel: Kernel | Kept,
    options: RunOptions,
    *,
    progress: Progress | None = None,
) -> Result:
    """Run the program. `progress` is called now and then with the simulated time. With a kernel
    that is kept its integrator stays after a run without failure.

    Raises `UsageError` for a wrong request, `PlanarcError` where no start exists.
    """
    kept = kernel if isinstance(kernel, Kept) else None
    if isinstance(kernel, Kept):
        kernel = kernel.kernel
    request = resolve(program, options)
    try:
        known = kept.integrator if kept else None
        run = Run(program, kernel, request, str(options.backend), known)
    except PlanarcError:
        _blame_parameters(program, kernel, request)
        raise
    whole = False
    try:
        try:
            run.begin()
        except PlanarcError as problem:
            _blame_parameters(program, kernel, request)
            doubt = impossible_parameters(program, kernel, request.start, warnings=True)
            raise with_reason(problem, program, doubt) from None
        with run.interruption:
            try:
                run.go(progress)
            except KeyboardInterrupt:
                run.ended = Interrupted("R440", f"interrupted at t = {run.integrator.t:.6g} s")
            result = run.result()
            if still := _nothing_moves(run):
                result = replace(result, warnings=(*result.warnings, *still))
            result = _with_doubts(result, doubts(program, options))
            whole = result.ended is None
            return result
    finally:
        if kept is not None and whole:
            kept.keep(run.integrator)
        else:
            run.close()


def _with_doubts(result: Result, found: tuple[Diagnostic, ...]) -> Result:
    """Values that were hardly meant: told with the error that ended the run, else by themselves."""
    if not found:
        return result
    ended = result.ended
    if ended is not None and ended.severity is Severity.ERROR:
        notes = tuple(Related(d.message) for d in found)
        return replace(result, ended=replace(ended, related=(*notes, *ended.related)))
    return replace(result, warnings=(*result.warnings, *found))


def _blame_parameters(program: Program, kernel: Kernel, request: Request) -> None:
    """Raise the assertion on parameters that fails, instead of what came of it."""
    reason = impossible_parameters(program, kernel, request.start)
    if reason is not None:
        raise PlanarcError(reason) from None


def with_reason(
    problem: PlanarcError, program: Program, doubt: Diagnostic | None = None
) -> PlanarcError:
    """The problem, and why: what a component warns of its parameters, a connection that may have
    been copied, or that nothing moves."""
    from planarc.solve.start.redundancy import Redundant
    from planarc.solve.start.refused import NotAssembled

    mechanism = program.mechanism
    if doubt is None and mechanism is not None and isinstance(problem, NotAssembled | Redundant):
        first, *others = problem.diagnostics
        if (told := mechanism.with_copied(first)) is not first:
            return type(problem)((told, *others))
    lock = doubt or program.locked
    if lock is None and mechanism is not None:
        lock = mechanism.locked
    if lock is None or not isinstance(problem, NotAssembled):
        return problem
    first, *others = problem.diagnostics
    rigid = isinstance(lock, RigidLoop) and not lock.related
    if lock in (doubt, program.locked) or first.code == "R411" or rigid:  # the start is not wrong
        notes: tuple[Related, ...] = (Related(first.message, first.span),)
        notes = () if first.span == lock.span else notes
        notes += lock.related
        found = replace(lock, code=first.code, severity=first.severity, related=notes)
        return NotAssembled((found, *others))
    if lock.related:  # parts are connected without a joint: lengths are hardly the reason
        notes, hint = (Related(lock.message, lock.span), *lock.related), lock.hint
    else:
        notes, hint = (Related(f"{lock.message}; {lock.hint}", lock.span),), first.hint
    found = replace(first, related=(*first.related, *notes), hint=hint)
    return NotAssembled((found, *others))


def _nothing_moves(run: Run) -> tuple[Diagnostic, ...]:
    """The warning that nothing moves: a mechanism has no states, but for what the start decides for
    the whole run, and by count no freedom. Redundant joints that are accepted make the count wrong:
    then a drive may move all of it."""
    program, w = run.program, run.kernel.w
    mechanism, accepted = program.mechanism, program.sharing is not None
    lock = None if mechanism is None or accepted else mechanism.locked
    if lock is None or any(w[program.candidates[i].derivative] for i in run.states.selection):
        return ()
    return (lock,)
