"""The words that tell the formatter where lines, blocks and classes begin and end.

Reference: Modelica Language Specification 3.6, section 2.3.3 and appendix A.
"""

from __future__ import annotations

OPENING = {"(": ")", "[": "]", "{": "}"}
CLOSING = frozenset(OPENING.values())

#: What may stand before the kind of a class.
CLASS_PREFIXES = frozenset(
    {"encapsulated", "partial", "final", "inner", "outer", "replaceable", "redeclare"}
    | {"pure", "impure", "expandable"}
)
CLASS_KINDS = frozenset(
    {"class", "model", "block", "type", "package", "record", "connector", "function", "operator"}
)
SECTIONS = frozenset({"public", "protected", "equation", "algorithm"})
BLOCKS = frozenset({"if", "for", "when", "while"})
BRANCHES = frozenset({"else", "elseif", "elsewhen"})

#: Words after which a parenthesis or a sign does not continue an operand.
KEYWORDS = (
    CLASS_PREFIXES
    | CLASS_KINDS
    | SECTIONS
    | BLOCKS
    | BRANCHES
    | {"and", "or", "not", "in", "then", "loop", "break", "return", "connect", "within", "import"}
    | {"extends", "constrainedby", "each", "external", "constant", "parameter", "discrete"}
    | {"flow", "stream", "input", "output"}
)

#: Keywords that are followed by a parenthesis as a function's name is.
CALLED = frozenset({"connect", "break"})
#: Operators with a space on both sides, wherever they stand.
SPACED = frozenset({":=", "==", "<>", "<", "<=", ">", ">="})
#: Operators whose spaces are the writer's choice, but on both sides or on none.
CHOSEN = frozenset({"+", "-", "*", "/", "^", ":", ".+", ".-", ".*", "./", ".^"})
SIGNS = frozenset({"+", "-", ".+", ".-"})
