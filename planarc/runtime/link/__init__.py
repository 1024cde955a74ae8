"""LLVM's objects, linked without a linker.

objects     object files read and put together
join        its sections put together, relocations applied, ways to imported functions
memory      the result in this process, where planarc places it itself

On other systems and processors LLVM places code: Apple's processors want such memory to be
asked for in a way of its own, and those of ARM to be told of new instructions.
"""

import os
import sys
from typing import Final

#: Whether `memory` places code here, which is then to be made for any place.
PLACES: Final = sys.platform == "linux" and os.uname().machine == "x86_64"
