"""What the branches of a when-equation set: each variable once, and the same ones in all of them.

In:   the typed branches of a when-equation
Out:  errors F301 and F321, warnings F321

Branches of an `if` inside are like those of the when: what one of them leaves out keeps its value.

Reference: Modelica Language Specification 3.6, section 8.3.5.2.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeAlias

from planarc.core.diagnostic import Miscounted, PlanarcError, Related, error
from planarc.core.source import Span
from planarc.flatten.tree.nodes import Env
from planarc.flatten.values.variability import variability_of
from planarc.ir import flat
from planarc.ir.flatwalk import inside, set_by, variables_of_target
from planarc.ir.text.flat import print_expression

Equations: TypeAlias = "tuple[flat.Equation, ...]"


def check_branches(branches: Sequence[tuple[flat.Expression, Equations]], env: Env) -> None:
    """Refuse what no branch may set, or sets twice; tell of what one of them leaves out."""
    for _, equations in branches:
        _expect_variables(equations)
        _expect_once(equations)
    _expect_alike(branches, env)
    for one in inside([e for _, body in branches for e in body]):
        if isinstance(one, flat.IfEquation):
            _expect_alike_inside(one, env)


def _expect_variables(equations: Equations) -> None:
    """A when sets variables at one instant; a derivative is what it is all the while."""
    for equation in equations:
        left = equation.left if isinstance(equation, flat.Equality) else None
        if isinstance(left, flat.Builtin) and left.function == "der":
            name = left.span.text
            message = f"a when sets variables at one instant, and `{name}` is none"
            hint = f"say it where `{name}` is given: `{name} = if ... then ... else ...`"
            raise error("F301", message, equation.span, hint=hint)


def _expect_once(equations: Equations) -> None:
    """A branch of a when gives each variable one value: its equations have no order (8.3.5.2)."""
    seen: dict[str, Span] = {}
    for equation in equations:
        for name, (text, span) in _targets(equation).items():
            if name in seen:
                message = f"`{text}` is given twice in one branch of a when"
                hint = "keep one of them, or make an `elsewhen` of the other"
                related = (Related("first here", seen[name]),)
                raise PlanarcError(Miscounted("F321", message, span, hint=hint, related=related))
            seen[name] = span


def _targets(equation: flat.Equation) -> dict[str, tuple[str, Span]]:
    """What an equation sets, with its text and place; of an `if` what equations of any branch do,
    beside which a `reinit` may stand again."""
    if isinstance(equation, flat.IfEquation):
        found: dict[str, tuple[str, Span]] = {}
        for body in (*(b for _, b in equation.branches), equation.otherwise):
            _expect_once(body)
            for inner in body:
                found |= {} if isinstance(inner, flat.Reinit) else _targets(inner)
        return found
    targets: Iterator[flat.Reference] = set_by(equation)
    if isinstance(equation, flat.Reinit):
        targets = variables_of_target(equation.variable)
    return {print_expression(t): (t.span.text, equation.span) for t in targets}


def _expect_alike(branches: Sequence[tuple[flat.Expression, Equations]], env: Env) -> None:
    """Warn in the user's own text of a branch that leaves out what another one gives: it keeps its
    value here, and other tools refuse it (8.3.5.2)."""
    given = [_names(body) for _, body in branches]
    for (condition, _), names in zip(branches, given, strict=True):
        for name in sorted(set().union(*given) - names):
            _warn(name, "this branch of a `when`", condition.span, env)


def _expect_alike_inside(one: flat.IfEquation, env: Env) -> None:
    """The same of the branches of an `if` that the run decides."""
    if all(variability_of(c, env.session) <= flat.Variability.PARAMETER for c, _ in one.branches):
        return
    _expect_alike(one.branches, env)
    given = set[str]().union(*(_names(body) for _, body in one.branches))
    for name in sorted(given - _names(one.otherwise)):
        what = "the `else` of this `if`" if one.otherwise else "this `if` without `else`"
        _warn(name, f"{what} in a `when`", one.span, env)


def _names(body: Equations) -> set[str]:
    return {v.name for e in inside(body) for v in set_by(e)}


def _warn(name: str, what: str, span: Span, env: Env) -> None:
    if span.source.name not in env.session.library.user_files():
        return
    short = name.removeprefix(f"{env.component}.") if env.component else name
    message = f"{what} gives `{short}` no value, which it then keeps"
    hint = f"write `{short} = pre({short})` in it, as other tools ask for it"
    env.session.warn("F321", message, span, hint)
