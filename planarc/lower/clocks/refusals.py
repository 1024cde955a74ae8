"""What is refused where ticking and continuous parts meet, with the way from one to the other.

Example: in `der(x) = u; u = -2*y; y = sample(x, Clock(0.1))` no `hold` stands between the tick of
`y` and `x`: the message names both, and the lines by way of which they hang together.

Reference: Modelica Language Specification 3.6, sections 16.4 to 16.7.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence

from planarc.core.diagnostic import PlanarcError, Related, error
from planarc.core.source import Span
from planarc.ir import flat
from planarc.ir.flatwalk import inside

_HOLD = "write `hold(...)` where a clocked value enters the continuous part"


def sampled_what_ticks(way: Sequence[Span]) -> PlanarcError:
    """What is read by `sample`, and ticks itself: the way from one to the other."""
    message = f"`{way[0].text}` is sampled like what is continuous, and hangs on what ticks"
    return error("L370", message, way[0], hint=_HOLD, related=_told(way[0], way[1:]))


def differentiated(span: Span, way: Sequence[Span]) -> PlanarcError:
    """A derivative in a part whose clock integrates none."""
    message = f"`{span.text}` is a derivative, and hangs on what ticks with a clock"
    hint = f'{_HOLD}, or give the clock a method that integrates: `Clock(c, "ImplicitEuler")`'
    return error("L371", message, span, hint=hint, related=_told(span, way))


def two_methods(span: Span, first: Span) -> PlanarcError:
    message = "two methods integrate the derivatives of one part of the model"
    related = [Related("the other one", first)]
    return error("L374", message, span, hint="keep one of them", related=related)


def _told(at: Span, way: Sequence[Span]) -> list[Related]:
    """What ticks at the end of a way, and the lines between."""
    lines = {(s.source.name, s.line): s for s in reversed(way[:-1])}
    for end in (at, way[-1]):
        lines.pop((end.source.name, end.line), None)
    middle = [Related("by way of this", s) for s in reversed(lines.values())]
    return [Related("this ticks", way[-1]), *middle]


def shortest_way(
    joins: Iterable[tuple[str, str, Span]], start: str, ends: Sequence[str]
) -> tuple[list[Span], str]:
    """The places of the joins on a shortest way from a name to one of several, and that one."""
    near: dict[str, list[tuple[str, Span]]] = {}
    for a, b, span in joins:
        near.setdefault(a, []).append((b, span))
        near.setdefault(b, []).append((a, span))
    before: dict[str, tuple[str, Span] | None] = {start: None}
    todo = deque([start])
    while todo and todo[0] not in ends:
        at = todo.popleft()
        for other, span in near.get(at, ()):
            if other not in before:
                before[other] = at, span
                todo.append(other)
    end = todo[0] if todo else ends[0]
    found: list[Span] = []
    step = before.get(end)
    while step is not None:
        found.append(step[1])
        step = before[step[0]]
    return found[::-1], end


def of_events(e: flat.Builtin) -> PlanarcError:
    """What asks for the value before an event, where there are ticks (16.4)."""
    variable = e.arguments[0].span.text
    instead = {
        "pre": f"previous({variable})",
        "edge": f"{variable} and not previous({variable})",
        "change": f"{variable} <> previous({variable})",
    }
    message = f"`{e.function}` asks for the value before an event, and stands in a clocked part"
    return error("L372", message, e.span, hint=f"write `{instead[e.function]}`")


def expect_no_events(equations: Iterable[flat.Equation]) -> None:
    """Refuse what happens at events of another kind inside of a clocked part (16.6)."""
    own = list(equations)
    for one in own:
        ends = (e for e in inside((one,)) if isinstance(e, flat.Terminate))
        if isinstance(one, flat.IfEquation) and (end := next(ends, None)) is not None:
            asked = " ".join(one.branches[0][0].span.text.split())
            hint = f"ask `{asked}` of `hold(...)`, in a `when` beside the one of the clock"
            message = "`terminate` under an `if` in a `when` of a clock"
            raise error("L349", message, end.span, hint=hint)
    for e in inside(own):
        if isinstance(e, flat.WhenEquation | flat.Reinit | flat.Impact):
            raise error(
                "L372",
                "this hangs on what ticks with a clock, and waits for another event",
                e.span,
                hint="write `hold(...)` in it for values that tick, `sample(...)` where what ticks "
                "reads what is set here, or let a clock tick: `when Clock(condition) then`",
            )
