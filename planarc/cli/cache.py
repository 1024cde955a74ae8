"""`planarc cache`: what is kept between runs, and its removal."""

from __future__ import annotations

from typing import Annotated

from planarc.cli import console
from planarc.cli.exits import Exit
from planarc.cli.line import Option
from planarc.core.prose import counted


def cache(
    clear: Annotated[bool, Option("--clear", help="Remove what is kept.")] = False,
) -> int:
    """Show or clear what planarc keeps between runs.

    It only saves time: everything in it is made again when it is needed.
    """
    from planarc.core import cache as store

    root = store.folder()
    if root is None:
        why = ": there is no folder for it, or PLANARC_CACHE_DIR is empty"
        console.say("nothing is kept" + ("" if store.refusal() else why))
        return Exit.DONE
    before = store.entries(root)
    if clear:
        left = store.clear(root)
        gone = sum(size for _, size in before.values())
        number = sum(n for n, _ in before.values())
        console.say(f"removed {counted(number, 'entry')}, {megabytes(gone)}")
        return Exit.RUN if left else Exit.DONE
    rows = [("folder", str(root))]
    rows += [
        (kind, f"{counted(n, 'entry')}, {megabytes(size)}") for kind, (n, size) in before.items()
    ]
    total = sum(size for _, size in before.values())
    rows.append(("total", f"{megabytes(total)} of at most {megabytes(store.MAX_BYTES)}"))
    console.say_rows(rows)
    return Exit.DONE


def megabytes(size: int) -> str:
    return f"{size / 1e6:.1f} MB"
