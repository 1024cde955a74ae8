"""The short summary of a run: labels with texts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from planarc.core.prose import counted, shortened
from planarc.ir.result import Held, Result, StateChoice

MOST_EVENTS = 20  # that `--verbose` shows
MOST_NAMES = 8  # of a list of names that are shown


def summary(
    result: Result, seconds: Mapping[str, float], cached: bool, written: Sequence[str]
) -> tuple[tuple[str, str], ...]:
    """The rows of the summary, in the order in which a reader asks."""
    program, statistics = result.program, result.statistics
    about = f"{program.name}: {program.description}" if program.description else program.name
    rows = [
        ("model", about),
        (
            "equations",
            f"{program.equations_before}, after reduction {program.equations_after}",
        ),
        ("states", states(moving_states(result))),
        ("start", start_values(result.held)),
        ("solver", solver(statistics.solver, statistics.backend, statistics.reason)),
        ("steps", statistics.effort),
        ("time", times(seconds, cached)),
        ("written", "\n".join(written)),
    ]
    return tuple((label, text) for label, text in rows if text)


def details(result: Result) -> tuple[tuple[str, str], ...]:
    """The rows that `--verbose` adds: the integrator's work, and the events with their causes."""
    statistics = result.statistics
    work = ""
    if statistics.steps is not None:
        work = (
            f"{statistics.rhs_calls} of the right-hand side, {statistics.jacobians} of its "
            f"Jacobian, {counted(statistics.error_test_failures, 'step')} rejected"
        )
    happened = [f"t = {e.time:.6g} s: {_names(e.causes)}" for e in result.events[:MOST_EVENTS]]
    if len(result.events) > MOST_EVENTS:
        happened.append(f"and {len(result.events) - MOST_EVENTS} more")
    rows = [("calls", work), ("events", "\n".join(happened))]
    return tuple((label, text) for label, text in rows if text)


def solver(name: str, backend: str, reason: str) -> str:
    return f"{name}, {backend} back end" + (f" ({reason})" if reason else "")


def states(choices: Sequence[StateChoice]) -> str:
    """The states, and when others were chosen while running."""
    if not choices:
        return "none"
    lines = [f"{_names(c.states)} from t = {c.time:.6g} s" for c in choices[-MOST_NAMES:]]
    if len(choices) == 1:
        return _names(choices[0].states) or "none"
    return "\n".join([f"chosen {len(choices)} times", *lines])


def moving_states(result: Result) -> list[StateChoice]:
    """The states without parameters that the start finds: to the integrator alone they are some."""
    constant = {c.display for c in result.program.candidates if c.at_start}
    return [
        StateChoice(c.time, tuple(name for name in c.states if name not in constant))
        for c in result.states
    ]


def state_reasons(result: Result) -> str:
    """Why these are the states: what the model says of them, among how many candidates."""
    select = {c.display: c.select for c in result.program.candidates if not c.at_start}
    chosen = [name for c in result.states[-1:] for name in c.states if name in select]
    if not chosen:
        return ""
    kinds = sorted({select[name] for name in chosen}, reverse=True)
    said = [
        f"StateSelect.{kind.name.lower()}: {_names([n for n in chosen if select[n] is kind])}"
        for kind in kinds
    ]
    rule = "the best conditioned choice" if len(chosen) < len(select) else "all"
    return "\n".join([*said, f"{rule} of {counted(len(select), 'candidate')}"])


def start_values(held: Sequence[Held], units: Mapping[str, tuple[float, str]] | None = None) -> str:
    """The values held at the start, and the ways that guesses moved (farthest first).

    `units` has factors and units for names; other numbers stand as they are.
    """

    def told(name: str, *values: float) -> str:
        factor, unit = (units or {}).get(name, (1.0, ""))
        return f"{name} = {' -> '.join(f'{factor * v:.6g}' for v in values)} {unit}".rstrip()

    lines = []
    exact = [told(h.name, h.start) for h in held if h.held]
    if exact:
        lines.append("held " + _names(exact))
    moved = sorted(
        (h for h in held if not h.held and abs(h.value - h.start) > 1e-9 * max(1.0, abs(h.start))),
        key=lambda h: -abs(h.value - h.start),
    )
    if moved:
        lines.append("guessed " + _names([told(h.name, h.start, h.value) for h in moved]))
    return "\n".join(lines)


def times(seconds: Mapping[str, float], cached: bool) -> str:
    """The whole time, and that of each phase in the order in which they ran."""
    phases = ", ".join(f"{p} {milliseconds(s)}" for p, s in seconds.items() if p != "total")
    note = " (compiled before)" if cached else ""
    return f"{milliseconds(seconds['total'])} in all{note}: {phases}"


def milliseconds(seconds: float) -> str:
    ms = 1000 * seconds
    return f"{ms:.0f} ms" if ms >= 10 else f"{ms:.1f} ms"


def _names(names: Sequence[str]) -> str:
    return shortened(names, MOST_NAMES) or "none"
