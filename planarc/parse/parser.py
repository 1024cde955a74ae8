"""From text to syntax tree: lark runs the grammar, `build` makes the nodes.

In:   Source              one text
Out:  StoredDefinition    its tree, or `PlanarcError` with every syntax error

Example:

    model M Real x; equation x = 1; end M;
    StoredDefinition(classes=(ClassDef(name="M", kind=ClassKind.MODEL, ...),))

Promises:  ends in a tree or in `PlanarcError` for every text; annotations are
           not read until `parse_annotation` is asked; lark is imported when the
           first text is parsed, not before.
Reference: Modelica Language Specification 3.6, appendix A.
"""

from __future__ import annotations

import gc
from functools import cache
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, Any, NamedTuple

from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.core.resources import grammar_file
from planarc.core.source import Source, Span, decode
from planarc.ir import syntax
from planarc.parse.build import Build
from planarc.parse.lexer import Terminals, Token, compile_terminals, scan

if TYPE_CHECKING:
    from lark import Lark

#: States of the parser inside each other. It bounds how deep a tree is nested, other
#: than by operators in a row.
MAX_NESTING = 400

_STARTS = ("stored_definition", "expression_text", "annotation_text")


class Machine(NamedTuple):
    """The grammar made ready, once in a process."""

    lark: Lark
    build: Build
    terminals: Terminals
    lock: Lock  # `build` collects errors: one text at a time


def parse_text(source: Source) -> syntax.StoredDefinition:
    """The tree of a whole file."""
    tree: syntax.StoredDefinition = _parse(source, "stored_definition")
    return tree


def parse_file(path: Path, name: str | None = None) -> syntax.StoredDefinition:
    """The tree of a file, under the name that messages show."""
    return parse_text(Source(name or str(path), decode(path.read_bytes()), path))


def parse_expression(text: str, name: str = "<expression>") -> syntax.Expression:
    """The tree of one expression, such as the value of `--set`."""
    tree: syntax.Expression = _parse(Source(name, text), "expression_text")
    return tree


def parse_annotation(annotation: syntax.Annotation) -> tuple[syntax.Argument, ...]:
    """The arguments of an annotation, which the file's parse only skipped."""
    span = annotation.span
    arguments: tuple[syntax.Argument, ...] = _parse(
        span.source, "annotation_text", span.start, span.end
    )
    return arguments


def _parse(source: Source, start: str, begin: int = 0, end: int | None = None) -> Any:
    from lark.exceptions import UnexpectedToken

    machine = load_machine()
    with machine.lock:
        collecting = gc.isenabled()
        gc.disable()  # a tree has no cycles, and looking for them costs 40 %
        try:
            tokens, errors = scan(source, machine.terminals, begin, end)
            machine.build.errors = errors
            machine.build.whole = Token("", "", Span(source, begin, tokens[-1].span.end))
            try:
                tree = _run(machine, tokens, start)
            except UnexpectedToken as found:
                token: Any = found.token
                errors.append(Diagnostic("P101", f"unexpected `{token.text}`", token.span))
        finally:
            if collecting:
                gc.enable()
    if errors:
        raise PlanarcError(sorted(errors, key=lambda e: e.span.start if e.span else 0))
    return tree


def _run(machine: Machine, tokens: list[Token], start: str) -> Any:
    """Feed the tokens to lark's automaton."""
    state = machine.lark.parse_interactive(start=start).parser_state
    feed, depth = state.feed_token, state.state_stack
    last: Any = tokens.pop()
    for token in tokens:
        feed(token)  # type: ignore[arg-type]
        if len(depth) > MAX_NESTING:
            raise PlanarcError(Diagnostic("P106", "this is nested too deeply", token.span))
    return feed(last, is_end=True)


@cache
def load_machine() -> Machine:
    """Read the grammar, or the table that lark made of it in an earlier run."""
    from lark import Lark
    from lark.lexer import Lexer, PatternStr

    class NoLexer(Lexer):
        """`lexer.scan` makes the tokens."""

        def __init__(self, lexer_conf: Any) -> None: ...

        def lex(self, lexer_state: Any, parser_state: Any) -> Any:
            return iter(())

    build = Build()
    lark = Lark(
        grammar_file().read_text("utf-8"),
        parser="lalr",
        lexer=NoLexer,
        start=list(_STARTS),
        keep_all_tokens=True,
        transformer=build,  # type: ignore[arg-type]
    )
    terminals = compile_terminals(
        (
            t.name,
            t.pattern.value if isinstance(t.pattern, PatternStr) else t.pattern.to_regexp(),
            isinstance(t.pattern, PatternStr),
        )
        for t in lark.terminals
    )
    return Machine(lark, build, terminals, Lock())
