"""What goes wrong at an event, in words."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence

from planarc.core.diagnostic import Diagnostic, Related, Severity
from planarc.core.prose import listed
from planarc.core.source import NOWHERE, Span
from planarc.ir.dae import Reinit, SetDiscrete, Terminate
from planarc.ir.expr import Op, postorder
from planarc.ir.kernel import Kernel
from planarc.ir.places import point_home
from planarc.ir.program import Let, Program, RelationSlot
from planarc.solve.messages import trouble
from planarc.solve.messages.failure import Place, not_finite
from planarc.solve.messages.hollows import too_big
from planarc.solve.messages.text import Reader


def unsolved(program: Program, kernel: Kernel, t: float, reset: Sequence[str]) -> Diagnostic:
    """The equations have no solution with what an event changed; `reset` are the variables
    that a `reinit` set there."""
    block = kernel.failed_block
    if block < 0:
        return not_finite(program, kernel, Place(t), t)
    worst = trouble.worst_equations(program, kernel, t, block)
    infos = [info for _, info in worst]
    names = trouble.components(program, infos)
    subject = trouble.subject(names, infos)
    message = f"at the event at t = {t:.6g} s {subject} could not be solved"
    hint = "these equations may have no solution after the event: look at what it changes"
    if program.mechanism is not None:
        hint = "the mechanism may be stretched or jammed here: look at its position at this time"
    if reset:
        message += f" with what `reinit` gives to {trouble.names(reset)}"
        hint = "reinit to a value that the closed loops allow, near to the one before"
    elif hollow := too_big(program, kernel, (info.component for info in infos)):
        hint = hollow
    found = trouble.Unsolved(
        "R422",
        message,
        infos[0].span if infos else None,
        hint=hint,
        related=tuple(Related(trouble.told(v, i), i.span) for v, i in worst),
    )
    return point_home(program, found, infos[0].component if infos else "")


def endless(program: Program, t: float, values: Iterable[Sequence[float]]) -> Diagnostic:
    """The refusal of an event that does not come to rest. `values` are truths of relations and
    discrete values of the last iterations at `t`."""
    values, first = list(values), len(program.relations)
    numbers = zip((d.name for d in program.discretes), values[-1][first:], strict=True)
    if (lost := undefined(program, t, dict(numbers))) is not None:
        return lost
    names = [_named(r) for r in program.relations]
    names += [f"`{d.name}`" for d in program.discretes]
    given = _statements(program)
    spans: list[Span | None] = [r.span for r in program.relations]
    spans += _places(program, [d.name for d in program.discretes])
    owners = [r.component for r in program.relations]
    owners += [d.name.rpartition(".")[0] for d in program.discretes]
    columns = zip(*values, strict=True)
    restless = [i for i, found in enumerate(columns) if len(set(found)) > 1]
    shown = [i for i in restless if not names[i].startswith("`$")]  # those of our own are none
    restless = shown or restless
    culprits = ", ".join(names[i] for i in shown[:4]) or "the when-clauses"
    switch = "switches" if len(restless) == 1 else "switch"
    hint = "break the loop with `pre(...)`, or make the relation's two sides agree"
    own = [program.discretes[i - first].name for i in restless if i >= first]
    counting = next((n for n in own if n in given and _counts(given[n])), None)
    if counting is not None:
        hint = f"each pass of the event counts `{counting}` on: set it in a `when`, which acts once"
    found = Diagnostic(
        "R433",
        f"the events at t = {t:.6g} s do not come to rest: {culprits} {switch} to and fro",
        spans[restless[0]] if restless else None,
        hint=hint,
    )
    return point_home(program, found, owners[restless[0]] if restless else "")


def _counts(statement: Let) -> bool:
    """Whether a statement adds to the value that a discrete variable had before."""
    terms = (a for e in postorder((statement.value,)) if e.op is Op.ADD for a in e.args)
    return any(a.op is Op.PRE and a.name == statement.target.name for a in terms)


def _statements(program: Program) -> dict[str, Let]:
    """What gives discrete variables outside of all when-clauses, in the order of computation."""
    return {s.target.name: s for s in program.discrete if isinstance(s, Let)}


def _places(program: Program, names: Iterable[str]) -> list[Span | None]:
    """Where the user gives discrete variables, or parameters, their values."""
    actions = (a for w in program.whens for branch in w.branches for a in branch[-1])
    places = {p.name: p.span for p in program.parameter_slots if p.span is not NOWHERE}
    places |= {a.name: a.span for a in actions if isinstance(a, SetDiscrete)}
    given = _statements(program)
    return [places.get(name) or _given(program, given, name) for name in names]


def _given(program: Program, given: Mapping[str, Let], name: str) -> Span | None:
    """The statement that gives a discrete variable outside of all when-clauses; in an algorithm the
    first one that assigns to it."""
    number = given[name].equation if name in given else None
    if number is None or number < 0:
        return None
    span = program.equations[number].span
    local = re.escape(name.rpartition(".")[2])
    found = re.search(rf"(?<![\w.]){local}\s*:=[^;]*", span.text)
    if found is None:
        return span
    return span._replace(start=span.start + found.start(), end=span.start + found.end())


def chattering(
    program: Program, kernel: Kernel, t: float, often: Sequence[int | str]
) -> Diagnostic:
    """The refusal of events that come again and again. `often` are the causes that come again and
    again: relations by their numbers, others by their texts."""
    relations = [program.relations[c] for c in often if isinstance(c, int)]
    told = [f"`{c}`" if isinstance(c, str) else _named(program.relations[c]) for c in often]
    told = list(dict.fromkeys(told))
    first = relations[0] if relations else None
    switch = "switches" if len(told) == 1 else "switch"
    found = Diagnostic(
        "R432",
        f"events follow each other without end at t = {t:.6g} s: {listed(told)} {switch} "
        f"to and fro{_sides(program, kernel, first)}",
        first.span if first else None,
        hint="let the model come to rest there (a stuck or resting mode), let it switch on and "
        "off at different values, or make the jump smooth",
    )
    return point_home(program, found, first.component if first else "")


def passed(
    program: Program,
    kernel: Kernel,
    number: int,
    since: float,
    reset: Sequence[str],
    slowed: bool,
) -> Diagnostic:
    """The warning of a bound at which a `reinit` held back, or only `slowed` down, what went on
    behind it. The workspace is that of the end."""
    relation = program.relations[number]
    does, states = "stops the motion for an instant, then it goes on", trouble.names(reset)
    if slowed:
        does = "keeps its direction, so that the motion goes on"
    part = ", or take a part that touches, as `Contact`" if program.mechanism is not None else ""
    found = Diagnostic(
        "R444",
        f"{_named(relation)} does not switch back after t = {since:.6g} s: `reinit` of "
        f"{states} {does} behind that bound{_sides(program, kernel, relation)} at the end",
        relation.span,
        Severity.WARNING,
        hint=f"to bounce, write `reinit` with the other sign, as in `-e*pre({reset[0]})`"
        if slowed
        else "a `when` acts once, at the instant at which its condition becomes true: let a force "
        f"hold there what is to rest{part}",
    )
    return point_home(program, found, relation.component)


#: Values below this are told as such: their digits depend on the machine.
_SMALL = 1e-6


def _sides(program: Program, kernel: Kernel, relation: RelationSlot | None) -> str:
    """The values of the variables in a relation, where they have some."""
    columns = {c.name: c for c in program.columns}
    names = re.findall(r"[A-Za-z_][\w.]*(?:\[\d+\])?", relation.text) if relation else []
    told = []
    for local in dict.fromkeys(names):
        inside = f"{relation.component}.{local}" if relation else local
        name = inside if inside in columns else local
        if name in columns:
            value = columns[name].sign * float(kernel.w[columns[name].slot])
            small = abs(value) < _SMALL
            told.append(f"|`{name}`| < {_SMALL:g}" if small else f"`{name}` = {value:.4g}")
    return f", with {listed(told)}" if told else ""


def sampling(span: Span, start: float, interval: float, ticks: float, endless: bool) -> Diagnostic:
    """A sampler that never ticks, or often, is warned of, one that ticks without end is refused."""
    if interval <= 0:
        return Diagnostic(
            "R434",
            f"`sample({start:g}, {interval:g})` never becomes true: its interval is not positive",
            span,
            Severity.WARNING,
            hint="give `sample` an interval greater than zero"
            + (f": the start comes first, `sample(0, {start:g})`" if start > 0 else ""),
        )
    often = f"`sample({start:g}, {interval:g})` becomes true {ticks:.3g} times in this run"
    hint = "choose a longer interval, or a shorter run"
    if not endless:
        slow = f"{often}, each an event, of which some ten thousand are done in a second"
        return Diagnostic("R434", slow, span, Severity.WARNING, hint=hint)
    refused = f"{often}: these are more instants than it can take, or can tell apart"
    return Diagnostic("R434", refused, span, hint=hint)


def oscillating(relation: RelationSlot) -> Diagnostic:
    """A relation of time alone that switches too often to be followed."""
    return Diagnostic(
        "R434",
        f"{_named(relation)} switches more than a million times in this run: these are more "
        "instants than it can take",
        relation.span,
        hint="choose a shorter run, or put the mean of what switches in its place",
    )


def _named(relation: RelationSlot) -> str:
    place = f" in `{relation.component}`" if relation.component else ""
    return f"`{relation.text}`{place}"


def ticked(program: Program, read: Reader, i: int) -> str:
    """A sampler that fires, as the cause of an event."""
    _, start, interval, _ = program.samplers[i]
    return f"sample({read(start):g}, {read(interval):g})"


def terminated(t: float, action: Terminate, message: str) -> Diagnostic:
    return Diagnostic("R431", f"terminated at t = {t:.6g} s: {message}", action.span, Severity.NOTE)


#: What has no finite value.
_NONE = "look for a division by zero, or the root of a negative number"


def no_value(program: Program, t: float, name: str, action: SetDiscrete | Reinit) -> Diagnostic:
    message = f"at t = {t:.6g} s the value that the event gives `{name}` is no finite number"
    found = Diagnostic("R421", message, action.span, hint=_NONE)
    return point_home(program, found, name.rpartition(".")[0])


def undefined(program: Program, t: float, values: Mapping[str, float]) -> Diagnostic | None:
    """The refusal of a discrete variable that is no number, the first of them to be computed."""
    computed = (n for n in _statements(program) if n in values)
    none = [n for n in dict.fromkeys((*computed, *values)) if math.isnan(values[n])]
    return inexact_integer(program, t, none[0], math.nan) if none else None


def inexact_integer(program: Program, t: float, name: str, value: float) -> Diagnostic:
    (place,) = _places(program, [name])
    shown = place.text if place is not None and name.startswith("$") else name
    message, hint = f"at t = {t:.6g} s the value of `{shown}` is no finite number", _NONE
    if math.isfinite(value):
        message = f"at t = {t:.6g} s the Integer `{name}` becomes {value:.6g}: beyond 2^53 not all "
        message += "Integers are told apart"
        hint = "use a Real, or count anew from time to time"
    code = "R439" if math.isfinite(value) else "R421"
    found = Diagnostic(code, message, place, hint=hint)
    return point_home(program, found, name.rpartition(".")[0])
