"""`planarc serve`: a page on this machine, on which a model is moved by sliders."""

from __future__ import annotations

import gc
import sys
from typing import Annotated

from planarc.cli import arguments as arg
from planarc.cli import console
from planarc.cli.exits import Exit
from planarc.cli.line import Option
from planarc.core.options import Redundant

#: Python's own thresholds of the search for cycles, which commands that end soon raise.
_OFTEN = (700, 10, 10)


def serve(
    target: arg.Target,
    class_name: arg.ClassName = None,
    port: Annotated[
        int,
        Option(
            min=0, max=65535, metavar="PORT", help="Port to listen on; 0 takes any that is free."
        ),
    ] = 0,
    no_open: Annotated[
        bool, Option("--no-open", help="Print the address, but open no browser.")
    ] = False,
    library: arg.Libraries = None,
    redundant: arg.RedundantJoints = Redundant.REFUSE,
) -> int:
    """Open a page on which the parameters of a model are sliders.

    Each change runs the model again and redraws it at once; replaceable parts are menus, and
    bodies and joints can be dragged. The page follows the file when it is edited. Only this machine
    is answered, and only who knows the address with its random token. Ctrl-C ends it.
    """
    from planarc.live.server import LiveServer
    from planarc.live.session import Session

    request = arg.make_request(target, class_name, library, redundant)
    session = Session(request, arg.choose_backend(None))
    server = LiveServer(session, request, port)
    try:
        # At once, also into a pipe: a script that starts this waits for it.
        console.say(server.address)
        sys.stdout.flush()
        console.tell(f"{session.name} is served here until Ctrl-C")
        if not no_open:
            import webbrowser

            if not webbrowser.open(server.address):
                console.tell("no browser was found: open the address by hand")
        # Unlike other commands this one goes on, and each request leaves cycles behind.
        gc.freeze()
        gc.set_threshold(*_OFTEN)
        server.serve()
    except KeyboardInterrupt:
        pass
    finally:
        server.stop()
    console.tell("stopped")
    return Exit.DONE
