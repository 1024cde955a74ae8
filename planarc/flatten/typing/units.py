"""Units: whether the two sides of equations, bindings and connections agree.

In:   FlatModel
Out:  warnings, each with both units as derived

A variable without a unit fits everything, and so does a number in a sum. In a product
only the numbers 1, 2 and 1/2 count as plain numbers: others may hide a unit of their own,
as in `tau = -0.1*w`, and so may `time`, as in `phi = time`. Nothing is reported that is
not certain. Scales count where they are certain, too: nothing converts `km/h` into `m/s`.

Example: `F = m*v` with units N, kg and m/s is reported with `N`, as declared, and `kg.m/s`.

Reference: Modelica Language Specification 3.6, chapter 19.

The file is long because what is certain of a unit and what is told of it are one walk.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable
from enum import Enum
from fractions import Fraction
from functools import reduce
from math import isclose

from msgspec import Struct, field
from msgspec.structs import replace

from planarc.core import unit
from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Once, Related, Severity, UsageError
from planarc.core.prose import both
from planarc.core.quantity import in_unit, measure
from planarc.core.source import Span
from planarc.core.unit import NUMBER, Dimension
from planarc.flatten.typing.meant import (
    SAME_SCALE,
    Known,
    Sides,
    agree,
    scale,
    terms,
    what_is_meant,
    wrongly_declared,
)
from planarc.ir import flat
from planarc.ir.flatwalk import CONVERSIONS, OUTWARDS, inside
from planarc.runtime import elementary
from planarc.runtime.elementary import Elementary, Units

_PLAIN = (*NUMBER, 0.0)

#: What is mostly forgotten, or too many, in a product.
_FACTORS = {"m": "a length", "s": "a time or a `der`", "kg": "a mass", "m/s2": "gravity"}

_PLAIN_NUMBERS = frozenset({0.5, 1.0, 2.0, -1.0})
_KEEP = CONVERSIONS | OUTWARDS | {"pre", "noEvent", "sum", "delay", "transpose", "fill", "previous"}


class _Given(Data):
    """An argument of a call whose unit is not that of its input."""

    name: str
    unit: str  # of the input, as it was declared
    wanted: Dimension
    argument: flat.Expression
    value: Dimension


class _Misfit(Data):
    """A value whose unit is not that of its variable. `told` is the number of the message."""

    name: str
    own: Dimension
    given: Dimension
    span: Span
    told: int


class Checker(Struct):
    """The units of a model's variables, and what was found wrong."""

    units: dict[str, Known]
    functions: dict[str, flat.Function]
    celsius: frozenset[str] = frozenset()  # variables in `degC`, whose zero is not that of `K`
    declared: dict[str, str] = field(default_factory=dict)  # units as texts
    found: list[Diagnostic] = field(default_factory=list)
    values: list[_Misfit] = field(default_factory=list)  # of other units than their variables

    def report(
        self, what: str, a: Dimension, b: Dimension, span: Span, sides: Sides = (None, None)
    ) -> None:
        hint, first, second = None, self.text(a, sides[0]), self.text(b, sides[1])
        if a[:-1] == b[:-1]:
            # What is in another unit than those of the SI is to be converted.
            power, given = scale(b) - scale(a), second
            if abs(scale(b)) < SAME_SCALE:
                power, given = -power, first
            hint = f"nothing converts units: multiply what is in `{given}` by {10**power:.6g}"
            hint = _other_way(sides[1]) or hint
        elif unit.multiply(a, b)[:-1] == NUMBER and a[:-1] != NUMBER:
            hint = "they are the reciprocals of each other: perhaps `1/...` is meant"
        else:
            ratios = (unit.unit_text(r[:-1]) for r in (unit.divide(a, b), unit.divide(b, a)))
            found = next((r for r in ratios if r in _FACTORS), None)
            hint = found and f"they differ by a factor in `{found}`: look for {_FACTORS[found]}"
            hint = what_is_meant(self.units, (a, b), sides) or hint
            hint = hint or wrongly_declared(self.units, self.declared, (a, b), sides)
        message = f"{what} have different units: `{first}` and `{second}`"
        self.found.append(Diagnostic("F330", message, span, Severity.WARNING, hint=hint))

    def text(self, known: Dimension, side: flat.Expression | str | None) -> str:
        """A unit as it was declared, where it is that of a variable, or of a sum of variables."""
        if isinstance(side, str):
            return side
        added = () if side is None else terms(side)
        names = (e.name for e in added if isinstance(e, flat.Reference))
        texts = (self.declared.get(n) for n in names if self.units.get(n) == known)
        return next((t for t in texts if t), None) or _text(known)

    def agree(
        self, what: str, a: Known, b: Known, span: Span, sides: Sides = (None, None)
    ) -> Known:
        """The unit that both sides have; a certain difference is reported, once: then it is not
        known."""
        if a is not None and b is not None and not agree(a, b):
            self.report(what, a, b, span, sides)
            return None
        return a if a is not None else b

    # Expressions ------------------------------------------------------------------------

    def of(self, e: flat.Expression) -> Known:
        """The unit of an expression."""
        match e:
            case flat.Literal():
                return None
            case flat.Reference(name=name):
                return self.units.get(name)
            case flat.Unary(operand=operand):
                return self.of(operand)
            case flat.Binary():
                return self.binary(e)
            case flat.If(branches=branches, otherwise=otherwise):
                for condition, _ in branches:
                    self.of(condition)
                values = [self.of(v) for _, v in branches] + [self.of(otherwise)]
                return self.together("the branches of `if`", values, e.span)
            case flat.Array(items=items):
                return shared([self.of(i) for i in items])
            case flat.Index(base=base):
                return self.of(base)
            case flat.Builtin():
                return self.builtin(e)
            case flat.Call():
                return self.call(e)
        return None

    def entries(
        self, what: str, own: Known, e: flat.Expression, span: Span, itself: flat.Expression
    ) -> None:
        """Compare a value with what it is given to: the entries of an array apart where they have
        units of several kinds, but where its unit is `1`, which is said of any numbers."""
        given = self.of(e)
        if isinstance(e, flat.Array) and given is None and own != _PLAIN:
            for item in e.items:
                self.entries(what, own, item, item.span, itself)
            return
        self.agree(what, own, given, span, (itself, e))

    def together(self, what: str, values: list[Known], span: Span) -> Known:
        return reduce(lambda a, b: self.agree(what, a, b, span), values)

    def binary(self, e: flat.Binary) -> Known:
        left, right = self.of(e.left), self.of(e.right)
        match e.op:
            case "-" | ".-" if self.zeros(e.right, e.left) > 0:
                self.report_zeros(f"the sides of `{e.op}`", e.span)
                return left
            case "+" | "-" | ".+" | ".-":
                if left != right and all(map(_has_gain, terms(e))):
                    return None
                sides = e.left, e.right
                return self.agree(f"the sides of `{e.op}`", left, right, e.span, sides)
            case "<" | "<=" | ">" | ">=" | "==" | "<>":
                if self.zeros(e.left, e.right):
                    self.report_zeros(f"the sides of `{e.op}`", e.span)
                self.agree(f"the sides of `{e.op}`", left, right, e.span, (e.left, e.right))
                return None
            case "*" | ".*":
                return self.combine(e, left, right, unit.multiply)
            case "/" | "./":
                return self.combine(e, left, right, unit.divide)
            case "^" | ".^":
                return self.power(left, e.right)
        return None

    def zeros(self, a: flat.Expression, b: flat.Expression) -> int:
        """1 where the first of two variables is in `degC` and the second in `K`, -1 where it is the
        other way round. A temperature in `degC` may well be lowered by a difference in `K`."""
        if not (isinstance(a, flat.Reference) and isinstance(b, flat.Reference)):
            return 0
        known = [self.units.get(e.name) for e in (a, b)]
        if None in known or known[0] != known[1]:
            return 0
        return (a.name in self.celsius) - (b.name in self.celsius)

    def report_zeros(self, what: str, span: Span) -> None:
        message = f"{what} have different units: one is in `K`, the other in `degC`"
        hint = "convert by `Modelica.Units.Conversions.from_degC` or `to_degC`"
        self.found.append(Diagnostic("F330", message, span, Severity.WARNING, hint=hint))

    def combine(
        self,
        e: flat.Binary,
        left: Known,
        right: Known,
        join: Callable[[Dimension, Dimension], Dimension],
    ) -> Known:
        first = _PLAIN if left is None and is_plain_number(e.left) else left
        second = _PLAIN if right is None and is_plain_number(e.right) else right
        product = isinstance(e.left, flat.Binary) and e.left.op in ("*", ".*")
        if e.op in ("/", "./") and right is None and not product:
            second = None  # `time/2` may well mean two seconds, `m*v^2/2` hardly
        if first == second == _PLAIN and (left is None or right is None):
            return None  # and `2*sin(phi)` two newtons
        if first is None or second is None or is_plain_number(e):
            return None
        if e.op in ("*", ".*") and _is_one(e.left):
            return None  # nobody writes a factor of 1 but as the value of a gain
        return join(first, second)

    def power(self, base: Known, exponent: flat.Expression) -> Known:
        if base is None or not isinstance(exponent, flat.Literal):
            return None
        assert not isinstance(exponent.value, str)
        return unit.power(base, Fraction(exponent.value).limit_denominator(64))

    def builtin(self, e: flat.Builtin) -> Known:
        values = [self.of(a) for a in e.arguments]
        name = e.function
        if name == "der":
            second = measure("s")
            assert second is not None
            return None if values[0] is None else unit.divide(values[0], second)
        if name in _KEEP or (name == "sample" and e.type.base is flat.Base.REAL):
            return values[0]
        if name == "interval":
            return measure("s")
        if name == "cat":
            return values[-1]
        if name == "smooth":
            return values[1]
        if name == "homotopy":
            return self.together("the arguments of `homotopy`", values, e.span)
        row = elementary.TABLE.get(name)
        return None if row is None else self.elementary(row, values, e)

    def elementary(self, row: Elementary, values: list[Known], e: flat.Builtin) -> Known:
        match row.units:
            case Units.KEPT:
                return values[0]
            case Units.ROOT:
                return None if values[0] is None else unit.power(values[0], Fraction(1, 2))
            case Units.SAME | Units.RATIO:
                shared = self.together(f"the arguments of `{row.name}`", values, e.span)
                return shared if row.units is Units.SAME else _PLAIN
            case Units.NUMBER:
                what = f"`{row.name}` takes a number: these"
                for value, argument in zip(values, e.arguments, strict=True):
                    self.agree(what, value, _PLAIN, e.span, (argument, None))
                return _PLAIN
        return None

    def call(self, e: flat.Call) -> Known:
        function = self.functions.get(e.function)
        values = [self.of(a) for a in e.arguments]
        if function is None:
            return None
        wrong = [
            _Given(variable.name, variable.attributes.unit, wanted, argument, value)
            for variable, value, argument in zip(function.inputs, values, e.arguments, strict=False)
            if value is not None
            and (wanted := measure(variable.attributes.unit)) is not None
            and not agree(wanted, value)
        ]
        if not self.exchanged(function.name, wrong):
            for one in wrong:
                what = f"the input `{one.name}` of `{function.name}` and what is given"
                sides = one.unit, one.argument
                self.report(what, one.wanted, one.value, one.argument.span, sides)
        if e.output is None or e.output >= len(function.outputs):
            return None
        return measure(function.outputs[e.output].attributes.unit)

    def exchanged(self, function: str, wrong: list[_Given]) -> bool:
        """Report two arguments whose units fit when each takes the other's place."""
        if len(wrong) != 2:
            return False
        first, second = wrong
        if not (agree(first.wanted, second.value) and agree(second.wanted, first.value)):
            return False
        given = both(self.text(one.value, one.argument) for one in wrong)
        message = f"the inputs {both(one.name for one in wrong)} of `{function}` take "
        message += f"{both(one.unit for one in wrong)}, but are given {given}"
        span, other = first.argument.span, second.argument.span
        hint = f"exchange {both(' '.join(s.text.split()) for s in (span, other))}"
        note = (Related("the other one", other),) if other.line != span.line else ()
        found = Diagnostic("F330", message, span, Severity.WARNING, hint=hint, related=note)
        self.found.append(found)
        return True

    def merge_exchanged(self) -> None:
        """Tell of two fields of a record of which each has the value of the other once."""
        dropped = set[int]()
        for k, first in enumerate(self.values):
            whole = first.name.rpartition(".")[0]
            for second in self.values[k + 1 :]:
                beside = whole and second.name.rpartition(".")[0] == whole
                swapped = agree(first.own, second.given) and agree(second.own, first.given)
                if beside and swapped and first.span.line == second.span.line:
                    names = both((first.name, second.name))
                    given = both(" ".join(m.span.text.split()) for m in (first, second))
                    message = f"{names} have each other's units: {given} are exchanged"
                    hint = f"exchange {given}, or give fields by name"
                    told = replace(self.found[first.told], message=message, hint=hint)
                    self.found[first.told] = told
                    dropped.add(second.told)
        self.found = [d for k, d in enumerate(self.found) if k not in dropped]

    # Equations ------------------------------------------------------------------------------

    def equations(self, equations: tuple[flat.Equation, ...]) -> None:
        for equation in inside(equations):
            self.equation(equation)

    def equation(self, equation: flat.Equation) -> None:
        match equation:
            case flat.Equality(left=flat.Record(items=left), right=flat.Record(items=right)):
                for a, b in zip(left, right, strict=True):
                    self.sides(a, b, equation)
            case flat.Equality(left=left, right=right) if not isinstance(left, flat.Targets):
                self.sides(left, right, equation)
            case flat.IfEquation(branches=branches) | flat.WhenEquation(branches=branches):
                for condition, _ in branches:
                    self.of(condition)
            case flat.Assert(condition=condition):
                self.of(condition)
            case flat.Reinit(variable=variable, value=value):
                what = "the variable and the new value of `reinit`"
                self.agree(what, self.of(variable), self.of(value), equation.span)

    def sides(self, left: flat.Expression, right: flat.Expression, e: flat.Equality) -> None:
        what = "the connected variables" if e.generated else "the sides of the equation"
        if isinstance(left, flat.Array) and isinstance(right, flat.Array):
            for a, b in zip(left.items, right.items, strict=False):
                self.agree(what, self.of(a), self.of(b), e.span)
            return
        if self.zeros(left, right):
            self.report_zeros(what, e.span)
        if isinstance(left, flat.Array):
            left, right = right, left
        self.entries(what, self.of(left), right, e.span, left)

    def name(self, variable: flat.Variable) -> None:
        """A unit that cannot be read, and one for display that measures something else."""
        own, shown = variable.attributes.unit, variable.attributes.display_unit
        if own and self.units[variable.name] is None:
            message = f"the unit `{own}` of `{variable.name}` is not known"
            hint = "write it with units of the SI, `.` for times, and powers behind: `N.m/s2`"
            if (meant := _with_a_dot(own)) is not None:
                hint = f"write `{meant}`: a `.` stands between units that are multiplied"
            self.found.append(
                Diagnostic("F331", message, variable.span, Severity.WARNING, hint=hint)
            )
        measured, known = unit.parse(shown), self.units[variable.name]
        if measured is not None and known is not None and known[:-1] != measured:
            message = f"`{variable.name}` has the unit `{own}`, which is not shown in `{shown}`"
            self.warn(message, variable.span)

    def warn(self, message: str, span: Span) -> None:
        self.found.append(Diagnostic("F331", message, span, Severity.WARNING))

    def variable(self, variable: flat.Variable) -> None:
        own = self.units[variable.name]
        a = variable.attributes
        for what, value in (
            ("value", variable.binding),
            ("start", a.start),
            ("min", a.min),
            ("max", a.max),
            ("nominal", a.nominal),
        ):
            if value is not None:
                names = f"`{variable.name}` and its {what}"
                itself = flat.Reference(variable.type, variable.span, variable.name)
                given, told = self.of(value), len(self.found)
                self.entries(names, own, value, value.span, itself)
                if own and given and len(self.found) > told:
                    place = variable.name, own, given, value.span
                    self.values.append(_Misfit(*place, told))
                if self.zeros(itself, value):
                    self.report_zeros(names, value.span)
                self.text_behind(variable, what, value)

    def text_behind(self, variable: flat.Variable, what: str, value: flat.Expression) -> None:
        """A unit in quotes behind a number, `1500 "rpm"`, which is a description."""
        text = value.span.source.text
        found = _TEXT_BEHIND.match(text, value.span.end)
        number = re.fullmatch(r"[-+]?[\d.]+([eE][-+]?\d+)?", value.span.text)
        own = variable.attributes.unit
        if found is None or number is None or unit.parse(own) is None:
            return
        try:
            meant = in_unit(variable.name, f"{number[0]} {found[1]}", own)
        except UsageError:  # another text, or a unit of something else
            return
        if meant is None or isclose(meant, float(number[0]), rel_tol=SAME_SCALE):
            return
        text_span = value.span._replace(start=found.start(1) - 1, end=found.end(1) + 1)
        message = f'the {what} of `{variable.name}` is {number[0]} {own}: the text "{found[1]}" '
        message += "behind it is a description, which converts nothing"
        hint = f"write `{meant:.6g}`, which is {number[0]} {found[1]} in {own}"
        kind = f"{text_span.source.name}:{text_span.start}"
        self.found.append(Once("F330", message, text_span, Severity.WARNING, hint=hint, kind=kind))


def _is_one(e: flat.Expression) -> bool:
    """Whether a number is 1, with either sign."""
    e = e.operand if isinstance(e, flat.Unary) else e
    return isinstance(e, flat.Literal) and not isinstance(e.value, str) and abs(e.value) == 1


def _has_gain(term: flat.Expression) -> bool:
    """Whether a number stands before one variable, as the gain of a controller, which may have any
    unit."""
    if not isinstance(term, flat.Binary) or term.op not in ("*", ".*"):
        return False
    gain = term.left.operand if isinstance(term.left, flat.Unary) else term.left
    right = term.right
    sum_of_two = isinstance(right, flat.Binary) and right.op in ("+", "-", ".+", ".-")
    return isinstance(gain, flat.Literal) and (sum_of_two or not isinstance(right, flat.Binary))


#: Units of other scales that have names of their own.
_USUAL = ("deg", "mm", "cm", "km", "km/h", "g", "min", "h", "rpm", "bar")

#: A text right behind a value.
_TEXT_BEHIND = re.compile(r'\s*"([^"\s]{1,12})"')


def shared(values: Iterable[Known]) -> Known:
    """The unit of those of an array's entries that have one, if it is the same one."""
    known = {v for v in values if v is not None}
    return known.pop() if len(known) == 1 else None


def _other_way(side: flat.Expression | str | None) -> str | None:
    """The hint where a conversion is taken for its reverse."""
    if not isinstance(side, flat.Call) or not re.search(r"\.Conversions\.to_\w+$", side.function):
        return None
    name, written = side.function.rpartition(".")[2], " ".join(side.span.text.split())
    if name not in written:
        return None
    return f"`{name}` gives `{name[3:]}`: write `{written.replace(name, f'from_{name[3:]}')}`"


def _with_a_dot(text: str) -> str | None:
    """A unit that can be read once a dot stands between two letters, as in `Nm`."""
    places = (m.start() for m in re.finditer(r"(?<=[A-Za-z])(?=[A-Za-z])", text))
    tried = (f"{text[:k]}.{text[k:]}" for k in places)
    return next((u for u in tried if unit.parse(u) is not None), None)


_PREFIXES = {"1000": "k", "1e+06": "M", "0.001": "m"}


def _text(known: Dimension) -> str:
    """A measure by a usual name, or with its scale: `mm`, `kN/m`, `0.277778 m2/s`."""
    usual = next((u for u in _USUAL if (m := measure(u)) is not None and agree(m, known)), None)
    if usual is not None and abs(scale(known)) >= SAME_SCALE:
        return usual
    text = unit.unit_text(known[:-1])
    if abs(scale(known)) < SAME_SCALE:
        return text
    factor = f"{10 ** scale(known):.6g}"
    if factor in _PREFIXES and re.match(r"(N|Pa|W|V)\b", text):
        return f"{_PREFIXES[factor]}{text}"
    return factor if text == "1" else f"{factor} {text}"


def is_plain_number(e: flat.Expression) -> bool:
    """A number that has no unit, even in a product."""
    match e:
        case flat.Literal(value=bool()) | flat.Literal(value=str()):
            return False
        case flat.Literal(value=value):
            return value in _PLAIN_NUMBERS
        case flat.Unary(operand=operand):
            return is_plain_number(operand)
        case flat.Array(items=items):
            return all(_is_zero(i) or is_plain_number(i) for i in items)
        case flat.Binary(op="*" | "/", left=left, right=right):
            return is_plain_number(left) and is_plain_number(right)
    return False


def _is_zero(e: flat.Expression) -> bool:
    return isinstance(e, flat.Literal) and e.value == 0


class UnitCheck(Enum):
    """The answer to units that differ."""

    WARN = "warn"
    ERROR = "error"
    OFF = "off"


def check_units(
    model: flat.FlatModel, files: Collection[str], distinct: flat.FlatModel | None = None
) -> list[Diagnostic]:
    """Warnings for units that certainly differ, in the files that the user works on:
    what a library says inside is for its author to see. A `distinct` part of the model has all
    that can be wrong in it."""
    checker = Checker(
        {v.name: measure(v.attributes.unit) for v in model.variables},
        {f.name: f for f in model.functions},
        frozenset(v.name for v in model.variables if v.attributes.unit == "degC"),
        {v.name: v.attributes.unit for v in model.variables},
    )
    checked = distinct or model
    for variable in checked.variables:
        checker.name(variable)
        checker.variable(variable)
    checker.merge_exchanged()
    checker.equations(checked.equations)
    checker.equations(checked.initial_equations)
    for declared in checked.declared:
        what = f"`{declared.name or declared.kind}` of `__planarc` and its value"
        wanted, value = measure(declared.unit), declared.value
        checker.agree(what, wanted, checker.of(value), value.span, (declared.unit, None))
    return [d for d in checker.found if d.span is not None and d.span.source.name in files]
