"""Equations and statements: from the grammar's rules to `ir.syntax`."""

from __future__ import annotations

from typing import Any

from planarc.ir import syntax
from planarc.parse.build.parts import Builder, Part, cover, made, nodes, part, separated
from planarc.parse.grammar.lexer import Token

#: Actions that are called, with what a call of them looks like.
_ACTIONS = {("terminate",): '("done")', ("reinit",): "(v, 0)", ("assert",): '(v < 10, "too fast")'}


class Equations(Builder):
    # Sections: a part whose value is (section, annotations found in it)

    equation_section = part(lambda c: _section(syntax.EquationSection, c))
    algorithm_section = part(lambda c: _section(syntax.AlgorithmSection, c))

    # Equations; the last child is always the description

    def equality(self, c: list[Any]) -> syntax.Equality:
        left, _, right, description = c
        return syntax.Equality(left.span.to(right.span), left, right, description.comment)

    def call_equation(self, c: list[Any]) -> syntax.CallEquation:
        call = c[0]
        if not isinstance(call, syntax.Call):
            self._refuse_bare(call)
        return syntax.CallEquation(call.span, call)

    def _refuse_bare(self, side: syntax.Expression) -> None:
        if isinstance(side, syntax.Binary) and side.op == "==":
            message = "`==` compares, it makes no equation"
            self.refuse("P111", message, side.span, "write `=`")
            return
        if isinstance(side, syntax.Ref) and side.names in _ACTIONS:
            name = str(side)
            message = f"`{name}` is a call and needs its arguments"
            self.refuse("P101", message, side.span, f"write `{name}{_ACTIONS[side.names]}`")
            return
        after = side.span._replace(start=side.span.end, end=side.span.end + 1)
        self.refuse("P101", "expected `=` after the left side of the equation", after)

    def connect_equation(self, c: list[Any]) -> Any:
        return c[0]

    connect_clause = made(syntax.Connect, lambda c: (c[2], c[4]))
    if_equation = made(syntax.IfEquation, lambda c: _branches(c))
    when_equation = made(syntax.WhenEquation, lambda c: _branches(c)[:1])
    for_equation = made(syntax.ForEquation, lambda c: _loop(c))

    equation_branch = part(lambda c: (c[0], nodes(c[2:])))
    equation_else = part(lambda c: (None, nodes(c)))
    statement_branch = equation_branch
    statement_else = equation_else

    # Statements

    assignment = made(syntax.Assignment, lambda c: (c[0], c[2]))
    if_statement = made(syntax.IfStatement, lambda c: _branches(c))
    when_statement = made(syntax.WhenStatement, lambda c: _branches(c)[:1])
    for_statement = made(syntax.ForStatement, lambda c: _loop(c))
    while_statement = made(syntax.WhileStatement, lambda c: (c[1], nodes(c[3:-1])))
    break_statement = made(syntax.Break, lambda c: ())
    return_statement = made(syntax.Return, lambda c: ())

    def tuple_assignment(self, c: list[Any]) -> syntax.TupleAssignment:
        close = next(i for i, child in enumerate(c) if _is(child, "RPAR"))
        targets = separated(c[1:close])
        for target in targets:
            if not isinstance(target, syntax.Ref | None):
                self.refuse("P101", "expected a variable on the left of `:=`", target.span)
        function, arguments = c[close + 2], c[close + 3]
        call = syntax.Call(function.span.to(arguments.span), function, *arguments.value)
        return syntax.TupleAssignment(c[0].span.to(call.span), tuple(targets), call)

    def call_statement(self, c: list[Any]) -> syntax.CallStatement:
        function, arguments, _ = c
        call = syntax.Call(function.span.to(arguments.span), function, *arguments.value)
        return syntax.CallStatement(call.span, call)


def _is(child: Any, kind: str) -> bool:
    return isinstance(child, Token) and child.type == kind


def _section(kind: type[syntax.EquationSection | syntax.AlgorithmSection], c: list[Any]) -> Any:
    section = kind(cover(c), nodes(c), c[0] is not None)
    return section, tuple(child for child in c if _is(child, "ANNOTATION"))


def _branches(c: list[Any]) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """The branches with a condition, and the body of `else`."""
    parts = [child.value for child in c if isinstance(child, Part)]
    branches = tuple(part for part in parts if part[0] is not None)
    return branches, parts[-1][1] if parts[-1][0] is None else ()


def _loop(c: list[Any]) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    at = next(i for i, child in enumerate(c) if _is(child, "LOOP"))
    return tuple(c[1:at:2]), nodes(c[at:-1])
