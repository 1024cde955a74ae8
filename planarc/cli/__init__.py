"""The command line. One file a command; nothing outside this folder prints."""

from __future__ import annotations


def main() -> None:
    """The console script `planarc`: run the command and leave with its exit code."""
    import gc
    import sys

    # A command ends soon, and most of what it makes lives until then: look for cycles
    # seldom. That takes a third off a check with many library classes.
    gc.set_threshold(1_000_000, 10, 10)

    from planarc.cli.app import run

    sys.exit(run(sys.argv[1:]))
