"""Which equations are too many and which unknowns nothing decides, in the user's own model.

In:   Dae      continuous equations and unknowns, as written: no alias is eliminated
Out:  Misfit   the equations that are too many, the unknowns that nothing decides, and the
               equations of the user's that stand in the same part (Dulmage-Mendelsohn)

Which equation of an over-determined part is too many is a matter of taste: all of the library are
taken to be right, then connections, then the user's own. Likewise an unknown of a library is taken
to be decided before one of the user's, one that is the left side of an equation before another, and
an input last. So a matching grows in that order, and what it leaves out is what the user hears of
(`blame`).

Example: `motor.tau = 5` and `hinge.w = 2` for a hinge that a motor drives. The over-determined part
holds some sixty equations; left out is `hinge.w = 2`, and its only rival is `motor.tau = 5`.

Reference: A. L. Dulmage, N. S. Mendelsohn, Canad. J. Math. 10, 1958, 517-534;
           P. Bunus, P. Fritzson, SIMULATION 80(7-8), 2004, 321-336 (explanations by the parts).
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence

from planarc.core.data import Data
from planarc.ir import places
from planarc.ir.dae import Dae, Equation, Variable
from planarc.ir.expr import Op, postorder
from planarc.structure.graph import Rows, columns_of
from planarc.structure.matching import Matching, find_singular_parts, match_equations


class Misfit(Data):
    """Equations and names of unknowns; empty where that kind is not off."""

    too_many: tuple[Equation, ...]
    rivals: tuple[Equation, ...]  # own equations of the same part, those too many among them
    undecided: tuple[str, ...]
    naming: tuple[Equation, ...]  # own equations of the part of the undecided
    over: tuple[Equation, ...] = ()  # all of the part with too many


def find_misfit(dae: Dae, inputs: Collection[str] = (), suspect: str | None = None) -> Misfit:
    """Equations and unknowns that are left without a partner. `inputs` are connected to nothing;
    `suspect` is the component whose class has too many equations by itself."""
    number = {v.name: i for i, v in enumerate(dae.variables)}
    rows = [_unknowns(equation, number) for equation in dae.equations]
    ranks = [2 if is_own(dae, e) else 1 if e.generated else 0 for e in dae.equations]
    suspects = _suspects(dae, suspect) if suspect else frozenset()
    ranks = [3 if e in suspects else r for e, r in zip(dae.equations, ranks, strict=True)]
    matching = _grown(rows, len(number), ranks)
    parts = find_singular_parts(rows, len(number), matching)
    ranks = _ranks_of_unknowns(dae, inputs)
    free = _grown(columns_of(rows, len(number)), len(rows), ranks).exposed
    too_many = tuple(dae.equations[e] for e in matching.exposed)
    own = _own(dae, parts.over_equations)
    own = tuple(e for e in own if e in suspects) or own
    return Misfit(
        too_many,
        _closest(own, too_many),
        tuple(dae.variables[v].name for v in free),
        _own(dae, parts.under_equations),
        tuple(dae.equations[e] for e in parts.over_equations),
    )


def without_written(dae: Dae, inputs: Mapping[str, str]) -> dict[str, str]:
    """Inputs that are connected to nothing, but for those that the user says by an equation; what
    stands in their own component only uses them."""
    own = (e for e in dae.equations if is_own(dae, e))
    sides = ((e, equation) for equation in own for e in (equation.left, equation.right))
    written = {
        e.name
        for e, equation in sides
        if e.is_symbol
        and not e.order
        and not f"{equation.component}.".startswith(f"{places.owner(e.name)}.")
    }
    return {name: array for name, array in inputs.items() if name not in written}


def _suspects(dae: Dae, component: str) -> frozenset[Equation]:
    """The user's equations of a component, but for those that it shares with other classes, if it
    has others."""
    classes = {part.name: part.class_name for part in dae.parts}
    cls = classes.get(component)
    inside = [e for e in dae.equations if f"{e.component}.".startswith(f"{component}.")]
    own = frozenset(e for e in inside if is_own(dae, e))
    shared = {e.span for e in dae.equations if classes.get(e.component) != cls}
    return frozenset(e for e in own if e.span not in shared) or own


def twins(equation: Equation, among: Iterable[Equation]) -> tuple[Equation, ...]:
    """Those that say the same as an equation: their sides are its sides, perhaps exchanged."""
    said = {equation.left, equation.right}
    return tuple(e for e in among if {e.left, e.right} == said)


def _closest(own: tuple[Equation, ...], too_many: Iterable[Equation]) -> tuple[Equation, ...]:
    """The equations that say the same, or what the same variable is, where there are several."""
    for surplus in too_many:
        if len(same := twins(surplus, own)) > 1:
            return same
    sides = {e.left for e in too_many if e.left.is_symbol}
    same = tuple(e for e in own if e.left in sides)
    return same if len(same) > 1 else own


def find_lack(
    dae: Dae,
    component: str,
    flows: Collection[str],
    given: Collection[str],
    inputs: Collection[str] = (),
) -> tuple[tuple[str, ...], bool]:
    """What the equations of a component leave open, by names within it, and whether all of that
    are flows of its connectors. `given` is what it has from others, by arrays as `flows`; `inputs`
    are those of its parts that are connected to nothing."""
    head = f"{component}." if component else ""
    names = [v.name for v in dae.variables if v.name.startswith(head)]
    number = {name: i for i, name in enumerate(names)}
    inside = [e for e in dae.equations if f"{e.component}.".startswith(head) and not e.generated]
    arrays = [name if name in flows else name.rpartition("[")[0] or name for name in names]
    # A flow is taken to be decided before another unknown, and what is given last.
    ranks = [
        3 if a in given else 0 if a in flows else 2 if n in inputs else 1
        for n, a in zip(names, arrays, strict=True)
    ]
    columns = columns_of([_unknowns(e, number) for e in inside], len(names))
    open_ones = [i for i in _grown(columns, len(inside), ranks).exposed if ranks[i] < 3]
    return tuple(names[i].removeprefix(head) for i in open_ones), all(
        not ranks[i] for i in open_ones
    )


def is_own(dae: Dae, equation: Equation) -> bool:
    """Whether an equation was written in the model's own file, and not as a connection."""
    return not equation.generated and places.is_own(dae, equation.span)


def _own(dae: Dae, equations: Iterable[int]) -> tuple[Equation, ...]:
    chosen = (dae.equations[e] for e in equations)
    return tuple(equation for equation in chosen if is_own(dae, equation))


def _unknowns(equation: Equation, number: Mapping[str, int]) -> list[int]:
    names = (e.name for e in postorder((equation.left, equation.right)) if e.op is Op.SYMBOL)
    return list(dict.fromkeys(number[n] for n in names if n in number))


def _grown(rows: Rows, columns: int, ranks: Sequence[int]) -> Matching:
    """A maximum matching in which rows of a low rank find their partners first."""
    found = Matching((-1,) * len(rows), (-1,) * columns)
    for rank in sorted(set(ranks)):
        known = [row if ranks[i] <= rank else [] for i, row in enumerate(rows)]
        found = match_equations(known, columns, found)
    return found


def _ranks_of_unknowns(dae: Dae, inputs: Collection[str]) -> list[int]:
    given = {e.left.name for e in dae.equations if e.left.is_symbol and not e.left.order}
    sides = (s for e in dae.equations if places.is_own(dae, e.span) for s in (e.left, e.right))
    given |= {
        e.name for e in postorder(sides) if e.is_symbol and e.order
    }  # a state has its equation

    def rank(v: Variable) -> int:
        if v.name in inputs:
            return 3
        return (1 if v.name in given else 2) if places.is_own(dae, v.span) else 0

    return [rank(v) for v in dae.variables]
