"""The levels below the top: what is a candidate for a state, and what follows from it.

In:   System      of a level, from the lowest one up
      Attributes  what the user said of each symbol
Out:  steps; their tears are the candidates for states

Each level is one tearing problem. Unknowns are torn in this order: StateSelect.always;
derivatives of candidates of the level below, so that velocities are chosen as positions
were; then by StateSelect (prefer, default, avoid, never); then those whose start was
written; then those that make most equations solvable; then the first. Those that the
others give all the same are no candidates (`thinning`). In a mechanism these are the
joints' coordinates, from the ground outwards; each loop leaves residuals, and the states
are the tears less the residuals, chosen while running.

Example: a crank-slider with the hinges A, B, C and the slide s

    tear A.phi, B.phi;  frames := ...;  C.phi := ...;  s := ...;  one residual: y = 0

Promises:  `StateSelect.always` is kept, or refused with what the symbol follows from.
Reference: S. E. Mattsson, G. Soederlind, SIAM J. Sci. Comput. 14(3), 1993, 677-692
           (dummy derivatives; here the choice is left to the run).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from msgspec.structs import astuple

from planarc.core.diagnostic import Diagnostic, Once, PlanarcError, Related, Severity
from planarc.core.prose import be, ticked
from planarc.core.source import Span
from planarc.ir.dae import Dae
from planarc.ir.expr import Expr, Exprs, postorder
from planarc.ir.flat import StateSelect
from planarc.ir.places import is_own, own_part, owner
from planarc.ir.sorted import Candidate, SourceEquation, Step
from planarc.structure.attributes import Attributes, plain_attributes
from planarc.structure.rewrite import NO_RESETS, Resets
from planarc.structure.steps import make_steps
from planarc.structure.system import System, Systems
from planarc.structure.tearing import Torn, tear_system
from planarc.structure.thinning import thin_tears


def sort_level(
    systems: Systems,
    system: System,
    attributes: Mapping[Expr, Attributes],
    favoured: frozenset[Expr],
) -> tuple[Step, ...]:
    """The steps of a level. `favoured` are the derivatives of the candidates of the level below."""
    rank = [_rank(symbol, attributes, favoured) for symbol in system.unknowns]
    rows = [s.row() for s in system.equations]
    torn = tear_system(rows, rank)
    if torn.residuals:
        torn = thin_tears(rows, torn, _droppable(system, torn, rank, attributes))
    return make_steps(systems, system, torn)


def _droppable(
    system: System, torn: Torn, rank: Sequence[int], attributes: Mapping[Expr, Attributes]
) -> list[int]:
    """The tears that nobody asked to be states, the least wanted ones first."""
    plain = [
        v
        for v in torn.tears
        if rank[v] > 1 and select_of(system.unknowns[v], attributes) < StateSelect.PREFER
    ]
    return sorted(plain, key=lambda v: -rank[v])


def _rank(symbol: Expr, attributes: Mapping[Expr, Attributes], favoured: frozenset[Expr]) -> int:
    select = select_of(symbol, attributes)
    if select is StateSelect.ALWAYS:
        return 0
    if symbol in favoured and select is not StateSelect.NEVER:
        return 1
    found = attributes.get(symbol)
    written = found is not None and found.start_written
    return 2 * (1 + int(StateSelect.ALWAYS) - int(select)) - int(written)


def select_of(symbol: Expr, attributes: Mapping[Expr, Attributes]) -> StateSelect:
    found = attributes.get(symbol)
    return found.select if found else StateSelect.DEFAULT


def derivatives_of_tears(table: Exprs, steps: Sequence[Step]) -> frozenset[Expr]:
    return frozenset(table.der(tear) for step in steps for tear in step.tears)


def describe_candidates(
    dae: Dae, steps: Sequence[Step], attributes: Mapping[Expr, Attributes]
) -> tuple[Candidate, ...]:
    symbols = (tear for step in steps for tear in step.tears)
    known = ((s, attributes.get(s) or plain_attributes(dae, s)) for s in symbols)
    return tuple(Candidate(symbol, *astuple(a)) for symbol, a in known)


def check_always(
    steps: Sequence[Step],
    attributes: Mapping[Expr, Attributes],
    equations: Sequence[SourceEquation],
    resets: Resets = NO_RESETS,
    dae: Dae | None = None,
) -> None:
    """A symbol with StateSelect.always is a candidate, and its block has states enough.

    Of what is set by a `reinit` and is no state, the states from which it follows can be found
    only where no equations have to be solved for it, or where there is one such state: a momentum
    `p = m*v` takes the place of `v`.
    """
    wrong = []
    for step in steps:
        always = [t for t in step.tears if select_of(t, attributes) is StateSelect.ALWAYS]
        if len(always) > step.free:
            if all(t in resets.symbols for t in always):
                wrong.append(_reset_together(always, step.free, attributes, resets))
                continue
            names = ticked(attributes[t].display for t in always)
            spans = [equations[r.equation].span for r in step.residuals]
            wrong.append(
                Diagnostic(
                    "S308",
                    f"{names} cannot all be states: only {step.free} of them "
                    f"{be(step.free)} independent",
                    *_place_and_cure(
                        attributes[always[-1]],
                        "take `StateSelect.always` away from the others",
                        [Related("this equation ties them", span) for span in dict.fromkeys(spans)],
                        dae,
                    ),
                )
            )
        wrong += [
            _no_state(attributes[t], equations[step.residuals[0].equation], resets)
            for t in step.tears
            if t in resets.stateless and step.residuals and not _replaces_one(step, resets)
        ]
        wrong += [
            _follows(attributes[a.target], a.target, equations[a.equation], resets, dae)
            if a.target in resets.symbols
            else _asked_too_much(attributes[a.target], equations[a.equation], dae)
            for a in step.inner
            if select_of(a.target, attributes) is StateSelect.ALWAYS
        ]
    if wrong:
        kinds = {w.kind if isinstance(w, Once) else str(n): w for n, w in enumerate(wrong[::-1])}
        raise PlanarcError([*kinds.values()][::-1])


def _replaces_one(step: Step, resets: Resets) -> bool:
    """Whether a block ties what is set to one state, or one derivative of a state, alone."""
    within = postorder([*(r.value for r in step.residuals), *(a.value for a in step.inner)])
    return len({e for e in within if e.is_symbol and e.name in resets.states}) == 1


def _reset_together(
    always: Sequence[Expr], free: int, attributes: Mapping[Expr, Attributes], resets: Resets
) -> Diagnostic:
    """The refusal of more `reinit`s than there are motions to set."""
    names = ticked(attributes[t].display for t in always)
    if not free:
        span = resets.spans.get(always[0], attributes[always[0]].span)
        it = "it follows" if len(always) == 1 else "they follow"
        message = f"{names} {be(len(always))} set by `reinit`, but {it} from the states"
        return Diagnostic("S313", message, span, hint=resets.hint)
    spans = list(dict.fromkeys(resets.spans[t] for t in always if t in resets.spans))
    hint = f"leave {len(always) - free} of these `reinit` out: what is set there follows"
    if len(spans) == 1 < len(always):  # of an array
        likely = attributes[always[0]].display
        hint = f"set what moves alone, such as `reinit({likely}, ...)`: the other entries follow"
    return Diagnostic(
        "S308",
        f"{names} are all set by `reinit`, but only {free} of them {be(free)} independent",
        spans[-1] if spans else attributes[always[-1]].span,
        hint=hint,
        related=tuple(Related("this one is another", span) for span in spans[:-1]),
    )


def _asked_too_much(a: Attributes, source: SourceEquation, dae: Dae | None) -> Diagnostic:
    """The refusal of a symbol that must be a state and is computed."""
    message = f"`{a.display}` has `StateSelect.always`, but follows from other variables"
    hint = "use `StateSelect.prefer`, or take `always` away from what it follows from"
    told = _place_and_cure(a, hint, [Related("from this equation", source.span)], dae)
    return Once("S307", message, *told, kind=a.display if told[0] == a.span else owner(a.display))


def _place_and_cure(
    a: Attributes, hint: str, notes: Sequence[Related], dae: Dae | None
) -> tuple[Span, Severity, str, tuple[Related, ...]]:
    """Where a state that is asked for in vain is told, and what to do: at the user's part, where a
    flag of that asks for it."""
    component = owner(a.display)
    part = own_part(dae, component) if dae is not None and component else None
    if dae is None or part is None or is_own(dae, a.span):
        return a.span, Severity.ERROR, hint, tuple(notes)
    if f"{component}.enforceStates" in {p.name for p in dae.parameters}:
        hint = f"leave `enforceStates=true` out of `{part.name}`: joints give its motion"
    return part.span, Severity.ERROR, hint, (Related("it is declared here", a.span),)


def _follows(
    a: Attributes, target: Expr, source: SourceEquation, resets: Resets, dae: Dae | None
) -> Diagnostic:
    """The refusal of a `reinit` of what is computed, at that `reinit`."""
    own, component = None, source.equation.component
    if dae is not None and component and component != owner(a.display):
        own = own_part(dae, component)
    span, hint, by = resets.spans.get(target, a.span), resets.hint, "other variables"
    related = (Related("from this equation", source.span),)
    if own is not None:
        by, related = f"`{own.name}`", (Related(f"`{own.name}` is declared here", own.span),)
        if dae is not None and own.name in dae.drives:
            hint = f"leave the `reinit` out, or `{own.name}`, which gives it at any time"
    message = f"`{a.display}` is set by `reinit`, but follows from {by}"
    return Diagnostic("S313", message, span, hint=hint, related=related)


def _no_state(a: Attributes, source: SourceEquation, resets: Resets) -> Diagnostic:
    """The refusal of a `reinit` of what other variables give, and no derivative moves."""
    message = f"`{a.display}` is set by `reinit`, but is no state: nothing differentiates it"
    related = (Related("it follows from this equation", source.span),)
    return Diagnostic("S313", message, a.span, hint=resets.hint, related=related)
