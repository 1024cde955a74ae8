"""`assert`, `terminate` and `reinit`, which are equations and statements alike.

Reference: Modelica Language Specification 3.6, sections 8.3.6 to 8.3.8.
"""

from __future__ import annotations

from planarc.core.diagnostic import error
from planarc.flatten.terms.conform import expect, expect_scalar
from planarc.flatten.tree.nodes import Env
from planarc.flatten.tree.predefined import ASSERTION_LEVEL
from planarc.flatten.values import evaluate
from planarc.ir import flat, syntax


def _arguments(
    call: syntax.Call, names: tuple[str, ...], least: int
) -> list[syntax.Expression | None]:
    found: list[syntax.Expression | None] = [*call.arguments]
    if len(found) > len(names):
        raise error("F290", f"`{call.function}` takes {len(names)} arguments", call.span)
    found += [None] * (len(names) - len(found))
    for named in call.named:
        if named.name not in names:
            raise error("F290", f"`{call.function}` has no argument `{named.name}`", named.span)
        found[names.index(named.name)] = named.value
    if any(value is None for value in found[:least]):
        raise error("F290", f"`{call.function}` takes at least {least} arguments", call.span)
    return found


def type_assert(call: syntax.Call, env: Env) -> tuple[flat.Assert, ...]:
    condition, message, level = _arguments(call, ("condition", "message", "level"), 2)
    assert condition is not None and message is not None
    typed = env.typed(condition)
    expect_scalar(typed, (flat.Base.BOOLEAN,), "the condition of `assert`")
    text = env.typed(message)
    expect(flat.STRING, text, "the message of `assert`")
    warning = False
    if level is not None:
        typed_level = env.typed(level)
        expect(ASSERTION_LEVEL, typed_level, "the level of `assert`")
        value = evaluate.structural_value(typed_level, env, "the level of `assert`")
        warning = value == 1
    return (flat.Assert(call.span, env.component, typed, text, warning),)


def type_terminate(call: syntax.Call, env: Env) -> tuple[flat.Terminate, ...]:
    (message,) = _arguments(call, ("message",), 1)
    assert message is not None
    text = env.typed(message)
    expect(flat.STRING, text, "the message of `terminate`")
    return (flat.Terminate(call.span, env.component, text),)


def type_reinit(call: syntax.Call, env: Env) -> tuple[flat.Reinit, ...]:
    variable, value = _arguments(call, ("x", "expr"), 2)
    assert variable is not None and value is not None
    target = env.typed(variable)
    typed = env.typed(value)
    expect(target.type, typed, "the new value of `reinit`")
    if not isinstance(target, flat.Reference) or target.type.base is not flat.Base.REAL:
        raise error("F304", "`reinit` takes a Real variable", call.span)
    return (flat.Reinit(call.span, env.component, target, typed),)
