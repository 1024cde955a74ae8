"""The bodies that a component stands between, by the names that a user gave them."""

from __future__ import annotations

from collections.abc import Iterable

from planarc.ir.mechanism import GROUND, Link
from planarc.ir.once import once
from planarc.ir.program import Program


def bodies(program: Program, component: str) -> tuple[str, ...]:
    """The bodies on the frames of a component, or of one around it, the ground last; none where
    it has no frames.

    Of what moves as one piece the name is that of its first part with mass.
    """
    links = program.mechanism.links if program.mechanism else ()
    while component:
        own = dict.fromkeys(_on_links(program).get(component, ()))
        if own:
            moving = [_body(program, links[n], component) for n in own if n != GROUND]
            return (*moving, *["the ground"] * (GROUND in own))
        component = component.rpartition(".")[0]
    return ()


def fixed_together(program: Program, components: Iterable[str]) -> str | None:
    """The first component all of whose frames, two or more, are on one body."""
    on = _on_links(program)
    return next((c for c in components if len(on.get(c, ())) > 1 == len(set(on[c]))), None)


@once
def _on_links(program: Program) -> dict[str, list[int]]:
    """The links of each component's frames, by their numbers."""
    on: dict[str, list[int]] = {}
    for n, link in enumerate(program.mechanism.links if program.mechanism else ()):
        for frame in link.frames:
            on.setdefault(_owner(frame), []).append(n)
    return on


def _body(program: Program, link: Link, component: str) -> str:
    masses = {d.component for d in program.declared if d.name.partition(".")[0] == "kinetic"}
    owners = sorted(dict.fromkeys(map(_owner, link.frames)), key=_depth)
    owners = [o for o in owners if o != component]
    heavy = [o for o in owners if any(m == o or m.startswith(f"{o}.") for m in masses)]
    return f"`{(*heavy, *owners, link.name)[0]}`"


def _owner(frame: str) -> str:
    return frame.rpartition(".")[0]


def _depth(component: str) -> int:
    return component.count(".")
