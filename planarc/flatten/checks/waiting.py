"""Values that a user gives to parameters which wait for a switch that is off.

In:   the variables with their declarations
Out:  warnings F338, at the value

A declaration tells when its value counts: `Dialog(enable = law == ContactLaw.Compliant)`. Told is
only where the switch has what it was declared with: who sets it knows what that leaves out.

Example: `Contact floor(c=1e4)`: the law is Rigid, and the floor as hard as steel.

Reference: Modelica Language Specification 3.6, section 18.7.
"""

from __future__ import annotations

from collections.abc import Container

from planarc.core.diagnostic import PlanarcError
from planarc.core.prose import ticked
from planarc.flatten.sections.alike import Variable
from planarc.flatten.terms.constant import NotConstant
from planarc.flatten.tree.annotation import arguments_of, binding_of, find_argument, inside
from planarc.flatten.tree.demand import leaf_binding
from planarc.flatten.tree.lookup import leaf_named
from planarc.flatten.tree.nodes import Element, Env, Leaf, Session
from planarc.flatten.values.evaluator import Evaluator
from planarc.ir import flat, syntax
from planarc.ir.flatwalk import nodes_of


def check_waiting(pairs: list[tuple[Variable, flat.Variable | None]], session: Session) -> None:
    """Warn of values without effect."""
    files = session.library.user_files()
    for leaf, variable in pairs:
        if variable is None or variable.variability is not flat.Variability.PARAMETER:
            continue
        if _is_given(variable.binding, leaf.element, files):
            _check(leaf if isinstance(leaf, Leaf) else leaf.leaf, variable, session)


def _is_given(value: flat.Expression | None, element: Element, files: Container[str]) -> bool:
    """Whether a user's modifier gives the value, not the declaration itself."""
    return (
        value is not None
        and value.span.source.name in files
        and not element.definition.span.covers(value.span)
    )


def _check(leaf: Leaf, variable: flat.Variable, session: Session) -> None:
    written = _enable(leaf.element, session)
    if written is None or variable.binding is None:
        return
    try:
        condition = Env(leaf.element.scope).typed(written)
        switches = [leaf_named(session, r.name) for r in _references(condition)]
        if not switches or not all(s and _is_untouched(s) for s in switches):
            return
        if Evaluator(session).value(condition) is not False:
            return
    except (PlanarcError, NotConstant):
        return
    own = leaf.element.name
    names = ticked(s.element.name for s in switches if s)
    message, hint = f"`{leaf.name}` has no effect: ", f"give {names}, too, or leave `{own}` out"
    message += f"it counts only with `{written.span.text}`"
    if wanted := _choice(condition):
        hint = f"write `{wanted}`, too, or leave `{own}` out"
    session.warn("F338", message, variable.binding.span, hint)


def _enable(element: Element, session: Session) -> syntax.Expression | None:
    definition = element.definition
    if not isinstance(definition, syntax.Component):
        return None
    arguments = arguments_of(definition.annotation, "enable", session)
    return binding_of(find_argument(inside(find_argument(arguments, "Dialog")), "enable"))


def _references(e: flat.Expression) -> list[flat.Reference]:
    return [n for n in nodes_of((e,)) if isinstance(n, flat.Reference)]


def _is_untouched(switch: Leaf) -> bool:
    """Whether a switch shapes the model, and has the value that it was declared with."""
    value = leaf_binding(switch)
    return (
        switch.structural
        and value is not None
        and switch.element.definition.span.covers(value.span)
    )


def _choice(condition: flat.Expression) -> str | None:
    """What sets the switch of `law == Types.ContactLaw.Compliant`."""
    if not isinstance(condition, flat.Binary) or condition.op != "==":
        return None
    switch, wanted = condition.left, condition.right
    if not isinstance(switch, flat.Reference) or not isinstance(wanted, flat.Literal):
        return None
    literals = wanted.type.literals
    if not literals or not isinstance(wanted.value, int):
        return None
    return f"{switch.name.rpartition('.')[2]}={wanted.type.name}.{literals[wanted.value - 1]}"
