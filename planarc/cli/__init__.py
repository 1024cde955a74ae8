"""The command line. One file a command; nothing outside this folder prints.

Nothing is imported before `main` catches Ctrl-C: outside of it, Python shows a traceback.
"""

from __future__ import annotations

TYPE_CHECKING = False  # as `typing` has it, which takes 5 ms to import

if TYPE_CHECKING:
    from typing import NoReturn


def main() -> None:
    """The console script `planarc`: run the command and leave with its exit code."""
    try:
        code = _run()
    except KeyboardInterrupt:  # while modules are imported: afterwards `run` tells it
        import sys

        sys.stderr.write("error[C130]: interrupted\n")
        code = 130
    _leave(code)


def _leave(code: int) -> NoReturn:
    """End the process. Python would first take apart all there is, object by object, for 5 to
    10 ms of a short command; that is of use only to whoever watches the command from inside.
    """
    import atexit
    import os
    import sys

    if sys.getprofile() or sys.gettrace():
        raise SystemExit(code)
    try:
        atexit._run_exitfuncs()
        sys.stdout.flush()
        sys.stderr.flush()
    finally:  # an error here is of a stream that nobody reads any more
        os._exit(code)


def _run() -> int:
    import gc
    import os
    import sys

    from planarc.cli.streams import open_streams

    open_streams()

    # A command ends soon, and most of what it makes lives until then: look for cycles
    # seldom. That takes a third off a check with many library classes.
    gc.set_threshold(1_000_000, 10, 10)

    # OpenBLAS's threads wait by spinning, which counts as work of the processor, and the
    # matrices of planar mechanisms are too small for them.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

    from planarc.cli.app import run

    return run(sys.argv[1:])
