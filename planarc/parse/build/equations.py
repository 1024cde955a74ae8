"""Equations and statements: from the grammar's rules to `ir.syntax`."""

from __future__ import annotations

from typing import Any

from planarc.ir import syntax
from planarc.parse.build.parts import Builder, Part, cover, nodes
from planarc.parse.grammar.lexer import Token


class Equations(Builder):
    # Sections: a part whose value is (section, annotations found in it)

    def equation_section(self, c: list[Any]) -> Part:
        initial = c[0] is not None
        section = syntax.EquationSection(cover(c), nodes(c), initial)
        return Part((section, _annotations(c)), section.span)

    def algorithm_section(self, c: list[Any]) -> Part:
        initial = c[0] is not None
        section = syntax.AlgorithmSection(cover(c), nodes(c), initial)
        return Part((section, _annotations(c)), section.span)

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
        after = side.span._replace(start=side.span.end, end=side.span.end + 1)
        self.refuse("P101", "expected `=` after the left side of the equation", after)

    def connect_equation(self, c: list[Any]) -> syntax.Connect:
        connect: syntax.Connect = c[0]
        return connect

    def connect_clause(self, c: list[Any]) -> syntax.Connect:
        return syntax.Connect(cover(c), c[2], c[4])

    def if_equation(self, c: list[Any]) -> syntax.IfEquation:
        return syntax.IfEquation(cover(c), *_branches(c))

    def when_equation(self, c: list[Any]) -> syntax.WhenEquation:
        return syntax.WhenEquation(cover(c), _branches(c)[0])

    def for_equation(self, c: list[Any]) -> syntax.ForEquation:
        iterators, body = _loop(c)
        return syntax.ForEquation(cover(c), iterators, body)

    def equation_branch(self, c: list[Any]) -> Part:
        return Part((c[0], nodes(c[2:])), cover(c))

    def equation_else(self, c: list[Any]) -> Part:
        return Part((None, nodes(c)), cover(c))

    statement_branch = equation_branch
    statement_else = equation_else

    # Statements

    def assignment(self, c: list[Any]) -> syntax.Assignment:
        return syntax.Assignment(c[0].span.to(c[2].span), c[0], c[2])

    def tuple_assignment(self, c: list[Any]) -> syntax.TupleAssignment:
        close = next(i for i, child in enumerate(c) if _is(child, "RPAR"))
        targets: list[Any] = [None]
        for child in c[1:close]:
            if isinstance(child, Token):
                targets.append(None)
                continue
            targets[-1] = child
            if not isinstance(child, syntax.Ref):
                self.refuse("P101", "expected a variable on the left of `:=`", child.span)
        function, arguments = c[close + 2], c[close + 3]
        call = syntax.Call(function.span.to(arguments.span), function, *arguments.value)
        return syntax.TupleAssignment(c[0].span.to(call.span), tuple(targets), call)

    def call_statement(self, c: list[Any]) -> syntax.CallStatement:
        function, arguments, _ = c
        call = syntax.Call(function.span.to(arguments.span), function, *arguments.value)
        return syntax.CallStatement(call.span, call)

    def if_statement(self, c: list[Any]) -> syntax.IfStatement:
        return syntax.IfStatement(cover(c), *_branches(c))

    def when_statement(self, c: list[Any]) -> syntax.WhenStatement:
        return syntax.WhenStatement(cover(c), _branches(c)[0])

    def for_statement(self, c: list[Any]) -> syntax.ForStatement:
        iterators, body = _loop(c)
        return syntax.ForStatement(cover(c), iterators, body)

    def while_statement(self, c: list[Any]) -> syntax.WhileStatement:
        return syntax.WhileStatement(cover(c), c[1], nodes(c[3:-1]))

    def break_statement(self, c: list[Any]) -> syntax.Break:
        return syntax.Break(c[0].span)

    def return_statement(self, c: list[Any]) -> syntax.Return:
        return syntax.Return(c[0].span)


def _is(child: Any, kind: str) -> bool:
    return isinstance(child, Token) and child.type == kind


def _annotations(c: list[Any]) -> tuple[Token, ...]:
    return tuple(child for child in c if _is(child, "ANNOTATION"))


def _branches(c: list[Any]) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """The branches with a condition, and the body of `else`."""
    parts = [child.value for child in c if isinstance(child, Part)]
    branches = tuple(part for part in parts if part[0] is not None)
    return branches, parts[-1][1] if parts[-1][0] is None else ()


def _loop(c: list[Any]) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    at = next(i for i, child in enumerate(c) if _is(child, "LOOP"))
    return tuple(c[1:at:2]), nodes(c[at:-1])
