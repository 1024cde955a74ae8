"""What a run of an exported model may end with, in planarc's words.

In:   Program
Out:  diagnostics with marks for what only the run knows, in the order of the numbers of endings

    ends        the texts and values of their messages
    ends_of     them as diagnostics
    templates   their messages as `instance.said` fills them, and the model's function
                `px_values(block, number)`, which stores the values of one
    subjects    what could not be solved
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from itertools import chain

from msgspec.structs import replace

from planarc.codegen.native.assembly import INT, POINTER, REAL, SELDOM, Code, Value
from planarc.codegen.native.formulas import formula, real
from planarc.core.diagnostic import Diagnostic
from planarc.export.crowds import overlaps
from planarc.export.fits import misfits
from planarc.instance.actions import endings
from planarc.instance.clauses import reader, warnings
from planarc.instance.plan import LETTERS, Jam, Own, crowd_names
from planarc.instance.said import MARK
from planarc.instance.text import text_constant
from planarc.instance.touches import jams
from planarc.ir.dae import Assertion, Message, Reinit, SetDiscrete, Terminate
from planarc.ir.expr import Expr, Exprs, Op, Substitution, postorder
from planarc.ir.frame import Frame
from planarc.ir.program import Program
from planarc.runtime import texts
from planarc.runtime.external import JOINED
from planarc.solve.contact.touches import Points
from planarc.solve.messages.assertion import assertion_diagnostic
from planarc.solve.messages.event import no_value, terminated
from planarc.solve.messages.failure import unsolved_block

#: A message names the instant, which only the run knows: it is built for this one.
THEN = 86753.0
NOW = f"t = {THEN:.6g} s"
#: Two bodies of a crowd that overlap: `instance.crowd` stores their names, and how deep.
PAIR, _PAIR_FORMS = Message(()), ("s0", "s0", "g3")
_FORM = re.compile(r"%?[-+ #0]*\d*(?:\.(\d*))?([gGeEfFdi])$")


def ends(program: Program) -> list[Message]:
    """The messages of all endings, or what is told of numbers in them."""
    found = [
        a.message if isinstance(a, Assertion | Terminate) else Message(()) for a in endings(program)
    ]
    apart = Exprs()
    crowds = crowd_names(program)
    for touch in Points(program).all:
        # Where there is a crowd no touch makes an event: its lowest gap says nothing.
        low = apart.const(0.0) if crowds else touch.read["low"]
        depth = apart.sub(low, touch.read["gap"])
        numbers = {Jam.OVERLAP: ((depth, ".3g"),)}
        found += [Message(numbers.get(kind, ())) for kind in Jam]
    found += [PAIR for _ in crowds]
    conditions = program.sharing.conditions if program.sharing is not None else ()
    return found + [Message(((apart.symbol(c.name), ".2g"),)) for c in conditions]


def values_of(message: Message) -> list[Expr]:
    """What a message tells besides its texts, in order. Of texts that are put together while
    running, which is done in Python, nothing is known: dots stand for them."""
    found = [p[0] for p in message.parts if not isinstance(p, str)]
    joined = [e for e in postorder(found) if e.op is Op.APPLY and e.data[0] == JOINED]
    if not joined:
        return found
    table = Exprs()
    return list(map(Substitution(table, dict.fromkeys(joined, table.const(math.nan))), found))


def ends_of(program: Program, names: bool = True) -> Iterator[Diagnostic]:
    """What a run tells that ends, in the order of the numbers of endings; with marks for `names`
    of bodies that overlap, or without them."""
    for action in endings(program):
        if isinstance(action, Assertion):
            yield _assertion(program, action)
        elif isinstance(action, Terminate):
            yield terminated(THEN, action, marked(action.message))
        else:
            assert isinstance(action, SetDiscrete | Reinit)
            name = action.name if isinstance(action, SetDiscrete) else repr(action.symbol)
            yield no_value(program, THEN, name, action)
    mark = MARK if names else ""
    for d in (*jams(program, MARK), *overlaps(program, mark), *misfits(program, MARK)):
        yield replace(d, message=d.message.replace("t = 0 s", NOW))


def _assertion(program: Program, failed: Assertion) -> Diagnostic:
    return assertion_diagnostic(program, THEN, failed, marked(failed.message))


def marked(message: Message) -> str:
    """A message with a mark for each value."""
    return "".join(p if isinstance(p, str) else MARK for p in message.parts)


def templates(program: Program, shown: Callable[[str], str], warns: bool) -> tuple[list[str], str]:
    """`shown` makes a text one that a logger shows as it is; `warns`: behind endings stand those of
    assertions that only warn."""
    c = Code("px_values", "void", ((POINTER, "m"), (INT, "number")))
    m, number = c.arguments
    leaf = _leaf(program, m)
    found: list[str] = []
    constants: list[str] = []
    mild = warnings(program) if warns else ()
    told_of = chain(ends_of(program), (_assertion(program, a) for a in mild))
    messages = (*ends(program), *(a.message for a in mild))
    for i, (d, message) in enumerate(zip(told_of, messages, strict=True), 1):
        forms = list(_PAIR_FORMS) if message is PAIR else []
        if values := values_of(message):
            told = [p[1] for p in message.parts if not isinstance(p, str)]
            with c.when(number.equals(i)):
                out = m.load(POINTER, Own.TEXT).at(LETTERS // 8)
                for k, (e, form) in enumerate(zip(values, told, strict=True)):
                    value = formula(c, e, leaf)
                    forms.append(_form(form, value))
                    if form == texts.TEXT:
                        value = _chosen(c, e, value, constants, shown)
                    elif value.type == "i1":
                        value = c.select(value, *_truths(c, constants))
                    else:
                        value = real(c, value)
                    out.store(value, k)
        found.append(_filled(shown(d.message), forms))
    c.give()
    return found, "\n".join((*constants, c.text(SELDOM)))


def _filled(text: str, forms: list[str]) -> str:
    """A text with the kinds of its marks, and one for the instant."""
    marks = iter(forms)
    parts = (part.replace(NOW, f"t = {MARK}t6 s") for part in text.split(MARK))
    return "".join((next(parts), *(MARK + next(marks) + part for part in parts)))


def subjects(program: Program, shown: Callable[[str], str]) -> str:
    """`px_subject(block)`: the loop that a block of equations closes, as far as there is one."""
    told = [unsolved_block(program, i) for i in range(len(program.blocks))]
    known = list(dict.fromkeys(("the equations could not be solved", *told)))
    c = Code("px_subject", POINTER, ((INT, "block"),))
    for i, text in enumerate(told):
        if k := known.index(text):
            with c.when(c.arguments[0].equals(i), leaves=True):
                c.give(Value(c, POINTER, f"@px_subject_{k}"))
    c.give(Value(c, POINTER, "@px_subject_0"))
    texts = (text_constant(f"px_subject_{k}", shown(text)) for k, text in enumerate(known))
    return "\n".join((*texts, c.text(SELDOM)))


def most_values(program: Program) -> int:
    messages = (*ends(program), *(a.message for a in warnings(program)))
    counts = (len(_PAIR_FORMS if m is PAIR else values_of(m)) for m in messages)
    return max(counts, default=0)


def _leaf(program: Program, m: Value) -> Callable[[Expr], Value]:
    """Leaves of values: of the model's formulas, or other variables that results show."""
    w = m.load(POINTER, Frame.W)
    read = reader(program, w, w.load(REAL))
    slots = {c.name: c.slot for c in program.columns}

    def leaf(e: Expr) -> Value:
        name = repr(e)
        known = name in program.slots or name not in slots
        return read(e) if known else w.load(REAL, slots[name])

    return leaf


def _form(form: str, value: Value) -> str:
    """How a value is written: a kind and a character above 48 for its digits."""
    if form == texts.TEXT or value.type == "i1":
        return "s0"
    match = _FORM.match(form)
    digits, kind = (match[1], match[2]) if match else (None, "g")
    count = int(digits) if digits else 6 if digits is None else 0
    if kind in "fF":
        return "f" + chr(48 + min(count, 15))
    if kind in "di":
        count = 15
    return "g" + chr(48 + min(max(count + (kind in "eE"), 1), 15))


def _truths(c: Code, constants: list[str]) -> tuple[Value, Value]:
    """The addresses of the names of both truth values."""
    for name in ("true", "false"):
        if (constant := text_constant(f"px_{name}", name)) not in constants:
            constants.append(constant)
    return Value(c, POINTER, "@px_true"), Value(c, POINTER, "@px_false")


def _chosen(
    c: Code, e: Expr, number: Value, constants: list[str], shown: Callable[[str], str]
) -> Value:
    """The address of the text that a number stands for, among those that an expression chooses;
    dots for another one."""
    numbers = {0.0: "", **{x.data: texts.text_of(x.data) for x in postorder([e])
                           if x.op is Op.CONST and not math.isnan(x.data)}}  # fmt: skip
    found = Value(c, POINTER, "@px_dots")
    if (dots := text_constant("px_dots", "...")) not in constants:
        constants.append(dots)
    for known, text in numbers.items():
        name = f"px_chosen_{len(constants)}"
        constants.append(text_constant(name, shown(text)))
        same = real(c, number).equals(float(known))
        found = c.select(same, Value(c, POINTER, f"@{name}"), found)
    return found
