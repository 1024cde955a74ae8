"""Built-in operators and functions: what they take and give.

In:   a name, typed arguments
Out:  a typed node: `flat.Builtin`, or the array that the function builds

Reference: Modelica Language Specification 3.6, sections 3.7, 8.3, 10.3 and 16.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import chain
from typing import Any

from planarc.core.data import Data
from planarc.core.diagnostic import error
from planarc.core.mend import Meant
from planarc.core.prose import counted
from planarc.core.source import Span
from planarc.flatten.terms.conform import NUMERIC, expect, unify
from planarc.flatten.terms.select import array, boolean, integer, opened
from planarc.flatten.tree.nodes import Env, is_overloaded
from planarc.flatten.typing import arrays, clocks
from planarc.flatten.typing.arrays import MANY, Arguments, wrong_argument
from planarc.flatten.values.variability import variability_of
from planarc.ir import flat
from planarc.runtime import elementary
from planarc.runtime.elementary import Result


class Rule(Data):
    """The number of arguments that a built-in takes, and their types; the type of its value, or
    what makes it."""

    least: int
    most: int
    gives: Callable[[Arguments], flat.Type] | None = None
    takes: Callable[[flat.Type], bool] = lambda type_: True
    make: Callable[[str, Arguments, Span, Env], flat.Expression] | None = None
    names: tuple[str, ...] = ()  # of arguments that may be given by name


def apply_builtin(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    """A call of a built-in with complete positional arguments."""
    rule = rule_of(name)
    if not rule.least <= len(arguments) <= rule.most:
        meant = f"{name}{len(arguments)}"  # `atan2` for `atan` of two
        hint: Meant | str | None = Meant(name, (meant,)) if is_name(meant) else None
        if name == "der" and len(arguments) > 1:
            hint = "declare a variable for the first derivative, `v = der(x)`, and write `der(v)`"
        if name in ("min", "max") and len(arguments) > 2:
            hint = (
                f"put them into a vector: `{name}({{{', '.join(a.span.text for a in arguments)}}})`"
            )
        message = f"`{name}` takes {_wanted(rule)}, not {len(arguments)}"
        raise error("F290", message, span, hint=hint)
    for argument in arguments:
        if not rule.takes(argument.type):
            raise wrong_argument(name, argument)
    if rule.make is not None:
        return rule.make(name, arguments, span, env)
    assert rule.gives is not None
    return flat.Builtin(rule.gives(arguments), span, name, tuple(arguments))


def _wanted(rule: Rule) -> str:
    if rule.most >= MANY:
        return f"at least {counted(rule.least, 'argument')}"
    if rule.least == rule.most:
        return counted(rule.least, "argument")
    return f"{rule.least} to {rule.most} arguments"


def _number(type_: flat.Type) -> bool:
    return type_.base in NUMERIC


def _scalar(type_: flat.Type) -> bool:
    return type_.base in NUMERIC and not type_.dims


def mapped(name: str, result: flat.Type, arguments: Arguments, span: Span) -> flat.Expression:
    """A scalar function; over arrays it is applied to each entry (12.4.6)."""
    longest = max(arguments, key=lambda a: len(a.type.dims))
    if not longest.type.dims:
        return flat.Builtin(result, span, name, tuple(arguments))
    size = longest.type.dims[0]
    if size is None:
        return flat.Builtin(result.with_dims(longest.type.dims), span, name, tuple(arguments))
    if any(a.type.dims and a.type.dims[0] != size for a in arguments):
        raise error("F291", f"the arrays given to `{name}` differ in size", span)
    columns = [opened(a) if a.type.dims else [a] * size for a in arguments]
    items = [mapped(name, result, list(row), span) for row in zip(*columns, strict=True)]
    element = items[0].type if items else result
    return array(items, element, span)


def _mapped(type_of: Callable[[Arguments], flat.Type]) -> Any:
    return lambda name, arguments, span, env: mapped(name, type_of(arguments), arguments, span)


def _same_number(arguments: Arguments) -> flat.Type:
    return flat.INTEGER if all(a.type.base is flat.Base.INTEGER for a in arguments) else flat.REAL


def _extreme(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    """The `min` or `max` of two scalars or of an array."""
    type_ = arguments[0].type
    if len(arguments) == 1:
        if not type_.dims or type_.base is flat.Base.RECORD:
            raise wrong_argument(name, arguments[0])
        return flat.Builtin(type_.with_dims(()), span, name, tuple(arguments))
    common = unify(type_, arguments[1].type)
    if common is None or common.dims or common.base in (flat.Base.STRING, flat.Base.RECORD):
        raise wrong_argument(name, arguments[1])
    return flat.Builtin(common, span, name, tuple(arguments))


def _total(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    (value,) = arguments
    if is_overloaded(value, env):
        return env.session.makers.operate(name, (value,), span, env)
    if not _number(value.type):
        raise wrong_argument(name, value)
    if not value.type.dims:
        return value
    return flat.Builtin(value.type.with_dims(()), span, name, (value,))


# Operators of differential and discrete equations -------------------------------------------


def _der(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    (value,) = arguments
    if value.type.base is not flat.Base.REAL:
        if variability_of(value, env.session, env.hidden) > flat.Variability.PARAMETER:
            message = "`der` cannot be applied to what changes at events only"
            raise error("F291", message, value.span)
    elif isinstance(value, flat.Reference):
        _warn_of_nothing(value, span, env)
        _refuse_steps(value, env)
    return flat.Builtin(flat.REAL.with_dims(value.type.dims), span, name, (value,))


def _warn_of_nothing(value: flat.Reference, span: Span, env: Env) -> None:
    """The derivative of a parameter is zero; a library may ask for it, a user hardly means it."""
    users = span.source.name in env.session.library.user_files()
    if users and variability_of(value, env.session, env.hidden) <= flat.Variability.PARAMETER:
        message = f"`{span.text}` is always 0: `{value.name}` is a parameter"
        env.session.warn("F322", message, span, "take a variable, or leave it out")


def _refuse_steps(value: flat.Reference, env: Env) -> None:
    """What is declared `discrete` keeps its value between events: it has no derivative."""
    if variability_of(value, env.session, env.hidden) is flat.Variability.DISCRETE:
        hint = f"leave out `discrete` where `{value.name}` is declared, or the derivative"
        message = f"`{value.name}` has no derivative: it is `discrete`, it changes at events only"
        raise error("F291", message, value.span, hint=hint)


def _pre(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    """The value before the event, of a record that of each field."""
    parts = arrays.by_fields(arguments[0], lambda part: _of_variable(name, [part], span, env))
    return _of_variable(name, arguments, span, env) if parts is None else parts


def _of_variable(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    if not isinstance(arguments[0], flat.Reference | flat.Array):
        hint = f"give the expression a variable of its own: `b = ...`, and write `{name}(b)`"
        raise error("F291", f"`{name}` takes a variable, not an expression", span, hint=hint)
    type_ = arguments[0].type
    result = type_ if name == "pre" else flat.BOOLEAN.with_dims(type_.dims)
    return flat.Builtin(result, span, name, tuple(arguments))


def _sample(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    if len(arguments) == 1 or clocks.is_clock(arguments[1].type):
        return clocks.sampled(name, arguments, span, env)
    for argument in arguments:
        if not _scalar(argument.type):
            raise wrong_argument(name, argument)
    start, interval = arguments
    if variability_of(start, env.session, env.hidden) is flat.Variability.CONTINUOUS:
        message = f"`sample` begins at an instant: `{start.span.text}` moves"
        hint = f"`sample({start.span.text}, Clock({interval.span.text}))` takes its values"
        raise error("F291", message, start.span, hint=hint)
    return flat.Builtin(flat.BOOLEAN, span, name, tuple(arguments))


def _smooth(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    order, value = arguments
    if order.type.base is not flat.Base.INTEGER or order.type.dims:
        raise wrong_argument(name, order)
    return flat.Builtin(value.type, span, name, (order, value))


def _homotopy(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    common = unify(arguments[0].type, arguments[1].type)
    if common is None:
        raise wrong_argument(name, arguments[1])
    return flat.Builtin(common, span, name, tuple(arguments))


def to_string(value: flat.Expression, options: flat.Named, span: Span) -> flat.Expression:
    """`String(value)`, `String(value, format)`, or with significant digits, minimum
    length and left justification, all three in this order (3.7.1)."""
    if value.type.dims or value.type.base is flat.Base.RECORD:
        raise wrong_argument("String", value)
    for option, wanted in STRING_OPTIONS.items():
        if option in options:
            expect(wanted, options[option], f"`{option}` of `String`")
    given: flat.Expressions = ()
    if "format" in options:
        given = (options["format"],)
    elif options:
        defaults = (integer(6, span), integer(0, span), boolean(True, span))
        given = tuple(options.get(n, d) for n, d in zip(STRING_OPTIONS, defaults, strict=False))
    return flat.Builtin(flat.STRING, span, "String", (value, *given))


STRING_OPTIONS = {
    "significantDigits": flat.INTEGER,
    "minimumLength": flat.INTEGER,
    "leftJustified": flat.BOOLEAN,
    "format": flat.STRING,
}


def _to_string(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    value, *rest = arguments
    if len(rest) == 1 and rest[0].type.base is flat.Base.STRING:
        return to_string(value, {"format": rest[0]}, span)
    names = list(STRING_OPTIONS)[value.type.base is not flat.Base.REAL : 3]
    return to_string(value, dict(zip(names, rest, strict=False)), span)


def _instance_name(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    """`Model.component` of the component that the text belongs to (3.7.4.6)."""
    instance = env.scope.instance
    root = env.session.root
    env.session.asked.append(None)
    if instance.prefix is None or root is None:
        return flat.Literal(flat.STRING, span, instance.cls.name)
    model = root.cls.definition.name
    return flat.Literal(flat.STRING, span, f"{model}.{instance.prefix}".rstrip("."))


RULES: dict[str, Rule] = {
    "integer": Rule(1, 1, takes=_number, make=_mapped(lambda a: flat.INTEGER)),
    "sum": Rule(1, 1, make=_total),
    "product": Rule(1, 1, make=_total),
    "der": Rule(1, 1, takes=_number, make=_der),
    "pre": Rule(1, 1, make=_pre),
    "edge": Rule(1, 1, make=_of_variable),
    "change": Rule(1, 1, make=_of_variable),
    "noEvent": Rule(1, 1, lambda a: a[0].type),
    "smooth": Rule(2, 2, make=_smooth),
    "homotopy": Rule(2, 2, takes=_number, make=_homotopy, names=("actual", "simplified")),
    "semiLinear": Rule(3, 3, takes=_number, make=_mapped(lambda a: flat.REAL)),
    "delay": Rule(2, 3, lambda a: flat.REAL, _scalar),
    "initial": Rule(0, 0, lambda a: flat.BOOLEAN),
    "terminal": Rule(0, 0, lambda a: flat.BOOLEAN),
    "sample": Rule(1, 2, make=_sample, names=("start", "u", "interval", "clock")),
    "Integer": Rule(
        1,
        1,
        takes=lambda type_: type_.base is flat.Base.ENUMERATION,
        make=_mapped(lambda a: flat.INTEGER),
    ),
    "String": Rule(1, 4, make=_to_string),
    "getInstanceName": Rule(0, 0, make=_instance_name),
    "size": Rule(1, 2, make=lambda name, a, span, env: arrays.size(a, span, env)),
    **{name: Rule(least, most, make=f) for name, (least, most, f) in arrays.BUILDERS.items()},
    **{
        name: Rule(least, most, make=f, names=names)
        for name, (least, most, f, names) in clocks.CLOCKS.items()
    },
}

#: operators of the language that planarc refuses by name, with the section
_MACHINES = ("transition", "initialState", "activeState", "ticksInState", "timeInState")
REFUSED = {
    **dict.fromkeys(("inStream", "actualStream"), ("stream connectors", "15")),
    "spatialDistribution": ("`spatialDistribution`", "3.7.4.2"),
    **dict.fromkeys(_MACHINES, ("state machines", "17")),
    "promote": ("`promote`", "10.3.5"),
}

#: built-ins that functions cannot use (specification 12.2)
OF_MODELS = frozenset(
    {"der", "initial", "terminal", "sample", "pre", "edge", "change", "delay", "cardinality"}
    | clocks.CLOCKS.keys()
)

_ELEMENTARY = {
    Result.REAL: _mapped(lambda a: flat.REAL),
    Result.INTEGER: _mapped(lambda a: flat.INTEGER),
    Result.SAME: _mapped(_same_number),
}


def rule_of(name: str) -> Rule:
    row = elementary.TABLE.get(name)
    if row is None:
        return RULES[name]
    if row.result is Result.EXTREME:
        return Rule(1, row.arity, make=_extreme)
    return Rule(row.arity, row.arity, takes=_number, make=_ELEMENTARY[row.result])


_EQUATIONS = ("cardinality", "assert", "terminate", "reinit")


def names() -> Iterator[str]:
    return chain(elementary.TABLE, RULES, REFUSED, _EQUATIONS)


def is_name(name: str) -> bool:
    return name in elementary.TABLE or name in RULES or name in REFUSED or name in _EQUATIONS
