"""Functions of texts in the place of external ones."""

from __future__ import annotations

import pytest

from planarc.runtime import external
from planarc.runtime.external import text


def test_the_hash_function_gives_what_the_standard_library_documents() -> None:
    assert text.hash_string("this is a test") == (1827717433,)
    assert text.hash_string("Controller.noise1") == (-1025762750,)


@pytest.mark.parametrize(
    ("name", "arguments", "wanted"),
    [
        ("length", ("abc",), (3,)),
        ("substring", ("abcdef", 2, 4), ("bcd",)),
        ("substring", ("abc", 2, 1), ("",)),
        ("compare", ("abc", "abd", True), (1,)),
        ("compare", ("ABC", "abc", False), (2,)),
        ("compare", ("b", "a", True), (3,)),
        ("skipWhiteSpace", ("  x", 1), (3,)),
        ("skipWhiteSpace", ("x  ", 2), (4,)),
        ("scanIdentifier", (" a_1+", 1), (5, "a_1")),
        ("scanIdentifier", ("1a", 1), (1, "")),
        ("scanInteger", (" -12 ", 1, False), (5, -12)),
        ("scanInteger", ("-12", 1, True), (1, 0)),
        ("scanInteger", ("1.5", 1, False), (1, 0)),
        ("scanReal", ("x 1.5e-3;", 2, False), (9, 1.5e-3)),
        ("scanReal", ("e5", 1, False), (1, 0.0)),
        ("scanString", (' "a b" ', 1), (7, "a b")),
        ("scanString", ("a", 1), (1, "")),
    ],
)
def test_texts(name: str, arguments: tuple[object, ...], wanted: tuple[object, ...]) -> None:
    assert external.call_texts(f"ModelicaStrings_{name}", arguments) == wanted


def test_a_part_that_is_not_there_is_refused() -> None:
    with pytest.raises(ValueError, match="is not in a text of 3"):
        external.call_texts("ModelicaStrings_substring", ("abc", 2, 9))
