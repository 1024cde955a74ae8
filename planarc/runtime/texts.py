"""Texts that change while a model runs, each by a number that stands for it.

A String variable holds such a number. So a choice between texts is one between numbers,
and texts are equal where their numbers are, in compiled code and in every process: a
number is made of its text alone. Text of a number: `text_of`; the empty text is 0.
"""

from __future__ import annotations

from planarc.core.digest import blake2b

#: The format of a number that stands for a text. No format of a number begins so.
TEXT = '"'

_FIRST = 1 << 52  # numbers of texts are whole, from here to twice that
_TEXTS: dict[float, str] = {0.0: ""}


def number_of(text: str) -> float:
    """The number that stands for a text, from now on."""
    if not text:
        return 0.0
    digest = blake2b(text.encode(errors="surrogatepass"), digest_size=8).digest()
    number = float(_FIRST + int.from_bytes(digest, "big") % _FIRST)
    known = _TEXTS.setdefault(number, text)
    assert known == text, f"two texts have one number: {known!r}, {text!r}"
    return number


def text_of(number: float) -> str:
    return _TEXTS.get(number, "")


def quoted(number: float) -> str | None:
    """The text in quotes, of a number that stands for one."""
    text = _TEXTS.get(number) if number >= _FIRST else None
    return None if text is None else f'"{text}"'


def formatted(value: float, form: str) -> str:
    """A value as `String(value, format=...)` writes it (six digits without a format)."""
    if form == TEXT:
        return text_of(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    try:
        return ("%" + form.lstrip("%") if form else "%.6g") % value
    except (ValueError, TypeError, OverflowError):
        return f"{value:.6g}"
