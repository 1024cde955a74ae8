"""The command line. One file a command; nothing outside this folder prints."""

from __future__ import annotations


def main() -> None:
    """The console script `planarc`: run the command and leave with its exit code."""
    import sys

    from planarc.cli.app import run

    sys.exit(run(sys.argv[1:]))
