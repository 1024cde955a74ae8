"""Texts as constants of LLVM."""

from __future__ import annotations


def text_constant(name: str, text: str) -> str:
    """A constant that ends with a zero, as C's functions expect."""
    data = text.encode()
    shown = "".join(chr(b) if 32 <= b < 127 and b not in (34, 92) else f"\\{b:02X}" for b in data)
    return f'@{name} = constant [{len(data) + 1} x i8] c"{shown}\\00"'
