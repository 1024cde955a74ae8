"""Numbers that remember how they were made, so that they can be made again from other rows.

A picture of a run is computed by functions of NumPy over its columns. Handed columns that
remember, the same functions leave a recipe: which operations led from the columns to what is
drawn. Choices (`if`, masks, how many hatches) stay as these rows decide them.

In:   Tape.rows, Tape.number   columns of a run; then whatever is computed of them
Out:  Tape.recipe(wanted)      steps, each over earlier ones, for what is wanted

Example: x + cos(phi)*0.4 of the columns 3 and 7

    [["column", 3], ["column", 7], ["cos", 1], ["multiply", 2, [0.4]], ["add", 0, 3]]

An argument is the number of a step, or a constant in brackets. What leaves NumPy's functions and
those named here (`float(x)`, `math.sin(x)`, entries of an array that are put in place) is an
ordinary number again: it stays what it was.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterable, Sequence
from functools import wraps
from typing import Any, ParamSpec, TypeAlias, TypeVar

import numpy as np

#: What a step does, by the names of NumPy's functions of entries; `record.js` knows the same.
ENTRIES = frozenset({
    "add", "subtract", "multiply", "divide", "power", "negative", "absolute", "sqrt", "square",
    "sign", "sin", "cos", "tan", "arcsin", "arccos", "arctan", "arctan2", "hypot", "sinh", "cosh",
    "tanh", "exp", "log", "log10", "floor", "ceil", "trunc", "remainder", "fmod", "minimum",
    "maximum", "less", "less_equal", "greater", "greater_equal", "equal", "not_equal",
    "logical_and", "logical_or", "logical_not", "isfinite",
})  # fmt: skip
#: Functions of whole columns.
_WHOLE = {np.unwrap: "unwrap", np.where: "where", np.nan_to_num: "nan_to_num"}

P = ParamSpec("P")
T = TypeVar("T")
Step: TypeAlias = "list[Any]"


#: What is no number of JSON, as JavaScript reads it.
_UNTOLD = {"nan": "NaN", "inf": "Infinity", "-inf": "-Infinity"}


class Tape:
    """The steps so far; equal ones are one."""

    def __init__(self) -> None:
        self.steps: list[tuple[Any, ...]] = []
        self._known: dict[tuple[Any, ...], int] = {}

    def rows(self, values: Any, *step: Any) -> Rows:
        """A column that is the result of a step."""
        found: Rows = np.asarray(values, dtype=float).view(Rows)
        found.tape, found.step = self, self.add(*step)
        return found

    def number(self, value: float, *step: Any) -> Number:
        found = Number(value)
        found.tape, found.step = self, self.add(*step)
        return found

    def add(self, *step: Any) -> int:
        if step not in self._known:
            self._known[step] = len(self.steps)
            self.steps.append(step)
        return self._known[step]

    def recipe(self, wanted: Sequence[int]) -> tuple[list[Step], list[int]]:
        """The steps that lead to what is wanted, and its numbers among them."""
        needed, waiting = set[int](), list(wanted)
        while waiting:
            number = waiting.pop()
            if number not in needed:
                needed.add(number)
                waiting += [a.step for a in self.steps[number] if isinstance(a, _Earlier)]
        place = {number: i for i, number in enumerate(sorted(needed))}

        def told(argument: Any) -> Any:
            if isinstance(argument, _Earlier):
                return place[argument.step]
            if not isinstance(argument, float):
                return argument
            return [argument if math.isfinite(argument) else _UNTOLD[str(argument)]]

        return [list(map(told, self.steps[n])) for n in sorted(needed)], [place[n] for n in wanted]

    def result(self, value: Any, name: str, *arguments: Any) -> Any:
        """What a function gave, with its step; as it is where an argument is not known."""
        told = [_argument(a) for a in arguments]
        if any(a is None for a in told):
            return value
        if name == "add" and 0.0 in told:
            return arguments[1 - told.index(0.0)]
        if name == "multiply" and 1.0 in told:
            return arguments[1 - told.index(1.0)]
        make = self.rows if isinstance(value, np.ndarray) and value.ndim else self.number
        return make(value, name, *told)


class _Earlier:
    """The number of an earlier step, as an argument."""

    __slots__ = ("step",)

    def __init__(self, step: int) -> None:
        self.step = step

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Earlier) and other.step == self.step

    def __hash__(self) -> int:
        return hash(("step", self.step))


def _argument(value: Any) -> Any:
    """A value as an argument of a step; None where it is an array that remembers nothing."""
    if isinstance(value, (Rows, Number)):
        return None if value.step is None else _Earlier(value.step)
    if isinstance(value, np.ndarray) and value.ndim:
        return None
    return float(value)


def _plain(value: Any) -> Any:
    if isinstance(value, Rows):
        return value.view(np.ndarray)
    return float(value) if isinstance(value, Number) else value


def _tape(values: Iterable[Any]) -> Tape | None:
    return next((v.tape for v in values if isinstance(v, (Rows, Number)) and v.tape), None)


def _entries(function: np.ufunc, method: str, inputs: Sequence[Any], options: Any) -> Any:
    """A function of entries, its step remembered."""
    options = {k: tuple(map(_plain, v)) if k == "out" else _plain(v) for k, v in options.items()}
    value = getattr(function, method)(*map(_plain, inputs), **options)
    tape = _tape(inputs)
    simple = method == "__call__" and not options and function.__name__ in ENTRIES
    return tape.result(value, function.__name__, *inputs) if tape and simple else value


def _whole(function: Callable[..., Any], given: Sequence[Any], options: Any) -> Any:
    value = function(*_deep(given), **{k: _deep(v) for k, v in options.items()})
    tape, name = _tape(given), _WHOLE.get(function)
    known = tape is not None and name is not None and not options
    return tape.result(value, name, *given) if tape and name and known else value


def _deep(value: Any) -> Any:
    return type(value)(map(_deep, value)) if type(value) in (list, tuple) else _plain(value)


class Rows(np.ndarray):
    """A column that remembers; a part of it does not."""

    tape: Tape | None = None
    step: int | None = None

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        if "out" in options:
            for changed in options["out"]:
                if isinstance(changed, Rows):
                    changed.step = None
            _entries(ufunc, method, inputs, options)
            return options["out"][0]
        return _entries(ufunc, method, inputs, options)

    def __array_function__(self, func: Any, types: Any, args: Any, kwargs: Any) -> Any:
        return _whole(func, args, kwargs)

    def __getitem__(self, place: Any) -> Any:
        value = self.view(np.ndarray)[place]
        if isinstance(place, int) and self.tape is not None:
            return self.tape.result(value, "entry", self, float(place))
        return value

    def __setitem__(self, place: Any, value: Any) -> None:
        self.step = None
        super().__setitem__(place, _plain(value))


class Number(float):
    """A number that remembers. Numbers made in other ways are not equal, so that nothing takes
    one for the other."""

    tape: Tape | None = None
    step: int | None = None

    def __array_ufunc__(self, function: Any, method: str, *inputs: Any, **options: Any) -> Any:
        return _entries(function, method, inputs, options)

    def __array_function__(self, function: Any, types: Any, given: Any, options: Any) -> Any:
        return _whole(function, given, options)

    def __eq__(self, other: object) -> bool:
        same = not isinstance(other, Number) or other.step == self.step
        return same and float(self) == other

    def __ne__(self, other: object) -> bool:
        return not self == other

    __hash__ = float.__hash__

    def __neg__(self) -> Any:
        return np.negative(self)

    def __abs__(self) -> Any:
        return np.absolute(self)


def _operation(function: np.ufunc, turned: bool) -> Callable[[Number, Any], Any]:
    def apply(self: Number, other: Any) -> Any:
        if not isinstance(other, (int, float, np.ndarray)):
            return NotImplemented
        return function(other, self) if turned else function(self, other)

    return apply


for _name, _function in (
    ("add", np.add),
    ("sub", np.subtract),
    ("mul", np.multiply),
    ("truediv", np.divide),
    ("pow", np.power),
    ("mod", np.remainder),
    ("lt", np.less),
    ("le", np.less_equal),
    ("gt", np.greater),
    ("ge", np.greater_equal),
):
    setattr(Number, f"__{_name}__", _operation(_function, False))
    if not _name.startswith(("l", "g")):  # comparisons are turned by Python itself
        setattr(Number, f"__r{_name}__", _operation(_function, True))


def whole(name: str) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Make a function of whole columns remember its step by a name."""

    def decorate(function: Callable[P, T]) -> Callable[P, T]:
        @wraps(function)
        def called(*given: P.args, **options: P.kwargs) -> T:
            tape = _tape(given)
            if tape is None:
                return function(*given, **options)
            anything: Any = function
            found: T = tape.result(anything(*map(_plain, given)), name, *given)
            return found

        return called

    return decorate


# Functions of one number: Python's own, unless it remembers.


def single(value: Any) -> float:
    """The number of Python's for one of NumPy's; one that remembers as it is."""
    return value if isinstance(value, Number) else float(value)


def first(track: Any) -> float:
    """A number, or the first of a column."""
    return single(track[0] if isinstance(track, np.ndarray) and track.ndim else track)


def _of(plain: Callable[..., float], function: np.ufunc) -> Callable[..., float]:
    def called(*x: float) -> float:
        some = any(isinstance(a, Number) for a in x)
        found: float = function(*x) if some else plain(*x)
        return found

    return called


cos, sin = _of(math.cos, np.cos), _of(math.sin, np.sin)
atan2, modulo = _of(math.atan2, np.arctan2), _of(operator.mod, np.remainder)


def span(values: Sequence[Any]) -> tuple[float, float] | None:
    """The least and the largest finite number of numbers and columns; None where there is none."""
    if not values:
        return None
    columns = [v for v in values if isinstance(v, np.ndarray) and v.ndim]
    single = [v for v in values if not (isinstance(v, np.ndarray) and v.ndim)]
    numbers = np.concatenate([np.array([*map(_plain, single)]), *map(_plain, columns)])
    finite = numbers[np.isfinite(numbers)]
    if not finite.size:
        return None
    low, high = float(finite.min()), float(finite.max())
    tape = _tape(values)
    if tape is None:
        return low, high
    return tape.result(low, "least", *values), tape.result(high, "largest", *values)
