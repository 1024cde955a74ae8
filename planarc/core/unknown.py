"""A name that is not there, with the nearest ones that are."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from functools import wraps
from typing import TYPE_CHECKING, ParamSpec, TypeVar

from planarc.core.diagnostic import Diagnostic, UsageError, said
from planarc.core.prose import either, shortened, ticked

if TYPE_CHECKING:
    from planarc.core.mend import Meant

P = ParamSpec("P")
T = TypeVar("T")


class UnknownName(UsageError, KeyError):
    """There is no such parameter or variable; the hint names the nearest ones."""


def unknown_name(kind: str, name: object, known: Iterable[str]) -> UnknownName:
    names = list(known)
    if not isinstance(name, str):
        return UnknownName(
            Diagnostic("C202", f"the name of a {kind} is a text, not {type(name).__name__}")
        )
    inside = [n for n in names if n.startswith(f"{name}.") and n.count(".") == name.count(".") + 1]
    hint = (
        f"`{name}` is a part: name one of its {kind}s, as {either(inside[:3])}" if inside else None
    )
    if (first := name.replace("[0]", "[1]")) != name and first in names:
        hint = f"indices count from 1: the first is `{first}`"
    hint = hint or said(_meant(name, names))
    if hint is None and 0 < len(names) <= 8:
        hint = f"choose among {ticked(names)}"
    none = "" if names else f": the model has no {kind}s"
    return UnknownName(Diagnostic("C201", f"there is no {kind} `{name}`{none}", hint=hint))


def unknown_attribute(owner: object, name: str, others: Iterable[str] = ()) -> AttributeError:
    """What Python says of an attribute that is not there, with the nearest ones that are."""
    names = [*(n for n in dir(type(owner)) if n[0] != "_"), *others]
    hint = None if name[:1] == "_" else _meant(name, names)
    message = f"`{type(owner).__name__}` has no attribute `{name}`"
    return AttributeError(f"{message}: {hint}" if hint else message, name=name, obj=owner)


def refuse_unknown(kind: str, names: Iterable[object], known: Collection[str]) -> None:
    """Raise UnknownName for the first of some names that is not there."""
    for name in names:
        if name not in known:
            raise unknown_name(kind, name, known)


def _elsewhere(function: str, name: str, owner: Sequence[object]) -> str | None:
    """The method beside a function that takes a keyword."""
    for beside, method in vars(type(owner[0])).items() if owner else ():
        code = getattr(getattr(method, "__wrapped__", method), "__code__", None)
        names = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount] if code else ()
        if name in names and beside != function and beside[0] != "_":
            return f"`{beside}({name}=...)` has one"
    return None


class UnknownKeyword(UsageError, TypeError):
    """A function was called with a keyword that it does not have; the hint names the nearest."""


def telling_keywords(function: Callable[P, T]) -> Callable[P, T]:
    """A function that names the keywords nearest to a misspelt one, and arguments that it lacks."""
    code = function.__code__
    known = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
    names = frozenset(known)
    needed = known[: code.co_argcount - len(function.__defaults__ or ())]

    @wraps(function)
    def call(*args: P.args, **given: P.kwargs) -> T:
        if not names.issuperset(given):
            name = next(n for n in given if n not in names)
            raise _unknown_keyword(function.__name__, name, known, args[:1])
        if len(args) > code.co_argcount and not code.co_flags & _VARARGS:
            raise _too_many(function.__name__, known, code.co_argcount)
        if len(args) < len(needed):
            missing = [n for n in needed[len(args) :] if n not in given]
            if missing:
                raise _missing(function.__name__, missing, needed)
        return function(*args, **given)

    return call


def _too_many(function: str, known: tuple[str, ...], most: int) -> UnknownKeyword:
    unnamed = [n for n in known[:most] if n != "self"]
    message = f"`{function}` takes {ticked(unnamed) or 'nothing'} without a name"
    named = shortened([f"`{n}=...`" for n in known[most:]], _SHOWN)
    hint = f"write the others by name: {named}" if named else "several values stand in one list"
    return UnknownKeyword(Diagnostic("C201", message, hint=hint))


_VARARGS = 0x04  # in `co_flags`: `*args` takes the rest
_SHOWN = 6  # keywords in a hint


def _missing(function: str, names: Sequence[str], needed: Sequence[str]) -> UnknownKeyword:
    message = f"`{function}` lacks {ticked(names)}"
    hint = f"write `{function}({', '.join(n for n in needed if n != 'self')})`"
    return UnknownKeyword(Diagnostic("C201", message, hint=hint))


def _unknown_keyword(
    function: str, name: str, known: Iterable[str], owner: Sequence[object]
) -> UnknownKeyword:
    names = [n for n in known if n != "self"]
    hint = said(_meant(name, names)) or _elsewhere(function, name, owner)
    hint = hint or f"choose among {ticked(names)}"
    return UnknownKeyword(Diagnostic("C201", f"`{function}` has no keyword `{name}`", hint=hint))


def _meant(name: str, names: Iterable[str]) -> Meant | None:
    # A run without a mistake looks for no nearest name, and does not import the search.
    from planarc.core.nearest import did_you_mean

    return did_you_mean(name, names)
