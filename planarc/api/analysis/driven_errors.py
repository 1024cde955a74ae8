"""What is wrong with a driven motion, told of the motions that were given.

In:   a message of the model that motions were added to
Out:  the same of what the user gave: its motion where the message is about that

A text of a motion stands in lines that are added to the model. What a message says of these is
told of a text of its own, which holds what was given:

    error[R421]: right after t = 1 s `der(hinge.phi) = -0.5/sqrt(1 - time)` gives no finite number
      --> motion:1:11
       |
     1 | hinge.phi=sqrt(1 - time)
       |           ^^^^^^^^^^^^^^
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cached_property

from msgspec.structs import replace

from planarc.api.variant import NAME
from planarc.core.diagnostic import Diagnostic, PlanarcError, Related, UsageError, usage_error
from planarc.core.prose import both, counted
from planarc.core.source import Source, Span
from planarc.ir.dae import Dae
from planarc.ir.mechanism import Mechanism
from planarc.ir.places import own_names
from planarc.ir.program import Program
from planarc.ir.result import Result

#: Names of what is added to the model.
ADDED = "planarcMotion"
#: Messages of a position that is not found, and of steps without end: a motion may be the reason.
_BY_MOTION = ("R410", "R411", "R412", "R420", "R422", "R426")


class Motions:
    """The motions of a run: coordinates, and what they follow where that is a text."""

    def __init__(self, coordinates: Sequence[str], texts: Sequence[str | None]) -> None:
        self.coordinates = tuple(coordinates)
        self.texts = tuple(texts)

    @cached_property
    def sources(self) -> tuple[Source, ...]:
        """Each motion as it was given."""
        given = zip(self.coordinates, self.texts, strict=True)
        return tuple(Source("motion", f"{c}={text or ''}") for c, text in given)

    def told(self, found: Diagnostic) -> Diagnostic:
        """A message with its places, of which those in what was added are in the motions."""
        related = tuple(
            replace(r, message=self._renamed(r.message), span=self._place(r.span))
            for r in found.related
        )
        return replace(
            found,
            message=self._renamed(found.message),
            span=self._place(found.span),
            hint=found.hint and self._renamed(found.hint),
            related=related,
        )

    def unreadable(self, problem: PlanarcError) -> PlanarcError:
        """The model alone is right, so that a text is wrong; it stands in no file of the user."""
        given = [
            (c, text)
            for c, text in zip(self.coordinates, self.texts, strict=True)
            if text is not None
        ]
        if not given:
            return problem
        first = problem.diagnostics[0]
        named = re.search(r"`(\w+)`", first.message)
        if named and len(given) > 1:  # of several texts, those that hold what is wrong
            word = rf"(?<![\w.]){re.escape(named[1])}(?!\w)"
            given = [(c, text) for c, text in given if re.search(word, text)] or given
        listed = " and ".join(f"`{c}` cannot follow `{text}`" for c, text in given)
        reason = self._renamed(first.message.removesuffix(f" in `{NAME}`"))
        hint = first.hint
        if any(re.search(r"(?<![A-Za-z_.])t(?!\w)", text) for _, text in given):
            hint = "write `time` for the time, as in `2*time`"
        return usage_error("C246", f"{listed}: {reason}", hint=hint)

    def unfit(
        self, problem: PlanarcError, model: Program, dae: Dae, mechanism: Mechanism | None
    ) -> PlanarcError:
        """The error about motions that the equations leave no room for: the model alone fits."""
        known = _too_many(len(self.coordinates), mechanism) or _driven_already(model, dae)
        hint = known or "drive joints of which none follows from the others"
        reasons = (self.told(d) for d in problem.diagnostics)
        # Without a cause in words of the mechanism, those of the equations are all that is known.
        notes = tuple(Related(r.message, r.span, detail=known is not None) for r in reasons)
        message = f"the model cannot move with {both(self.coordinates)} given"
        return PlanarcError(Diagnostic("C243", message, hint=hint, related=notes))

    def stopped(self, problem: PlanarcError) -> PlanarcError:
        """The error of a run that does not begin."""
        if isinstance(problem, UsageError):
            return problem
        return PlanarcError(self._failed(d) for d in problem.diagnostics)

    def told_of_rows(self, rows: Result) -> Result:
        """The rows of a run, with its messages."""
        ended = rows.ended and self._failed(rows.ended)
        return replace(rows, ended=ended, warnings=tuple(map(self.told, rows.warnings)))

    def _failed(self, found: Diagnostic) -> Diagnostic:
        """An end of a run, with the motions where they may be its reason."""
        told = self.told(found)
        if told.code not in _BY_MOTION or told.span != found.span:
            return told
        notes = tuple(
            Related(f"`{c}` follows this", Span(source, len(c) + 1, len(source.text)))
            if text
            else Related(f"`{c}` is driven")
            for c, source, text in zip(self.coordinates, self.sources, self.texts, strict=True)
        )
        hint = f"give {both(self.coordinates)} a motion that the mechanism can follow"
        hint += f"; {told.hint}" if told.hint else ""
        return replace(told, related=(*notes, *told.related), hint=hint)

    def _place(self, span: Span | None) -> Span | None:
        """A place in an added text as one in the motion; None for the other added lines."""
        if span is None:
            return None
        whole = span.source.text
        added = whole.rfind(f"\nmodel {NAME}\n")
        if added < 0 or span.start <= added:
            return span
        for k, text in enumerate(self.texts):
            head = f"\n  Real {ADDED}{k} = "
            begin = whole.rfind(head) + len(head)
            if text is not None and begin <= span.start <= span.end <= begin + len(text):
                shift = len(self.coordinates[k]) + 1 - begin
                return Span(self.sources[k], span.start + shift, span.end + shift)
        return None

    def _renamed(self, text: str) -> str:
        """A text in which a motion has the name of what it drives."""
        return re.sub(rf"{ADDED}(\d+)", lambda m: self.coordinates[int(m[1])], text)


def _too_many(count: int, mechanism: Mechanism | None) -> str | None:
    """What to do about more motions than the mechanism has."""
    if mechanism is None or not 0 < mechanism.mobility < count:
        return None
    freedom = counted(mechanism.mobility, "degree")
    surplus = count - mechanism.mobility
    left_out = "one" if surplus == 1 else str(surplus)
    return f"leave {left_out} of them out: the mechanism has {freedom} of freedom"


def _driven_already(model: Program, dae: Dae) -> str | None:
    """What to do about motions beside those that the model's own drives give."""
    mechanism = model.mechanism
    if mechanism is None or model.state_count >= 2 * mechanism.mobility or not dae.drives:
        return None
    drives = own_names(dae, sorted(dae.drives))
    verb = "moves" if len(drives) == 1 else "move"
    return f"leave out {both(drives)}, which {verb} the mechanism already"
