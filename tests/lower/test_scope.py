"""Ways that are tried and given up leave no assertion behind."""

from __future__ import annotations

import pytest

from planarc.core.source import NOWHERE
from planarc.ir.expr import Exprs
from planarc.lower.scope import Model, OutsideArray, Scope, outside_array


def test_a_block_that_fails_takes_its_assertions_back() -> None:
    model = Model(Exprs(), {})
    scope = Scope(model)
    place = model.table.symbol("k")
    scope.keep_within(place, range(1, 4), NOWHERE)
    kept = list(model.assertions)
    with pytest.raises(OutsideArray), model.undone_on_error():
        scope.keep_within(place, range(1, 3), NOWHERE)
        assert len(model.assertions) == 2
        raise outside_array(4, 3, NOWHERE)
    assert model.assertions == kept
    scope.keep_within(place, range(1, 3), NOWHERE)  # is asserted again, since it was forgotten
    assert len(model.assertions) == 2
