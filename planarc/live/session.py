"""The model of a live page: compiled as often as it must be, run as often as it is moved.

In:   Order    the values, start values and classes that the page asks for
Out:  a value for `json`: the motion and the curves, or what is wrong; and the fields of the
      page, where the model is another one than the page knows

A run that is overtaken by a later order of the same page is given up. What was compiled is
kept, so that going back costs nothing.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from threading import Lock
from time import perf_counter
from typing import Any

from msgspec import field, to_builtins
from msgspec.structs import replace

from planarc.api.model import Model
from planarc.api.result import Result, RunStopped
from planarc.api.variant import texts_of, variant_of
from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, PlanarcError, Severity, mistake, usage_error
from planarc.core.options import Backend, RunOptions
from planarc.core.prose import be, both
from planarc.core.render import render_all
from planarc.flatten.library.library import Library
from planarc.ir.dae import Kind
from planarc.ir.result import Result as Rows
from planarc.live.choices import choices_of, numbers_of
from planarc.live.grip import Grip
from planarc.live.variant import Variant
from planarc.request.request import Request, open_target
from planarc.stages import study
from planarc.view.page.data import choose_rows, curve_data, scene_data
from planarc.view.page.figures import choose_figures
from planarc.view.scene import make_scene

#: The most compiled models that are kept.
_KEPT = 24
#: The most characters of the curves in an answer: a page that follows a finger is small.
_ROOM = 700_000
_QUOTED = re.compile(r"`([^`]+)`")


class Order(Data):
    """The order of a page. Values by name in SI units; only those that were changed.

    `known` is the key of the model whose fields the page shows, `changed` the name of the
    field that was moved last, `page` tells pages apart. `still` asks for the start alone.
    `pose` are start values of the position to which the mechanism was dragged.
    """

    values: Mapping[str, float] = field(default_factory=dict)
    starts: Mapping[str, float] = field(default_factory=dict)
    pose: Mapping[str, float] = field(default_factory=dict)
    choices: Mapping[str, str] = field(default_factory=dict)
    stop: float | None = None
    known: str = ""
    changed: str = ""
    page: str = ""
    still: bool = False


class Drag(Data):
    """A place of the pointer that drags a part of what a page shows; with `components`, the shape
    that is taken hold of there, at a time of the run."""

    x: float
    y: float
    page: str = ""
    components: tuple[str, ...] = ()
    time: float = 0.0


class Overtaken(Exception):
    """A later order of the same page makes this one superfluous."""


class Session:
    """A model on a live page. Raises PlanarcError where the model is wrong at once."""

    def __init__(self, request: Request, backend: Backend) -> None:
        self._request, self._backend = request, backend
        self._lock = Lock()  # one compilation or run at a time
        self._latest: dict[str, int] = {}  # number of the last order of each page
        self._edition = 0
        self._seen: dict[str, tuple[Variant, RunOptions, Rows]] = {}  # what each page shows
        self._grips: dict[str, Grip] = {}
        self._trouble: PlanarcError | None = None
        self._open()

    def _open(self, model: Model | None = None, library: Library | None = None) -> None:
        begin = perf_counter()
        model = model or Model(self._request, self._backend)
        seconds = perf_counter() - begin
        self._library = library or open_target(self._request).library
        self._choices = choices_of(self._library, model.name, model.program.parts)
        self._base = Variant(model, self._key({}, {}), seconds)
        self._variants = {self._base.key: self._base}

    @property
    def name(self) -> str:
        return self._base.model.name

    @property
    def description(self) -> str:
        return self._base.model.description

    def reload(
        self,
        request: Request | None = None,
        model: Model | None = None,
        library: Library | None = None,
    ) -> None:
        """Forget what was compiled, for a file was edited, or a text that is no file yet; the
        next answer tells of mistakes. A `model` of the request, and the libraries that it is
        from, are taken as they are."""
        for page in tuple(self._latest):  # nobody waits for a run of the old text
            self.leave(page)
        with self._lock:
            self._edition += 1
            self._request = request or self._request
            try:
                self._open(model, library)
                self._trouble = None
            except PlanarcError as problem:
                self._trouble = problem
            except Exception as error:
                self._trouble = PlanarcError(mistake(error))

    def leave(self, page: str) -> None:
        """Forget a page that is gone: nobody waits for its run."""
        self._latest[page] = self._latest.get(page, 0) + 1
        self._seen.pop(page, None)
        self._grips.pop(page, None)

    def drag(self, drag: Drag) -> dict[str, Any]:
        """The poses of the items that the page shows, as a pointer drags them, and the start
        values there; nothing where that cannot be."""
        with self._lock:
            try:
                grip = self._held(drag)
                if grip is None or not grip.move(drag.x, drag.y):
                    return {}
                return {"poses": grip.poses(), "start": grip.start()}
            except PlanarcError:
                return {}

    def _held(self, drag: Drag) -> Grip | None:
        """The grip of a page; a new one where it takes hold."""
        if not drag.components:
            return self._grips.get(drag.page)
        self._grips.pop(drag.page, None)
        if drag.page in self._seen:
            variant, options, rows = self._seen[drag.page]
            grip = Grip(variant.model, options, rows, drag.time)
            if grip.take(drag.components, drag.x, drag.y):
                self._grips[drag.page] = grip
        return self._grips.get(drag.page)

    # Answers

    def answer(self, order: Order) -> dict[str, Any]:
        """The answer to an order, mistakes in it told. Raises nothing but `Overtaken`."""
        with self._turn(order) as number:
            variant = self._base
            begin = perf_counter()
            found: dict[str, Any] = {"problems": [], "notes": []}
            try:
                if self._trouble is not None:
                    raise self._trouble
                variant, result, ended = self._run(order, number, found["notes"])
                found |= self._shown(result, ended)
                if ended is not None:
                    found["problems"] = self._told((ended,), variant, order)
            except PlanarcError as problem:
                variant = self._variants.get(self._wanted(order), variant)
                found["problems"] = self._told(problem.diagnostics, variant, order)
            except Overtaken:
                raise
            except Exception as error:
                if os.environ.get("PLANARC_DEBUG"):
                    raise
                found["problems"] = self._told((mistake(error),), variant, order)
            found["seconds"] = perf_counter() - begin
            found["key"] = variant.key
            if variant.key != order.known:
                found["model"] = self._described(variant)
            return found

    def result(self, order: Order) -> Result:
        """The result of an order, for a file. Raises PlanarcError, Overtaken."""
        with self._turn(order) as number:
            if self._trouble is not None:
                raise self._trouble
            return self._run(order, number, [])[1]

    @contextmanager
    def _turn(self, order: Order) -> Iterator[int]:
        """Wait until the session is free; go on only if nothing later was ordered. Gives the
        number of the order."""
        number = self._latest[order.page] = self._latest.get(order.page, 0) + 1
        with self._lock:
            if self.overtaken(order.page, number):
                raise Overtaken
            yield number

    def overtaken(self, page: str, number: int) -> bool:
        return self._latest.get(page, 0) != number

    def _run(
        self, order: Order, number: int, notes: list[tuple[str, str]]
    ) -> tuple[Variant, Result, Diagnostic | None]:
        variant, values = self._variant(order, notes)
        names = variant.names
        values = {n: v for n, v in values.items() if n in names}
        given = {n: v for n, v in order.starts.items() if f"{n}.start" in names}
        starts = {**_of_model(variant.model, order.pose), **given}

        def progress(_time: float) -> None:
            if self.overtaken(order.page, number):
                raise Overtaken

        model = variant.model
        stop = model.program.experiment.start if order.still else order.stop
        model, options = model.asked(values, starts, None, stop, None, None)
        near = variant.began if variant.began_with == starts else None
        ended: Diagnostic | None = None
        try:
            try:
                result = model.run(replace(options, near=near), progress=progress)
            except RunStopped:
                raise
            except PlanarcError:  # no assembly beside the last one: it is looked for afresh
                if near is None:
                    raise
                result = model.run(options, progress=progress)
        except RunStopped as stopped:
            if not len(stopped.result):
                raise
            result, ended = stopped.result, stopped.diagnostics[0]
        if len(result):
            count = len(model.program.candidates)
            variant.began = tuple(h.value for h in result.start[:count])
            variant.began_with = starts
        _, options = model.asked(values, starts)
        self._seen[order.page] = variant, options, result.rows
        return variant, result, ended

    # Variants

    def _variant(
        self, order: Order, notes: list[tuple[str, str]]
    ) -> tuple[Variant, dict[str, float]]:
        """The model with other classes and structural values, and the values left to set."""
        chosen = self._compiled(order.choices, {}, notes)
        fixed = {n: f.value for n, f in chosen.names.items() if f.structural}
        structural = {n: v for n, v in order.values.items() if n in fixed and fixed[n] != v}
        plain = {n: v for n, v in order.values.items() if n not in fixed}
        if not structural:
            return chosen, plain
        return self._compiled(order.choices, structural, notes, chosen.model), plain

    def _compiled(
        self,
        choices: Mapping[str, str],
        structural: Mapping[str, float],
        notes: list[tuple[str, str]],
        of: Model | None = None,
    ) -> Variant:
        key = self._key(choices, structural)
        if key in self._variants:
            return self._variants[key]
        base = self._base.model
        allowed = {c.component: {o.name for o in c.options} for c in self._choices}
        for component, name in choices.items():
            if name not in allowed.get(component, ()):
                raise usage_error("C281", f"`{component}` cannot be a `{name}`")
        begin = perf_counter()
        texts: dict[str, str] = {}
        if of is not None:
            texts = texts_of(of.request, of.program, structural, self._backend)
        kept = self._kept(choices)
        try:
            model = Model(variant_of(base.request, kept | texts, classes=choices), self._backend)
        except PlanarcError:
            if not kept:
                raise
            model = Model(variant_of(base.request, texts, classes=choices), self._backend)
        model.take_name(base.program)
        made = Variant(model, key, perf_counter() - begin)
        while len(self._variants) >= _KEPT:
            del self._variants[next(k for k in self._variants if k != self._base.key)]
        self._variants[key] = made
        named = ""
        if structural:
            named = f"{both(structural)} {be(len(structural))} structural: "
        notes.append(("remark", f"{named}compiled again in {made.seconds:.2f} s"))
        return made

    def _kept(self, choices: Mapping[str, str]) -> dict[str, str]:
        """Numbers that a new class takes over from the one in its place: those that both
        call the same. An ellipse with waves is as large as the ellipse was."""
        slots = [p for p in self._base.model.program.parameter_slots if p.settable and not p.final]
        found = {}
        for component, class_name in choices.items():
            allowed = numbers_of(self._library, class_name)
            for p in slots:
                if p.kind not in (Kind.REAL, Kind.INTEGER):
                    continue
                owner, _, name = p.name.rpartition(".")
                if owner == component and name in allowed and p.default is not None:
                    found[p.name] = repr(p.default)
        return found

    def _wanted(self, order: Order) -> str:
        """The key of the model with the order's classes, if it could be compiled."""
        return self._key(order.choices, {})

    def _key(self, choices: Mapping[str, str], structural: Mapping[str, float]) -> str:
        return repr((self._edition, sorted(choices.items()), sorted(structural.items())))

    # What the page shows

    def _described(self, variant: Variant) -> dict[str, Any]:
        program = variant.model.program
        return {
            "name": program.name,
            "description": program.description,
            "stop": program.experiment.stop,
            "start": program.experiment.start,
            "groups": [to_builtins(g) for g in variant.groups],
            "choices": [to_builtins(c) for c in self._choices],
            "warnings": [["warning", _line(w)] for w in variant.model.warnings],
        }

    def _shown(self, result: Result, ended: Diagnostic | None) -> dict[str, Any]:
        rows = result.rows
        scene, insight = make_scene(rows), study(rows, peaks=False)
        figures = choose_figures(rows, None, insight)
        chosen = choose_rows(rows, figures, tracks=4 * len(scene.items))
        events = sorted({e.time for e in rows.events})
        notes = [["warning", _line(w)] for w in rows.warnings]
        notes += [["remark", n] for n in scene.notes]
        if rows.ended is not None and ended is None:
            notes.append(["remark", rows.ended.message])
        return {
            "scene": scene_data(scene, chosen, events, insight.layers),
            "curves": curve_data(rows, figures, chosen, insight.series, room=_ROOM),
            "warnings": notes,
            "rows": len(rows.time),
        }

    def _told(
        self, diagnostics: Sequence[Diagnostic], variant: Variant, order: Order
    ) -> list[dict[str, Any]]:
        names = set(variant.names)
        return [
            {
                "severity": d.severity.value,
                "code": d.code,
                "message": d.message,
                "hint": d.hint,
                "text": render_all((d,)) if d.span is not None else "",
                "field": next((n for n in _named(d) if n in names), order.changed),
            }
            for d in diagnostics
            if d.severity is not Severity.NOTE
        ]


def _of_model(model: Model, pose: Mapping[str, float]) -> dict[str, float]:
    """The start values that a model knows; after a structural change some may be gone."""
    program = model.program
    known = {name for c in program.candidates for name in (c.display, c.name)}
    known |= {f.display for f in program.fixed}
    return {name: value for name, value in pose.items() if name in known}


def _named(d: Diagnostic) -> list[str]:
    """The names that a message puts in backticks; a start value may stand for its variable."""
    found = [n for text in (d.message, d.hint or "") for n in _QUOTED.findall(text)]
    return [*found, *(f"{n}.start" for n in found)]


def _line(d: Diagnostic) -> str:
    return f"{d.message}\n{d.hint}" if d.hint else d.message
