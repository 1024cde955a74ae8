"""What an expression is typed in: its scope, local names, the function around it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec import field
from msgspec.structs import replace

from planarc.core.data import Data
from planarc.flatten.tree.nodes import Scope, Session
from planarc.ir import flat

if TYPE_CHECKING:
    from planarc.flatten.functions.signature import FunctionBuilder


class Env(Data):
    scope: Scope
    #: iterators and, inside functions, the function's own variables
    locals: dict[str, flat.Expression] = field(default_factory=dict)
    function: FunctionBuilder | None = None
    #: inside a subscript: the array and the dimension (from 0) that `end` refers to
    end: tuple[flat.Expression, int] | None = None
    #: in an algorithm: a loop whose body needs constant indices must be unrolled
    in_algorithm: bool = False
    #: the iterators of the loops around
    iterators: frozenset[str] = frozenset()
    #: inside the body of a loop that `break` can leave
    in_loop: bool = False

    @property
    def session(self) -> Session:
        return self.scope.session

    @property
    def hidden(self) -> frozenset[str]:
        """Local names that have no value yet; they hide variables of the model."""
        return frozenset(n for n, v in self.locals.items() if isinstance(v, flat.Reference))

    def with_local(self, name: str, value: flat.Expression) -> Env:
        return replace(self, locals={**self.locals, name: value})

    def with_iterator(self, name: str, value: flat.Expression) -> Env:
        inner = replace(self, iterators=self.iterators | {name}, in_loop=True)
        return inner.with_local(name, value)

    def with_end(self, base: flat.Expression, dimension: int) -> Env:
        return replace(self, end=(base, dimension))
