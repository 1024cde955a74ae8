"""Diagnostics: what went wrong, where, and what to do, as data.

Stages raise `PlanarcError` with one or more diagnostics, or collect warnings;
`render` alone turns them into text. Codes are a letter for the stage and three
digits: C usage and files, P parse, F flatten, L lower, S structure,
G code generation, R run, V view.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.mend import Accept, Declare, Meant, Mend
from planarc.core.source import Span


class Severity(Enum):
    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


class Related(Data):
    """A second place that belongs to a diagnostic, with what it shows; `detail` is shown with
    `--verbose` only."""

    message: str
    span: Span | None = None
    detail: bool = False


class Diagnostic(Data):
    """One message. `message` is lower case, names in backticks; `hint` an imperative.

    `code` is a key: `planarc explain CODE`. `span` is the place in a text, None where there is
    none, and `related` are further places. `mend` is what an editor offers to do.
    """

    code: str
    message: str
    span: Span | None = None
    severity: Severity = Severity.ERROR
    hint: str | None = None
    related: tuple[Related, ...] = ()
    mend: Mend | None = None

    def noting(self, others: Iterable[Diagnostic]) -> Diagnostic:
        """The same, with other messages as the first of its further places."""
        told = (Related(f"{o.message}; {o.hint}" if o.hint else o.message, o.span) for o in others)
        return replace(self, related=(*told, *self.related))


class Once(Diagnostic):
    """A message that is told once for all places of one `kind`."""

    kind: str = ""


class Ungiven(Diagnostic):
    """Whoever uses a component gives what is missing: a value, a size, or what is `inner`."""


class UngivenOnce(Ungiven, Once):
    pass


class Varies(UngivenOnce):
    """A variable stands where a value is wanted that never changes; `kind` is its name."""


class Explained(Diagnostic):
    """An error whose hint tells the cause: a warning of its place is no better one."""


class Unconnected(Diagnostic):
    """The warning that nothing is connected to a connector that was asked for."""

    connector: str = ""


class Loose(Diagnostic):
    """Parts that nothing joins to the ground; `open` are connectors of theirs that are free."""

    open: tuple[str, ...] = ()


class Locked(Diagnostic):
    """Parts that are held where they are."""


class RigidLoop(Locked):
    """The same, by a loop of three joints, of which a motion is asked: lengths are not the reason
    why it does not start."""


class Bound(Locked):
    """The same, by equations that may depend on others: then they hold nothing."""


class Exhausted(Diagnostic):
    """The end of a run whose steps become too short, or whose values too large."""


class Laborious(Diagnostic):
    """A stretch of a run that takes very many steps."""


class HeldAgainst(Diagnostic):
    """A start value that is held against the equations."""


class Still(Diagnostic):
    """That nothing moves in a run, which what else is told may explain."""


class Secondary(Diagnostic):
    """What a warning of the same part explains: that a controller is at its limit, or a part far
    larger than its mechanism."""


class Limited(Secondary):
    """That a controller is at its limit."""


class Oversized(Secondary):
    """That a part is far larger than its mechanism, which may be why it moves so fast."""


class Sparse(Diagnostic):
    """That the rows of a run do not show a motion, which is faster than it was meant where a part
    is far too large."""


class Massless(Diagnostic):
    """That nothing has a mass behind a joint, which may be why no start is found."""


class Runaway(Diagnostic):
    """A motion that grows beyond all bounds."""


class Repelling(Diagnostic):
    """What drives away from where it is to go, so that a motion grows beyond all bounds."""


class Miscounted(Diagnostic):
    """Equations are too many or too few, as they may be where a part of the text is broken."""


class Undecided(Miscounted):
    """Unknowns that nothing decides; `names` are those as the message has them."""

    names: tuple[str, ...] = ()


class PlanarcError(Exception):
    """The model, its files or the request are wrong; carries the diagnostics.

    As a text it is what the command line prints: messages with their places and hints.
    """

    def __init__(self, diagnostics: Diagnostic | Iterable[Diagnostic]) -> None:
        if isinstance(diagnostics, Diagnostic):
            diagnostics = (diagnostics,)
        self.diagnostics: tuple[Diagnostic, ...] = tuple(diagnostics)
        super().__init__(self.diagnostics)

    def after(self, warnings: Iterable[Diagnostic]) -> PlanarcError:
        """The same error behind warnings, of which one may tell what led to it; a wrong request
        stays alone."""
        if isinstance(self, UsageError):
            return self
        return PlanarcError(led_to(warnings, self.diagnostics))

    def __str__(self) -> str:
        from planarc.core.render import render_all

        return render_all(self.diagnostics).rstrip("\n")

    def __reduce__(self) -> tuple[Any, ...]:
        # An error crosses processes, and subclasses take other arguments than it holds.
        return _again, (type(self), self.diagnostics), self.__dict__

    def _render_traceback_(self) -> list[str]:
        """The lines that a notebook shows instead of a traceback: the user's, and the message."""
        from traceback import extract_tb

        from planarc.core.render import render_all

        frames = (f for f in extract_tb(self.__traceback__) if _is_users(f.filename))
        return [
            *(f"line {f.lineno}: {f.line}" for f in frames),
            *render_all(self.diagnostics, color=True).splitlines(),
        ]


def led_to(warnings: Iterable[Diagnostic], errors: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Warnings, then errors; a warning of a place that an error points at tells its reason, and
    so does one of a value that is missing where no start is found."""
    errors = list(errors)
    told = {(e.code, e.span) for e in errors}
    others = []
    said = [text for e in errors for text in (e.message, *(r.message for r in e.related))]
    warnings = [w for w in warnings if not any(text.startswith(w.message) for text in said)]
    lacking = [w for w in warnings if isinstance(w, UngivenOnce) and w.span is not None]
    if lacking and errors and errors[0].code.startswith("R41"):
        # A start that cannot be found with a length of 0, say, which nobody wrote.
        notes = (*(Related(w.message, w.span) for w in lacking), *errors[0].related)
        errors[0] = replace(errors[0], related=notes, hint=f"first {lacking[0].hint}")
        warnings = [w for w in warnings if w not in lacking]
    redundant = any(isinstance(e.mend, Accept) for e in errors)
    for w in warnings:
        if redundant and isinstance(w, Bound):
            continue  # what follows from others holds nothing
        at = next((k for k, e in enumerate(errors) if _names(e, w.span)), None)
        if (w.code, w.span) in told:
            continue
        apart = at == 0 and errors[0].span != w.span
        if isinstance(w, Massless) and apart and errors[0].code.startswith("R41"):
            # Another part is said to hold what has no mass, and so no motion of its own.
            there = Related(errors[0].message, errors[0].span, detail=True)
            related = (there, *(replace(r, detail=True) for r in errors[0].related))
            told_of = {"message": w.message, "span": w.span, "hint": w.hint or errors[0].hint}
            errors[0] = replace(errors[0], related=related, **told_of)
            continue
        if isinstance(w, Massless) and errors and errors[0].code.startswith("R41"):
            related = (*errors[0].related, Related(w.message, w.span))
            errors[0] = replace(errors[0], hint=w.hint or errors[0].hint, related=related)
            continue
        if at is not None and w.span is not None and isinstance(errors[at], Explained):
            related = (*errors[at].related, Related(w.message, w.span))
            errors[at] = replace(errors[at], related=related)
        elif at is not None and w.span is not None:
            errors[at] = replace(errors[at], hint=f"mend `{w.span.text}` first: {w.message}")
        else:
            others.append(w)
    return (*others, *errors)


def in_one(warnings: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Warnings; that a world is missing and that nothing stands on it is one of them, and so is
    that parts are loose and that the end is free by which they are. One that stands as a note at
    another one is not told by itself."""
    every = tuple(warnings)
    notes = {(r.message, r.span) for w in every for r in w.related}
    free = {end for w in every if isinstance(w, Loose) for end in w.open}
    found = [
        w
        for w in every
        if (w.message, w.span) not in notes
        and not (isinstance(w, Unconnected) and w.connector in free)
    ]
    declared = (k for k, w in enumerate(found) if isinstance(w.mend, Declare))
    world, loose = next(declared, None), [w for w in found if isinstance(w, Loose)]
    if world is None or not loose:
        return tuple(found)
    alone = tuple(Related(w.message, w.span) for w in loose)
    hint = f"{found[world].hint}, and {loose[0].hint}"
    found[world] = replace(found[world], related=(*found[world].related, *alone), hint=hint)
    return tuple(w for w in found if w not in loose)


def unexplained(told: Iterable[Diagnostic], found: Iterable[Diagnostic]) -> list[Diagnostic]:
    """What was found in a run and no other message explains."""
    told, found = tuple(told), tuple(found)
    places = {d.span for d in told if d.severity is Severity.WARNING}
    fleeing = any(isinstance(d, Repelling) for d in (*told, *found))
    oversized = any(isinstance(d, Oversized) for d in found)

    def is_explained(d: Diagnostic) -> bool:
        match d:
            case Runaway():
                return fleeing
            case Still():
                return bool(places)
            case Sparse():
                return oversized
            case Limited():
                return fleeing or d.span in places
            case Secondary():
                return d.span in places
        return False

    return [d for d in found if not is_explained(d)]


def _names(error: Diagnostic, span: Span | None) -> bool:
    return span is not None and (error.span == span or any(r.span == span for r in error.related))


class Misfit(PlanarcError):
    """Sizes of arrays that do not fit together, told with the calls that give them."""

    def called(self, span: Span) -> Misfit:
        """The same, met in a call; of calls inside each other the first and the last are told."""
        found = self.diagnostics[0]
        inner = found.related[:1]
        outer = () if any(r.span == span for r in inner) else (Related("called here", span),)
        return Misfit(replace(found, related=(*inner, *outer)))


class UsageError(PlanarcError):
    """The request itself is wrong (a missing file, an unknown option value): exit code 2."""


class RunError(PlanarcError):
    """The run failed part-way; what was computed until then is kept: exit code 3."""


def error(
    code: str,
    message: str,
    span: Span | None = None,
    *,
    hint: str | Meant | None = None,
    related: Iterable[Related] = (),
    mend: Mend | None = None,
) -> PlanarcError:
    """A `PlanarcError` with one diagnostic, ready to raise."""
    if isinstance(hint, Meant):
        mend = hint
    found = Diagnostic(code, message, span, hint=said(hint), related=tuple(related), mend=mend)
    return PlanarcError(found)


def usage_error(code: str, message: str, *, hint: str | Meant | None = None) -> UsageError:
    """A `UsageError` with one diagnostic, ready to raise."""
    return UsageError(Diagnostic(code, message, hint=said(hint)))


def said(hint: str | Meant | None) -> str | None:
    """A hint as a text."""
    return str(hint) if hint else None


def refused(code: str, what: str, problem: Exception, hint: str | None = None) -> UsageError:
    """A `UsageError` for what the system refuses, with its reason: a file that cannot be read."""
    reason = getattr(problem, "strerror", None) or str(problem)
    return usage_error(code, f"{what}: {reason.lower()}", hint=hint)


def mistake(error: Exception) -> Diagnostic:
    """A mistake of planarc's own: where it broke, in one line that a user can pass on."""
    place = ""
    trace = error.__traceback__
    while trace is not None:
        file = Path(trace.tb_frame.f_code.co_filename)
        place = f"{file.parent.name}/{file.name}:{trace.tb_lineno}"
        trace = trace.tb_next
    return Diagnostic(
        "X001",
        f"sorry, planarc made a mistake: {type(error).__name__} in {place}",
        hint="report this line together with the model; PLANARC_DEBUG=1 shows the traceback",
    )


def _again(kind: type[PlanarcError], diagnostics: tuple[Diagnostic, ...]) -> PlanarcError:
    """The error without its own attributes, which pickle sets."""
    found = kind.__new__(kind)
    PlanarcError.__init__(found, diagnostics)
    return found


def _is_users(file: str) -> bool:
    path = Path(file)
    return "IPython" not in path.parts and not path.is_relative_to(Path(__file__).parent.parent)
