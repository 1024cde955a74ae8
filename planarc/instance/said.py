"""Messages with values in them, in LLVM.

    px_fill(block, template) -> text                  in the block, until the next one
    px_number(out, at, value, digits, decimals) -> at  a number as C's `%g` and `%f` write it

A template is a text with marks (`MARK`): the present time, or the next of the values that the
model's own `px_values(block, number)` has stored for message `number` (`export.endings`). A mark is
followed by a letter and a digit, which counts on in ASCII behind 9:

    t6    the time, with six digits
    g6    a number of six digits; f2 one of two decimals
    s0    a text, whose address is stored
    w0    what could not be solved last, which `px_subject(block of equations)` names
"""

from __future__ import annotations

from planarc.codegen.native.assembly import INT, POINTER, REAL, Code, Value, function
from planarc.codegen.native.newton import open_frame
from planarc.instance.block import BYTE, load_narrow, store_narrow, whole
from planarc.instance.plan import LETTERS, Own
from planarc.instance.text import text_constant
from planarc.ir.frame import Number

MARK = "\x01"
#: Most digits that a number is known to.
_DIGITS = 15


def said_functions() -> tuple[str, ...]:
    names = (text_constant(f"px_{name}", name) for name in ("nan", "inf"))
    return *names, _put(), _zeros(), _number(), _copy(), _fill()


@function("i64 px_letter(ptr out, i64 at, i64 letter)", seldom=True)
def _put(c: Code, out: Value, at: Value, letter: Value) -> None:
    """What is too long for its room ends there."""
    with c.when(at < LETTERS - 1, leaves=True):
        store_narrow(c, BYTE, out, letter, at)
        c.give(at + 1)
    c.give(at)


@function("i64 px_noughts(ptr out, i64 at, i64 count)", seldom=True)
def _zeros(c: Code, out: Value, at: Value, count: Value) -> None:
    end = c.variable(at, INT)
    with c.loop(count):
        end.set(c.call(INT, "px_letter", out, end.get(), whole(c, ord("0"))))
    c.give(end.get())


@function("i64 px_words(ptr out, i64 at, ptr text)", seldom=True)
def _copy(c: Code, out: Value, at: Value, text: Value) -> None:
    end = c.variable(at, INT)
    with c.loop(whole(c, LETTERS)) as i:
        letter = load_narrow(c, BYTE, text, i)
        with c.when(letter.equals(0), leaves=True):
            c.give(end.get())
        end.set(c.call(INT, "px_letter", out, end.get(), letter))
    c.give(end.get())


@function("i64 px_number(ptr out, i64 at, double value, i64 digits, i64 decimals)", seldom=True)
def _number(c: Code, out: Value, at: Value, value: Value, digits: Value, decimals: Value) -> None:
    """With decimals below zero as `%g` does it: without zeros at the end, and with an exponent
    where the number is very large or small."""
    end = c.variable(at, INT)

    def put(letter: Value | str) -> None:
        code = whole(c, ord(letter)) if isinstance(letter, str) else letter
        end.set(c.call(INT, "px_letter", out, end.get(), code))

    size, fixed = c.absolute(value), decimals >= 0
    with c.when(value < 0.0):
        put("-")
    with c.when(~(size < 1e300), leaves=True):
        names = (Value(c, POINTER, f"@px_{name}") for name in ("nan", "inf"))
        c.give(c.call(INT, "px_words", out, end.get(), c.select(value.is_nan(), *names)))
    power, e = c.variable(1.0), c.variable(0, INT)
    with c.loop(whole(c, 300)), c.when((size > 0.0) & (size >= power.get() * 10.0)):
        power.set(power.get() * 10.0)
        e.set(e.get() + 1)
    with c.loop(whole(c, 300)), c.when((size > 0.0) & (size < power.get())):
        power.set(power.get() / 10.0)
        e.set(e.get() - 1)
    wanted = c.select(fixed, e.get() + decimals + 1, digits)
    wanted = c.select(wanted > _DIGITS, whole(c, _DIGITS), wanted)
    none = wanted < 0  # all digits are behind the last decimal
    wanted = c.select(none, whole(c, 0), wanted)
    n, top = c.variable(wanted, INT), c.variable(1, INT)
    with c.loop(wanted):
        top.set(top.get() * 10)
    scaled = c.select(none, c.constant(0.0, REAL), size / power.get() * (c.real(top.get()) * 0.1))
    number = c.variable(c.whole(scaled + 0.5), INT)
    with c.when(number.get() >= top.get()):  # rounded up to one digit more
        e.set(e.get() + 1)
        with c.when(fixed):
            n.set(n.get() + 1)
            top.set(top.get() * 10)
        with c.when(~fixed):
            number.set(number.get() / 10)
    with c.when(~fixed), c.loop(wanted):  # zeros at the end say nothing
        tenth = number.get() / 10
        with c.when((tenth * 10).equals(number.get()) & (n.get() > 1)):
            number.set(tenth)
            n.set(n.get() - 1)
            top.set(top.get() / 10)
    exponent = ~fixed & ((e.get() < -4) | (e.get() >= digits))
    point = c.variable(c.select(exponent, whole(c, 0), e.get()), INT)  # after which digit
    with c.when(point.get() < 0):
        put("0")
        with c.when(~decimals.equals(0)):
            put(".")
        leading = whole(c, -1) - point.get()
        leading = c.select(fixed & (leading > decimals), decimals, leading)
        end.set(c.call(INT, "px_noughts", out, end.get(), leading))
    with c.loop(n.get()) as i:
        top.set(top.get() / 10)
        digit = number.get() / top.get()
        number.set(number.get() - digit * top.get())
        put(digit + ord("0"))
        with c.when(i.equals(point.get()) & (i < n.get() - 1)):
            put(".")
    behind = point.get() - n.get() + 1
    end.set(c.call(INT, "px_noughts", out, end.get(), behind))
    with c.when(exponent):
        put("e")
        low = e.get() < 0
        put(c.select(low, whole(c, ord("-")), whole(c, ord("+"))))
        far = c.select(low, e.get().negative(), e.get())
        with c.when(far >= 100):
            put(far / 100 + ord("0"))
        put(far / 10 - far / 100 * 10 + ord("0"))
        put(far - far / 10 * 10 + ord("0"))
    c.give(end.get())


@function("ptr px_fill(ptr m, ptr template)", seldom=True)
def _fill(c: Code, m: Value, template: Value) -> None:
    out = m.load(POINTER, Own.TEXT)
    values = out.at(LETTERS // 8)
    w, numbers, _, _ = open_frame(m)
    at, i, k = c.variable(0, INT), c.variable(0, INT), c.variable(0, INT)
    again, marked, plain, text, number = (c.label() for _ in range(5))

    def following() -> Value:
        letter = load_narrow(c, BYTE, template, i.get())
        i.set(i.get() + 1)
        return letter

    c.enter(again)
    letter = following()
    with c.when(letter.equals(0), leaves=True):
        store_narrow(c, BYTE, out, whole(c, 0), at.get())
        c.give(out)
    c.branch(letter.equals(ord(MARK)), marked, plain)
    c.begin(plain)
    at.set(c.call(INT, "px_letter", out, at.get(), letter))
    c.jump(again)
    c.begin(marked)
    kind, digits = following(), following() - ord("0")
    value, words = values.load(REAL, k.get()), values.load(POINTER, k.get())
    stored = (kind >= ord("f")) & (kind < ord("t"))
    k.set(k.get() + c.select(stored, whole(c, 1), whole(c, 0)))
    c.branch(kind.equals(ord("s")) | kind.equals(ord("w")), text, number)
    c.begin(text)
    subject = c.call(POINTER, "px_subject", numbers.load(INT, Number.FAILED))
    found = c.select(kind.equals(ord("s")), words, subject)
    at.set(c.call(INT, "px_words", out, at.get(), found))
    c.jump(again)
    c.begin(number)
    told = c.select(kind.equals(ord("t")), w.load(REAL), value)
    decimals = c.select(kind.equals(ord("f")), digits, whole(c, -1))
    at.set(c.call(INT, "px_number", out, at.get(), told, digits, decimals))
    c.jump(again)
