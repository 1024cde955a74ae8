"""Options of LLVM, which a whole process has.

    with options(("disable-lsr", 1, 0)): ...     here 1; before and behind it 0

Where this process has an LLVM that was not tried with them, they stay as they are: one that does
not know an option ends the process.
"""

from __future__ import annotations

# Beneath the module `threading`, whose import is 0.6 ms of a run.
from _thread import allocate_lock
from collections.abc import Iterator
from contextlib import contextmanager

#: A name, the value here, and the one behind it.
Option = tuple[str, int | str, int | str]
#: Whether LLVM's quickest way keeps values in registers, as all others do. By itself LLVM goes by
#: the way; once it is told, it has to be told each time.
_REGISTERS = "optimize-regalloc"
IN_REGISTERS: Option = (_REGISTERS, 1, 1)
IN_MEMORY: Option = (_REGISTERS, 0, 1)
#: Of its quickest way in registers: nothing is scheduled, and no values are split to stay in them.
QUICK: tuple[Option, ...] = (
    IN_REGISTERS,
    ("enable-misched", 0, 1),
    ("grow-region-complexity-budget", 0, 10000),
    ("aarch64-enable-global-isel-at-O", -1, 0),  # it chooses instructions on ARM as elsewhere
)
#: Versions of LLVM that are known to have the options that planarc sets.
_TRIED = range(20, 23)
_LOCK = allocate_lock()


def are_known() -> bool:
    """Whether this process has an LLVM that was tried with them."""
    import llvmlite.binding as llvm

    return llvm.llvm_version_info[0] in _TRIED


@contextmanager
def options(*wanted: Option) -> Iterator[None]:
    """Code is made with these meanwhile."""
    if not are_known():
        yield
        return
    import llvmlite.binding as llvm

    with _LOCK:
        for name, here, _ in wanted:
            llvm.set_option("", f"-{name}={here}")
        try:
            yield
        finally:
            for name, _, behind in wanted:
                llvm.set_option("", f"-{name}={behind}")
