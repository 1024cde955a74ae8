"""Who is to blame where equations do not fit their unknowns, in words of the user's own model.

In:   Dae, Misfit
Out:  Diagnostics that name equations, unknowns and their lines

What a user means by equations too many has many forms. Each is told by a function of its own, and
the first that fits counts. The file is long because these forms are many.

Example: `motor.tau = 5` and `hinge.w = 2` decide the same unknowns: 1 equation too many.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

from planarc.core.diagnostic import Diagnostic, Related, Undecided
from planarc.core.prose import be, both, counted, listed, shortened
from planarc.core.source import Span
from planarc.ir import places
from planarc.ir.dae import Dae, Equation, Kind, SetDiscrete, Variable
from planarc.ir.expr import Expr, Op, below, brief, postorder
from planarc.structure.places import owner_span
from planarc.structure.slopes import likely_slope
from planarc.structure.unmatched import Misfit, is_own

_SHOWN = 4  # equations and names in one message
_NONE: Mapping[str, str] = {}


def explain_misfit(
    dae: Dae, misfit: Misfit, inputs: Mapping[str, str] = _NONE
) -> tuple[tuple[Diagnostic, ...], tuple[Diagnostic, ...]]:
    """Messages about too many equations and about undecided unknowns: each one message, or () where
    the user wrote none of them himself. `inputs` are connected to nothing, each with the array that
    it is of. Codes are those of `structure`."""
    over: tuple[Diagnostic, ...] = ()
    under: tuple[Diagnostic, ...] = ()
    if misfit.rivals:
        over = (_too_many(dae, misfit),)
    elif misfit.too_many:
        over = _set_in_whens(dae, misfit.over)
    known = {v.name: v for v in dae.variables}
    own = [n for n in misfit.undecided if places.is_own(dae, known[n].span)]
    open_inputs = [n for n in misfit.undecided if n in inputs]
    if open_inputs:
        named = dict.fromkeys(_whole_or_entry(dae, n, open_inputs, inputs) for n in open_inputs)
        under = tuple(_not_connected(dae, name) for name in [*named][:_SHOWN])
    if others := [n for n in own if n not in inputs]:
        slope = likely_slope(dae, known[others[0]]) if len(others) == 1 else None
        under += (_undecided(others, known[others[0]], misfit.naming, slope),)
    return over, under


def _too_many(dae: Dae, misfit: Misfit) -> Diagnostic:
    return (
        _derived_though_set(dae, misfit.too_many)
        or _held_though_it_moves(dae, misfit)
        or _given_parameters(dae, misfit.too_many)
        or _given_what_moves(dae, misfit.rivals)
        or _moved_parameter(dae, misfit.rivals)
        or _given_elsewhere(dae, misfit)
        or _assigned_apart(misfit)
        or _decided_by_each(misfit)
        or _added_up(misfit)
        or _surplus(dae, misfit)
    )


def _surplus(dae: Dae, misfit: Misfit) -> Diagnostic:
    """The message of which none says more."""
    rivals, surplus = misfit.rivals, max(1, len(misfit.too_many))
    alone = len(rivals) == 1
    if alone:
        message = (
            f"{_named(rivals[0])} is one equation too many: what it names is decided without it"
        )
    else:
        shown = listed([*(e.shown for e in rivals[:_SHOWN]), *["others"][: len(rivals) - _SHOWN]])
        what = f"{shown} decide the same unknowns"
        if len({e.shown for e in rivals}) == 1:
            what = f"{rivals[0].shown} stands here again"
        message = f"{what}: {counted(surplus, 'equation')} too many"
    last = next((e for e in reversed(rivals) if e in misfit.too_many), rivals[-1])
    others = tuple(Related(f"{e.shown} stands here", e.span) for e in rivals if e is not last)
    hint = _how_to_move(dae, last, alone) if surplus == 1 else None
    several = "them" if surplus >= len(rivals) else f"{surplus} of them"
    if not alone and surplus > 1:
        hint = f"remove {several}, or free what they decide"
    hint = hint or _in_order(rivals)
    if (meant := _as_parameters(dae, rivals)) is not None:
        hint = f"write {both(meant)}, which {'give' if len(meant) > 1 else 'gives'} the value"
    hint = hint or f"remove {'it' if alone else 'one of them'}, or free what it decides"
    return Diagnostic("S302", message, last.span, hint=hint, related=others[:_SHOWN])


def _as_parameters(dae: Dae, rivals: Sequence[Equation]) -> list[str] | None:
    """What each of some equations says by a parameter that has the value of its variable already:
    `drive(w_fixed=10)` for the equation of `drive(w=10)`."""
    settable = {p.name for p in dae.parameters if p.settable}
    given = {
        e.left.name: e.right.name
        for e in dae.equations
        if e.left.is_symbol and e.right.is_symbol and e.right.name in settable
    }
    known = {p.name for p in dae.parameters}
    found = []
    for equation in rivals:
        parameter = given.get(equation.left.name) if equation.left.is_symbol else None
        owner, _, name = (parameter or "").rpartition(".")
        if not owner or "[" in owner or equation.right.name == parameter:
            return None
        if any(
            e.op in (Op.TIME, Op.EVENT, Op.PRE) or (e.is_symbol and e.name not in known)
            for e in postorder((equation.right,))
        ):
            return None
        value = f"{name}={brief(equation.right)}"
        for part in reversed(owner.split(".")):
            value = f"{part}({value})"
        found.append(value)
    return found


def _in_order(rivals: Sequence[Equation]) -> str | None:
    """The hint where an equation gives a variable a new value from its own, which another one
    decides, as assignments do one after the other."""
    given = [e.left.name for e in rivals if e.left.is_symbol]
    for e in rivals:
        if e.left.is_symbol and given.count(e.left.name) > 1 and e.left in below((e.right,)):
            value = _written(e).partition("=")[2].strip()
            return (
                f"equations hold at once, and are no assignments in order: give the new value a "
                f"name of its own, as in `{e.left}New = {value}`"
            )
    return None


def _named(equation: Equation) -> str:
    """An equation as it is told; of constants only, of which values are left, as it is written."""
    if any(e.op is Op.SYMBOL for e in postorder((equation.left, equation.right))):
        return equation.shown
    return f"`{_written(equation)}`"


def _written(equation: Equation) -> str:
    return " ".join(equation.span.text.split())


def _assigned_apart(misfit: Misfit) -> Diagnostic | None:
    """The message about a variable that several algorithms assign: each gives it one value."""
    places: dict[str, list[Span]] = {}
    for equation in misfit.rivals:
        if equation.left.is_symbol and equation.span.text.startswith("algorithm"):
            places.setdefault(equation.left.name, []).append(equation.span)
    for name, (*others, last) in places.items():
        if others:
            return Diagnostic(
                "S302",
                f"`{name}` is assigned in {counted(len(others) + 1, 'algorithm')}, each of which "
                "gives it a value of its own",
                last,
                hint="put all that assigns it into one `algorithm`",
                related=tuple(Related("it is assigned here, too", span) for span in others),
            )
    return None


def _decided_by_each(misfit: Misfit) -> Diagnostic | None:
    """The message about one line of a class whose components all decide what they share, an `outer`
    variable."""
    rivals = misfit.rivals
    parts = [*dict.fromkeys(e.component for e in rivals)]
    if len({(e.span, e.left) for e in rivals}) > 1 or not 1 < len(parts) == len(rivals):
        return None
    what = rivals[0].left
    shared = f"`{what}`" if what.is_symbol else "the same unknowns"
    return Diagnostic(
        "S302",
        f"{listed([f'`{part}`' for part in parts[:_SHOWN]])} each decide {shared} by this: "
        f"{counted(max(1, len(misfit.too_many)), 'equation')} too many",
        rivals[0].span,
        hint="let one of them decide what they share, or the model around them",
    )


def _added_up(misfit: Misfit) -> Diagnostic | None:
    """The message about a loop that makes several equations of one variable, as if each added to
    it."""
    rivals, count = misfit.rivals, len(misfit.rivals)
    what = rivals[0].left
    if count < 2 or len({(e.span, e.left) for e in rivals}) > 1 or not what.is_symbol:
        return None
    return Diagnostic(
        "S302",
        f"the loop around this makes {count} equations, all of which decide `{what}`: "
        f"{counted(max(1, len(misfit.too_many)), 'equation')} too many",
        rivals[0].span,
        hint=f"an equation holds all the while and adds nothing up: write one, such as "
        f"`{what} = sum(... for i in 1:{count});`, or a loop in an `algorithm`",
    )


def _given_elsewhere(dae: Dae, misfit: Misfit) -> Diagnostic | None:
    """The message about the one equation too many, where a connection or a part of a library gives
    what it gives."""
    if len(misfit.rivals) > 1:
        return None
    (own,) = misfit.rivals
    what = f"{_named(own)} is one equation too many"
    if (joined := _connected(dae, misfit)) is not None:
        name, connection = joined
        return Diagnostic(
            "S302",
            f"{what}: `{_written(connection)}` decides `{name}`",
            own.span,
            hint="remove one of the two",
            related=(Related(f"`{name}` is connected here", connection.span),),
        )
    if _how_to_move(dae, own, True) or (shows := _given_by_a_part(misfit)) is None:
        return None
    part, name = shows
    return Diagnostic(
        "S302",
        f"{what}: `{part}` itself says what `{name}` is",
        own.span,
        hint=f"remove it: `{name}` only shows what the other equations make of it",
    )


def _connected(dae: Dae, misfit: Misfit) -> tuple[str, Equation] | None:
    """The variable that the one equation gives although a connection of the same part makes it
    equal to another one, and that connection."""
    for side in _given_by(misfit.rivals[0]):
        for other in misfit.over:
            joined = other.generated and side in (other.left, other.right)
            if joined and places.is_own(dae, other.span):
                return side.name, other
    return None


def _given_by_a_part(misfit: Misfit) -> tuple[str, str] | None:
    """A part of a library that gives a variable its value, as a sensor does, and that variable,
    which the one equation gives again."""
    (own,) = misfit.rivals
    for side in _given_by(own):
        part = side.name.rpartition(".")[0]
        for other in misfit.over:
            if other.component == part != own.component and other.left is side:
                return part, side.name
    return None


def _given_by(equation: Equation) -> Iterator[Expr]:
    """The variables that are a side of an equation."""
    return (s for s in (equation.left, equation.right) if s.is_symbol and not s.order)


def _given_what_moves(dae: Dae, rivals: Iterable[Equation]) -> Diagnostic | None:
    """The message about a variable that changes at events only, and is given what moves."""
    discrete = {v.name: v for v in dae.discretes}
    moving = {v.name for v in dae.variables}
    for equation in rivals:
        for side, other in ((equation.left, equation.right), (equation.right, equation.left)):
            variable = discrete.get(side.name) if side.is_symbol else None
            names = [e.name for e in postorder((other,)) if e.is_symbol and e.name in moving]
            if variable is None or not names:
                continue
            hint = f"write a `when` that sets it, or declare `{side.name}` without `discrete`"
            if variable.kind is Kind.INTEGER:
                hint = f"write `{side.name} = integer({brief(other)})`, which rounds down, or "
                hint += "declare it Real"
            return Diagnostic(
                "S302",
                f"`{side.name}` changes at events only, and {both(dict.fromkeys(names))} moves all "
                f"the while: {equation.shown} cannot hold",
                equation.span,
                hint=hint,
            )
    return None


def _moved_parameter(dae: Dae, rivals: Iterable[Equation]) -> Diagnostic | None:
    """The message about an equation with the derivative of a parameter, which is zero: only the
    text still has it."""
    parameters = {p.name for p in dae.parameters}
    for equation in rivals:
        shown = _written(equation)
        shown += ")" * (shown.count("(") - shown.count(")"))  # its place ends before the last one
        for name in re.findall(r"\bder\(\s*(\w+)\s*\)", shown):
            if f"{equation.component}.{name}".removeprefix(".") in parameters:
                return Diagnostic(
                    "S302",
                    f"`{name}` is a parameter, which never changes: `{shown}` cannot move it",
                    equation.span,
                    hint=f"declare `{name}` without `parameter`",
                )
    return None


def _held_though_it_moves(dae: Dae, misfit: Misfit) -> Diagnostic | None:
    """The message about `phi = 0.5` beside `der(phi) = w`: a value at the start was meant."""
    if len(misfit.too_many) > 1:
        return None
    still = {p.name for p in dae.parameters}
    for equation in misfit.rivals:
        left, right = equation.left, equation.right
        leaves = [e for e in postorder((right,)) if not e.args]
        constant = all(e.op is Op.CONST or (e.is_symbol and e.name in still) for e in leaves)
        moving = left.is_symbol and not left.order
        if not (moving and constant and places.is_own(dae, equation.span)):
            continue
        for other in misfit.over:
            if _moves(left.name, (other,)):
                value, name = brief(right), left.name.removeprefix(f"{equation.component}.")
                return Diagnostic(
                    "S302",
                    f"{equation.shown} holds `{left.name}` for all times, but it moves by "
                    f"{other.shown}: 1 equation too many",
                    equation.span,
                    hint=f"for its value at the start, write `{name}(start={value}, "
                    "fixed=true)` where it is declared, and remove the equation",
                    related=(Related(f"{other.shown} stands here", other.span),),
                )
    return None


def _given_parameters(dae: Dae, too_many: Sequence[Equation]) -> Diagnostic | None:
    """The message about equations that give parameters their values."""
    parameters = {p.name for p in dae.parameters}
    if not too_many or not all(
        is_own(dae, e) and e.left.is_symbol and e.left.name in parameters for e in too_many
    ):
        return None
    names = both(dict.fromkeys(e.left.name for e in too_many))
    shown, count = listed(e.shown for e in too_many[:_SHOWN]), len(too_many)
    first, *others = too_many
    owner, _, name = first.left.name.rpartition(".")
    value = f"{name} = {brief(first.right)}"
    written = f"`{owner}({value})`" if owner else f"`{value}`"
    what, rest = ("parameters", "equations") if others else ("a parameter", "equation")
    hint = f"give {'each its' if others else 'it its'} value where it is declared, {written}, "
    hint += f"and remove the {rest}"
    changing = (Op.TIME, Op.EVENT, Op.PRE)
    leaves = [e for e in postorder(e.right for e in too_many) if not e.args]
    if any(e.op in changing or (e.is_symbol and e.name not in parameters) for e in leaves):
        hint = f"what changes in a run is no parameter: declare `{name}` without `parameter`"
        if owner:
            hint = f"`{owner}` keeps the `{name}` that `{owner}({name}=...)` gives it: remove the "
            hint += f"{rest}; a part in which it changes is a class of its own"
    return Diagnostic(
        "S302",
        f"{names} {be(count)} {what}, which no equation decides: {shown} {be(count)} too many",
        first.span,
        hint=hint,
        related=tuple(Related(f"{e.shown} stands here", e.span) for e in others[:_SHOWN]),
    )


def _derived_though_set(dae: Dae, too_many: Iterable[Equation]) -> Diagnostic | None:
    """The message about a variable that has a derivative, and that a when-clause sets."""
    actions = (a for when in dae.whens for branch in when.branches for a in branch[-1])
    set_at = {a.name: a.span for a in actions if isinstance(a, SetDiscrete)}
    for equation in too_many:
        # What is set in a when has a derivative of zero: only the text still has it.
        text_of = "".join(equation.span.text.split())
        for name, span in set_at.items():
            if f"der({name.removeprefix(f'{equation.component}.')})" in text_of:
                message = f"`{name}` moves by `{_written(equation)}`, so that a when cannot set it"
                note = (Related(f"`{name}` moves here", equation.span),)
                hint = f"let it jump: write `reinit({name}, ...)` in the when"
                return Diagnostic("S302", message, span, hint=hint, related=note)
    return None


def _how_to_move(dae: Dae, equation: Equation, alone: bool) -> str | None:
    """What a user means who gives a joint's coordinate by an equation; `alone`: it is the only one
    that is too many."""
    parameters = {p.name for p in dae.parameters}
    for side, value in ((equation.left, equation.right), (equation.right, equation.left)):
        owner, _, name = side.name.rpartition(".") if side.is_symbol else ("", "", "")
        if f"{owner}.drivenFlange" in parameters:
            axis = next((c for c in dae.connections if f"{owner}.axis" in c), ())
            givers = [c for c in axis if not c.startswith(f"{owner}.")]
            if givers and not alone:
                return None
            if givers:
                return f"remove it: `{givers[0]}` drives `{owner}`, which decides `{side.name}`"
            driven = f"`{owner}(drivenFlange=true)` takes a motion or a torque on its flange"
            if value.op is Op.CONST and not side.order and _moves(side.name, dae.equations):
                start = f"`{owner}({name}(start={brief(value)}, fixed=true))`"
                return f"to begin there, write {start}; to drive the joint, {driven}"
            moving = any(
                e.is_symbol and e.name.startswith(f"{owner}.") for e in postorder((value,))
            )
            if name in _EFFORTS and moving:  # `hinge.tau = -d*hinge.w`
                return (
                    f"remove it, write `{owner}(drivenFlange=true)`, and put what gives this "
                    f"between `{owner}.support` and `{owner}.axis`, such as a `Damper`"
                )
            return f"to drive the joint, remove the equation: {driven}"
    return None


_EFFORTS = ("tau", "f")


def _moves(name: str, equations: Iterable[Equation]) -> bool:
    """Whether equations hold the derivative of a variable."""
    sides = (side for e in equations for side in (e.left, e.right))
    return any(e.op is Op.SYMBOL and e.data == (name, 1) for e in postorder(sides))


def _undecided(
    names: Sequence[str], first: Variable, naming: Sequence[Equation], likely: str | None = None
) -> Diagnostic:
    such = f", such as `{likely}`," if likely else ""
    others = tuple(Related(f"{e.shown} decides something else", e.span) for e in naming[:_SHOWN])
    return Undecided(
        "S303",
        f"nothing decides {shortened([f'`{n}`' for n in names], _SHOWN)}",
        first.span,
        hint=f"write an equation for `{first.name}`{such or ','} or a value where it is declared",
        related=others,
        names=tuple(names),
    )


def _whole_or_entry(
    dae: Dae, name: str, open_inputs: Collection[str], inputs: Mapping[str, str]
) -> str:
    """The array of an input, where all entries of it are open."""
    array = inputs[name]
    entries = {v.name for v in dae.variables if v.name.startswith(f"{array}[")}
    return array if entries <= {*open_inputs} else name


def _not_connected(dae: Dae, name: str) -> Diagnostic:
    return Diagnostic(
        "S303",
        f"nothing gives `{name}`: this input is connected to nothing",
        owner_span(dae, name),
        hint=f"connect a signal to it, or write `{name} = ...`",
    )


def explain_discretes(dae: Dae) -> tuple[Diagnostic, ...]:
    """Messages about discrete variables: those with two values, and those with none; where all
    equations say by their left side what they give."""
    if (jumping := _derived_though_set(dae, dae.discrete_equations)) is not None:
        return (jumping,)
    if not all(e.left.is_symbol for e in dae.discrete_equations):
        return ()
    given: dict[str, list[Span]] = {}
    for equation in dae.discrete_equations:
        given.setdefault(equation.left.name, []).append(equation.span)
    for when in dae.whens:
        actions = (a for branch in when.branches for a in branch[-1] if isinstance(a, SetDiscrete))
        for name, span in {a.name: a.span for a in actions}.items():  # once for all its branches
            given.setdefault(name, []).append(span)
    own = [v for v in dae.discretes if places.is_own(dae, v.span)]
    twice = [_given_twice(v.name, given[v.name]) for v in own if len(given.get(v.name, ())) > 1]
    missing = [v for v in own if v.name not in given]
    undecided = [_undecided([v.name for v in missing], missing[0], ())] if missing else []
    return (*twice, *undecided)


def _set_in_whens(dae: Dae, over: Iterable[Equation]) -> tuple[Diagnostic, ...]:
    """Messages about what a when-clause of the user's sets and a connection gives, too."""
    actions = (a for when in dae.whens for branch in when.branches for a in branch[-1])
    places_of = {
        a.name: a.span for a in actions if isinstance(a, SetDiscrete) and places.is_own(dae, a.span)
    }
    for equation in over:
        for e in postorder((equation.left, equation.right)):
            if e.is_symbol and e.name in places_of and places.is_own(dae, equation.span):
                message = f"`{e.name}` gets its value in a when-clause and from {equation.shown}"
                other = (Related(f"{equation.shown} stands here", equation.span),)
                hint = "remove one of them"
                place = places_of[e.name]
                return (Diagnostic("S302", message, place, hint=hint, related=other),)
    known = {v.name for v in dae.discretes if not places.is_own(dae, v.span)}
    for equation in over:  # what a library's part decides
        for e in postorder((equation.left, equation.right)):
            if e.is_symbol and e.name in places_of and e.name in known:
                return (_jump_of_a_part(dae, e.name, equation, places_of[e.name]),)
    return ()


def _jump_of_a_part(dae: Dae, name: str, equation: Equation, place: Span) -> Diagnostic:
    """The message about a when-clause that sets what a component of a library decides."""
    part = places.own_part(dae, equation.component)
    where = f" (in `{equation.component}`)" if equation.component else ""
    return Diagnostic(
        "S302",
        f"`{name}` is decided by `{part.name if part else equation.component}` all the while, so "
        "that a when cannot set it",
        place,
        hint=f"let it jump: write `reinit({name}, ...)` in the when",
        related=(Related(f"{equation.shown}{where} decides it", equation.span, detail=True),),
    )


def _given_twice(name: str, spans: Sequence[Span]) -> Diagnostic:
    *others, last = spans
    related = tuple(Related(f"`{name}` gets a value here, too", span) for span in others[:_SHOWN])
    hint = "give it all its values in one clause: `when ... elsewhen ... end when`"
    message = f"`{name}` gets its value in {counted(len(spans), 'place')}"
    return Diagnostic("S302", message, last, hint=hint, related=related)
