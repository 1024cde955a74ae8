"""Shapes as a page carries them: what `paint.js` draws."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from planarc.evaluate.record import Number
from planarc.view.marks.forms import Form
from planarc.view.marks.measure import BASIS, Measure
from planarc.view.marks.shapes import Shape
from planarc.view.page.columns import number


@lru_cache(maxsize=1000)
def shape_data(shape: Shape) -> dict[str, Any]:
    """A shape for `json`, which nobody changes: equal ones are one object."""
    return {"needs": shape.needs, "forms": [_form(form) for form in shape.forms]}


def _form(form: Form) -> dict[str, Any]:
    """A form without its defaults, with lengths by the basis that it uses."""
    lengths = {"width": form.width, "radius": form.radius, "hole": form.hole}
    own = [*(m for point in form.points for m in point), *lengths.values()]
    used = sorted({place for m in own for place, _ in m.terms})

    def parts(measure: Measure) -> list[float | None]:
        factors = dict(measure.terms)
        return [_short(factors.get(i, 0.0), BASIS[i]) for i in used]

    data: dict[str, Any] = {
        "kind": form.kind,
        "basis": "".join(BASIS[i] for i in used),
        "points": [[*parts(x), *parts(y)] for x, y in form.points],
        **{name: parts(length) for name, length in lengths.items() if length.terms},
    }
    told = {"fill": form.fill, "line": form.line, "least": form.least, "text": form.text}
    data.update({name: value for name, value in told.items() if value})
    return data if form.closed else {**data, "open": True}


def _short(part: float, basis: str) -> float | None:
    """A number in few digits: seven in metres, but four as a share of a shape's size."""
    if isinstance(part, Number):
        return part
    value = number(part) if basis == "i" else round(part, 4) + 0.0
    return int(value) if value is not None and value.is_integer() else value
