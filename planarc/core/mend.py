"""What an editor can do about a diagnostic, as data; the hint says it in words.

Write      another text in the place that the diagnostic points at
Insert     a text before that place
Meant      one of some names in the place of a wrong one
Each       `each` before the modifier whose value is pointed at
Declare    a declaration as the first of the class whose name is pointed at
MakeInner  `inner` before the declaration whose name is pointed at
Accept     a run that accepts redundant joints
"""

from __future__ import annotations

from typing import TypeAlias

from planarc.core.data import Data
from planarc.core.prose import either


class Write(Data):
    text: str


class Insert(Data):
    text: str


class Meant(Data):
    """Names that a user may have meant by a wrong one. As a text it is the hint that names them."""

    wrong: str
    names: tuple[str, ...]

    def __str__(self) -> str:
        return f"did you mean {either(self.names)}?"


class Each(Data):
    pass


class Declare(Data):
    text: str


class MakeInner(Data):
    pass


class Accept(Data):
    pass


Mend: TypeAlias = Write | Insert | Meant | Each | Declare | MakeInner | Accept
