"""The printer of the flat model: valid Modelica text, one declaration or equation a line.

In:   FlatModel
Out:  text, as `planarc flatten` shows it and golden tests compare it

Names with dots and brackets are quoted identifiers, `'crank.frame_b.r'`, so that the
text is a model of its own; functions and types come first.

Example:
    model FourBar
      parameter Real 'crank.L'(unit = "m") = 0.1 "Length of the rod";
      Real 'crank.frame_b.r'[2](each unit = "m");
    equation
      'crank.frame_b.r'[1] = cos('crank.phi');
    end FourBar;

The file is long because every node of the flat model has its text here.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from msgspec.structs import replace

from planarc.ir import flat
from planarc.ir.flatwalk import (
    expressions_of_function,
    expressions_of_model,
    functions_called,
    nodes_of,
)
from planarc.ir.text.compound import Compound
from planarc.ir.text.expression import quote

_PLAIN = r"^(?:[A-Za-z_][A-Za-z_0-9]*|'(?:[^'\\]|\\.)*')$"

#: strength of operators; an operand that binds less is put in parentheses (3.2)
_STRENGTH = {
    "or": 1,
    "and": 2,
    "not": 3,
    **dict.fromkeys(("<", "<=", ">", ">=", "==", "<>"), 4),
    **dict.fromkeys(("+", "-", ".+", ".-"), 5),
    **dict.fromkeys(("*", "/", ".*", "./"), 6),
    **dict.fromkeys(("^", ".^"), 7),
}
_ATOM = 9

_RECORD_NAMES = (flat.Base.RECORD, flat.Base.ENUMERATION)


def quoted(name: str) -> str:
    """A full name as one identifier."""
    if re.match(_PLAIN, name):
        return name
    escaped = name.replace("\\", "\\\\").replace("'", "\\'")
    return f"'{escaped}'"


def print_expression(expression: flat.Expression) -> str:
    return _text(expression)[0]


def _within(expression: flat.Expression, strength: int) -> str:
    text, own = _text(expression)
    return text if own >= strength else f"({text})"


def _list(expressions: tuple[flat.Expression, ...]) -> str:
    return ", ".join([print_expression(e) for e in expressions])


def _named(arguments: Iterable[tuple[str, flat.Expression]]) -> str:
    return ", ".join([f"{quoted(n)} = {print_expression(v)}" for n, v in arguments])


def _text(e: flat.Expression) -> tuple[str, int]:
    """The text of an expression, and how strongly it binds."""
    match e:
        case flat.Literal():
            return _literal(e)
        case flat.Reference(name=name, subscripts=subscripts):
            return quoted(name) + _subscripts(subscripts), _ATOM
        case flat.Slice():
            return ":", _ATOM
        case flat.Unary(op="not", operand=operand):
            return f"not {_within(operand, 4)}", 3
        case flat.Unary(operand=operand):
            return f"-{_within(operand, 6)}", 5
        case flat.Binary():
            return _binary(e)
        case flat.If(branches=branches, otherwise=otherwise):
            parts = [f"if {print_expression(c)} then {print_expression(v)}" for c, v in branches]
            return " else".join(parts) + f" else {print_expression(otherwise)}", 0
        case flat.Array(items=items):
            return ("{" + _list(items) + "}" if items else _empty(e.type)), _ATOM
        case flat.Range(start=start, step=step, stop=stop):
            ends = (start, stop) if step is None else (start, step, stop)
            return ":".join([_within(x, 5) for x in ends]), 0
        case flat.Index(base=base, subscripts=subscripts):
            field = isinstance(base, flat.Field) and isinstance(base.base, flat.Reference)
            text = print_expression(base)
            return (text if field else f"({text})") + _subscripts(subscripts), _ATOM
        case flat.Field(base=flat.Reference() as base, name=name):
            return f"{print_expression(base)}.{quoted(name)}", _ATOM
        case flat.Field(base=base, name=name):
            return f"({print_expression(base)}).{name}", _ATOM
        case flat.Record(type=type_, items=items):
            return f"{quoted(type_.name)}({_list(items)})", _ATOM
        case flat.Builtin(function="time"):
            return "time", _ATOM
        case flat.Builtin(function="Enumeration", arguments=arguments):
            return f"{quoted(e.type.name)}({_list(arguments)})", _ATOM
        case flat.Builtin(function="String", arguments=(value, digits, length, left)):
            named = {"minimumLength": length, "leftJustified": left}
            if value.type.base is flat.Base.REAL:
                named = {"significantDigits": digits, **named}
            return f"String({print_expression(value)}, {_named(named.items())})", _ATOM
        case flat.Builtin(function="String", arguments=(value, format_)):
            return f"String({_list((value,))}, {_named((('format', format_),))})", _ATOM
        case flat.Builtin(function=function, arguments=arguments):
            return f"{function}({_list(arguments)})", _ATOM
        case flat.Call(function=function, arguments=arguments):
            return f"{quoted(function)}({_list(arguments)})", _ATOM
        case flat.PartialCall(function=function, bound=bound):
            return f"function {quoted(function)}({_named(bound)})", _ATOM
        case flat.Comprehension():
            return _comprehension(e), _ATOM
    raise TypeError(f"not an expression: {e!r}")


def _literal(e: flat.Literal) -> tuple[str, int]:
    value = e.value
    if e.type.base is flat.Base.ENUMERATION:
        literal = e.type.literals[int(value) - 1]
        return f"{quoted(e.type.name)}.{literal}", _ATOM
    if isinstance(value, bool):
        return ("true" if value else "false"), _ATOM
    if isinstance(value, str):
        return quote(value), _ATOM
    return number_text(value), (5 if value < 0 else _ATOM)


def number_text(value: float) -> str:
    """A number that reads back as the same number; Reals show a point or an exponent."""
    if isinstance(value, int):
        return str(value)
    if value in (float("inf"), float("-inf")):
        return "1e400" if value > 0 else "-1e400"
    text = repr(float(value))
    return text if any(c in text for c in ".en") else text + ".0"


def _binary(e: flat.Binary) -> tuple[str, int]:
    """A left-leaning chain of one strength is walked, not recursed."""
    strength = _STRENGTH[e.op]
    tail: list[str] = []
    node: flat.Expression = e
    while isinstance(node, flat.Binary) and _STRENGTH[node.op] == strength:
        tail.append(f" {node.op} {_within(node.right, strength + 1)}")
        node = node.left
        if strength in (4, 7):
            break  # relations and powers do not chain
    left = _within(node, strength + 1 if strength in (4, 7) else strength)
    return left + "".join(reversed(tail)), strength


def _subscripts(subscripts: tuple[flat.Expression, ...]) -> str:
    return f"[{_list(subscripts)}]" if subscripts else ""


def _empty(type_: flat.Type) -> str:
    neutral = {
        flat.Base.REAL: "0.0",
        flat.Base.INTEGER: "0",
        flat.Base.BOOLEAN: "false",
        flat.Base.STRING: '""',
    }
    sizes = ", ".join(str(d or 0) for d in type_.dims)
    return f"fill({neutral.get(type_.base, '0')}, {sizes})"


def _comprehension(e: flat.Comprehension) -> str:
    iterators = e.iterators[::-1] if e.reduce == "array" else e.iterators  # the last is outermost
    ranges = ", ".join([f"{n} in {print_expression(r)}" for n, r in iterators])
    inner = f"{print_expression(e.body)} for {ranges}"
    return "{" + inner + "}" if e.reduce == "array" else f"{e.reduce}({inner})"


# Types and declarations -----------------------------------------------------------------------


def type_name(type_: flat.Type) -> str:
    return quoted(type_.name) if type_.name else type_.base.value


def _dims(type_: flat.Type, sizes: tuple[flat.Expression | None, ...] = ()) -> str:
    if not type_.dims:
        return ""
    texts = []
    for k, size in enumerate(type_.dims):
        expression = sizes[k] if k < len(sizes) else None
        known = ":" if size is None else str(size)
        texts.append(known if expression is None else print_expression(expression))
    return f"[{', '.join(texts)}]"


def _attributes(variable: flat.Variable) -> str:
    a = variable.attributes
    dims = variable.type.dims
    found: list[str] = []
    for name in ("start", "fixed", "min", "max", "nominal"):
        value = getattr(a, name)
        if value is not None:
            each = "each " if dims and not value.type.dims else ""
            found.append(f"{each}{name} = {print_expression(value)}")
    each = "each " if dims else ""
    if a.state_select is not flat.StateSelect.DEFAULT:
        found.append(f"{each}stateSelect = StateSelect.{a.state_select.name.lower()}")
    for name, text in (("unit", a.unit), ("displayUnit", a.display_unit), ("quantity", a.quantity)):
        if text:
            found.append(f"{each}{name} = {quote(text)}")
    return f"({', '.join(found)})" if found else ""


def print_variable(variable: flat.Variable) -> str:
    """A declaration, without `;`."""
    variability, real = variable.variability, variable.type.base is flat.Base.REAL
    text = "final " if variable.final else ""
    if variability < flat.Variability.DISCRETE or (
        variability is flat.Variability.DISCRETE and real
    ):
        text += f"{variability.name.lower()} "
    text += f"{variable.causality} " if variable.causality else ""
    text += f"{type_name(variable.type)} {quoted(variable.name)}"
    text += _dims(variable.type, variable.sizes) + _attributes(variable)
    if variable.binding is not None:
        text += f" = {print_expression(variable.binding)}"
    if variable.description:
        text += f" {quote(variable.description)}"
    return text


# Equations and statements ---------------------------------------------------------------------


def _body(
    items: Iterable[flat.Equation | flat.Statement], records: frozenset[str] = frozenset()
) -> Iterator[str]:
    """The lines of equations or statements. `records` are local variables whose fields are
    assigned."""

    def head(loop: flat.ForStatement) -> str:
        return f"{quoted(loop.iterator)} in {print_expression(loop.range)}"

    return Compound(print_expression, head, lambda item: _plain(item, records)).body(items)


def _plain(item: flat.Equation | flat.Statement, records: frozenset[str]) -> str:
    match item:
        case flat.Equality(left=flat.Targets(items=items), right=right):
            shown = ["" if i is None else print_expression(i) for i in items]
            return f"{_several(shown, '=')}{print_expression(right)};"
        case flat.Equality(left=left, right=right):
            assert not isinstance(left, flat.Targets)
            side = print_expression(left)
            side = f"({side})" if isinstance(left, flat.If) else side
            return f"{side} = {print_expression(right)};"
        case flat.Assignment(target=target, value=value):
            return f"{_target(target, records)} := {print_expression(value)};"
        case flat.TupleAssignment(targets=targets, value=call):
            shown = ["" if t is None else _target(t, records) for t in targets]
            return f"{_several(shown, ':=')}{print_expression(call)};"
        case flat.Assert(condition=condition, message=message, warning=warning):
            level = ", AssertionLevel.warning" if warning else ""
            return f"assert({print_expression(condition)}, {print_expression(message)}{level});"
        case flat.Terminate(message=message):
            return f"terminate({print_expression(message)});"
        case flat.Impact(arguments=arguments, crowd=crowd):
            return (
                f"{'crowd' if crowd else 'impact'}({', '.join(map(print_expression, arguments))});"
            )
        case flat.Reinit(variable=variable, value=value):
            return f"reinit({print_expression(variable)}, {print_expression(value)});"
    raise TypeError(f"not an equation: {item!r}")


def _several(shown: list[str], sign: str) -> str:
    """The left side of a call with several results; nothing where there are none."""
    return f"({', '.join(shown)}) {sign} " if shown else ""


def _target(target: flat.Target, records: frozenset[str]) -> str:
    if not isinstance(target, flat.Reference):
        return print_expression(target)
    first, *fields = target.name.split(".")
    if fields and first in records:
        return ".".join(map(quoted, (first, *fields))) + _subscripts(target.subscripts)
    return print_expression(target)


# The whole ----------------------------------------------------------------------------------------


def print_function(function: flat.Function) -> str:
    """A function as text."""
    name = quoted(function.name)
    if function.derivative_of is not None:
        of, inputs = function.derivative_of
        return f"function {name} = der({quoted(of)}, {', '.join(inputs)});"
    head = "partial function" if function.partial else "function"
    lines = [f"{head} {name}"]
    lines += [f"  {print_variable(v)};" for v in (*function.inputs, *function.outputs)]
    if function.locals:
        lines += ["protected", *(f"  {print_variable(v)};" for v in function.locals)]
    if function.external is not None:
        lines.append(_external(function))
    elif not function.partial:
        own = (*function.outputs, *function.locals)
        records = frozenset(v.name for v in own if v.type.base is flat.Base.RECORD)
        lines += ["algorithm", *_body(function.body, records)]
    if function.derivatives:
        shown = ", ".join(map(_derivative, function.derivatives))
        lines.append(f"  annotation({shown});")
    return "\n".join([*lines, f"end {name};"])


def _derivative(derivative: flat.Derivative) -> str:
    still = "".join(f", noDerivative = {quoted(n)}" for n in sorted(derivative.still))
    return f"derivative(order = {derivative.order}{still}) = {quoted(derivative.function)}"


def _external(function: flat.Function) -> str:
    """Results behind what is given, but a single one in front (12.9)."""
    results = [quoted(n) for n in function.results or [v.name for v in function.outputs]]
    given = [print_expression(e) for e in function.given]
    if not given and not function.results:
        given = [quoted(v.name) for v in function.inputs]
    head = f"{results.pop()} = " if len(results) == 1 else ""
    return f'external "builtin" {head}{function.external}({", ".join([*given, *results])});'


def _named_types(model: flat.FlatModel) -> dict[str, flat.Type]:
    """Enumerations and records that are named somewhere, in order."""
    found: dict[str, flat.Type] = {}
    variables = list(model.variables)
    expressions = list(expressions_of_model(replace(model, visuals=())))
    for function in model.functions:
        variables += [*function.inputs, *function.outputs, *function.locals]
        expressions += expressions_of_function(function)
    stack = [v.type for v in variables]
    stack += [e.type for e in nodes_of(expressions) if isinstance(e, flat.Literal | flat.Record)]
    stack.reverse()
    while stack:
        type_ = stack.pop()
        if type_.name and type_.name not in found and type_.base in _RECORD_NAMES:
            found[type_.name] = type_
            stack.extend(t for _, t in reversed(type_.fields))
    found.pop("StateSelect", None)
    found.pop("AssertionLevel", None)
    return found


def _type_lines(name: str, type_: flat.Type) -> list[str]:
    if type_.base is flat.Base.ENUMERATION:
        return [f"type {quoted(name)} = enumeration({', '.join(type_.literals)});"]
    lines = [f"record {quoted(name)}"]
    lines += [f"  {type_name(t)} {quoted(n)}{_dims(t)};" for n, t in type_.fields]
    return [*lines, f"end {quoted(name)};"]


def _without_declared(model: flat.FlatModel) -> flat.FlatModel:
    """The model as its equations and its drawing need it: fewer functions."""
    functions = {f.name: f for f in model.functions}
    plain = replace(model, declared=())
    others = functions_called((d.value for d in model.declared), functions)
    others -= functions_called(expressions_of_model(plain), functions)
    return replace(plain, functions=tuple(f for f in model.functions if f.name not in others))


def print_model(model: flat.FlatModel) -> str:
    """The flat model as Modelica text, without what its components declare of themselves."""
    model = _without_declared(model)
    blocks = ["\n".join(_type_lines(n, t)) for n, t in _named_types(model).items()]
    blocks += [print_function(f) for f in model.functions]
    name = quoted(model.name)
    lines = [f"model {name}" + (f" {quote(model.description)}" if model.description else "")]
    lines += [f"  {print_variable(v)};" for v in model.variables if not v.protected]
    hidden = [v for v in model.variables if v.protected]
    if hidden:
        lines += ["protected", *(f"  {print_variable(v)};" for v in hidden)]
    for head, equations in (
        ("initial equation", model.initial_equations),
        ("equation", model.equations),
    ):
        if equations:
            lines += [head, *_body(equations)]
    for head, algorithms in (
        ("initial algorithm", model.initial_algorithms),
        ("algorithm", model.algorithms),
    ):
        for algorithm in algorithms:
            lines += [head, *_body(algorithm.statements)]
    return "\n\n".join([*blocks, "\n".join([*lines, f"end {name};"])]) + "\n"
