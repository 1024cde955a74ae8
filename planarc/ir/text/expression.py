"""Prints expressions and modifications of the syntax tree as Modelica text.

Parentheses stand where the grammar needs them and nowhere else, so that
`parse(print(tree)) == tree`. Long chains of operators take no recursion.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from planarc.ir import syntax

# How tightly a construct binds: the levels of the grammar, loosest first (3.2).
_IF, _RANGE, _OR, _AND, _NOT, _RELATION, _SUM, _PRODUCT, _POWER, _PRIMARY = range(10)

#: Level of an operator, and the least levels of its left and right operand.
_BINARY = {
    **dict.fromkeys(("+", "-", ".+", ".-"), (_SUM, _SUM, _PRODUCT)),
    **dict.fromkeys(("*", "/", ".*", "./"), (_PRODUCT, _PRODUCT, _POWER)),
    **dict.fromkeys(("^", ".^"), (_POWER, _PRIMARY, _PRIMARY)),
    **dict.fromkeys(("<", "<=", ">", ">=", "==", "<>"), (_RELATION, _SUM, _SUM)),
    "and": (_AND, _AND, _NOT),
    "or": (_OR, _OR, _AND),
}
_TIGHT = frozenset({"*", "/", "^"})  # printed without spaces
_ESCAPES = str.maketrans(
    {
        "\\": "\\\\",
        '"': '\\"',
        "\a": "\\a",
        "\b": "\\b",
        "\f": "\\f",
        "\n": "\\n",
        "\r": "\\r",
        "\t": "\\t",
        "\v": "\\v",
    }
)


def quote(text: str) -> str:
    """A string literal with this value (2.4.4)."""
    return f'"{text.translate(_ESCAPES)}"'


def expression_text(expression: syntax.Expression) -> str:
    return _text(expression, _IF)


def simple_text(expression: syntax.Expression) -> str:
    """Print where the grammar has no `if` expression: the left side of an equation."""
    return _text(expression, _RANGE)


def _text(e: syntax.Expression, least: int) -> str:
    """The text of an expression where at least this level must stand."""
    level, text = _level_and_text(e)
    return text if level >= least else f"({text})"


def _level_and_text(e: syntax.Expression) -> tuple[int, str]:
    match e:
        case syntax.Binary():
            return _BINARY[e.op][0], _chain(e)
        case syntax.Unary(op="not"):
            return _NOT, f"not {_text(e.operand, _RELATION)}"
        case syntax.Unary():
            return _SUM, f"{e.op}{_text(e.operand, _PRODUCT)}"
        case syntax.If():
            return _IF, _if_text(e)
        case syntax.Range():
            parts = (e.start, e.stop) if e.step is None else (e.start, e.step, e.stop)
            return _RANGE, ":".join(_text(part, _OR) for part in parts)
        case _:
            return _PRIMARY, _primary(e)


def _chain(e: syntax.Binary) -> str:
    """`a + b - c`: the left operands, then each operator and its right operand."""
    pieces: list[str] = []
    left: syntax.Expression = e
    while True:
        assert isinstance(left, syntax.Binary)
        _, left_least, right_least = _BINARY[left.op]
        op = left.op if left.op in _TIGHT else f" {left.op} "
        pieces.append(op + _text(left.right, right_least))
        left = left.left
        if not isinstance(left, syntax.Binary) or _BINARY[left.op][0] < left_least:
            pieces.append(_text(left, left_least))
            return "".join(reversed(pieces))


def _if_text(e: syntax.If) -> str:
    words = ("if", *("elseif",) * (len(e.branches) - 1))
    branches = (
        f"{word} {_text(condition, _IF)} then {_text(value, _IF)}"
        for word, (condition, value) in zip(words, e.branches, strict=True)
    )
    return f"{' '.join(branches)} else {_text(e.otherwise, _IF)}"


def _primary(e: syntax.Expression) -> str:
    match e:
        case syntax.Integer():
            return str(e.value)
        case syntax.Real():
            return e.text
        case syntax.String():
            return quote(e.value)
        case syntax.Boolean():
            return "true" if e.value else "false"
        case syntax.End():
            return "end"
        case syntax.Colon():
            return ":"
        case syntax.Ref():
            return ref_text(e)
        case syntax.Call():
            named = (f"{n.name} = {_text(n.value, _IF)}" for n in e.named)
            return (
                f"{ref_text(e.function)}({', '.join([*map(expression_text, e.arguments), *named])})"
            )
        case syntax.PartialApplication():
            named = (f"{n.name} = {_text(n.value, _IF)}" for n in e.named)
            return f"function {ref_text(e.function)}({', '.join(named)})"
        case syntax.Comprehension():
            return f"{_text(e.body, _IF)} for {iterators_text(e.iterators)}"
        case syntax.Array():
            return f"{{{list_text(e.items)}}}"
        case syntax.Matrix():
            return f"[{'; '.join(map(list_text, e.rows))}]"
        case syntax.Tuple():
            return f"({', '.join('' if i is None else _text(i, _IF) for i in e.items)})"
        case syntax.Index():
            return f"{_parenthesised(e.base)}{subscripts_text(e.subscripts)}"
        case syntax.Member():
            return f"{_parenthesised(e.base)}.{e.name}"
        case _:
            raise TypeError(f"no expression: {e!r}")


def _parenthesised(e: syntax.Expression) -> str:
    return _primary(e) if isinstance(e, syntax.Tuple) else f"({_text(e, _IF)})"


def ref_text(ref: syntax.Ref) -> str:
    parts = (part.name + subscripts_text(part.subscripts) for part in ref.parts)
    return ("." if ref.absolute else "") + ".".join(parts)


def subscripts_text(subscripts: Sequence[syntax.Expression]) -> str:
    return f"[{list_text(subscripts)}]" if subscripts else ""


def list_text(items: Iterable[syntax.Expression]) -> str:
    return ", ".join(map(expression_text, items))


def iterators_text(iterators: Iterable[syntax.Iterator]) -> str:
    return ", ".join(
        i.name if i.range is None else f"{i.name} in {_text(i.range, _IF)}" for i in iterators
    )
