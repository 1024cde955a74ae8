"""What a model does at events, in LLVM: its when-clauses, and when its samplers fire.

    px_branches(frame, initial)   which branch of each when-clause acts here
    px_lefts(frame, t)            left limits of continuous variables, before anything acts
    px_assign(frame, t) -> flag   discrete variables set; what no clause sets keeps its left limit
    px_act(frame, t) -> moved     `reinit`, `assert`, `terminate`; 1 where a state was set anew
    px_samples(frame, rows)       starts and intervals

and the tables of samplers and of unknowns that `instance` reads.

Reference: `solve.events.whens`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial

from planarc.codegen.native.assembly import (
    FLAG,
    INT,
    POINTER,
    REAL,
    SELDOM,
    Code,
    Value,
    table,
)
from planarc.codegen.native.carried import Carrier
from planarc.codegen.native.formulas import bit, formula, real
from planarc.codegen.native.rolling import SHORTEST_SELDOM
from planarc.codegen.native.spelled import is_spelled
from planarc.instance.assignments import Assignments, long_branches
from planarc.instance.clauses import actions, keeps, ordered_discretes, reader, slot_of, warnings
from planarc.instance.plan import Jam, Own, crowd_names
from planarc.instance.settling import discrete
from planarc.ir.dae import (
    EDGE,
    Action,
    Assertion,
    Impact,
    Reinit,
    SetDiscrete,
    Terminate,
)
from planarc.ir.expr import Expr
from planarc.ir.frame import Frame
from planarc.ir.program import DiscreteSlot, Let, Program
from planarc.solve.contact.touches import Points
from planarc.solve.events.crossings import unknowns
from planarc.solve.events.iteration import lefts
from planarc.solve.events.whens import initial_conditions, own_slots


def errors(program: Program) -> tuple[Assertion, ...]:
    """The assertions that end a run."""
    return tuple(a for a in program.assertions if not a.warning)


def endings(program: Program) -> list[Action]:
    """Everything that a run may end with, in the order of their numbers, from 1."""
    return [*errors(program), *(a for a in actions(program) if _ends(a))]


def first_misfit(program: Program) -> int:
    """The number of the first condition that was left out of redundant joints."""
    jams = len(Jam) * len(Points(program).all) + len(crowd_names(program))
    return len(endings(program)) + jams + 1


def first_warning(program: Program) -> int:
    """The number of the first of `warnings`, behind all endings."""
    conditions = program.sharing.conditions if program.sharing is not None else ()
    return first_misfit(program) + len(conditions)


def _ends(action: Action) -> bool:
    """Whether it may end a run."""
    if isinstance(action, Assertion):
        return not action.warning
    return isinstance(action, Terminate | SetDiscrete | Reinit) and not keeps(action)


def numbers(program: Program) -> dict[int, int]:
    """The number of the message of each action, by its place among all of them."""
    found, number = {}, len(errors(program))
    for i, action in enumerate(actions(program)):
        if _ends(action):
            number += 1
            found[i] = number
    return found


def carry_values(
    program: Program, formulas: Sequence[Expr], carrier: Carrier | None, c: Code, out: Value
) -> bool:
    """Whether a function of an instance and a time, `c`, has the formulas carried out: their values
    stand in an array then."""
    results = [program.table.symbol(f"$value({i})") for i in range(len(formulas))]
    lets = list(map(Let, results, formulas))
    if carrier is None or len(lets) < SHORTEST_SELDOM or not is_spelled(lets):
        return False
    m, t = c.arguments[:2]
    told = carrier.values(lets, lambda e: slot_of(program, e))
    c.run("pc_carry", m, t, *(c.constant(n, INT) for n in told))
    memory = m.load(POINTER, Frame.W).at(carrier.memory)
    c.run("px_copy", out, memory, c.constant(len(lets), INT))
    return True


def action_functions(program: Program, asks: bool = False, warns: bool = False) -> str:
    """The functions and tables of a model's events. `asks`: a run in Python asks for them, which
    tells by itself what an action ends or warns of; `warns`: they tell that (`px_warn`)."""
    followed = () if asks else lefts(program)
    return "\n".join(
        (
            "declare i32 @pc_outputs(ptr, double, ptr)" if followed else "",
            "declare i64 @px_reinit(ptr, i64, double)",
            "declare void @px_impact(ptr, double)",
            "declare void @px_copy(ptr, ptr, i64)",
            "declare void @px_warn(ptr, i64)" if warns else "",
            _branches(program),
            _lefts(followed, partial(reader, program)),
            _assign(program, asks),
            _act(program, asks, warns),
            "" if asks else _samples(program),
            table("px_sampled", (slot for slot, *_ in program.samplers)),
            table("px_quiet_slots", unknowns(program)),
        )
    )


def _branches(program: Program) -> str:
    c = Code("px_branches", "void", ((POINTER, "m"), (INT, "initial")))
    m, initial = c.arguments
    w, chosen = m.load(POINTER, Frame.W), m.load(POINTER, Own.BRANCHES)
    edges = {d.slot for d in program.discretes if d.name.startswith(f"{EDGE}[")}
    at_start = initial_conditions(program)
    ordinary = initial.equals(0)
    for k, when in enumerate(program.whens):
        found = c.constant(0, INT)
        for number, (slot, pre, _) in reversed(list(enumerate(when.branches, 1))):
            acts = ~w.load(REAL, slot).equals(0.0)
            if slot not in edges:
                acts = acts & w.load(REAL, pre).equals(0.0)
            if slot not in at_start:
                acts = acts & ordinary
            found = c.select(acts, c.constant(number, INT), found)
        chosen.store(found, k)
    c.give()
    return c.text(SELDOM)


def _lefts(
    followed: Sequence[tuple[int, int, Expr]],
    reader_of: Callable[[Value, Value], Callable[[Expr], Value]],
) -> str:
    c = Code("px_lefts", "void", ((POINTER, "m"), (REAL, "t")))
    m, t = c.arguments
    w = m.load(POINTER, Frame.W)
    if followed:
        c.call(FLAG, "pc_outputs", m, t, m.load(POINTER, Own.Y))
    for slot, pre, value in followed:
        found = real(c, formula(c, value, reader_of(w, t)))
        w.store(found, slot)
        w.store(found, pre)
    c.give()
    return c.text(SELDOM)


def _each(
    program: Program, c: Code, asks: bool, is_wanted: Callable[[Action], bool]
) -> Iterator[dict[int, Action]]:
    """What each branch does of what is wanted, by its places among all actions: where code is
    written then, the branch acts. `asks`: a long branch is `Own.DOUBT`."""
    m = c.arguments[0]
    chosen, first = m.load(POINTER, Own.BRANCHES), 0
    for k, when in enumerate(program.whens):
        for number, (*_, found) in enumerate(when.branches, 1):
            wanted = {i: a for i, a in enumerate(found, first) if is_wanted(a)}
            first += len(found)
            if not wanted:
                continue
            with c.when(chosen.load(INT, k).equals(number)):
                if asks and (k, number) in long_branches(program):
                    m.store(c.constant(1, INT), Own.DOUBT)
                else:
                    yield wanted


def _assign(program: Program, asks: bool) -> str:
    c = Code("px_assign", FLAG, ((POINTER, "m"), (REAL, "t")))
    number, assigning = numbers(program), Assignments(program, c)
    discretes, count = ordered_discretes(program)
    resting = {d.name for d in discretes[:count]}
    for found in _each(
        program, c, asks, lambda a: isinstance(a, SetDiscrete) and a.name not in resting
    ):
        assigning.write({i: a for i, a in found.items() if isinstance(a, SetDiscrete)}, number)
    m = c.arguments[0]
    w = m.load(POINTER, Frame.W)
    with c.loop(count) as i:
        w.store(w.load(REAL, discrete(m, i, 1)), discrete(m, i, 0))
    chosen = m.load(POINTER, Own.BRANCHES)
    own, setters = own_slots(program), _setters(program)
    kept: dict[tuple[tuple[int, int], ...], list[DiscreteSlot]] = {}
    for d in discretes[count:]:
        if d.slot in own:
            kept.setdefault(tuple(setters[d.slot]), []).append(d)
    for branches, listed in kept.items():
        quiet = Value(c, "i1", "true")
        for k, branch in branches:
            quiet = quiet & ~chosen.load(INT, k).equals(branch)
        with c.when(quiet):
            assigning.copy([d.slot for d in listed], [d.pre for d in listed])
    c.give(0)
    return assigning.text() + c.text(SELDOM)


def _setters(program: Program) -> dict[int, list[tuple[int, int]]]:
    """Of each variable the branches that set it, as numbers of clauses and branches."""
    found: dict[int, list[tuple[int, int]]] = {}
    for k, when in enumerate(program.whens):
        for branch, (*_, done) in enumerate(when.branches, 1):
            for slot in {program.slots[a.name] for a in done if isinstance(a, SetDiscrete)}:
                found.setdefault(slot, []).append((k, branch))
    return found


def _act(program: Program, asks: bool, warns: bool) -> str:
    c = Code("px_act", INT, ((POINTER, "m"), (REAL, "t")))
    m, t = c.arguments
    number, moved, struck = numbers(program), c.variable(0, INT), c.variable(0, INT)
    leaf = reader(program, m.load(POINTER, Frame.W), t)
    mild = [i for i, a in enumerate(actions(program)) if isinstance(a, Assertion) and a.warning]
    behind = first_warning(program) + len(warnings(program)) - len(mild)
    warned = {i: k for k, i in enumerate(mild, behind)}

    def end(i: int, over: bool) -> None:
        with c.when(m.load(INT, Own.ENDED).equals(0)):
            m.store(c.constant(number[i], INT), Own.ENDED)
            if not asks:
                c.run("px_values", m, c.constant(number[i], INT))
            m.store(c.constant(int(over), INT), Own.OVER)

    def act(i: int, action: Action) -> None:
        if isinstance(action, Terminate):
            end(i, True)
        elif isinstance(action, Reinit):
            value = real(c, formula(c, action.value, leaf))
            none = value.is_nan()
            with c.when(none):
                end(i, False)
            with c.when(~none):
                slot = c.constant(program.slots[repr(action.symbol)], INT)
                one = c.call(INT, "px_reinit", m, slot, value)
                moved.set(c.select(one.equals(1), one, moved.get()))
        elif isinstance(action, Assertion) and not action.warning:
            with c.when(~bit(c, formula(c, action.condition, leaf))):
                end(i, False)
        elif isinstance(action, Assertion) and asks:
            with c.when(~bit(c, formula(c, action.condition, leaf))):
                m.store(c.constant(1, INT), Own.DOUBT)
        elif isinstance(action, Assertion) and warns:
            with c.when(~bit(c, formula(c, action.condition, leaf))):
                c.run("px_warn", m, c.constant(warned[i], INT))

    for found in _each(program, c, asks, lambda a: isinstance(a, Terminate | Reinit | Assertion)):
        for i, action in found.items():
            act(i, action)
    if not crowd_names(program) and any(isinstance(a, Impact) for a in actions(program)):
        for _ in _each(program, c, asks, lambda a: isinstance(a, Impact)):
            struck.set(c.constant(1, INT))
        goes_on = m.load(INT, Own.ENDED).equals(0) & m.load(INT, Own.OVER).equals(0)
        with c.when(struck.get().equals(1) & goes_on):
            c.run("px_impact", m, t)
            moved.set(c.constant(1, INT))
    c.give(moved.get())
    return c.text(SELDOM)


def _samples(program: Program) -> str:
    c = Code("px_samples", "void", ((POINTER, "m"), (POINTER, "rows")))
    m, rows = c.arguments
    w = m.load(POINTER, Frame.W)
    leaf = reader(program, w, w.load(REAL))
    for k, (_, start, interval, _) in enumerate(program.samplers):
        for place, e in enumerate((start, interval)):
            value = real(c, formula(c, e, leaf))
            rows.store(value, place * len(program.samplers) + k)
    c.give()
    return c.text(SELDOM)
