"""Tables for notebooks."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence
from itertools import islice

#: A notebook shows no more rows.
MOST = 200


def html_table(
    head: Sequence[str], rows: Iterable[Iterable[object]], note: str = "", most: int = MOST
) -> str:
    """Rows below their head; numbers with six digits. `note` is a sentence above."""
    shown = list(islice(rows, most + 1))
    lines = ["".join(f"<td>{html.escape(_text(v))}</td>" for v in row) for row in shown[:most]]
    if len(shown) > most:
        lines.append(f'<td colspan="{len(head)}">...</td>')
    names = "".join(f"<th>{html.escape(n)}</th>" for n in head)
    above = f"<p>{html.escape(note)}</p>" if note else ""
    return f"{above}<table><tr>{names}</tr><tr>{'</tr><tr>'.join(lines)}</tr></table>"


def _text(value: object) -> str:
    if value is None:
        return ""
    return f"{value:.6g}" if isinstance(value, float | complex) else str(value)
