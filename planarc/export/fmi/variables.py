"""What a host sees of a model: its variables, by names and references.

In:   Program, the values at the start, what is held there
Out:  Seen    one for each value: names that share it are its aliases

A value's reference is 8*slot + 2*kind + sign (`instance.block`); names that share an
output have references of their own, since each may be one, and so have those of another unit
(the angle and a force of the ground are both zero) or with limits of their own. Those of a value
that is held at the start have, too: the standard lets one name of a reference have a start, and
it is to be set by each. Where the choice of
states may change, the states are variables of their own: `_state[1]` is the first of them,
whichever coordinate that is, and its derivative `der(_state[1])`.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

from msgspec import field
from msgspec.structs import replace

from planarc.core.data import Data
from planarc.export.fmi.entries import INTEGER, NUMBER, TRUTH
from planarc.export.fmi.limits import Declared, kept
from planarc.export.tunable import tunable_parameters
from planarc.instance.block import OTHER
from planarc.instance.plan import crowd_names, is_eventful, is_settable
from planarc.ir.dae import Kind
from planarc.ir.program import Column, Enumeration, ParameterSlot, Program
from planarc.solve.stepping.ports import Sites

if TYPE_CHECKING:
    from planarc.codegen.slopes import Slopes

_KINDS = {Kind.REAL: NUMBER, Kind.INTEGER: INTEGER, Kind.ENUMERATION: INTEGER,
          Kind.BOOLEAN: TRUTH}  # fmt: skip
_TWICE = re.compile(r"der\(der\((.*)\)\)")


#: The parameter that chooses between the ways to integrate, or the length of steps.
STIFF, STEP = "_stiff", "_step"


class Seen(Data):
    """`derivative` is the reference of the state that it is the derivative of."""

    reference: int
    kind: int
    name: str
    causality: str
    variability: str
    initial: str | None
    start: float | None = None
    unit: str = ""
    display_unit: str = ""
    description: str = ""
    minimum: float | None = None
    maximum: float | None = None
    nominal: float | None = None
    derivative: int | None = None
    type: Enumeration | None = None
    aliases: tuple[Column, ...] = ()


#: Of outputs and derivatives of states: references, or slots, of what they depend on, and how.
Dependencies: TypeAlias = "Mapping[int, Mapping[int, str]]"


class Interface(Data):
    """`states` and `rates` are references, in the order of the states."""

    variables: tuple[Seen, ...]
    states: tuple[int, ...]
    rates: tuple[int, ...]
    indicators: tuple[int, ...] = ()
    dependencies: Dependencies = field(default_factory=dict)


def output_slots(program: Program, outputs: re.Pattern[str] | None) -> tuple[int, ...]:
    """The slots of all that may be outputs, before it is known what a host is shown."""
    own = _outputs(program, outputs)
    columns = (c for c in program.columns if not c.constant and c.kind in _KINDS)
    slots = (c.slot for c in columns if c.name in own)
    return tuple(dict.fromkeys(slots))


def dependencies(program: Program, slopes: Slopes, slots: Collection[int]) -> Dependencies:
    """What these slots and the derivatives of states depend on, by slots, where the states are
    always the same and it is known what moves with the time; else nothing."""
    from planarc.export.fmi.dependencies import KINDS, find_dependencies

    nodes = {slot: node for node, slot in enumerate(slopes.slots) if slot >= 0}
    if not never_exchanged(program) or 0 not in nodes:
        return {}
    states = [c.slot for c in program.candidates]
    inputs = [c.slot for c in program.columns if c.name in program.inputs]
    knowns = {nodes[slot]: slot for slot in (0, *states, *inputs) if slot in nodes}
    tunable = tunable_parameters(program)
    fixed = {c.name for c in program.columns if c.constant} - tunable
    found = find_dependencies(slopes, knowns, fixed, tunable)
    return {
        slot: {knowns[k]: KINDS[kind] for k, kind in found[nodes[slot]].items()}
        for slot in (*slots, *(c.derivative for c in program.candidates))
        if slot in nodes
    }


def by_reference(program: Program, shown: Interface, found: Dependencies) -> Dependencies:
    """The same for what a host is shown; nothing of what nothing is known."""
    if not found:
        return {}
    known = [v.reference for v in shown.variables if v.causality in ("input", "independent")]
    names = {r // 8: r for r in (*shown.states, *known)}
    # At events outputs may follow anything, by relations and what is held between events.
    outputs = [v.reference for v in shown.variables if not is_eventful(program)
               and v.causality == "output" and v.kind == NUMBER]  # fmt: skip
    return {
        r: {
            names[slot]: kind
            for slot, kind in found.get(r % OTHER // 8, {}).items()
            if slot in names
        }
        for r in (*outputs, *shown.rates)
    }


def shown_columns(program: Program, outputs: re.Pattern[str] | None) -> list[Column]:
    """The variables that a host is shown: not what a component has for itself, but for states."""
    moving = {slot for c in program.candidates for slot in (c.slot, c.derivative)}
    moving -= {c.slot for c in program.columns if not c.protected and c.sign > 0}
    return [
        column
        for column in program.columns
        if column.kind in _KINDS
        and not column.name.startswith("$")
        and (not column.protected or column.slot in moving
             or (outputs is not None and outputs.search(column.name)))
    ]  # fmt: skip


def interface(
    program: Program,
    w: Sequence[float],
    held: Sequence[tuple[int, int]],
    selection: Sequence[int],
    outputs: re.Pattern[str] | None,
    timed: Collection[int] = (),
    stiff: bool = False,
    step: float | None = None,
) -> Interface:
    """`timed` are the relations that switch at known times: no host need look at them.
    `selection` are the states where they never change; `outputs` matches names of variables
    that a host is shown as outputs, besides the model's own; `stiff` is the choice of steps.
    Where steps have one length, `step`, they are the model's own: no host sees its states."""
    groups: dict[int, list[Column]] = {}
    for column in shown_columns(program, outputs):
        kind = _KINDS[column.kind]
        sign = int(column.sign < 0 and kind == NUMBER)
        groups.setdefault(8 * column.slot + 2 * kind + sign, []).append(column)
    found = _Shown(program, w, {slot for slot, _ in held}, outputs)
    candidates = [program.candidates[i] for i in selection]
    fixed = never_exchanged(program) or step is not None
    place = program.size + 2 * program.state_count + 1 + len(program.relations)
    choice = Seen(8 * place + 2 * TRUTH, TRUTH, STIFF,
                  "parameter", "fixed", "exact", float(stiff),
                  description="= true, if co-simulation takes implicit steps")  # fmt: skip
    if step is not None:
        choice = Seen(8 * place + 2 * NUMBER, NUMBER, STEP, "parameter", "fixed", "exact", step,
                      unit="s", description="Length of the steps with contacts")  # fmt: skip
    seen = [
        Seen(0, NUMBER, "time", "independent", "continuous", None, unit="s", description="Time")
    ]
    if fixed:
        if step is not None:
            candidates, timed = [], range(len(program.relations))
        states = tuple(8 * c.slot for c in candidates)
        rates = tuple(8 * c.derivative for c in candidates)
        rate_of = dict(zip(rates, states, strict=True))
        shown = [v for ref, cols in groups.items() for v in found.all(ref, cols, rate_of.get(ref))]
        zeros = _zeros(program, timed)
        watched = tuple(v.reference for v in zeros)
        return Interface((*seen, *shown, *zeros, choice), states, rates, watched)
    n = program.state_count
    states = tuple(8 * (program.size + k) for k in range(n))
    rates = tuple(8 * (program.size + n + k) for k in range(n))
    seen += [v for ref, cols in groups.items() for v in found.all(ref, cols, None)]
    for k, (state, rate) in enumerate(zip(states, rates, strict=True), 1):
        told = f"State {k} as it is chosen at present"
        name = f"_state[{k}]"
        seen.append(Seen(state, NUMBER, name, "local", "continuous", "calculated",
                         description=told))  # fmt: skip
        seen.append(Seen(rate, NUMBER, f"der({name})", "local", "continuous", "calculated",
                         derivative=state))  # fmt: skip
    margin = 8 * (program.size + 2 * n)
    told = "What is left until other states are chosen"
    seen.append(Seen(margin, NUMBER, "_margin", "local", "continuous", "calculated",
                     description=told))  # fmt: skip
    from planarc.solve.states.selector import open_blocks

    zeros = _zeros(program, timed)
    watched = ((margin,) if open_blocks(program) else ()) + tuple(v.reference for v in zeros)
    return Interface((*seen, *zeros, choice), states, rates, watched)


def _zeros(program: Program, timed: Collection[int]) -> list[Seen]:
    """What is seen of the relations."""
    first = program.size + 2 * program.state_count + 1
    return [
        Seen(8 * (first + i), NUMBER, f"_zero[{i + 1}]", "local", "continuous", "calculated",
             description=f"Crosses zero where `{r.text}` switches")
        for i, r in enumerate(program.relations)
        if i not in timed
    ]  # fmt: skip


def never_exchanged(program: Program) -> bool:
    """Whether the states are the same candidates in every run, each shown by a column."""
    from planarc.solve.states.selector import open_blocks

    shown = {c.slot for c in program.columns if c.sign > 0 and c.kind is Kind.REAL}
    homes = all(c.slot in shown and c.derivative in shown for c in program.candidates)
    return not open_blocks(program) and homes


def _types(program: Program) -> dict[str, Enumeration]:
    """The types of variables, with names that nothing else has."""
    taken = {_name(c.name) for c in program.columns}
    found: dict[str, Enumeration] = {}
    for type in program.enumerations:
        name = type.name
        while name in taken:
            name += "_"
        taken.add(name)
        found |= dict.fromkeys(type.members, replace(type, name=name))
    return found


def _outputs(program: Program, wished: re.Pattern[str] | None) -> set[str]:
    """The names of outputs: the model's own, and those wished for."""
    own = set(program.outputs)
    if wished is not None:
        return own | {c.name for c in program.columns if wished.search(c.name)}
    # A host shows outputs first: those that say where everything is.
    return own or {c.display for c in program.candidates}


class _Shown:
    """Variables by their groups of columns."""

    def __init__(
        self, program: Program, w: Sequence[float], held: set[int], outputs: re.Pattern[str] | None
    ) -> None:
        self._w, self._held = w, held
        self._tunable = tunable_parameters(program)
        self._nominals = {c.slot: abs(float(w[c.nominal])) for c in program.candidates
                          if c.nominal is not None}  # fmt: skip
        self._parameters: dict[str, ParameterSlot] = {p.name: p for p in program.parameter_slots}
        self._outputs, self._inputs = _outputs(program, outputs), set(program.inputs)
        self._discrete = {d.slot for d in program.discretes}
        self._declared = Declared(program, w)
        self._types = _types(program)
        if crowd_names(program):  # what presses does so in every step
            self._discrete -= {*Sites(program).pushes}

    def all(self, reference: int, columns: list[Column], state: int | None) -> list[Seen]:
        """The variables that a group of names makes."""
        first = self.group(reference, columns, state)
        apart = [c for c in first.aliases if first.causality == "output" or
                 (first.initial == "exact" and first.causality == "local") or
                 (first.kind == NUMBER and c.unit != first.unit) or
                 self._limited_otherwise(c, first)]  # fmt: skip
        found = [replace(first, aliases=tuple(c for c in first.aliases if c not in apart))]
        for k, column in enumerate(apart, 1):
            other = self.group(reference, [column], None)
            found.append(replace(other, reference=reference + k * OTHER))
        return found

    def _limited_otherwise(self, column: Column, first: Seen) -> bool:
        """Whether a name has limits of its own that are not those of a variable."""
        if not self._declared.declares(column):
            return False
        own = self._declared.limits(column, column.sign * float(self._w[column.slot]))
        return own != (first.minimum, first.maximum)

    def group(self, reference: int, columns: list[Column], state: int | None) -> Seen:
        main = next((c for c in columns if c.name in self._outputs and not c.constant), columns[0])
        main = next((c for c in columns if c.name in self._parameters), main)
        main = next((c for c in columns if c.name in self._inputs), main)
        kind, sign = reference // 2 % 4, reference % 2
        parameter = self._parameters.get(main.name)
        value: Any = 0.0 - self._w[main.slot] if sign else self._w[main.slot]
        steady = kind != NUMBER or main.slot in self._discrete
        causality, variability = "local", "discrete" if steady else "continuous"
        initial: str | None = "calculated"
        limits = self._declared.limits(main, float(value))
        if main.name in self._inputs:
            causality, initial = "input", None
        elif parameter is not None and is_settable(parameter):
            causality, variability, initial = "parameter", "fixed", "exact"
            if main.name in self._tunable:
                variability = "tunable"
            limits = kept((parameter.minimum, parameter.maximum), float(value), kind != NUMBER)
        elif all(c.constant for c in columns):
            variability = "tunable" if main.name in self._tunable else "fixed"
        elif main.name in self._outputs:
            causality = "output"
        if main.slot in self._held and initial == "calculated":
            initial = "exact"
        return Seen(
            reference=reference,
            kind=kind,
            name=_name(main.name),
            causality=causality,
            variability=variability,
            initial=initial,
            start=None if initial == "calculated" else float(value),
            unit=main.unit if kind == NUMBER else "",
            display_unit=main.display_unit if kind == NUMBER else "",
            description=main.description,
            minimum=limits[0],
            maximum=limits[1],
            nominal=self._nominals.get(main.slot) or self._declared.size((main, *columns)),
            derivative=state,
            type=self._types.get(main.name),
            aliases=tuple(c for c in columns if c is not main and _name(c.name) != main.name),
        )


def _name(name: str) -> str:
    """A second derivative as the standard writes it."""
    return _TWICE.sub(r"der(\1,2)", name) if "der(der(" in name else name


def shown_name(column: Column) -> str:
    """The name of an alias."""
    return _name(column.name)
