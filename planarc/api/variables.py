"""The parameters and variables of a model, as a user looks them up."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from planarc.core.data import Data
from planarc.core.diagnostic import UsageError, usage_error
from planarc.core.prose import shortened
from planarc.core.unknown import refuse_unknown, unknown_attribute
from planarc.ir.kernel import Kernel
from planarc.ir.program import Program


class Parameter(Data):
    """A parameter of a model. `value` is the default. `settable`: a run may replace it without
    compiling again; `structural`: the equations depend on it, and a new value compiles the model
    again."""

    name: str
    unit: str
    description: str
    value: float
    settable: bool
    structural: bool
    kind: str  # Real, Integer, Boolean or enumeration
    literals: tuple[str, ...] = ()  # of an enumeration; the value is the number of one, from 1


class Variable(Data):
    """A variable of a model. `start` is its start value (None: it follows from others), `value`
    that at the start of a run with default values (None where the model has no start)."""

    name: str
    unit: str
    description: str
    start: float | None
    value: float | None
    kind: str


def _kept(name: str, way: str) -> UsageError:
    """The error of who sets a value of a model."""
    hint = f'give a run another one: simulate({way}={{"{name}": ...}})'
    return usage_error("C202", f"`{name}` keeps its value: a model never changes", hint=hint)


def _refuse_setting(item: Parameter | Variable, field: str, value: object) -> None:
    raise _kept(item.name, "parameters" if isinstance(item, Parameter) else "start")


for _kind in (Parameter, Variable):  # in the place of what frozen structs say
    type.__setattr__(_kind, "__setattr__", _refuse_setting)


Item = TypeVar("Item")


class Names(Mapping[str, Item], Generic[Item]):
    """Items by name, in the order of the model."""

    def __init__(self, kind: str, items: Mapping[str, Item]) -> None:
        self._kind, self._items = kind, items

    def __getitem__(self, name: str) -> Item:
        refuse_unknown(self._kind, (name,), self._items)
        return self._items[name]

    if not TYPE_CHECKING:  # whoever checks types is told of wrong names by their checker

        def __getattr__(self, name: str) -> Any:
            """Raises AttributeError, with the item of that name or of such a part."""
            problem = unknown_attribute(self, name)
            inside = () if name[0] == "_" else self._items
            found = next((n for n in inside if n == name or n.startswith(f"{name}.")), None)
            raise problem if found is None else AttributeError(f'{problem}: write `["{found}"]`')

    def __setitem__(self, name: str, value: object) -> None:
        refuse_unknown(self._kind, (name,), self._items)
        raise _kept(name, "parameters" if self._kind == "parameter" else "start")

    def __iter__(self) -> Iterator[str]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __contains__(self, name: object) -> bool:
        return name in self._items

    def _ipython_key_completions_(self) -> list[str]:
        return list(self._items)

    def _repr_html_(self) -> str:
        from planarc.api.htmltable import html_table

        rows = (
            (name, item.value, item.unit, item.description)  # type: ignore[attr-defined]
            for name, item in self._items.items()
        )
        note = f"{len(self)} {self._kind}s"
        return html_table(("name", "value", "unit", "description"), rows, note)

    def __repr__(self) -> str:
        return f"<{len(self)} {self._kind}s: {shortened(list(self._items), 8)}>"


def parameters_of(program: Program, kernel: Kernel) -> dict[str, Parameter]:
    """All parameters with their defaults; `kernel.parameters()` has run."""
    return {
        p.name: Parameter(
            name=p.name,
            unit=p.unit,
            description=p.description,
            value=float(kernel.w[p.slot]),
            settable=p.settable,
            structural=p.structural,
            kind=p.kind.value,
            literals=p.literals,
        )
        for p in program.parameter_slots
        if not p.name.startswith("$")
    }


def variables_of(program: Program, kernel: Kernel, started: bool) -> dict[str, Variable]:
    """All variables that are no parameters; `started`: the kernel holds the values at the start."""
    starts = {c.slot: c.start for c in program.candidates}
    starts |= {d.slot: d.start for d in program.discretes}
    starts |= {f.slot: f.start for f in program.fixed}
    parameters = {p.name for p in program.parameter_slots}
    found = {}
    for c in program.columns:
        if c.name in parameters or c.name.startswith("$"):
            continue
        start = c.sign * float(kernel.w[starts[c.slot]]) if c.slot in starts else None
        value = c.sign * float(kernel.w[c.slot]) if started else None
        found[c.name] = Variable(c.name, c.unit, c.description, start, value, c.kind.value)
    return found
