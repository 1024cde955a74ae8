"""`python -m planarc` is the command `planarc`."""

from planarc.cli import main

main()
