"""Built-in operators and functions: what they take and give.

In:   a name, typed arguments
Out:  a typed node: `flat.Builtin`, or the array that the function builds

Reference: Modelica Language Specification 3.6, sections 3.7, 8.3, 10.3 and 16.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import chain

from planarc.core.data import Data
from planarc.core.diagnostic import error
from planarc.core.prose import counted
from planarc.core.source import Span
from planarc.flatten.refusal import unsupported
from planarc.flatten.terms.conform import NUMERIC, expect, unify
from planarc.flatten.terms.select import array, boolean, integer, opened
from planarc.flatten.tree.nodes import Env
from planarc.flatten.typing import arrays
from planarc.flatten.typing.arrays import MANY, Arguments, wrong_argument
from planarc.flatten.values.variability import variability_of
from planarc.ir import flat
from planarc.runtime import elementary
from planarc.runtime.elementary import Result


class Rule(Data):
    """The number of arguments that a built-in takes, and the maker of its result."""

    least: int
    most: int
    make: Callable[[str, Arguments, Span, Env], flat.Expression]
    names: tuple[str, ...] = ()  # of arguments that may be given by name


def apply_builtin(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    """A call of a built-in with complete positional arguments."""
    rule = rule_of(name)
    if not rule.least <= len(arguments) <= rule.most:
        raise error("F290", f"`{name}` takes {_wanted(rule)}, not {len(arguments)}", span)
    return rule.make(name, arguments, span, env)


def _wanted(rule: Rule) -> str:
    if rule.most >= MANY:
        return f"at least {counted(rule.least, 'argument')}"
    if rule.least == rule.most:
        return counted(rule.least, "argument")
    return f"{rule.least} to {rule.most} arguments"


def _numeric(name: str, arguments: Arguments) -> None:
    for argument in arguments:
        if argument.type.base not in NUMERIC:
            raise wrong_argument(name, argument)


def _scalars(name: str, arguments: Arguments) -> None:
    """Numbers, and no arrays of them."""
    for argument in arguments:
        if argument.type.base not in NUMERIC or argument.type.dims:
            raise wrong_argument(name, argument)


def mapped(name: str, result: flat.Type, arguments: Arguments, span: Span) -> flat.Expression:
    """A scalar function; over arrays it is applied to each entry (12.4.6)."""
    longest = max(arguments, key=lambda a: len(a.type.dims))
    if not longest.type.dims:
        return flat.Builtin(result, span, name, tuple(arguments))
    size = longest.type.dims[0]
    if size is None:
        return flat.Builtin(result.with_dims(longest.type.dims), span, name, tuple(arguments))
    columns = []
    for argument in arguments:
        if not argument.type.dims:
            columns.append([argument] * size)
        elif argument.type.dims[0] == size:
            columns.append(opened(argument))
        else:
            raise error("F291", f"the arrays given to `{name}` differ in size", span)
    items = [mapped(name, result, list(row), span) for row in zip(*columns, strict=True)]
    element = items[0].type if items else result
    return array(items, element, span)


def _real(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    _numeric(name, arguments)
    return mapped(name, flat.REAL, arguments, span)


def _integer(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    _numeric(name, arguments)
    return mapped(name, flat.INTEGER, arguments, span)


def _same_number(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    _numeric(name, arguments)
    all_integer = all(a.type.base is flat.Base.INTEGER for a in arguments)
    return mapped(name, flat.INTEGER if all_integer else flat.REAL, arguments, span)


def _extreme(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    """`min` and `max`: of two scalars or of an array."""
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
    _numeric(name, arguments)
    if not arguments[0].type.dims:
        return arguments[0]
    return flat.Builtin(arguments[0].type.with_dims(()), span, name, tuple(arguments))


# Operators of differential and discrete equations -------------------------------------------


def _der(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    value = arguments[0]
    if value.type.base not in NUMERIC:
        raise wrong_argument(name, value)
    if value.type.base is not flat.Base.REAL:
        _expect_steady(value, env)
    elif isinstance(value, flat.Reference):
        _warn_of_nothing(value, span, env)
    type_ = flat.REAL.with_dims(value.type.dims)
    return flat.Builtin(type_, span, "der", (value,))


def _warn_of_nothing(value: flat.Reference, span: Span, env: Env) -> None:
    """The derivative of a parameter is zero; a library may ask for it, a user hardly means it."""
    users = span.source.name in env.session.library.user_files()
    if users and variability_of(value, env.session, env.hidden) <= flat.Variability.PARAMETER:
        message = f"`{span.text}` is always 0: `{value.name}` is a parameter"
        env.session.warn("F322", message, span, "take a variable, or leave it out")


def _expect_steady(value: flat.Expression, env: Env) -> None:
    if variability_of(value, env.session, env.hidden) > flat.Variability.PARAMETER:
        raise error("F291", "`der` cannot be applied to what changes at events only", value.span)


def _same(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    return flat.Builtin(arguments[0].type, span, name, tuple(arguments))


def _of_variable(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    if not isinstance(arguments[0], flat.Reference | flat.Array):
        raise error("F291", f"`{name}` takes a variable, not an expression", span)
    type_ = arguments[0].type
    result = type_ if name == "pre" else flat.BOOLEAN.with_dims(type_.dims)
    return flat.Builtin(result, span, name, tuple(arguments))


def _flag(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    return flat.Builtin(flat.BOOLEAN, span, name)


def _sample(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    if len(arguments) == 1:
        raise unsupported("clocks", "16", span)
    _scalars(name, arguments)
    return flat.Builtin(flat.BOOLEAN, span, name, tuple(arguments))


def _smooth(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    if arguments[0].type.base is not flat.Base.INTEGER or arguments[0].type.dims:
        raise wrong_argument(name, arguments[0])
    return flat.Builtin(arguments[1].type, span, name, tuple(arguments))


def _homotopy(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    _numeric(name, arguments)
    common = unify(arguments[0].type, arguments[1].type)
    if common is None:
        raise wrong_argument(name, arguments[1])
    return flat.Builtin(common, span, name, tuple(arguments))


def _scalar_real(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    _scalars(name, arguments)
    return flat.Builtin(flat.REAL, span, name, tuple(arguments))


def _to_integer(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    if arguments[0].type.base is not flat.Base.ENUMERATION:
        raise wrong_argument(name, arguments[0])
    return mapped(name, flat.INTEGER, arguments, span)


def to_string(
    value: flat.Expression, options: dict[str, flat.Expression], span: Span
) -> flat.Expression:
    """`String(value)`, `String(value, format)`, or with significant digits, minimum
    length and left justification, all three in this order (3.7.1)."""
    if value.type.dims or value.type.base is flat.Base.RECORD:
        raise wrong_argument("String", value)
    for option, wanted in STRING_OPTIONS.items():
        if option in options:
            expect(wanted, options[option], f"`{option}` of `String`")
    if "format" in options:
        return flat.Builtin(flat.STRING, span, "String", (value, options["format"]))
    if not options:
        return flat.Builtin(flat.STRING, span, "String", (value,))
    digits = options.get("significantDigits", integer(6, span))
    length = options.get("minimumLength", integer(0, span))
    left = options.get("leftJustified", boolean(True, span))
    return flat.Builtin(flat.STRING, span, "String", (value, digits, length, left))


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
    names = ["significantDigits", "minimumLength", "leftJustified"]
    if value.type.base is not flat.Base.REAL:
        names = names[1:]
    return to_string(value, dict(zip(names, rest, strict=False)), span)


def _instance_name(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    """`Model.component` of the component that the text belongs to (3.7.4.6)."""
    instance = env.scope.instance
    root = env.session.root
    if instance.prefix is None or root is None:
        return flat.Literal(flat.STRING, span, instance.cls.name)
    model = root.cls.definition.name
    return flat.Literal(flat.STRING, span, f"{model}.{instance.prefix}".rstrip("."))


def _size(name: str, arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    return arrays.size(arguments, span, env)


RULES: dict[str, Rule] = {
    "integer": Rule(1, 1, _integer),
    "sum": Rule(1, 1, _total),
    "product": Rule(1, 1, _total),
    "der": Rule(1, 1, _der),
    "pre": Rule(1, 1, _of_variable),
    "edge": Rule(1, 1, _of_variable),
    "change": Rule(1, 1, _of_variable),
    "noEvent": Rule(1, 1, _same),
    "smooth": Rule(2, 2, _smooth),
    "homotopy": Rule(2, 2, _homotopy, ("actual", "simplified")),
    "semiLinear": Rule(3, 3, _scalar_real),
    "delay": Rule(2, 3, _scalar_real),
    "initial": Rule(0, 0, _flag),
    "terminal": Rule(0, 0, _flag),
    "sample": Rule(1, 2, _sample),
    "Integer": Rule(1, 1, _to_integer),
    "String": Rule(1, 4, _to_string),
    "getInstanceName": Rule(0, 0, _instance_name),
    "size": Rule(1, 2, _size),
    **{name: Rule(*rule) for name, rule in arrays.BUILDERS.items()},
}

#: operators of the language that planarc refuses by name, with the section
_CLOCKS = ("previous", "hold", "subSample", "superSample", "shiftSample", "backSample")
_MACHINES = ("transition", "initialState", "activeState", "ticksInState", "timeInState")
REFUSED = {
    **dict.fromkeys(("inStream", "actualStream"), ("stream connectors", "15")),
    "spatialDistribution": ("`spatialDistribution`", "3.7.4.2"),
    **dict.fromkeys((*_CLOCKS, "noClock", "interval", "Clock", "firstTick"), ("clocks", "16")),
    **dict.fromkeys(_MACHINES, ("state machines", "17")),
    "promote": ("`promote`", "10.3.5"),
}

#: built-ins that functions cannot use (specification 12.2)
OF_MODELS = frozenset(
    {"der", "initial", "terminal", "sample", "pre", "edge", "change", "delay", "cardinality"}
)

_ELEMENTARY = {
    Result.REAL: _real,
    Result.INTEGER: _integer,
    Result.SAME: _same_number,
    Result.EXTREME: _extreme,
}


def rule_of(name: str) -> Rule:
    row = elementary.TABLE.get(name)
    if row is None:
        return RULES[name]
    least = 1 if row.result is Result.EXTREME else row.arity
    return Rule(least, row.arity, _ELEMENTARY[row.result])


_EQUATIONS = ("cardinality", "assert", "terminate", "reinit")


def names() -> Iterator[str]:
    return chain(elementary.TABLE, RULES, REFUSED, _EQUATIONS)


def is_name(name: str) -> bool:
    return name in elementary.TABLE or name in RULES or name in REFUSED or name in _EQUATIONS
