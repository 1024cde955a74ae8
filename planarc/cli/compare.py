"""`planarc compare`: where two results part."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from msgspec.structs import asdict

from planarc.cli import console
from planarc.cli.arguments import AsJson, Pattern, read_pattern
from planarc.cli.exits import Exit
from planarc.cli.line import Argument, Option
from planarc.core.diagnostic import usage_error
from planarc.core.prose import counted, shortened

if TYPE_CHECKING:
    from planarc.view.table.compare import Comparison, Parting

MOST = 20  # variables that are told, the earliest first


def compare(
    reference: Annotated[Path, Argument(metavar="A", help="The reference, .csv or .mat.")],
    other: Annotated[Path, Argument(metavar="B", help="What is compared with it.")],
    tolerance: Annotated[
        float, Option(help="Half the height of the tube, as a share of a variable's range.")
    ] = 1e-3,
    width: Annotated[
        float, Option(help="Half the width of the tube, as a share of the time.")
    ] = 1e-3,
    absolute: Annotated[
        float,
        Option(help="Half the height that a tube has at least, in the variable's own unit."),
    ] = 1e-12,
    variables: Pattern = None,
    as_json: AsJson = False,
) -> int:
    """Compare two results, and show where they part.

    Around each curve of A lies a tube; B may run anywhere in it. Exit code 1 when it does not.
    """
    from planarc.view.table.compare import compare_tables
    from planarc.view.table.files import read_table

    for value, name, what, hint in (
        (tolerance, "--tolerance", "share", "0.001"),
        (width, "--width", "share", "0.001"),
        (absolute, "--absolute", "height", "1e-9"),
    ):
        if not 0 <= value < float("inf"):
            raise usage_error("C161", f"`{name} {value:g}` is no {what}", hint=f"give e.g. {hint}")
    chosen, tables = read_pattern(variables), (read_table(reference), read_table(other))
    found = compare_tables(*tables, tolerance, width, chosen, absolute)
    if not found.compared and not found.apart:
        raise usage_error(
            "C162",
            f"`{reference}` and `{other}` have no variable in common"
            + (f" that matches `{variables}`" if variables else ""),
            hint="compare results of the same model",
        )
    console.say(_to_json(found) if as_json else _text(found, reference, other))
    return Exit.DONE if found.same else Exit.MODEL


def _text(found: Comparison, a: Path, b: Path) -> str:
    lines = []
    if found.ends is not None:
        lines.append(f"{a} ends at t = {found.ends[0]:.6g} s, {b} at {found.ends[1]:.6g} s")
    for names, here, there in ((found.only_a, a, b), (found.only_b, b, a)):
        if names:
            lines.append(
                f"{counted(len(names), 'variable')} of {here} not in {there}: {shortened(names, 5)}"
            )
    lines += [f"`{n}` is in `{u}` in {a}, in `{v}` in {b}" for n, u, v in found.apart[:MOST]]
    if found.compared and not found.meet:
        lines.append(f"{a} and {b} have no time in common")
    elif found.parted:
        first = found.parted[0]
        lines.append(
            f"{len(found.parted)} of {counted(found.compared, 'variable')} part, "
            f"the first at t = {first.time:.6g} s:"
        )
        lines += _table(found.parted[:MOST])
        if len(found.parted) > MOST:
            lines.append(f"  and {len(found.parted) - MOST} more")
    elif found.compared:
        lines.append(f"{counted(found.compared, 'variable')} compared: all stay in the tube")
    return console.plain_lines(lines)


def _table(parted: tuple[Parting, ...]) -> list[str]:
    width = max(8, *(len(p.name) for p in parted))
    head = f"  {'variable':{width}}  {'from t':>10}  {'A':>12}  {'B':>12}  {'most':>10}  at t"
    rows = [
        f"  {p.name:{width}}  {p.time:>10.6g}  {p.a:>12.6g}  {p.b:>12.6g}  "
        f"{p.most:>10.3g}  {p.most_time:.6g}"
        for p in parted
    ]
    return [head, *rows]


def _to_json(found: Comparison) -> str:
    return json.dumps(
        {
            "ok": found.same,
            "compared": found.compared,
            "ends": found.ends and dict(zip("ab", found.ends, strict=True)),
            "only_a": list(found.only_a),
            "only_b": list(found.only_b),
            "units": {n: {"a": u, "b": v} for n, u, v in found.apart},
            "parted": [
                asdict(p) | {n: _finite(getattr(p, n)) for n in ("a", "b", "most")}
                for p in found.parted
            ],
        }
    )


def _finite(value: float) -> float | None:
    return value if abs(value) < float("inf") else None
