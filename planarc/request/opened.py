"""Variables that become inputs: what the model says of their values is left out.

In:   Dae, names of variables
Out:  Dae   with these among its `inputs`

A variable can become one where an equation gives it a formula of parameters and time alone, by
itself or through variables that are equal to it: a torque that is zero, the signal of a source.
The coordinate of a joint can, too: then the law of its own effort, `tau = 0`, is left out, and
the speed is free at the start.

Example: `revA.tau = 0` is left out for the name `revA.tau`; its start as an input is 0.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from msgspec.structs import replace

from planarc.core.diagnostic import UsageError, usage_error
from planarc.core.prose import either
from planarc.core.unknown import refuse_unknown
from planarc.ir.dae import Dae, Equation
from planarc.ir.expr import Expr, Op, postorder

_SHOWN = 4  # names in a hint
#: The coordinate of a joint: its effort, and its speed.
_OF_JOINTS = {"phi": ("tau", "w"), "s": ("f", "v")}


def open_inputs(dae: Dae, names: Sequence[str]) -> Dae:
    """Raises UnknownName, and UsageError C301 for what follows from the rest of the model."""
    own = {v.name for v in dae.inputs}
    refuse_unknown("variable", names, (*(v.name for v in dae.variables), *own))
    for name in dict.fromkeys(names):
        dae = dae if name in own else _opened(dae, name)
    return dae


def _opened(dae: Dae, name: str) -> Dae:
    found, freed = _given(dae, name), ""
    joint, _, last = name.rpartition(".")
    if found is None and last in _OF_JOINTS:
        effort, speed = _OF_JOINTS[last]
        law, freed = _given(dae, f"{joint}.{effort}"), f"{joint}.{speed}"
        found = law and (law[0], None)
    if found is None:
        raise _refusal(dae, name)
    gone, value = found
    (variable,) = (v for v in dae.variables if v.name == name)
    others = (v for v in dae.variables if v is not variable)
    return replace(
        dae,
        equations=tuple(e for e in dae.equations if e is not gone),
        variables=tuple(replace(v, fixed=v.fixed and v.name != freed) for v in others),
        inputs=(*dae.inputs, replace(variable, causality="input", start=value or variable.start)),
    )


def _given(dae: Dae, name: str) -> tuple[Equation, Expr | None] | None:
    """The equation that gives a variable its value, and that where it does not hang on time."""
    table, parameters = dae.table, {p.name for p in dae.parameters}
    known: set[Expr] = set()
    waiting: list[tuple[Expr, Equation | None]] = [(table.symbol(name), None)]
    for symbol, first in waiting:
        known.add(symbol)
        equal = []
        for equation, other in _alone(dae, symbol):
            leaves = [e for e in postorder([other]) if not e.args]
            if all(_is_known(e, parameters) for e in leaves):
                timeless = all(e.op not in (Op.TIME, Op.EVENT) for e in leaves)
                return first or equation, other if timeless else None
            if other.op is Op.SYMBOL and other not in known and not other.order:
                equal.append((other, first or equation))
        waiting += equal
    return None


def _alone(dae: Dae, symbol: Expr) -> Iterator[tuple[Equation, Expr]]:
    """The equations that have a symbol alone on one side, and the other side of each."""
    for e in dae.equations:
        if e.left is symbol:
            yield e, e.right
        elif e.right is symbol:
            yield e, e.left


def _is_known(leaf: Expr, parameters: set[str]) -> bool:
    if leaf.op is Op.SYMBOL:
        return leaf.name in parameters
    return leaf.op in (Op.CONST, Op.TIME, Op.EVENT)


def _refusal(dae: Dae, name: str) -> UsageError:
    part = name.rpartition(".")[0]
    beside = (v.name for v in dae.variables if v.name.rpartition(".")[0] == part)
    near = [other for other in beside if _given(dae, other)]
    hint = f"choose {either(near[:_SHOWN])}" if near else None
    return usage_error(
        "C301",
        f"`{name}` cannot become an input: it follows from the rest of the model",
        hint=hint or "choose a variable that the model gives a value, as the torque of a motor",
    )
