"""Clocks, and what ticks with them: the operators of chapter 16, typed.

In:   a name, typed arguments
Out:  `flat.Builtin`, of the type `Clock` or of what the operator passes on

What says how often a clock ticks shapes the model: factors, shifts and whole-numbered intervals
are put in as numbers. Which clock a variable has is found later (`lower.clocks`).

Example: `subSample(Clock(1, 10), 2)` with parameters of these values.

Reference: Modelica Language Specification 3.6, sections 16.3 to 16.10.
"""

from __future__ import annotations

from collections.abc import Callable

from planarc.core.diagnostic import error
from planarc.core.source import Span
from planarc.flatten.terms.conform import expect_scalar, type_text
from planarc.flatten.terms.select import integer, real, string
from planarc.flatten.tree.nodes import Env
from planarc.flatten.typing.arrays import Arguments, by_fields, wrong_argument
from planarc.flatten.values import evaluate
from planarc.flatten.values.variability import variability_of
from planarc.ir import flat

Maker = Callable[[str, Arguments, Span, Env], flat.Expression]

_PARAMETER = flat.Variability.PARAMETER


def sampled(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    """`sample(u)` and `sample(u, clock)`: the left limit of what moves, at the ticks of a clock."""
    if len(arguments) > 1:
        _expect_clock(name, arguments[1])
    return _clocked(arguments[0].type, name, arguments, span, env)


def _clocked(
    type_: flat.Type, name: str, arguments: Arguments, span: Span, env: Env
) -> flat.Expression:
    env.session.clocked = True
    return flat.Builtin(type_, span, name, tuple(arguments))


def is_clock(type_: flat.Type) -> bool:
    return type_.base is flat.Base.CLOCK


def _expect_clock(name: str, argument: flat.Expression) -> None:
    if not is_clock(argument.type) or argument.type.dims:
        raise wrong_argument(name, argument)


# Clocks ------------------------------------------------------------------------------------------


def make_clock(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    """`Clock(...)` in its five forms (16.3)."""
    if not arguments:
        return _clocked(flat.CLOCK, name, [], span, env)
    first, second = arguments[0], arguments[1] if len(arguments) > 1 else None
    if first.type.dims:
        raise wrong_argument(name, first)
    match first.type.base:
        case flat.Base.CLOCK:
            given = [first, _method(second, span, env)]
        case flat.Base.INTEGER:
            resolution = integer(1, span) if second is None else second
            given = [
                _whole(first, "the interval of a clock", 1, env),
                _whole(resolution, "the resolution of a clock", 1, env),
            ]
        case flat.Base.REAL:
            if second is not None:
                hint = "give whole numbers: an interval of 3/10 s is `Clock(3, 10)`"
                message = "a clock with a Real interval takes nothing else"
                raise error("F290", message, span, hint=hint)
            given = [_interval(first, env)]
        case flat.Base.BOOLEAN:
            start = real(0.0, span) if second is None else second
            given = [first, expect_scalar(start, _NUMBERS, "the interval before the first tick")]
        case _:
            raise wrong_argument(name, first)
    return _clocked(flat.CLOCK, name, given, span, env)


_NUMBERS = (flat.Base.REAL, flat.Base.INTEGER)


def _method(value: flat.Expression | None, span: Span, env: Env) -> flat.Expression:
    """The name of what integrates the derivatives in a clocked part (16.8.2)."""
    if value is None:
        message = "a clock of a clock takes the name of a solver method as well"
        hint = 'as in `Clock(c, "ImplicitEuler")`; the same clock again is `c`'
        raise error("F290", message, span, hint=hint)
    known = evaluate.structural_value(
        expect_scalar(value, (flat.Base.STRING,), "the solver method of a clock"),
        env,
        "the solver method of a clock",
    )
    return string(str(known), value.span)


def _interval(value: flat.Expression, env: Env) -> flat.Expression:
    if variability_of(value, env.session, env.hidden) > _PARAMETER:
        message = "planarc does not support clocks whose interval changes (16.3)"
        hint = "let a condition tick: `Clock(condition)`"
        raise error("F299", message, value.span, hint=hint)
    known = evaluate.literal_value(value)
    if isinstance(known, float | int) and known <= 0:
        raise error("F291", f"a clock needs a positive interval, not {known:g} s", value.span)
    return value


def _whole(value: flat.Expression, what: str, least: int, env: Env) -> flat.Expression:
    """A whole number that is known when the model is compiled."""
    expect_scalar(value, (flat.Base.INTEGER,), what)
    known = evaluate.structural_value(value, env, what)
    assert isinstance(known, int)
    if known < least:
        message = f"{what} must be at least {least}, and is {known}"
        raise error("F291", message, value.span)
    return integer(known, value.span)


# Conversions of clocks ------------------------------------------------------------------------


def _scaled(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    """`subSample(u, factor)`, `superSample(u, factor)`; a factor of 0 is one to be found."""
    value, *factors = arguments
    found = [_whole(f, f"the factor of `{name}`", 0, env) for f in factors]
    written = [f for f in found if evaluate.literal_value(f) != 0]
    return _clocked(value.type, name, [value, *written], span, env)


def _shifted(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    """`shiftSample(u, counter, resolution)`, `backSample(...)`."""
    value, counter, *resolution = arguments
    given = [
        _whole(counter, f"the shift of `{name}`", 0, env),
        _whole(resolution[0] if resolution else integer(1, span), "the resolution", 1, env),
    ]
    return _clocked(value.type, name, [value, *given], span, env)


# Values ----------------------------------------------------------------------------------------


def _passed(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    """`hold(u)`, `noClock(u)`."""
    if is_clock(arguments[0].type):
        raise wrong_argument(name, arguments[0])
    return _clocked(arguments[0].type, name, arguments, span, env)


def _previous(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    (value,) = arguments
    if is_clock(value.type):
        raise wrong_argument(name, value)
    parts = by_fields(value, lambda part: _previous(name, [part], span, env))
    if parts is not None:
        return parts
    if not isinstance(value, flat.Reference):
        hint = "give the expression a variable of its own: `b = ...`, and write `previous(b)`"
        raise error("F291", "`previous` takes a variable, not an expression", span, hint=hint)
    return _clocked(value.type, name, arguments, span, env)


def _of_tick(type_: flat.Type) -> Maker:
    """`interval(u)`, `firstTick(u)`: what is known of a tick of the clock of `u`."""
    return lambda name, arguments, span, env: _clocked(type_, name, arguments, span, env)


#: Names of what a clock takes as its second argument.
_SECONDS = ("resolution", "startInterval", "solverMethod")

#: The least and the highest number of arguments, what makes the call, and the arguments' names.
CLOCKS: dict[str, tuple[int, int, Maker, tuple[str, ...]]] = {
    "previous": (1, 1, _previous, ("u",)),
    "hold": (1, 1, _passed, ("u",)),
    "noClock": (1, 1, _passed, ("u",)),
    "subSample": (1, 2, _scaled, ("u", "factor")),
    "superSample": (1, 2, _scaled, ("u", "factor")),
    "shiftSample": (2, 3, _shifted, ("u", "shiftCounter", "resolution")),
    "backSample": (2, 3, _shifted, ("u", "backCounter", "resolution")),
    "interval": (0, 1, _of_tick(flat.REAL), ("u",)),
    "firstTick": (0, 1, _of_tick(flat.BOOLEAN), ("u",)),
    "Clock": (
        0,
        2,
        make_clock,
        ("c", "interval", "intervalCounter", "condition", *_SECONDS),
    ),
}


def branch_of(conditions: list[flat.Expression], what: str, env: Env) -> int:
    """The branch of an `if` between clocks: parameters alone may choose one."""
    for index, condition in enumerate(conditions):
        if evaluate.structural_value(condition, env, what):
            return index
    return len(conditions)


def expect_alone(condition: flat.Expression, branches: int) -> None:
    """A `when` of a clock has one branch (16.6)."""
    if branches > 1:
        message = "a `when` of a clock has no `elsewhen`"
        hint = "write an `if` into it, or a `when` of its own"
        raise error("F301", message, condition.span, hint=hint)
    if condition.type.dims:
        text = type_text(condition.type)
        raise error("F270", f"the condition of `when` is one clock, not {text}", condition.span)
