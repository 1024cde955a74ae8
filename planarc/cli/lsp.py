"""`planarc lsp`: the language server, which an editor starts."""

from __future__ import annotations

import gc
from typing import Annotated

from planarc.cli.exits import Exit
from planarc.cli.line import Option
from planarc.core.extras import need

#: The search for cycles between those that the server itself asks for when it is idle.
_SELDOM = (200_000, 10, 10)


def lsp(
    tcp: Annotated[
        int | None,
        Option(
            min=1,
            max=65535,
            metavar="PORT",
            help="Listen on this port instead of standard input.",
        ),
    ] = None,
    host: Annotated[
        str, Option(metavar="ADDRESS", help="The address to listen on, with --tcp.")
    ] = "127.0.0.1",
) -> int:
    """Start the language server for an editor.

    It speaks the Language Server Protocol over standard input and output, or over TCP: mistakes
    while typing, completion, what a name means and where it is used, renaming, and the live page.
    """
    need("pygls", "lsp")
    from planarc.editor.server import serve

    gc.freeze()
    gc.set_threshold(*_SELDOM)
    serve(host, tcp)
    return Exit.DONE
