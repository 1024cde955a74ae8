"""What a function's annotations name: its derivatives, and functions that undo it.

In:   the instance of a function, its Signature
Out:  the derivatives that can be called; warnings F335 of those and of inverses that do not fit

planarc differentiates and inverts functions itself, but where a derivative is to be taken as it is
given, `noDerivative`: elsewhere a wrong annotation harms nothing here, but in a tool that heeds
it. It is told where the user's own text holds it.

Example: `annotation(derivative=f_der)` of `f(Real x, Integer n)` asks for `f_der(x, n, der_x)`.

Reference: Modelica Language Specification 3.6, sections 12.7.1 and 12.8.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError
from planarc.core.mend import Meant
from planarc.core.prose import listed
from planarc.core.source import Span
from planarc.flatten.terms.conform import base_conforms, type_text
from planarc.flatten.tree.annotation import arguments_of, binding_of, find_argument, inside
from planarc.flatten.tree.demand import function_of
from planarc.flatten.tree.lookup import find_class
from planarc.flatten.tree.nodes import Class, FunctionInfo, Instance, Session, Signature
from planarc.ir import flat, syntax

#: Arguments of `derivative` that name inputs without a derivative: with the first their derivatives
#: are given by other inputs, with the second they are zero.
_GIVEN, _ZERO = "noDerivative", "zeroDerivative"


class _Slot(Data):
    """An input or output that another function must have; any name does for a derivative."""

    name: str
    type: flat.Type
    derived: bool = False

    def __str__(self) -> str:
        return f"`{type_text(self.type)} {self.name}`"


def derivatives_of(
    instance: Instance, signature: Signature, session: Session
) -> tuple[flat.Derivative, ...]:
    """The derivatives that a function's annotations name."""
    found = []
    for argument in _annotated(instance, "derivative", session):
        value = binding_of(argument)
        if not isinstance(value, syntax.Ref):
            continue
        order = binding_of(find_argument(inside(argument), "order"))
        number = order.value if isinstance(order, syntax.Integer) else 1
        info = _named(value, "derivative", instance, session)
        if info is None:
            continue  # the function is differentiated itself
        _check_derivative(info, value, argument, number, signature, session)
        if not info.bound:
            still = frozenset(_named_by(argument, (_GIVEN,)))
            found.append(flat.Derivative(info.signature.name, number, still))
    return tuple(found)


def _annotated(
    instance: Instance, word: str, session: Session
) -> Iterator[syntax.ElementModification]:
    for part in instance.layout.parts:
        for argument in _function_annotation(part.cls, word, session):
            if isinstance(argument, syntax.ElementModification) and argument.name == (word,):
                yield argument


def _function_annotation(cls: Class, word: str, session: Session) -> tuple[syntax.Argument, ...]:
    found = arguments_of(cls.definition.annotation, word, session)
    body = cls.definition.body
    external = body.external if isinstance(body, syntax.Composition) else None
    if external is not None:
        found += arguments_of(external.annotation, word, session)
    return found


def _named(
    name: syntax.Ref, word: str, instance: Instance, session: Session
) -> FunctionInfo | None:
    """The function that an annotation names; None, with a warning, where there is none."""
    try:
        return function_of(find_class(instance.scope(), name), name.span)
    except PlanarcError as problem:
        first = next(iter(problem.diagnostics), None)
        if first is not None:
            message = f"`{name}` is named as {_ROLES[word]} of `{instance.cls.name}`, and is none"
            hint = first.hint if isinstance(first.mend, Meant) and first.hint else _NO_NEED
            _warn(f"{message}: {first.message}", name.span, hint, session)
        return None


_ROLES = {"derivative": "the derivative", "inverse": "an inverse"}
_NO_NEED = "write that function, or leave the annotation out: planarc does without"


def _warn(message: str, span: Span, hint: str, session: Session) -> None:
    if span.source.name in session.library.user_files():
        session.warn("F335", message, span, hint)


# Derivatives ---------------------------------------------------------------------------


def _check_derivative(
    info: FunctionInfo,
    name: syntax.Ref,
    argument: syntax.ElementModification,
    order: int,
    signature: Signature,
    session: Session,
) -> None:
    """Warn of a derivative that takes or gives something else (12.7.1). Which inputs of a function
    that is a derivative already are derived is not known: of a second one the rest is free."""
    still = _named_by(argument, (_GIVEN, _ZERO))
    moving = [v for v in signature.inputs if v.name not in still]
    more = _derived(moving) if order == 1 else []
    wanted = [*_slots(signature.inputs), *more]
    takes = _open_inputs(info)
    if not _fit(takes if order == 1 else takes[: len(wanted)], wanted):
        rest = "" if order == 1 else " and further derivatives"
        message = f"`{name}` does not take what a derivative takes"
        hint = f"give it the inputs {listed(map(str, wanted))}{rest}, in this order"
        _warn(message, name.span, hint, session)
    elif not _fit(_slots(info.signature.outputs), outputs := _derived(signature.outputs)):
        message = f"`{name}` does not give what a derivative gives"
        hint = f"give it the output {listed(map(str, outputs))}"
        _warn(message, name.span, hint, session)


def _named_by(argument: syntax.ElementModification, words: Sequence[str]) -> set[str]:
    """The inputs that `noDerivative` and the like name."""
    return {
        str(binding_of(a))
        for a in inside(argument)
        if isinstance(a, syntax.ElementModification) and a.name[0] in words
    }


def _slots(variables: Iterable[flat.Variable]) -> list[_Slot]:
    return [_Slot(v.name, v.type) for v in variables]


def _derived(variables: Iterable[flat.Variable]) -> list[_Slot]:
    return [_Slot(f"der_{v.name}", v.type, True) for v in variables if _has_reals(v.type)]


def _has_reals(type_: flat.Type) -> bool:
    if type_.base is flat.Base.RECORD:
        return any(_has_reals(t) for _, t in type_.fields)
    return type_.base is flat.Base.REAL


def _open_inputs(info: FunctionInfo) -> list[_Slot]:
    return _slots(v for v in info.signature.inputs if v.name not in info.bound)


def _fit(given: Sequence[_Slot], wanted: Sequence[_Slot]) -> bool:
    return len(given) == len(wanted) and all(
        _alike(g.type, w.type) and (w.derived or g.name == w.name)
        for g, w in zip(given, wanted, strict=True)
    )


def _alike(given: flat.Type, wanted: flat.Type) -> bool:
    if len(given.dims) != len(wanted.dims):
        return False
    return wanted.base is flat.Base.RECORD or base_conforms(wanted, given)


# Inverses ------------------------------------------------------------------------------


def check_inverses(instance: Instance, signature: Signature, session: Session) -> None:
    """Look at `annotation(inverse(x = f_inv(y)))`: the output of `f` goes in, and `x` comes out."""
    inputs = {v.name: v for v in signature.inputs}
    for argument in (
        a for whole in _annotated(instance, "inverse", session) for a in inside(whole)
    ):
        if not isinstance(argument, syntax.ElementModification):
            continue
        call, undone = binding_of(argument), inputs.get(argument.name[0])
        if undone is None:
            message = f"`{instance.cls.name}` has no input `{argument.name[0]}` to solve for"
            hint = f"its inputs are {listed(map(str, _slots(signature.inputs)))}"
            _warn(message, argument.span, hint, session)
        elif isinstance(call, syntax.Call):
            info = _named(call.function, "inverse", instance, session)
            if info is not None and not _undoes(info, call, undone, signature):
                wanted = [*signature.outputs, *(v for v in signature.inputs if v is not undone)]
                message = f"this is no inverse of `{instance.cls.name}`"
                hint = f"hand {listed(map(str, _slots(wanted)))} to a function whose only output "
                hint += f"is {_Slot(undone.name, undone.type)}"
                _warn(message, call.span, hint, session)


def _undoes(
    info: FunctionInfo, call: syntax.Call, undone: flat.Variable, signature: Signature
) -> bool:
    """Whether the function gives the input, and is given the output and nothing unknown."""
    own = {v.name: v for v in (*signature.inputs, *signature.outputs) if v is not undone}
    takes, gives = _open_inputs(info), info.signature.outputs
    given = [own.get(str(a)) for a in call.arguments]
    if len(given) != len(takes) or len(gives) != 1 or not _alike(gives[0].type, undone.type):
        return False
    if not any(v in signature.outputs for v in given):
        return False
    return all(v and _alike(v.type, t.type) for v, t in zip(given, takes, strict=True))
