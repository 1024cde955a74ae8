"""What `package.order` names and its package does not hold.

In:   the entry of a package in a folder
Out:  errors F206, each at its line of that file
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from planarc.core.diagnostic import Diagnostic, said
from planarc.core.nearest import did_you_mean
from planarc.core.source import Source, Span, decode
from planarc.flatten.library.library import Entry
from planarc.ir import syntax


def check_order(package: Entry) -> Iterator[Diagnostic]:
    file = package.folder / "package.order" if package.folder else None
    if file is None or not file.is_file():
        return
    order = Source(str(file), decode(file.read_bytes()), file)
    composition = package.definition.composition
    elements = () if composition is None else composition.elements
    constants = [e.name for e in elements if isinstance(e, syntax.Component)]
    known = [*package.child_names(), *constants]
    lines = list(re.finditer(r"\S.*\S|\S", order.text))
    left = set(known).difference(line[0] for line in lines)
    for line in lines:
        if line[0] not in known:
            near = did_you_mean(line[0], sorted(left))
            yield Diagnostic(
                "F206",
                f"`package.order` names `{line[0]}`, which `{package.full_name}` does not hold",
                Span(order, *line.span()),
                hint=said(near) or "remove the line, or add the class",
                mend=near,
            )
