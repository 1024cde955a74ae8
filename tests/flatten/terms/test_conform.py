"""Which types fit each other: laws of `conforms` and `unify`."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from planarc.core.source import Source, Span
from planarc.flatten.terms.conform import conforms, mismatch, scalar_count, unify
from planarc.ir import flat

bases = st.sampled_from([flat.REAL, flat.INTEGER, flat.BOOLEAN, flat.STRING])
dims = st.lists(st.one_of(st.none(), st.integers(0, 3)), max_size=2).map(tuple)
types = st.builds(lambda base, sizes: base.with_dims(sizes), bases, dims)


@given(types)
def test_a_type_fits_itself(a: flat.Type) -> None:
    assert conforms(a, a)
    assert unify(a, a) == a


@given(types, types)
def test_both_types_fit_the_one_that_unifies_them(a: flat.Type, b: flat.Type) -> None:
    common = unify(a, b)
    assert (common is None) == (unify(b, a) is None)
    assert common is None or (conforms(common, a) and conforms(common, b))


@pytest.mark.parametrize(
    ("type_", "count"),
    [
        (flat.REAL, 1),
        (flat.REAL.with_dims((2, 3)), 6),
        (flat.REAL.with_dims((0,)), 0),
        (flat.Type(flat.Base.RECORD, (2,), "R", (), (("x", flat.REAL.with_dims((3,))),)), 6),
    ],
)
def test_scalars_of_arrays_and_records_are_counted(type_: flat.Type, count: int) -> None:
    assert scalar_count(type_) == count


@pytest.mark.parametrize("size", [0, 1, 4, 5, 10**12])
def test_the_hint_of_a_wrong_shape_is_short_whatever_the_size(size: int) -> None:
    span = Span(Source("m.mo", "{1, 2}"), 0, 6)
    for dims in ((), (2,)):
        found = mismatch(flat.REAL.with_dims((size,)), flat.REAL.with_dims(dims), "it", span)
        assert len(found.diagnostics[0].hint or "") < 120
