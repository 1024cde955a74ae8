"""External functions that planarc has of its own, by the names of the C functions.

A standard library declares some functions as `external "C"`. planarc runs no C, so the
published algorithms stand here in Python: of numbers (random generators, Fourier
transform), which models call while they run, and of texts, which are evaluated while a
model is compiled.

A function of numbers takes and gives all its scalars in one row: arrays entry by entry
in the order of the arguments, results in the order of the outputs. It is `pure` when equal
arguments give equal results; one that is not is called with two more numbers, the
place of the call and the time, so that it keeps its value while events are iterated.

Reference: Modelica Language Specification 3.6, sections 12.3 and 12.9.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from importlib import import_module
from sys import modules
from typing import Any, TypeAlias

Numbers: TypeAlias = Callable[[Sequence[float]], Sequence[float]]
Texts: TypeAlias = Callable[..., tuple[Any, ...]]

_HERE = "planarc.runtime.external"

#: The name of planarc's own function that puts texts together from their parts.
JOINED = "planarc_text"

#: The function that draws from a row of numbers, one after the other.
_DRAWN = "ModelicaRandom_impureRandom_xorshift1024star"
#: C name -> (module, function); modules are imported when first called.
_NUMBERS = {
    "ModelicaRandom_xorshift64star": ("random", "xorshift64star"),
    "ModelicaRandom_xorshift128plus": ("random", "xorshift128plus"),
    "ModelicaRandom_xorshift1024star": ("random", "xorshift1024star"),
    _DRAWN: ("random", "drawn"),
    "ModelicaRandom_automaticGlobalSeed": ("random", "automatic_seed"),
    "ModelicaFFT_kiss_fftr": ("fourier", "real_spectrum"),
    JOINED: ("text", "joined"),
    "planarc_solution": ("linear", "solution"),
    "planarc_factors": ("linear", "factors"),
    "planarc_solutionByFactors": ("linear", "solution_by_factors"),
    "planarc_inverseByFactors": ("linear", "inverse_by_factors"),
    "planarc_reciprocalCondition": ("linear", "reciprocal_condition"),
    "planarc_cholesky": ("linear", "cholesky"),
    "planarc_leastSquares": ("linear", "least_squares"),
    "planarc_constrainedLeastSquares": ("linear", "constrained_least_squares"),
    "planarc_eigenvalues": ("linear", "eigenvalues"),
    "planarc_generalEigenvalues": ("linear", "general_eigenvalues"),
    "planarc_singularValues": ("linear", "singular_values"),
    "planarc_orthogonalFactors": ("linear", "orthogonal_factors"),
    "planarc_orthogonal": ("linear", "orthogonal"),
    "planarc_schur": ("linear", "schur"),
    "planarc_reorderedSchur": ("linear", "reordered_schur"),
    "planarc_sylvester": ("linear", "sylvester"),
}
_IMPURE = frozenset({_DRAWN, "ModelicaRandom_automaticGlobalSeed"})
_TEXTS = {
    "ModelicaStrings_length": ("text", "length"),
    "ModelicaStrings_substring": ("text", "substring"),
    "ModelicaStrings_compare": ("text", "compare"),
    "ModelicaStrings_skipWhiteSpace": ("text", "skip_white_space"),
    "ModelicaStrings_hashString": ("text", "hash_string"),
    "ModelicaStrings_scanIdentifier": ("text", "scan_identifier"),
    "ModelicaStrings_scanInteger": ("text", "scan_integer"),
    "ModelicaStrings_scanReal": ("text", "scan_real"),
    "ModelicaStrings_scanString": ("text", "scan_string"),
    "ModelicaInternal_fullPathName": ("text", "full_path_name"),
    "ModelicaInternal_stat": ("text", "file_type"),
    "ModelicaIO_readMatrixSizes": ("matrix", "sizes"),
    "ModelicaIO_readRealMatrix": ("matrix", "matrix"),
    "planarc_tableSizes": ("matrix", "table_sizes"),
    "planarc_table": ("matrix", "table"),
}

#: The values that a function of texts takes by its annotations, and how a model declares them.
_KINDS = {"str": (str, "String"), "int": (int, "Integer"), "bool": (int, "Boolean")}

#: Functions that act on the world outside and give nothing: they are not run. What the
#: user misses is said once.
SILENT = {
    "ModelicaInternal_print": "does not print what models write with `print`",
    "ModelicaInternal_removeFile": "does not remove files that models name",
    "ModelicaStreams_closeFile": "does not write files that models name",
    "ModelicaIO_writeRealMatrix": "does not write files that models name",
}


#: The number by which native code calls each function of numbers.
INDEX = {name: i for i, name in enumerate(_NUMBERS)}


def is_of_numbers(name: str) -> bool:
    return name in _NUMBERS


def is_of_texts(name: str) -> bool:
    return name in _TEXTS


def is_of_files(name: str) -> bool:
    """True for functions whose result depends on the files that there are, and where."""
    return name.startswith("ModelicaInternal_")


def is_of_contents(name: str) -> bool:
    """True for functions that read the file that they are first given."""
    return name in _TEXTS and _TEXTS[name][0] == "matrix"


def is_pure(name: str) -> bool:
    return name not in _IMPURE


def is_known(name: str) -> bool:
    return name in _NUMBERS or name in _TEXTS or name in SILENT


@lru_cache(maxsize=256)
def call_numbers(name: str, arguments: tuple[float, ...]) -> tuple[float, ...]:
    """The results of a function of numbers. Those of one call are asked for one by
    one, so the last calls are remembered.

    Raises ValueError where the function has no value.
    """
    return _run(name, arguments)


def _run(name: str, arguments: tuple[float, ...]) -> tuple[float, ...]:
    module, function = _NUMBERS[name]
    run: Numbers = getattr(import_module(f"{_HERE}.{module}"), function)
    try:
        return tuple(map(float, run(arguments)))
    except IndexError:
        raise ValueError(f"`{name}` takes more than {len(arguments)} numbers") from None


def number(name: str, output: int, arguments: Sequence[float]) -> float:
    """A result of a function of numbers, nan where it has no value. A tuple holds floats."""
    call = _run if name == _DRAWN else call_numbers
    given = arguments if isinstance(arguments, tuple) else tuple(map(float, arguments))
    try:
        return call(name, given)[output]
    except (ValueError, IndexError, OverflowError):
        return float("nan")


def begin_run() -> None:
    """Let rows of numbers that an earlier run of this thread drew from begin anew."""
    module = modules.get(f"{_HERE}.random")
    if module is not None:
        module.forget()


def call_texts(name: str, arguments: Sequence[Any]) -> tuple[Any, ...]:
    """The results of a function of texts. Raises ValueError where it has none, and where these
    are not its arguments: a model may declare the function with others."""
    module, function = _TEXTS[name]
    run: Texts = getattr(import_module(f"{_HERE}.{module}"), function)
    kinds = [_KINDS[kind] for of, kind in run.__annotations__.items() if of != "return"]
    if len(kinds) != len(arguments) or not all(
        isinstance(a, kind) for a, (kind, _) in zip(arguments, kinds, strict=True)
    ):
        raise ValueError(f"`{name}` takes ({', '.join(word for _, word in kinds)})")
    return run(*arguments)
